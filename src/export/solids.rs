//! The marks of a grasp as triangles: arrows, cones, spheres and bent arrows. All but the bent arrow are
//! solids of revolution.

use std::f64::consts::{PI, TAU};

use nalgebra::{Point3, Rotation3, Unit, UnitVector3, Vector3};

use crate::picture::marks::perpendicular;

/// Sides of the polygon that stands for a circle.
const SIDES: usize = 24;
/// Pieces of a semicircle.
const ARCS: usize = 12;
/// The angle that a bent arrow covers.
const BEND: f64 = 1.5 * PI;

/// Triangles around the point that they mark.
#[derive(Debug, Default)]
pub(super) struct Solid {
    pub vertices: Vec<Point3<f64>>,
    pub triangles: Vec<[u32; 3]>,
}

/// Returns a straight arrow along `axis` that ends in the origin.
pub(super) fn arrow(axis: &UnitVector3<f64>, length: f64, radius: f64) -> Solid {
    let head = (6.0 * radius).min(0.5 * length);
    let mut solid = Solid::default();
    solid.revolve(
        axis,
        &[
            (-length, 0.0),
            (-length, radius),
            (-head, radius),
            (-head, 2.6 * radius),
            (0.0, 0.0),
        ],
    );
    solid
}

/// Returns a cone with its apex in the origin that opens along `axis`; `tangent` is that of half the
/// angle at the apex.
pub(super) fn cone(axis: &UnitVector3<f64>, height: f64, tangent: f64) -> Solid {
    let mut solid = Solid::default();
    solid.revolve(axis, &[(0.0, 0.0), (height, height * tangent)]);
    solid
}

/// Returns a sphere about the origin.
pub(super) fn sphere(radius: f64) -> Solid {
    let profile: Vec<(f64, f64)> = (0..=ARCS)
        .map(|step| PI * step as f64 / ARCS as f64)
        .map(|angle| (-radius * angle.cos(), radius * angle.sin()))
        .collect();
    let mut solid = Solid::default();
    solid.revolve(&Vector3::z_axis(), &profile);
    solid
}

/// Returns an arrow that goes three quarters round `axis`, in the sense of a right-handed torque.
pub(super) fn bent_arrow(axis: &UnitVector3<f64>, radius: f64, thickness: f64) -> Solid {
    let across = perpendicular(axis);
    let mut solid = Solid::default();
    let head = 6.0 * thickness;
    let shaft_end = BEND - head / radius;
    let at = |angle: f64| Rotation3::from_axis_angle(axis, angle) * across.into_inner();
    let steps = 3 * ARCS;
    let mut rings = Vec::new();
    for step in 0..=steps {
        let out = at(shaft_end * step as f64 / steps as f64);
        rings.push(solid.ring(&Point3::from(out * radius), axis, &out, thickness));
    }
    let start = solid.point(Point3::from(across.into_inner() * radius));
    for (a, b) in sides() {
        solid.triangles.push([rings[0] + b, rings[0] + a, start]);
    }
    // The head is straight.
    let out = at(shaft_end);
    let base = Point3::from(out * radius);
    let along = Unit::new_normalize(axis.cross(&out));
    let rim = solid.ring(&base, axis, &out, 2.6 * thickness);
    rings.push(rim);
    for pair in rings.windows(2) {
        solid.bridge(pair[0], pair[1]);
    }
    let tip = solid.point(base + along.into_inner() * head);
    for (a, b) in sides() {
        solid.triangles.push([rim + a, rim + b, tip]);
    }
    solid
}

impl Solid {
    /// Revolves a profile about `axis`: points, each by its distance along the axis and from it.
    fn revolve(&mut self, axis: &UnitVector3<f64>, profile: &[(f64, f64)]) {
        let across = perpendicular(axis);
        let beyond = Unit::new_unchecked(axis.cross(&across));
        let mut before: Option<(u32, bool)> = None;
        for &(along, radius) in profile {
            let middle = Point3::from(axis.into_inner() * along);
            // The computed sine of π is not quite zero.
            let is_point = radius < 1e-9 * along.abs().max(1e-300);
            let number = match is_point {
                true => self.point(middle),
                false => self.ring(&middle, &across, &beyond, radius),
            };
            match (before, is_point) {
                (Some((apex, true)), false) => {
                    for (a, b) in sides() {
                        self.triangles.push([apex, number + b, number + a]);
                    }
                }
                (Some((ring, false)), true) => {
                    for (a, b) in sides() {
                        self.triangles.push([ring + a, ring + b, number]);
                    }
                }
                (Some((ring, false)), false) => self.bridge(ring, number),
                (Some((_, true)), true) | (None, _) => {}
            }
            before = Some((number, is_point));
        }
    }

