//! Draws the body, its defective edges, the centre of mass and the axes.

use nalgebra::Vector3;

use super::canvas::{Canvas, Color, Ink};
use super::view::View;
use graspd_core::mesh::{DefectiveEdges, Mesh};

/// Colour of the outside of the surface.
const OUTSIDE: [f64; 3] = [226.0, 220.0, 210.0];
/// Colour of the inside of the surface, seen through a hole.
const INSIDE: [f64; 3] = [112.0, 146.0, 188.0];
/// Sine of the angle of view below which a triangle is always drawn in the colour of the outside: it is nearly edge-on, so
/// that rounding decides which side is visible, and outlines would flicker.
const EDGE_ON: f64 = 0.02;
/// Direction to the lamp: right, down, towards the viewer.
const LAMP: [f64; 3] = [-0.25, -0.8, 0.55];
/// Shares of ambient light, of light from the viewer, and of the lamp.
const LIGHT: [f64; 3] = [0.33, 0.23, 0.50];

/// Width of the line of an edge, as a share of the height of the canvas.
const EDGE_WIDTH: f64 = 0.0042;
/// Radius of the mark at the centre of mass, as a share of the height.
const MARK_RADIUS: f64 = 0.0135;
/// Length of an axis, as a share of the height.
const AXIS_LENGTH: f64 = 0.065;
/// Half the height of the letters at the axes, as a share of the height.
const LETTER: f64 = 0.0095;

/// The letters x, y and z as lines between points from −1 to 1, y down.
const LETTERS: [&[[[f64; 2]; 2]]; 3] = [
    &[[[-0.8, -1.0], [0.8, 1.0]], [[0.8, -1.0], [-0.8, 1.0]]],
    &[
        [[-0.8, -1.0], [0.0, 0.1]],
        [[0.8, -1.0], [0.0, 0.1]],
        [[0.0, 0.1], [0.0, 1.0]],
    ],
    &[
        [[-0.75, -1.0], [0.75, -1.0]],
        [[0.75, -1.0], [-0.75, 1.0]],
        [[-0.75, 1.0], [0.75, 1.0]],
    ],
];

/// Draws a mesh with its defective edges, its centre of mass and the axes of its frame.
pub(super) fn draw(canvas: &mut Canvas, view: &View, mesh: &Mesh, defects: &DefectiveEdges) {
    body(canvas, view, mesh);
    let at = |index: u32| view.project(&mesh.vertices()[index as usize]);
    let [_, height] = canvas.size().map(|side| side as f64);
    // Drawn before the edges, which may use up the budget; the layers decide what is on top.
    let [x, y, _] = view.project(&mesh.report().center_of_mass);
    mark(canvas, [x, y], (MARK_RADIUS * height).max(4.0));
    axes(canvas, view);
    let width = (EDGE_WIDTH * height).max(2.0);
    for edge in &defects.border {
        canvas.edge(edge.map(at), width, Ink::Border, Ink::HiddenBorder);
    }
    for edge in &defects.non_manifold {
        canvas.edge(
            edge.map(at),
            width,
            Ink::NonManifold,
            Ink::HiddenNonManifold,
        );
    }
}

/// Draws only the surface.
pub(super) fn body(canvas: &mut Canvas, view: &View, mesh: &Mesh) {
    let at = |index: u32| view.project(&mesh.vertices()[index as usize]);
    for &triangle in mesh.triangles() {
        let corners = triangle.map(at);
        canvas.triangle(corners, || shade(&corners));
    }
}

/// Returns the colour of a triangle by the direction that it faces.
fn shade([a, b, c]: &[[f64; 3]; 3]) -> Color {
    let [a, b, c] = [a, b, c].map(|corner| Vector3::from(*corner));
    let normal = (b - a).cross(&(c - a));
    let normal = normal.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
    // y points down here, which mirrors the winding.
    let outside = normal.z < EDGE_ON;
    let normal = if normal.z < 0.0 { -normal } else { normal };
    // The light wraps around the body, so that the shape stays visible where it faces away from the lamp.
    let lamp = (0.5 + 0.5 * normal.dot(&Vector3::from(LAMP).normalize())).powi(2);
    let light = LIGHT[0] + LIGHT[1] * normal.z + LIGHT[2] * lamp;
    let body = if outside { OUTSIDE } else { INSIDE };
    body.map(|part| (part * light).min(255.0) as u8)
}

/// Draws the symbol of a centre of mass: a disc in black and white quarters.
fn mark(canvas: &mut Canvas, at: [f64; 2], radius: f64) {
    let rim = radius * 0.8;
    canvas.disc(at, radius, |x, y| {
        if x.hypot(y) > rim || (x < 0.0) == (y < 0.0) {
            Ink::Dark
        } else {
            Ink::Light
        }
    });
}

/// Draws the axes of the mesh's frame in the lower left corner, the farthest first.
pub(super) fn axes(canvas: &mut Canvas, view: &View) {
    let [_, height] = canvas.size().map(|side| side as f64);
    let length = AXIS_LENGTH * height;
    let letter = LETTER * height;
    // The length of an axis parallel to the picture, its letter, and a margin.
    let room = length + 4.4 * letter;
    let origin = [room, height - room];
    let width = (0.3 * letter).max(2.0);
    let inks = [Ink::AxisX, Ink::AxisY, Ink::AxisZ];
    for (axis, ink) in inks.into_iter().enumerate() {
        let direction = view.turn(&Vector3::ith(axis, 1.0));
        let along = |share: f64| [0, 1].map(|n| origin[n] + direction[n] * length * share);
        canvas.stroke([origin, along(1.0)], 1.3 * width, ink);
        let flat = direction[0].hypot(direction[1]).max(0.2);
        let center = along(1.0 + 2.2 * letter / (length * flat));
        for &line in LETTERS[axis] {
            let ends = line.map(|[x, y]| [center[0] + x * letter, center[1] + y * letter]);
            canvas.stroke(ends, width, ink);
        }
    }
}
