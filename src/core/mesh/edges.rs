//! Which triangles meet at which edge.

use rayon::prelude::*;

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
    /// The two vertices in the order in which the triangle runs through them.
    pub(super) fn vertices(&self) -> [u32; 2] {
        let (lesser, greater) = ((self.key >> 32) as u32, self.key as u32);
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
    /// O(n log n) on the current rayon pool. The three vertices of each triangle must differ.
    pub(super) fn new(triangles: &[[u32; 3]]) -> Self {
        let mut uses: Vec<_> = (0..=u32::MAX)
            .zip(triangles)
            .flat_map(|(triangle, &[a, b, c])| {
                [(a, b), (b, c), (c, a)].map(|(from, to)| EdgeUse {
                    key: u64::from(from.min(to)) << 32 | u64::from(from.max(to)),
                    triangle,
                    ascending: from < to,
                })
            })
            .collect();
        uses.par_sort_unstable();
        Self(uses)
    }

    /// The uses of one edge after the other.
    pub(super) fn iter(&self) -> impl Iterator<Item = &[EdgeUse]> {
        self.0.chunk_by(|a, b| a.key == b.key)
    }
}
