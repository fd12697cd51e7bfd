//! Which regions of the boundary no finger can reach, since they bound a cavity that is sealed.
//!
//! A region that has a closed part around it, and is nevertheless no matter, bounds a void of that part. Where parts
//! meet, they may also seal a cavity together, as six plates do. Two regions that see each other bound the same space, and
//! a region that a ray leaves for good bounds the space around everything:
//!
//! ```text
//! for each region of the boundary, and some directions to the side that it faces:
//!     the ray ends on another region:    both bound the same space
//!     the ray meets nothing:             the region bounds the outside
//! enclosed = the regions that do not bound the outside, themselves or through others
//! ```
//!
//! Regions of a corner see each other across it, so a chain of them leads out of every bend. A cavity that opens through
//! a channel too narrow and crooked for [`RAYS`] directions from each region passes for sealed.
//!
//! **Cost:** a ray through every tree for each region and direction; only the first for regions from which it leaves.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use super::cut;
use super::regions::{Extent, NONE, Region, Regions, find, join};
use super::shells::Shells;
use crate::mesh::cover::State;
use crate::mesh::loose::direction;
use crate::mesh::triangle;

/// Directions from each point.
const RAYS: usize = 24;

/// Triangles of a patch from which rays begin.
const ORIGINS: usize = 24;

/// Distance of the origins from the surface, in welding tolerances.
const STEP: f64 = 4.0;

/// Marks the exposed regions that are sealed off.
pub(super) fn mark_enclosed(
    found: &Regions,
    shells: &Shells<'_>,
    voids: &[bool],
    met: bool,
    states: &mut [State],
) {
    let regions = &found.regions;
    for (state, region) in states.iter_mut().zip(regions) {
        let is_void = voids[region.part as usize];
        let within = region
            .around
            .iter()
            .any(|a| if is_void { a.below } else { a.above } >= 1);
        if *state == State::Exposed && within {
            *state = State::Enclosed;
        }
    }
    if !met {
        return;
    }
    let outside = regions.len() as u32;
    let mut root: Vec<u32> = (0..=outside).collect();
    // The least representative wins, so the outside is compared by its own.
    let origins = origins(found, shells);
    for ray in 0..RAYS {
        let reached: Vec<bool> = {
            let out = find(&mut root, outside);
            (0..outside).map(|n| find(&mut root, n) == out).collect()
        };
        let open: Vec<u32> = (0..outside)
            .filter(|&n| states[n as usize] == State::Exposed && !reached[n as usize])
            .collect();
        let ends: Vec<(u32, Option<u32>)> = open
            .par_iter()
            .flat_map_iter(|&n| origins[n as usize].iter().map(move |origin| (n, origin)))
            .filter_map(|(n, (point, normal))| {
                let direction = direction(normal, ray, RAYS);
                let origin = point + normal * (STEP * shells.tolerance);
                match first_region(&origin, &direction, found, shells) {
                    Some(end) if end == NONE || states[end as usize] != State::Exposed => None,
                    end => Some((n, end)),
                }
            })
            .collect();
        ends.into_iter()
            .for_each(|(n, end)| join(&mut root, n, end.unwrap_or(outside)));
    }
    let out = find(&mut root, outside);
    for (n, state) in (0..outside).zip(states) {
        if *state == State::Exposed && find(&mut root, n) != out {
            *state = State::Enclosed;
        }
    }
}

/// Points of each region with the normal there: one of a piece, several of a patch.
fn origins(found: &Regions, shells: &Shells<'_>) -> Vec<Vec<(Point3<f64>, Vector3<f64>)>> {
    let first = |region: &Region| vec![region.point(shells)];
    let mut origins: Vec<Vec<_>> = found.regions.iter().map(first).collect();
    let mut members = vec![0_usize; found.regions.len()];
    let patch = |number: usize| {
        let region = found.first[number];
        let is_patch =
            region != NONE && matches!(found.regions[region as usize].extent, Extent::Patch(_));
        is_patch.then_some(region as usize)
    };
    (0..found.first.len())
        .filter_map(patch)
        .for_each(|region| members[region] += 1);
    let mut passed = vec![0_usize; found.regions.len()];
    for number in 0..found.first.len() {
        let Some(region) = patch(number) else {
            continue;
        };
        if passed[region].is_multiple_of(members[region].div_ceil(ORIGINS)) {
            let corners = shells.corners(number as u32);
            let normal = triangle::normal(&corners).normalize();
            origins[region].push((triangle::centroid(&corners), normal));
        }
        passed[region] += 1;
    }
    origins
}

/// The region on which a ray ends, [`NONE`] for a triangle without one; `None` when it meets nothing.
fn first_region(
    origin: &Point3<f64>,
    direction: &Vector3<f64>,
    found: &Regions,
    shells: &Shells<'_>,
) -> Option<u32> {
    let mut first: Option<(u32, f64)> = None;
    for tree in shells.trees.iter().flatten() {
        let limit = first.map_or(f64::MAX, |(_, at)| at);
        first = tree.first_hit(origin, direction, limit).or(first);
    }
    let (number, at) = first?;
    let region = found.first[number as usize];
    let pieces = found.regions.iter().enumerate().skip(region as usize);
    let pieces = pieces.take_while(
        |(_, r)| matches!(r.extent, Extent::Piece { triangle, .. } if triangle == number),
    );
    let point = origin + direction * at;
    let holds = |region: &Region| match &region.extent {
        Extent::Piece { polygon, plane, .. } => cut::inside(polygon, &plane.flat(&point)),
        Extent::Patch(_) => f64::INFINITY,
    };
    let best = pieces.max_by(|a, b| holds(a.1).total_cmp(&holds(b.1)));
    Some(best.map_or(region, |(n, _)| n as u32))
}
