//! The parts of a surface, and one winding for each.
//!
//! A part is a set of triangles that hang together over edges of exactly two triangles. Over such an edge the
//! winding of one triangle decides that of the other: a consistent surface runs through their common edge once
//! in each direction. So the winding of one triangle decides the whole part.
//!
//! ```text
//! for each triangle without a part:
//!     begin a part with it, not turned
//!     for each triangle of the part, in the order in which they are found:
//!         for each neighbour without a part:
//!             take it in; it is turned if both run through the edge in the same direction, unless
//!             the triangle itself is turned
//! ```
//!
//! **Invariant:** every triangle of a part agrees, once the turned ones are reversed, with the one from which it
//! was found. On a surface with two sides it then agrees with all its neighbours; on one without, such as a
//! Möbius strip, some edge is left that no winding makes consistent, and that edge counts as non-manifold.
//!
//! **Why it ends:** a triangle enters a part once. **Cost:** O(n) on top of the sorted edges.

use super::edges::{EdgeUse, Edges};

/// A part of the surface that hangs together over edges of two triangles.
#[derive(Debug)]
pub(super) struct Part {
    pub(super) triangles: Vec<u32>,
    /// Each of its edges is used as often in one direction as in the other.
    pub(super) closed: bool,
}

/// A surface cut into its parts.
#[derive(Debug)]
pub(super) struct Parts {
    pub(super) parts: Vec<Part>,
    /// For each triangle whether it must be reversed to agree with the first of its part.
    pub(super) turned: Vec<bool>,
    /// Edges with one triangle.
    pub(super) border_edges: usize,
    /// Edges with three or more triangles, or with two that no winding can make consistent.
    pub(super) non_manifold_edges: usize,
}

impl Parts {
    pub(super) fn of(triangles: &[[u32; 3]]) -> Self {
        let edges = Edges::new(triangles);
        let neighbours = neighbours(triangles.len(), &edges);
        let mut part_of = vec![u32::MAX; triangles.len()];
        let mut parts = Self {
            parts: Vec::new(),
            turned: vec![false; triangles.len()],
            border_edges: 0,
            non_manifold_edges: 0,
        };
        for seed in 0..triangles.len() {
            if part_of[seed] == u32::MAX {
                parts.grow(seed as u32, &neighbours, &mut part_of);
            }
        }
        parts.classify_edges(&edges, &part_of);
        parts
    }

    /// Adds the part that a triangle belongs to.
    fn grow(&mut self, seed: u32, neighbours: &[[Option<Neighbour>; 3]], part_of: &mut [u32]) {
        let id = self.parts.len() as u32;
        part_of[seed as usize] = id;
        let mut members = vec![seed];
        let mut done = 0;
        while let Some(&at) = members.get(done) {
            done += 1;
            for next in neighbours[at as usize].into_iter().flatten() {
                let there = next.triangle as usize;
                if part_of[there] == u32::MAX {
                    part_of[there] = id;
                    self.turned[there] = self.turned[at as usize] ^ next.same_direction;
                    members.push(next.triangle);
                }
            }
        }
        self.parts.push(Part {
            triangles: members,
            closed: true,
        });
    }

    /// Counts the edges that keep the surface from being closed, and marks the parts that are open.
    fn classify_edges(&mut self, edges: &Edges, part_of: &[u32]) {
        let mut directions = Vec::new();
        for uses in edges.iter() {
            directions.clear();
            directions.extend(uses.iter().map(|edge| {
                let triangle = edge.triangle as usize;
                (part_of[triangle], edge.ascending ^ self.turned[triangle])
            }));
            // Sorted, the uses by one part are next to each other. There may be as many as there are triangles.
            directions.sort_unstable();
            let mut balanced = true;
            for group in directions.chunk_by(|a, b| a.0 == b.0) {
                let ascending = group.iter().filter(|(_, ascending)| *ascending).count();
                if ascending * 2 != group.len() {
                    self.parts[group[0].0 as usize].closed = false;
                    balanced = false;
                }
            }
            match uses.len() {
                1 => self.border_edges += 1,
                2 if balanced => {}
                _ => self.non_manifold_edges += 1,
            }
        }
    }
}

/// The triangle on the other side of an edge.
#[derive(Debug, Clone, Copy)]
struct Neighbour {
    triangle: u32,
    /// Both run through the edge in the same direction, so that one of them must be reversed.
    same_direction: bool,
}

/// For each triangle its neighbours over edges of two triangles.
fn neighbours(count: usize, edges: &Edges) -> Vec<[Option<Neighbour>; 3]> {
    let mut neighbours = vec![[None; 3]; count];
    let mut join = |from: &EdgeUse, to: &EdgeUse| {
        // A triangle has three edges, so a place is free.
        let mut places = neighbours[from.triangle as usize].iter_mut();
        if let Some(place) = places.find(|place| place.is_none()) {
            *place = Some(Neighbour {
                triangle: to.triangle,
                same_direction: from.ascending == to.ascending,
            });
        }
    };
    for uses in edges.iter() {
        if let [a, b] = uses {
            join(a, b);
            join(b, a);
        }
    }
    neighbours
}
