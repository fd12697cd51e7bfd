//! What a prepared mesh and a grasp on it look like, and how a search came along.
//!
//! | file | subject |
//! |---|---|
//! | `canvas.rs` | triangles and strokes into samples, with depth; samples into pixels |
//! | `view.rs` | where the eye is and what scale fits |
//! | `scene.rs` | what is drawn: body, defective edges, centre of mass, axes |
//! | `sheet.rs` | the picture of a mesh above the figures, as SVG |
//! | `paper.rs`, `colors.rs` | what is drawn on, and the colours of what is written there; colours of marks |
//! | `marks.rs` | how large the marks of a grasp are |
//! | `text.rs` | numbers, and texts of anyone |
//! | `grasp/` | a grasp on its body, as SVG and PNG |
//! | `convergence.rs` | quality over generations, likewise |
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
/// Width in pixels of a picture of which nobody said how wide.
pub const DEFAULT_WIDTH: u32 = 1024;

/// Where the eye is in the left view: in front of the body (−y), to its right (+x), above it (+z).
/// The right view is from the opposite side, so every face of a box is in one of them.
const EYE: Vector3<f64> = Vector3::new(0.62, -1.0, 0.62);

/// How a picture is to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// In pixels; beyond [`MIN_WIDTH`] to [`MAX_WIDTH`] the nearest of them. The height is half of it.
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

/// Why there is no picture: a bug, or no memory.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    #[error("the picture cannot be encoded: {0}")]
    Encoding(#[from] png::EncodingError),
    #[error("the drawing cannot be read: {0}")]
    Drawing(#[from] resvg::usvg::Error),
    #[error("there is no memory for the pixels")]
    Memory,
}

/// A PNG of the mesh in two opposite orthographic views, z up: from the front, right and above, and from
/// the back, left and below.
///
/// Flat shading with light beside the eye; triangles of some size have lines around them, and the inside of
/// the surface is bluish. Border edges are red, non-manifold ones magenta, thin and faint where the body
/// hides them. The centre of mass is the disc in black and white quarters, drawn over everything.
///
/// O(triangles + pixels), in at most about 8 bytes a sample, four samples a pixel, of half the picture. A
/// thicket of large triangles, more than some hundred of them behind each other everywhere, is completed with
/// a point for each triangle that is left.
///
/// # Errors
/// None that a caller can do something about.
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
