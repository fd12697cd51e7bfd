//! Small solids made by code, for examples and tests.

use std::f64::consts::{PI, TAU};

use nalgebra::{Point3, Vector3};

use super::RawMesh;

/// An axis-aligned box from `low` to `high`, wound outward, 12 triangles.
pub fn cuboid(low: [f64; 3], high: [f64; 3]) -> RawMesh {
    let vertices = (0..8)
        .map(|n| {
            let pick = |axis: usize| if n >> axis & 1 == 0 { low } else { high }[axis];
            Point3::new(pick(0), pick(1), pick(2))
        })
        .collect();
    let quads = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let triangles = quads
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    RawMesh {
        vertices,
        triangles,
        ..RawMesh::default()
    }
}

/// A cube with one corner at the origin and the others at positive coordinates.
pub fn cube(side: f64) -> RawMesh {
    cuboid([0.0; 3], [side; 3])
}

/// The corner of the unit cube at the origin: volume 1/6, centre of mass (1/4, 1/4, 1/4).
pub fn tetrahedron() -> RawMesh {
    RawMesh {
        vertices: vec![
            Point3::origin(),
            Point3::new(1.0, 0.0, 0.0),
            Point3::new(0.0, 1.0, 0.0),
            Point3::new(0.0, 0.0, 1.0),
        ],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        ..RawMesh::default()
    }
}

/// A ball about the origin, cut along meridians and parallels.
pub fn sphere(radius: f64, rings: u32, segments: u32) -> RawMesh {
    let mut vertices = vec![Point3::new(0.0, 0.0, radius)];
    for ring in 1..rings {
        let polar = PI * f64::from(ring) / f64::from(rings);
        for segment in 0..segments {
            let around = TAU * f64::from(segment) / f64::from(segments);
            vertices.push(Point3::new(
                radius * polar.sin() * around.cos(),
                radius * polar.sin() * around.sin(),
                radius * polar.cos(),
            ));
        }
    }
    vertices.push(Point3::new(0.0, 0.0, -radius));
    let last = vertices.len() as u32 - 1;
    let at = |ring: u32, segment: u32| match ring {
        0 => 0,
        _ if ring == rings => last,
        _ => 1 + (ring - 1) * segments + segment % segments,
    };
    let mut triangles = Vec::new();
    for ring in 0..rings {
        for segment in 0..segments {
            let (a, b) = (at(ring, segment), at(ring + 1, segment));
            let (c, d) = (at(ring + 1, segment + 1), at(ring, segment + 1));
            if ring + 1 < rings {
                triangles.push([a, b, c]);
            }
            if ring > 0 {
                triangles.push([a, c, d]);
            }
        }
    }
    RawMesh {
        vertices,
        triangles,
        ..RawMesh::default()
    }
}

