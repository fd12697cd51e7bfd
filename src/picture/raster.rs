//! SVG into pixels.

use std::sync::{Arc, LazyLock};

use resvg::tiny_skia::{Color, IntSize, Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

use super::{PictureError, encode};

/// The one font there is, on every machine the same.
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

/// How wide a line of bold text is, which is given as XML has it; the font's size is the unit's.
pub(super) fn width(text: &str, size: f64) -> f64 {
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\"><text font-weight=\"bold\" font-size=\"{size}\">{text}</text></svg>"
    );
    // Without a glyph there is nothing to measure.
    parse(&svg).map_or(0.0, |tree| tree.root().bounding_box().width().into())
}

/// A PNG, `width` pixels wide, of what is drawn on paper of one colour, over `under` if there is such a thing.
///
/// # Errors
/// None that a caller can do something about.
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
    // The last row may be higher than what is drawn.
    pixmap.fill(Color::from_rgba8(red, green, blue, 255));
    if let Some(under) = under {
        under.put(&mut pixmap)?;
    }
    resvg::render(
        &tree,
        Transform::from_scale(scale, scale),
        &mut pixmap.as_mut(),
    );
    // Opaque all over, where opacity is no longer a factor of the colours.
    encode(width, height, pixmap.data())
}

/// Red, green, blue and opacity of pixels at the upper left.
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