    /// Adds a vertex and returns its number.
    fn point(&mut self, at: Point3<f64>) -> u32 {
        self.vertices.push(at);
        self.vertices.len() as u32 - 1
    }

    /// Adds a circle of vertices and returns the number of the first.
    fn ring(
        &mut self,
        middle: &Point3<f64>,
        across: &Vector3<f64>,
        beyond: &Vector3<f64>,
        radius: f64,
    ) -> u32 {
        let first = self.vertices.len() as u32;
        for side in 0..SIDES {
            let (sine, cosine) = (TAU * side as f64 / SIDES as f64).sin_cos();
            self.vertices
                .push(middle + (across * cosine + beyond * sine) * radius);
        }
        first
    }

    /// Joins two rings by triangles.
    fn bridge(&mut self, from: u32, to: u32) {
        for (a, b) in sides() {
            self.triangles.push([from + a, from + b, to + b]);
            self.triangles.push([from + a, to + b, to + a]);
        }
    }
}

/// The sides of a ring, each by its two corners.
fn sides() -> impl Iterator<Item = (u32, u32)> {
    let count = SIDES as u32;
    (0..count).map(move |side| (side, (side + 1) % count))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By the divergence theorem; positive when wound outwards.
    fn volume(solid: &Solid) -> f64 {
        let corners = |t: &[u32; 3]| t.map(|n| solid.vertices[n as usize].coords);
        let triangles = solid.triangles.iter().map(corners);
        triangles.map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0).sum()
    }

    /// Whether each edge of a triangle belongs to exactly one other, in the opposite direction.
    fn is_beside_its_twin(solid: &Solid, [a, b, c]: &[u32; 3]) -> bool {
        let has = |from: &u32, to: &u32| {
            let edges = solid.triangles.iter();
            let edges = edges.flat_map(|[a, b, c]| [(a, b), (b, c), (c, a)]);
            edges.filter(|edge| *edge == (from, to)).count() == 1
        };
        [(a, b), (b, c), (c, a)]
            .iter()
            .all(|(from, to)| has(from, to) && has(to, from))
    }

    #[test]
    fn solids_are_where_and_as_large_as_they_should_be() {
        let axis = Unit::new_normalize(Vector3::new(1.0, -2.0, 0.5));
        let sphere = volume(&sphere(2.0));
        assert!(
            (sphere / (4.0 / 3.0 * PI * 8.0) - 1.0).abs() < 0.03,
            "{sphere}"
        );
        let arrow = arrow(&axis, 1.0, 0.01);
        assert!(volume(&arrow) > 0.0);
        let along = |p: &Point3<f64>| p.coords.dot(&axis);
        let ends = arrow.vertices.iter().map(along);
        let (low, high) = ends.fold((0.0_f64, -1.0_f64), |(l, h), x| (l.min(x), h.max(x)));
        assert!((low + 1.0).abs() < 1e-12 && high.abs() < 1e-12);
        for vertex in &cone(&axis, 3.0, 0.5).vertices {
            let height = along(vertex);
            let radius = (vertex.coords - axis.into_inner() * height).norm();
            assert!((radius - 0.5 * height).abs() < 1e-12 && height < 3.0 + 1e-12);
        }
    }

    #[test]
    fn a_bent_arrow_turns_right_handed() {
        let axis = Vector3::z_axis();
        let bent = bent_arrow(&axis, 1.0, 0.02);
        // From its start over a quarter turn.
        let start = perpendicular(&axis);
        let quarter = axis.cross(&start);
        let reaches = |direction: &Vector3<f64>| {
            let reach = bent.vertices.iter().map(|v| v.coords.dot(direction));
            reach.fold(f64::NEG_INFINITY, f64::max)
        };
        assert!(reaches(&quarter) > 0.99 && reaches(&-start.into_inner()) > 0.99);
        let tip = bent.vertices.last().unwrap();
        assert!(tip.coords.dot(&-quarter) > 0.9, "{tip}");
        // A torus of three quarters, and a cone.
        let shaft = PI * 0.02_f64.powi(2) * (BEND - 0.12);
        let head = PI * (2.6 * 0.02_f64).powi(2) * 0.12 / 3.0;
        let volume = volume(&bent);
        assert!((volume / (shaft + head) - 1.0).abs() < 0.03, "{volume}");
        for corners in &bent.triangles {
            assert!(is_beside_its_twin(&bent, corners), "{corners:?}");
        }
    }
}
