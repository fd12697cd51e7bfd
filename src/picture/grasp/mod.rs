//! A picture of a grasp on its body: shaded surface, marks, and a legend.
//!
//! | file | subject |
//! |---|---|
//! | `viewpoint.rs` | the directions of view |
//! | `overlay.rs` | arrows, cones and wrench over the surface of one view |
//! | `legend.rs` | the numbers and the meaning of the marks |

mod legend;
mod overlay;
#[cfg(test)]
mod tests;
mod viewpoint;

pub use viewpoint::Viewpoint;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use nalgebra::Point3;

use self::overlay::Overlay;
use super::canvas::Canvas;
use super::raster::{self, Under};
use super::text::escape;
use super::view::View;
use super::{Background, MAX_WIDTH, MIN_WIDTH, PictureError, encode, scene};
use crate::wire::{ChosenGrasp, PlanResult};
use graspd_core::mesh::Mesh;

/// Width of the drawing in its own unit.
const WIDTH: f64 = 1024.0;
/// Greatest distance, in radii of the body, at which a given centre of mass is still included in the picture.
const FAR: f64 = 4.0;

/// The options of a picture of a grasp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GraspOptions {
    /// Width in pixels, clamped to [`MIN_WIDTH`] to [`MAX_WIDTH`].
    pub width: u32,
    /// With [`Background::Transparent`] an SVG has the colours that the viewer prefers; a PNG is light.
    pub background: Background,
    pub view: Viewpoint,
    /// Whether there is a legend below. Without it, marks are larger, as for a thumbnail.
    pub legend: bool,
}

impl GraspOptions {
    /// Size of the views in pixels.
    pub fn pixels(&self) -> u64 {
        let width = f64::from(self.width);
        (width * width * panel_height(self.view) / WIDTH) as u64
    }
}

/// The surface of all views, and the marks over it.
struct Drawn {
    pixels: Vec<u8>,
    size: [u32; 2],
    marks: String,
}

/// Draws the picture as SVG, which contains the shaded surface as an image.
///
/// `title` may be any text. Each finger is an arrow that comes from outside along the inward normal and ends in
/// its contact; its friction cone is mirrored to the outside, where it can be seen. Marks that the body hides are faint.
/// O(triangles + pixels).
///
/// # Errors
/// Only faults that the caller cannot remedy.
pub fn grasp_svg(
    mesh: &Mesh,
    result: &PlanResult,
    grasp: &ChosenGrasp<'_>,
    title: &str,
    options: &GraspOptions,
) -> Result<String, PictureError> {
    let drawn = draw(mesh, result, grasp, options);
    let [width, height] = drawn.size;
    let png = encode(width, height, &drawn.pixels)?;
    let image = format!(
        "<image width=\"{WIDTH}\" height=\"{}\" href=\"data:image/png;base64,{}\"/>\n",
        panel_height(options.view),
        STANDARD.encode(png)
    );
    Ok(compose(result, grasp, title, options, &image, &drawn.marks))
}

/// The same picture as a PNG, light unless the background is dark.
///
/// # Errors
/// Only faults that the caller cannot remedy.
pub fn grasp_png(
    mesh: &Mesh,
    result: &PlanResult,
    grasp: &ChosenGrasp<'_>,
    title: &str,
    options: &GraspOptions,
) -> Result<Vec<u8>, PictureError> {
    let background = options.background.opaque();
    let options = &GraspOptions {
        background,
        ..*options
    };
    let Drawn {
        pixels,
        size,
        marks,
    } = draw(mesh, result, grasp, options);
    let svg = compose(result, grasp, title, options, "", &marks);
    let under = Under { pixels, size };
    raster::png(&svg, size[0], background.paper(), Some(under))
}

/// Height of the views in the unit of the drawing.
fn panel_height(view: Viewpoint) -> f64 {
    match view {
        Viewpoint::Both => WIDTH / 2.0,
        _ => WIDTH * 0.75,
    }
}

fn draw(
    mesh: &Mesh,
    result: &PlanResult,
    grasp: &ChosenGrasp<'_>,
    options: &GraspOptions,
) -> Drawn {
    let width = options.width.clamp(MIN_WIDTH, MAX_WIDTH) as usize;
    let height = (width as f64 * panel_height(options.view) / WIDTH).round() as usize;
    let eyes = options.view.eyes();
    let radius = mesh.radius_about(&mesh.report().center_of_mass);
    let mut beside: Vec<Point3<f64>> = overlay::tails(grasp, radius).collect();
    // A given centre of mass may be anywhere; with one far away the body would shrink to nothing.
    let center = Point3::from(result.center_of_mass);
    if (center - mesh.report().center_of_mass).norm() < FAR * radius {
        beside.push(center);
    }
    let mut pixels = vec![0; 4 * width * height];
    let mut marks = String::new();
    let mut left = 0;
    for (index, eye) in eyes.iter().enumerate() {
        let right = width * (index + 1) / eyes.len();
        let mut canvas = Canvas::new(right - left, height);
        let view = View::of(mesh, &beside, eye, canvas.size());
        scene::body(&mut canvas, &view, mesh);
        if options.legend {
            scene::axes(&mut canvas, &view);
        }
        canvas.resolve(Background::Transparent, &mut pixels, left, width);
        let unit = WIDTH / width as f64;
        let size = if options.legend { 1.0 } else { 2.2 } * if eyes.len() == 1 { 1.4 } else { 1.0 };
        let overlay = Overlay::new(&view, &canvas, unit, left as f64 * unit, size);
        let drawn = overlay.draw(result, grasp, radius, options.legend);
        let clip = format!(
            "<clipPath id=\"view{index}\"><rect x=\"{}\" width=\"{}\" height=\"{}\"/></clipPath>\n\
             <g clip-path=\"url(#view{index})\">\n{drawn}</g>\n",
            left as f64 * unit,
            (right - left) as f64 * unit,
            panel_height(options.view),
        );
        marks.push_str(&clip);
        left = right;
    }
    Drawn {
        pixels,
        size: [width as u32, height as u32],
        marks,
    }
}

/// The drawing: paper, surface, marks, legend.
fn compose(
    result: &PlanResult,
    grasp: &ChosenGrasp<'_>,
    title: &str,
    options: &GraspOptions,
    image: &str,
    marks: &str,
) -> String {
    let top = panel_height(options.view);
    let (legend, height) = match options.legend {
        true => legend::draw(result, grasp, title, top),
        false => (String::new(), top),
    };
    // A PNG already has its background.
    let paper = match image.is_empty() {
        true => "",
        false => "<rect class=\"paper\" width=\"100%\" height=\"100%\"/>\n",
    };
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" width=\"{WIDTH}\" \
         height=\"{height}\" role=\"img\" font-family=\"DejaVu Sans,system-ui,sans-serif\" font-size=\"14\">\n\
         <style>{}</style>\n<title>{}</title>\n{paper}{image}{marks}{legend}</svg>\n",
        options.background.style(),
        escape(title),
    )
}
