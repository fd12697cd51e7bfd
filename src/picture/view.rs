//! Where the eye is and what scale fits.

use nalgebra::{Point3, Vector3};

use graspd_core::mesh::Mesh;

/// Share of the canvas that the body fills at most.
const FILL: f64 = 0.84;

/// An orthographic projection onto a canvas.
#[derive(Debug)]
pub(super) struct View {
    right: Vector3<f64>,
    up: Vector3<f64>,
    /// Unit vector to the eye.
    pub(super) eye: Vector3<f64>,
    middle: Point3<f64>,
    /// Length that becomes one, so that bodies of any size have numbers of the same size.
    unit: f64,
    /// Samples per unit.
    scale: f64,
    /// Where the middle comes to be, in samples.
    center: [f64; 2],
}

impl View {
    /// The view from the direction `eye` in which the mesh, and points beside it, fill a canvas of so many
    /// samples. z is up or, seen from above or below, y. O(vertices).
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

    /// Where a point is on the canvas: to the right, down, and towards the eye, all in samples.
    pub(super) fn project(&self, point: &Point3<f64>) -> [f64; 3] {
        let [x, y, z] = self.turn(&((point - self.middle) / self.unit));
        [
            self.center[0] + self.scale * x,
            self.center[1] + self.scale * y,
            self.scale * z,
        ]
    }

    /// A direction as seen: to the right, down, towards the eye.
    pub(super) fn turn(&self, direction: &Vector3<f64>) -> [f64; 3] {
        [
            self.right.dot(direction),
            -self.up.dot(direction),
            self.eye.dot(direction),
        ]
    }
}
