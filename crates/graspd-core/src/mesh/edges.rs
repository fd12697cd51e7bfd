//! Which triangles meet at which edge.
//!
//! Each triangle uses three edges. Sorted by their two vertices, the uses of one edge are next to each other, and
//! their number and directions say all that matters: one use is a border, two in opposite directions are a proper
//! joint of two triangles, anything else is non-manifold.
//!
//! ```text
//! count the uses by their lesser vertex, and turn the counts into places    (a counting sort)
//! put every use to its place
//! sort the few uses of each lesser vertex by the greater one
//! ```
//!
//! **Cost:** O(n) where few triangles meet at a vertex, as on every real surface; O(n log n) at worst. A comparison
//! sort of all uses would be the slowest step of preparation.

use super::BLOCK;
use crate::interrupt::{Interrupt, Interrupted, uninterrupted};

/// One use of an edge by a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct EdgeUse {
    /// The two vertices, the lesser in the upper half.
    key: u64,
    pub(super) triangle: u32,
    /// Whether the triangle runs from the lesser vertex to the greater.
    pub(super) ascending: bool,
}

impl EdgeUse {
    /// The two vertices, the lesser first.
    pub(super) fn ends(&self) -> [u32; 2] {
        [(self.key >> 32) as u32, self.key as u32]
    }

    /// The two vertices in the order in which the triangle runs through them.
    pub(super) fn vertices(&self) -> [u32; 2] {
        let [lesser, greater] = self.ends();
        match self.ascending {
            true => [lesser, greater],
            false => [greater, lesser],
        }
    }
}

/// Every use of every edge, sorted by edge.
#[derive(Debug)]
pub(super) struct Edges(Vec<EdgeUse>);

impl Edges {
    /// The edges of triangles, each of which must have three different vertices.
    pub(super) fn new(triangles: &[[u32; 3]]) -> Self {
        uninterrupted(|interrupt| Self::interruptible(triangles, interrupt))
    }

    /// The same; `interrupt` is checked every few milliseconds.
    pub(super) fn interruptible(
        triangles: &[[u32; 3]],
        interrupt: Interrupt<'_>,
    ) -> Result<Self, Interrupted> {
        let last = triangles.iter().flatten().max();
        let vertices = last.map_or(0, |&last| last as usize + 1);
        // For each vertex, where the uses begin of which it is the lesser end.
        let mut begins = vec![0; vertices + 1];
        for block in triangles.chunks(BLOCK) {
            interrupt.check()?;
            for &[a, b, c] in block {
                for lesser in [a.min(b), b.min(c), c.min(a)] {
                    begins[lesser as usize + 1] += 1;
                }
            }
        }
        for vertex in 0..vertices {
            begins[vertex + 1] += begins[vertex];
        }
        // For each vertex, the next place for such a use.
        let mut free: Vec<usize> = begins.clone();
        let nothing = EdgeUse {
            key: 0,
            triangle: 0,
            ascending: false,
        };
        let mut uses = vec![nothing; 3 * triangles.len()];
        for (triangle, &[a, b, c]) in (0..=u32::MAX).zip(triangles) {
            if (triangle as usize).is_multiple_of(BLOCK) {
                interrupt.check()?;
            }
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let lesser = from.min(to);
                let place = &mut free[lesser as usize];
                uses[*place] = EdgeUse {
                    key: u64::from(lesser) << 32 | u64::from(from.max(to)),
                    triangle,
                    ascending: from < to,
                };
                *place += 1;
            }
        }
        for vertex in 0..vertices {
            if vertex.is_multiple_of(BLOCK) {
                interrupt.check()?;
            }
            uses[begins[vertex]..begins[vertex + 1]].sort_unstable();
        }
        Ok(Self(uses))
    }

    /// The uses of each edge, in the order of the edges.
    pub(super) fn iter(&self) -> impl Iterator<Item = &[EdgeUse]> {
        self.0.chunk_by(|a, b| a.key == b.key)
    }
}
