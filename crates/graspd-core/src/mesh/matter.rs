//! What of a surface bounds matter.
//!
//! ```text
//! close the surface: as it is, or by caps over its holes if these are small; else it is a shell, and bounds nothing
//! compare its closed parts                                                    (see overlap)
//! reverse the parts that bound voids
//! group the parts that touch, cross or nest into bodies
//! ```
//!
//! A part that lies in a cavity of another belongs to the same body: it cannot leave.
//!
//! **Cost:** that of the comparison; for a single closed part, of the lines that `probe.rs` lays through it.

use nalgebra::Point3;

use super::caps::Caps;
use super::cover::Cover;
use super::mass::{Bounded, Extent};
use super::orient::{self, Orientation};
use super::overlap::{self, Moments, Outcome, Overlap};
use super::parts::{Part, Parts};
use super::tree::Bounds;
use super::{bodies, mass, probe};

/// The surface that is weighed, and what was found about it.
#[derive(Debug)]
pub(super) struct Matter {
    /// The caps over all holes of an open surface; `None` when it is closed or has no inside.
    pub(super) caps: Option<Caps>,
    /// Whether the surface, with its caps if it has any, bounds a solid.
    pub(super) is_solid: bool,
    pub(super) cover: Cover,
    /// How many parts have matter in common with another.
    pub(super) overlapping_parts: usize,
    /// The moments of the union, where parts overlap.
    pub(super) union: Option<Moments>,
    /// Whether there were too many parts to compare.
    pub(super) unexamined: bool,
    /// For each triangle its body.
    pub(super) body_of: Vec<u32>,
    /// The parts of the surface without caps.
    pub(super) parts: Vec<Part>,
}

/// Examines a surface whose parts are wound outward, and reverses those that bound voids. `before` are its triangles as
/// the file has them.
pub(super) fn examine(
    vertices: &[Point3<f64>],
    triangles: &mut [[u32; 3]],
    before: &[[u32; 3]],
    orientation: Orientation,
    extent: &Extent,
    tolerance: f64,
) -> Matter {
    let count = triangles.len();
    let caps = match orientation.closed {
        true => None,
        false => Caps::of(vertices, triangles),
    };
    let small = caps
        .as_ref()
        .filter(|caps| mass::are_small(caps, vertices, triangles));
    let mut matter = Matter {
        is_solid: orientation.closed || small.is_some(),
        cover: Cover::default(),
        overlapping_parts: 0,
        union: None,
        unexamined: false,
        body_of: Vec::new(),
        parts: orientation.parts,
        caps: None,
    };
    match small {
        None => matter.compare(vertices, triangles, before, extent, tolerance),
        // One part with caps has nothing to be compared with.
        Some(_) if matter.parts.len() == 1 => {}
        Some(small) => {
            let (all, mut capped) = small.applied(vertices, triangles);
            let mut closed = Parts::of(&all, &capped);
            let turned = capped
                .iter_mut()
                .zip(&closed.turned)
                .filter(|(_, turned)| **turned);
            turned.for_each(|(corners, _)| corners.swap(1, 2));
            let said = orient::said(&all, &capped, &[], &closed.parts, &extent.center);
            for (part, said) in closed.parts.iter().zip(said) {
                if part.closed && said.volume < 0.0 {
                    orient::reverse(part, &mut capped);
                }
            }
            std::mem::swap(&mut matter.parts, &mut closed.parts);
            matter.compare(&all, &mut capped, before, extent, tolerance);
            triangles.copy_from_slice(&capped[..count]);
            matter.body_of.truncate(count);
            matter.parts = closed.parts;
        }
    }
    // Caps follow the winding of the surface.
    matter.caps = match orientation.closed {
        true => None,
        false => Caps::of(vertices, triangles),
    };
    matter
}

impl Matter {
    /// What is to be weighed.
    pub(super) fn bounded(&self) -> Bounded<'_> {
        Bounded {
            is_solid: self.is_solid,
            caps: self.caps.as_ref(),
            union: self.union.as_ref(),
        }
    }

    fn compare(
        &mut self,
        vertices: &[Point3<f64>],
        triangles: &mut [[u32; 3]],
        before: &[[u32; 3]],
        extent: &Extent,
        tolerance: f64,
    ) {
        let center = &extent.center;
        let bounds = Bounds {
            low: extent.low,
            high: extent.high,
        };
        let parts = &self.parts;
        let twice = probe::crosses_itself(vertices, triangles, parts, &bounds, tolerance);
        let said = orient::said(vertices, triangles, before, parts, center);
        let compared =
            overlap::compare(vertices, triangles, parts, twice, &said, center, tolerance);
        let joined = match compared {
            Outcome::Apart => Vec::new(),
            Outcome::TooMany => {
                self.unexamined = true;
                return;
            }
            Outcome::Found(found) => self.take(vertices, triangles, before.len(), extent, found),
        };
        self.body_of = bodies::group(vertices, triangles, &self.parts, &joined, extent, tolerance);
    }

    /// Takes over what was found, and reverses the parts that bound voids; returns the pairs of parts that belong to one
    /// body.
    fn take(
        &mut self,
        vertices: &[Point3<f64>],
        triangles: &mut [[u32; 3]],
        count: usize,
        extent: &Extent,
        found: Overlap,
    ) -> Vec<[u32; 2]> {
        self.overlapping_parts = found
            .overlapping
            .iter()
            .filter(|overlaps| **overlaps)
            .count();
        if self.overlapping_parts > 0 {
            let &Extent {
                center, diagonal, ..
            } = extent;
            self.union = Some(found.moments(vertices, triangles, &center, diagonal));
        }
        let cover = found.cover(vertices, triangles, count);
        if !cover.is_trivial() {
            self.cover = cover;
        }
        for (part, _) in self
            .parts
            .iter()
            .zip(&found.voids)
            .filter(|(_, is_void)| **is_void)
        {
            orient::reverse(part, triangles);
        }
        found.joined
    }
}
