//! Pictures of a prepared mesh, of a grasp on it, and of the progress of a search.
//!
//! | file | subject |
//! |---|---|
//! | `canvas.rs` | triangles and strokes into samples, with depth; samples into pixels |
//! | `view.rs` | the direction of view and the scale |
//! | `scene.rs` | what is drawn: body, defective edges, centre of mass, axes |
//! | `sheet.rs` | the picture of a mesh above the figures, as SVG |
//! | `paper.rs`, `colors.rs` | the background and the colours of text; the colours of marks |
//! | `marks.rs` | the sizes of the marks of a grasp |
//! | `text.rs` | numbers, and texts from clients |
//! | `grasp/` | a grasp on its body, as SVG and PNG |
//! | `convergence.rs` | a plot of the quality over the generations, as SVG and PNG |
//! | `raster.rs` | SVG into pixels |

mod canvas;
mod colors;
mod convergence;
mod grasp;
pub mod marks;
mod paper;
mod raster;
mod scene;
mod sheet;
mod text;
mod view;

#[cfg(test)]
mod tests;

pub use colors::{CENTER, CONTACT_COLORS, FORCE, TORQUE};
pub use convergence::{convergence_pixels, convergence_png, convergence_svg};
pub use grasp::{GraspOptions, Viewpoint, grasp_png, grasp_svg};
pub use paper::Background;
pub use sheet::sheet;

use nalgebra::Vector3;

use self::canvas::Canvas;
use self::view::View;
use graspd_core::mesh::Mesh;

/// Least width of a picture in pixels.
pub const MIN_WIDTH: u32 = 64;
/// Greatest width of a picture in pixels.
pub const MAX_WIDTH: u32 = 4096;
/// Default width of a picture in pixels.
pub const DEFAULT_WIDTH: u32 = 1024;

/// Direction to the viewer in the left view: in front of the body (−y), to its right (+x), above it (+z). The right view is
/// from the opposite side, so that every face of a box is visible in one of them.
const EYE: Vector3<f64> = Vector3::new(0.62, -1.0, 0.62);

/// The options of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// Width in pixels, clamped to [`MIN_WIDTH`] to [`MAX_WIDTH`]. The height is half of it.
    pub width: u32,
    pub background: Background,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            width: DEFAULT_WIDTH,
            background: Background::Light,
        }
    }
}

/// Why a picture could not be drawn: a bug, or lack of memory.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    #[error("the picture cannot be encoded: {0}")]
    Encoding(#[from] png::EncodingError),
    #[error("the drawing cannot be read: {0}")]
    Drawing(#[from] resvg::usvg::Error),
    #[error("there is no memory for the pixels")]
    Memory,
}

/// Draws a PNG of the mesh in two opposite orthographic views, z up: from the front, right and above, and from
/// the back, left and below.
///
/// The surface is flat-shaded with a light beside the viewer; large triangles are outlined, and the inside of the surface
/// is bluish. Border edges are red, non-manifold ones magenta, thin and faint where the body
/// hides them. The centre of mass is the disc in black and white quarters, drawn over everything.
///
/// O(triangles + pixels), with about 8 bytes per sample and four samples per pixel for half the picture. If more than about
/// a hundred large triangles lie behind each other everywhere, each of the remaining triangles is drawn as a point.
///
/// # Errors
/// Only faults that the caller cannot remedy.
pub fn preview(mesh: &Mesh, options: &Options) -> Result<Vec<u8>, PictureError> {
    let width = options.width.clamp(MIN_WIDTH, MAX_WIDTH) as usize;
    let height = width / 2;
    let mut pixels = vec![0; 4 * width * height];
    let halves = [(0, width / 2, EYE), (width / 2, width - width / 2, -EYE)];
    let defects = mesh.defective_edges();
    for (left, width_of_half, eye) in halves {
        let mut canvas = Canvas::new(width_of_half, height);
        let view = View::of(mesh, &[], &eye, canvas.size());
        scene::draw(&mut canvas, &view, mesh, &defects);
        canvas.resolve(options.background, &mut pixels, left, width);
    }
    encode(width as u32, height as u32, &pixels)
}

fn encode(width: u32, height: u32, pixels: &[u8]) -> Result<Vec<u8>, PictureError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels)?;
    writer.finish()?;
    Ok(bytes)
}
