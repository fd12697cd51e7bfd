//! Unions of convex polyhedra: what they contain, and their volume and centre of mass by an integral over lines.

use nalgebra::{Point3, Rotation3, Vector3};

use crate::mesh::{RawMesh, triangle};

/// A solid and the convex bodies that make it up.
#[derive(Clone)]
pub(super) struct Solid {
    pub raw: RawMesh,
    pub convex: Vec<Convex>,
}

/// Half-spaces by outward normal and offset.
pub(super) type Convex = Vec<(Vector3<f64>, f64)>;

pub(super) fn half_spaces(raw: &RawMesh) -> Convex {
    let planes = raw.triangles.iter().map(|&indices| {
        let corners = triangle::corners(&raw.vertices, indices);
        let normal = triangle::normal(&corners).normalize();
        (normal, normal.dot(&corners[0].coords))
    });
    planes.collect()
}

pub(super) fn convex(raw: RawMesh) -> Solid {
    Solid {
        convex: vec![half_spaces(&raw)],
        raw,
    }
}

impl Solid {
    pub(super) fn placed(mut self, turn: Rotation3<f64>, by: [f64; 3]) -> Self {
        let by = Vector3::from(by);
        self.raw
            .vertices
            .iter_mut()
            .for_each(|v| *v = turn * *v + by);
        for (normal, offset) in self.convex.iter_mut().flatten() {
            *normal = turn * *normal;
            *offset += normal.dot(&by);
        }
        self
    }

    pub(super) fn at(self, by: [f64; 3]) -> Self {
        self.placed(Rotation3::identity(), by)
    }
}

pub(super) fn contains(solids: &[Solid], point: &Point3<f64>) -> bool {
    let convex = solids.iter().flat_map(|solid| &solid.convex);
    let inside = |planes: &Convex| planes.iter().all(|(n, d)| n.dot(&point.coords) <= *d);
    convex.into_iter().any(inside)
}

/// Distance that a step may take a point past a surface nearby: how far the union's membership is unsure.
pub(super) fn near_surface(solids: &[Solid], point: &Point3<f64>, within: f64) -> bool {
    let offsets = [-within, within];
    let all = offsets
        .iter()
        .flat_map(|&x| offsets.iter().map(move |&y| (x, y)));
    let corners = all.flat_map(|(x, y)| offsets.iter().map(move |&z| Vector3::new(x, y, z)));
    let here = contains(solids, point);
    corners
        .into_iter()
        .any(|by| contains(solids, &(point + by)) != here)
}

/// Volume and centre of mass by the midpoint rule over lines along z.
pub(super) fn by_lines(
    solids: &[Solid],
    [low, high]: &[Point3<f64>; 2],
    lines: usize,
) -> (f64, Point3<f64>) {
    let size = high - low;
    let (dx, dy) = (size.x / lines as f64, size.y / lines as f64);
    let (mut volume, mut moment) = (0.0, Vector3::zeros());
    for i in 0..lines {
        for j in 0..lines {
            let x = low.x + (i as f64 + 0.5) * dx;
            let y = low.y + (j as f64 + 0.5) * dy;
            let mut intervals: Vec<[f64; 2]> = Vec::new();
            for planes in solids.iter().flat_map(|solid| &solid.convex) {
                let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
                for (n, d) in planes {
                    let left = d - n.x * x - n.y * y;
                    if n.z > 0.0 {
                        to = to.min(left / n.z);
                    } else if n.z < 0.0 {
                        from = from.max(left / n.z);
                    } else if left < 0.0 {
                        to = f64::NEG_INFINITY;
                    }
                }
                if from < to {
                    intervals.push([from, to]);
                }
            }
            intervals.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let mut reached = f64::NEG_INFINITY;
            for [from, to] in intervals {
                let from = from.max(reached);
                if to > from {
                    let length = (to - from) * dx * dy;
                    volume += length;
                    moment += Vector3::new(x, y, (from + to) / 2.0) * length;
                    reached = to;
                }
            }
        }
    }
    (volume, Point3::from(moment / volume))
}
