//! A grasp on its body: shaded surface, drawn marks, and what they mean.
//!
//! | file | subject |
//! |---|---|
//! | `viewpoint.rs` | from where it is seen |
//! | `overlay.rs` | arrows, cones and wrench over the surface of one view |
//! | `legend.rs` | the numbers and what the marks mean |

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
/// How far a centre of mass may be from that of the body to be in the picture, over its radius.
const FAR: f64 = 4.0;

/// How the picture of a grasp is to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GraspOptions {
    /// In pixels; beyond [`MIN_WIDTH`] to [`MAX_WIDTH`] the nearest of them.
    pub width: u32,
    /// [`Background::Transparent`] stands for the colours that the reader prefers; a PNG is light then.
    pub background: Background,
    pub view: Viewpoint,
    /// Whether numbers and meanings stand below; without, marks are larger, as for a thumbnail.
    pub legend: bool,
}

impl GraspOptions {
    /// How many pixels the views have.
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

/// The picture as SVG, with the shaded surface as pixels of `width` inside.
///
/// `title` is a text of any kind. Each finger is an arrow that comes from outside along the inward normal and ends in
/// its contact; its friction cone is mirrored to the outside, where it can be seen. What the body hides is faint.
/// O(triangles + pixels).
///
/// # Errors
/// None that a caller can do something about.
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

/// The same as PNG, light unless it is to be dark.
///
/// # Errors
/// None that a caller can do something about.
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

/// How high the views are in the unit of the drawing.
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
    // One that was given may be anywhere; one that is far away would leave nothing of the body.
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
    // Under a PNG the paper is there already.
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