/// A ring about the z axis: `major` is the distance of its core from the axis, `minor` the radius of its section.
pub fn torus(major: f64, minor: f64, around: u32, across: u32) -> RawMesh {
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..around {
        for j in 0..across {
            let u = TAU * f64::from(i) / f64::from(around);
            let v = TAU * f64::from(j) / f64::from(across);
            let r = major + minor * v.cos();
            vertices.push(Point3::new(r * u.cos(), r * u.sin(), minor * v.sin()));
            let at = |i: u32, j: u32| (i % around) * across + j % across;
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    RawMesh {
        vertices,
        triangles,
        ..RawMesh::default()
    }
}

/// A square rod of side 10 that turns about the z axis, its inner side from 20 to 25 away, between z = 0 and 10. With more
/// than one turn it runs through itself.
pub fn spiral(turns: f64) -> RawMesh {
    let sections = 60_u32;
    let mut raw = cuboid([0.0; 3], [1.0; 3]);
    raw.vertices.clear();
    raw.triangles.clear();
    for n in 0..=sections {
        let share = f64::from(n) / f64::from(sections);
        let (sin, cos) = (TAU * turns * share).sin_cos();
        for (out, up) in [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)] {
            let radius = 20.0 + 5.0 * share + out;
            raw.vertices
                .push(Point3::new(radius * cos, radius * sin, up));
        }
    }
    for n in 0..sections {
        for side in 0..4 {
            let (a, b) = (4 * n + side, 4 * n + (side + 1) % 4);
            raw.triangles.extend([[a, b, b + 4], [a, b + 4, a + 4]]);
        }
    }
    let last = 4 * sections;
    raw.triangles.extend([
        [0, 2, 1],
        [0, 3, 2],
        [last, last + 1, last + 2],
        [last, last + 2, last + 3],
    ]);
    flipped(&raw)
}

/// A prism of height 1 over an L of three unit squares: volume 3, not convex.
pub fn l_shape() -> RawMesh {
    let outline = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)];
    let vertices = [0.0, 1.0]
        .iter()
        .flat_map(|&z| outline.map(|(x, y)| Point3::new(f64::from(x), f64::from(y), z)))
        .collect();
    let mut triangles = Vec::new();
    for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]] {
        triangles.extend([[a, c, b], [a + 6, b + 6, c + 6]]);
    }
    for i in 0..6 {
        let j = (i + 1) % 6;
        triangles.extend([[i, j, j + 6], [i, j + 6, i + 6]]);
    }
    RawMesh {
        vertices,
        triangles,
        ..RawMesh::default()
    }
}

/// A cube of side 3 about the origin with a cubic cavity of side 1: volume 26.
pub fn hollow_cube() -> RawMesh {
    join(&[
        cuboid([-1.5; 3], [1.5; 3]),
        flipped(&cuboid([-0.5; 3], [0.5; 3])),
    ])
}

/// A fan of triangles between a far point and the pairs of neighbours in a row of points `step` apart.
pub fn strip(count: u32, step: f64) -> RawMesh {
    let row = (0..count).map(|n| Point3::new(f64::from(n) * step, 0.0, 0.0));
    RawMesh {
        vertices: row.chain([Point3::new(0.0, 1.0, 0.0)]).collect(),
        triangles: (1..count).map(|n| [n - 1, n, count]).collect(),
        ..RawMesh::default()
    }
}

/// Several meshes as one; they share no vertices.
pub fn join(parts: &[RawMesh]) -> RawMesh {
    let mut all = RawMesh {
        vertices: Vec::new(),
        triangles: Vec::new(),
        ..RawMesh::default()
    };
    for part in parts {
        let offset = all.vertices.len() as u32;
        all.vertices.extend(&part.vertices);
        all.triangles
            .extend(part.triangles.iter().map(|t| t.map(|index| index + offset)));
    }
    all
}

/// The mesh with every winding reversed.
pub fn flipped(raw: &RawMesh) -> RawMesh {
    flipped_where(raw, |_| true)
}

/// The mesh with the winding of those triangles reversed for whose index `which` holds.
pub fn flipped_where(raw: &RawMesh, which: impl Fn(usize) -> bool) -> RawMesh {
    let mut raw = raw.clone();
    for (n, triangle) in raw.triangles.iter_mut().enumerate() {
        if which(n) {
            triangle.swap(0, 1);
        }
    }
    raw
}

/// The mesh moved by a vector.
pub fn moved(raw: &RawMesh, by: [f64; 3]) -> RawMesh {
    let mut raw = raw.clone();
    raw.vertices
        .iter_mut()
        .for_each(|v| *v += Vector3::from(by));
    raw
}

/// The mesh without shared vertices, as STL has it.
pub fn soup(raw: &RawMesh) -> RawMesh {
    RawMesh {
        vertices: raw
            .triangles
            .iter()
            .flatten()
            .map(|&index| raw.vertices[index as usize])
            .collect(),
        triangles: (0..raw.triangles.len() as u32)
            .map(|n| [3 * n, 3 * n + 1, 3 * n + 2])
            .collect(),
        ..RawMesh::default()
    }
}
