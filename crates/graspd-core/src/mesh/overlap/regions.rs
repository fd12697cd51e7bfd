//! The surface in regions, each of which is on one side of every other part as a whole.
//!
//! Where no other part meets a triangle, it has the same surroundings as its neighbours: to change them, the surface of
//! the other part must be crossed. So all triangles that hang together over vertices, and are met by nothing, make one
//! region. A triangle that others meet is cut along them (`cut.rs`), and every piece is a region of its own.
//!
//! The surroundings of a region are how often each other part winds about a point just above it and one just below.
//! They are asked for one point of the region: of its largest triangle, or of the piece.
//!
//! **Cost:** a winding number on each side for every region and every part whose box holds it.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use super::cut::Polygon;
use super::cut::{self, Pieces};
use super::shells::Shells;
use crate::mesh::triangle;

/// Distance of the points above and below a region, in welding tolerances: beyond a wall that touches it, which may be
/// one tolerance away, and not beyond anything else.
const STEP: f64 = 4.0;

/// What a region is made of.
#[derive(Debug)]
pub(super) enum Extent {
    /// Whole triangles that hang together; the one given is the largest.
    Patch(u32),
    /// A part of a triangle.
    Piece {
        triangle: u32,
        polygon: Polygon,
        plane: cut::Plane,
    },
}

/// How often a part winds about the points above and below a region, seen from the side to which the region faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Around {
    pub(super) part: u32,
    pub(super) above: i32,
    pub(super) below: i32,
}

#[derive(Debug)]
pub(super) struct Region {
    pub(super) part: u32,
    pub(super) extent: Extent,
    pub(super) area: f64,
    /// Of the other parts that wind about either point, in ascending order.
    pub(super) around: Vec<Around>,
    /// Of its own part.
    pub(super) own: Around,
}

/// The regions, and where each triangle belongs.
#[derive(Debug)]
pub(super) struct Regions {
    pub(super) regions: Vec<Region>,
    /// For each triangle of the parts looked at the first of its regions, else [`NONE`].
    pub(super) first: Vec<u32>,
    /// How much area lies in regions whose surroundings are uncertain, and within the tolerance of a cut, each times the
    /// distance of its plane from the reference point: three times the volume that may be wrong.
    pub(super) uncertain: f64,
}

/// The entry of a triangle that belongs to no region: degenerate, or of a part that meets no other.
pub(super) const NONE: u32 = u32::MAX;

/// Stretches along which others meet a triangle.
pub(super) type Stretches = [(u32, Option<[Point3<f64>; 2]>)];

/// Cuts the parts that are `involved` into regions. `met` has an entry for every meeting of a triangle, in ascending
/// order of the triangles, and a stretch where it is to be cut.
pub(super) fn regions(shells: &Shells<'_>, met: &Stretches, reference: &Point3<f64>) -> Regions {
    let mut first = vec![NONE; shells.triangles.len()];
    let mut regions = Vec::new();
    patches(shells, met, &mut regions, &mut first);
    let groups: Vec<&Stretches> = met.chunk_by(|a, b| a.0 == b.0).collect();
    let pieces: Vec<(u32, Pieces)> = groups
        .into_par_iter()
        .map(|group| {
            let number = group[0].0;
            let stretches: Vec<[Point3<f64>; 2]> = group.iter().filter_map(|met| met.1).collect();
            (
                number,
                cut::cut(&shells.corners(number), &stretches, shells.tolerance),
            )
        })
        .collect();
    let mut uncertain = 0.0;
    for (number, pieces) in pieces {
        let corners = shells.corners(number);
        let height = height(&corners, reference);
        uncertain += 2.0 * shells.tolerance * pieces.cut * height;
        first[number as usize] = regions.len() as u32;
        for polygon in pieces.polygons {
            let (area, _) = cut::area_and_centroid(&polygon);
            let narrow = area < STEP * shells.tolerance * cut::perimeter(&polygon);
            if narrow || !pieces.finished {
                uncertain += area * height;
            }
            let extent = Extent::Piece {
                triangle: number,
                polygon,
                plane: pieces.plane,
            };
            regions.push(region(shells.part_of[number as usize], extent, area));
        }
    }
    regions
        .par_iter_mut()
        .for_each(|region| look_around(region, shells));
    Regions {
        regions,
        first,
        uncertain,
    }
}

