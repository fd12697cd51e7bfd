//! Renders SVG into pixels.

use std::sync::{Arc, LazyLock};

use resvg::tiny_skia::{Color, IntSize, Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

use super::{PictureError, encode};

/// The only font, the same on every machine.
static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    for font in [dejavu::sans::regular(), dejavu::sans::bold()] {
        fonts.load_font_data(font.to_vec());
    }
    fonts.set_sans_serif_family("DejaVu Sans");
    Arc::new(fonts)
});

fn parse(svg: &str) -> Result<Tree, PictureError> {
    let options = Options {
        fontdb: Arc::clone(&FONTS),
        font_family: "DejaVu Sans".to_owned(),
        ..Options::default()
    };
    Ok(Tree::from_str(svg, &options)?)
}

/// Returns the width of a line of bold text, given as XML, in units of the font size.
pub(super) fn width(text: &str, size: f64) -> f64 {
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\"><text font-weight=\"bold\" font-size=\"{size}\">{text}</text></svg>"
    );
    // A text without glyphs has no width.
    parse(&svg).map_or(0.0, |tree| tree.root().bounding_box().width().into())
}

/// Renders a drawing as a PNG of `width` pixels, on a background of one colour and over the image `under`, if any.
///
/// # Errors
/// Only faults that the caller cannot remedy.
pub(super) fn png(
    svg: &str,
    width: u32,
    paper: [u8; 3],
    under: Option<Under>,
) -> Result<Vec<u8>, PictureError> {
    let tree = parse(svg)?;
    let scale = width as f32 / tree.size().width();
    let height = (tree.size().height() * scale).ceil().max(1.0) as u32;
    let mut pixmap = Pixmap::new(width, height).ok_or(PictureError::Memory)?;
    let [red, green, blue] = paper;
    // The last row may extend beyond the drawing.
    pixmap.fill(Color::from_rgba8(red, green, blue, 255));
    if let Some(under) = under {
        under.put(&mut pixmap)?;
    }
    resvg::render(
        &tree,
        Transform::from_scale(scale, scale),
        &mut pixmap.as_mut(),
    );
    // All pixels are opaque, so the colours are no longer multiplied by an opacity.
    encode(width, height, pixmap.data())
}

/// Pixels (red, green, blue, opacity) to draw at the upper left.
pub(super) struct Under {
    pub pixels: Vec<u8>,
    pub size: [u32; 2],
}

impl Under {
    fn put(self, pixmap: &mut Pixmap) -> Result<(), PictureError> {
        let size = IntSize::from_wh(self.size[0], self.size[1]).ok_or(PictureError::Memory)?;
        let mut pixels = self.pixels;
        for pixel in pixels.chunks_exact_mut(4) {
            let opacity = u16::from(pixel[3]);
            for part in &mut pixel[..3] {
                *part = ((u16::from(*part) * opacity + 127) / 255) as u8;
            }
        }
        let picture = Pixmap::from_vec(pixels, size).ok_or(PictureError::Memory)?;
        let paint = resvg::tiny_skia::PixmapPaint::default();
        pixmap.draw_pixmap(0, 0, picture.as_ref(), &paint, Transform::identity(), None);
        Ok(())
    }
}
