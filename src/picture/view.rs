//! The direction of view and the scale.

use nalgebra::{Point3, Vector3};

use graspd_core::mesh::Mesh;

/// Greatest share of the canvas that the body fills.
const FILL: f64 = 0.84;

/// An orthographic projection onto a canvas.
#[derive(Debug)]
pub(super) struct View {
    right: Vector3<f64>,
    up: Vector3<f64>,
    /// Unit vector to the viewer.
    pub(super) eye: Vector3<f64>,
    middle: Point3<f64>,
    /// Length that is mapped to one, so that numbers have the same magnitude for bodies of any size.
    unit: f64,
    /// Samples per unit.
    scale: f64,
    /// Position of the centre, in samples.
    center: [f64; 2],
}

impl View {
    /// Returns the view from the direction `eye` in which the mesh and further points fill a canvas of the given size in
    /// samples. z is up; seen from above or below, y is up. O(vertices).
    pub(super) fn of(
        mesh: &Mesh,
        beside: &[Point3<f64>],
        eye: &Vector3<f64>,
        size: [usize; 2],
    ) -> Self {
        let eye = eye.normalize();
        let right = Vector3::z().cross(&eye).try_normalize(1e-6);
        let right = right.unwrap_or_else(|| Vector3::x() * eye.z.signum());
        let [low, high] = mesh.report().bounds;
        let mut view = Self {
            right,
            up: eye.cross(&right),
            eye,
            middle: nalgebra::center(&low, &high),
            unit: (high - low).norm(),
            scale: 1.0,
            center: [0.0; 2],
        };
        let (mut least, mut greatest) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for vertex in mesh.vertices().iter().chain(beside) {
            let [x, y, _] = view.project(vertex);
            least = [least[0].min(x), least[1].min(y)];
            greatest = [greatest[0].max(x), greatest[1].max(y)];
        }
        let [width, height] = size.map(|samples| samples as f64);
        let extent = [greatest[0] - least[0], greatest[1] - least[1]];
        view.scale = FILL * (width / extent[0]).min(height / extent[1]);
        let at =
            |axis: usize, side: f64| side / 2.0 - view.scale * (least[axis] + greatest[axis]) / 2.0;
        view.center = [at(0, width), at(1, height)];
        view
    }

    /// Projects a point to the canvas: right, down, and towards the viewer, all in samples.
    pub(super) fn project(&self, point: &Point3<f64>) -> [f64; 3] {
        let [x, y, z] = self.turn(&((point - self.middle) / self.unit));
        [
            self.center[0] + self.scale * x,
            self.center[1] + self.scale * y,
            self.scale * z,
        ]
    }

    /// Projects a direction: right, down, towards the viewer.
    pub(super) fn turn(&self, direction: &Vector3<f64>) -> [f64; 3] {
        [
            self.right.dot(direction),
            -self.up.dot(direction),
            self.eye.dot(direction),
        ]
    }
}