fn region(part: u32, extent: Extent, area: f64) -> Region {
    let own = Around {
        part,
        above: 0,
        below: 1,
    };
    Region {
        part,
        extent,
        area,
        around: Vec::new(),
        own,
    }
}

/// Distance of the plane of a triangle from a point.
pub(super) fn height(corners: &[Point3<f64>; 3], point: &Point3<f64>) -> f64 {
    triangle::normal(corners)
        .normalize()
        .dot(&(corners[0] - point))
        .abs()
}

/// Makes regions of the triangles that nothing meets, joined over vertices.
fn patches(shells: &Shells<'_>, met: &Stretches, regions: &mut Vec<Region>, first: &mut [u32]) {
    let mut root: Vec<u32> = (0..shells.vertices.len() as u32).collect();
    let mut is_met = vec![false; shells.triangles.len()];
    met.iter()
        .for_each(|(number, _)| is_met[*number as usize] = true);
    let free = || {
        let involved = shells
            .parts
            .iter()
            .enumerate()
            .filter(|(n, _)| shells.trees[*n].is_some());
        let numbers = involved.flat_map(|(_, part)| part.triangles.iter().copied());
        numbers.filter(|&n| !is_met[n as usize] && shells.is_usable(n))
    };
    for number in free() {
        let [a, b, c] = shells.triangles[number as usize];
        join(&mut root, a, b);
        join(&mut root, b, c);
    }
    let mut region_of = vec![NONE; shells.vertices.len()];
    let mut largest: Vec<f64> = Vec::new();
    for number in free() {
        let at = find(&mut root, shells.triangles[number as usize][0]) as usize;
        let area = triangle::area(&shells.corners(number));
        if region_of[at] == NONE {
            region_of[at] = regions.len() as u32;
            regions.push(region(
                shells.part_of[number as usize],
                Extent::Patch(number),
                0.0,
            ));
            largest.push(area);
        }
        let index = region_of[at] as usize;
        first[number as usize] = region_of[at];
        regions[index].area += area;
        if area > largest[index] {
            largest[index] = area;
            regions[index].extent = Extent::Patch(number);
        }
    }
}

/// The representative of an element of disjoint sets (Tarjan 1975), with paths halved on the way.
pub(in crate::mesh) fn find(root: &mut [u32], mut at: u32) -> u32 {
    while root[at as usize] != at {
        root[at as usize] = root[root[at as usize] as usize];
        at = root[at as usize];
    }
    at
}

/// Makes one set of two; its representative is the lesser of theirs.
pub(in crate::mesh) fn join(root: &mut [u32], a: u32, b: u32) {
    let (a, b) = (find(root, a), find(root, b));
    root[a.max(b) as usize] = a.min(b);
}

impl Region {
    /// The triangle that the region is a piece of, or its largest.
    pub(super) fn triangle(&self) -> u32 {
        match &self.extent {
            Extent::Patch(number)
            | Extent::Piece {
                triangle: number, ..
            } => *number,
        }
    }

    /// A point of the region, and the unit normal of its triangle.
    pub(super) fn point(&self, shells: &Shells<'_>) -> (Point3<f64>, Vector3<f64>) {
        let (number, point) = match &self.extent {
            Extent::Patch(number) => (*number, triangle::centroid(&shells.corners(*number))),
            Extent::Piece {
                triangle,
                polygon,
                plane,
            } => (*triangle, plane.point(&cut::area_and_centroid(polygon).1)),
        };
        (point, triangle::normal(&shells.corners(number)).normalize())
    }
}

fn look_around(region: &mut Region, shells: &Shells<'_>) {
    let (point, normal) = region.point(shells);
    let step = normal * (STEP * shells.tolerance);
    let [above, below] = [point + step, point - step];
    for &part in &shells.neighbours[region.part as usize] {
        let [above, below] = [&above, &below].map(|point| shells.winding(part, point));
        if above != 0 || below != 0 {
            region.around.push(Around { part, above, below });
        }
    }
    if shells.crosses_itself[region.part as usize] {
        let [above, below] = [&above, &below].map(|point| shells.winding(region.part, point));
        region.own = Around {
            part: region.part,
            above,
            below,
        };
    }
}
