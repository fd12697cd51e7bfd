//! The parts of a surface, and one winding for each.
//!
//! A part is a set of triangles that hang together over edges of exactly two triangles, and over edges of more where
//! [pairs](super::pairing) show which two bound the same solid. Over an edge of two the winding of one triangle decides
//! that of the other: a consistent surface runs through their common edge once in each direction. So the winding of one
//! triangle decides the whole part.
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

use nalgebra::Point3;

use super::edges::{EdgeUse, Edges};
use super::pairing;

/// A part of the surface that hangs together.
#[derive(Debug)]
pub(super) struct Part {
    pub(super) triangles: Vec<u32>,
    /// Each of its edges is used as often in one direction as in the other.
    pub(super) closed: bool,
    /// It may consist of several solids that overlap and are flush along an edge.
    pub(super) ambiguous: bool,
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
    /// Those of them at which some part is not closed.
    pub(super) unresolved_edges: usize,
}

impl Parts {
    pub(super) fn of(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Self {
        let edges = Edges::new(triangles);
        let (neighbours, ambiguous) = neighbours(vertices, triangles, &edges);
        let mut part_of = vec![u32::MAX; triangles.len()];
        let mut parts = Self {
            parts: Vec::new(),
            turned: vec![false; triangles.len()],
            border_edges: 0,
            non_manifold_edges: 0,
            unresolved_edges: 0,
        };
        for seed in 0..triangles.len() {
            if part_of[seed] == u32::MAX {
                parts.grow(seed as u32, &neighbours, &mut part_of);
            }
        }
        parts.classify_edges(&edges, &part_of);
        for triangle in ambiguous {
            parts.parts[part_of[triangle as usize] as usize].ambiguous = true;
        }
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
            ambiguous: false,
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
                _ => {
                    self.non_manifold_edges += 1;
                    self.unresolved_edges += usize::from(!balanced);
                }
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

/// For each triangle its neighbours over edges of two triangles, and over others where it has a partner; and the
/// triangles that could have others.
fn neighbours(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    edges: &Edges,
) -> (Vec<[Option<Neighbour>; 3]>, Vec<u32>) {
    let mut neighbours = vec![[None; 3]; triangles.len()];
    let mut has_crowded = false;
    for uses in edges.iter() {
        match uses {
            [a, b] => join(&mut neighbours, a, b),
            _ => has_crowded |= uses.len() > 2,
        }
    }
    let mut ambiguous = Vec::new();
    if !has_crowded {
        return (neighbours, ambiguous);
    }
    let piece_of = pieces(&neighbours);
    for uses in edges.iter().filter(|uses| uses.len() > 2) {
        let found = pairing::pairs(uses, vertices, triangles, &piece_of);
        if found.ambiguous {
            ambiguous.extend(uses.iter().map(|edge| edge.triangle));
        }
        for (a, b) in found.pairs {
            join(&mut neighbours, &uses[a], &uses[b]);
        }
    }
    (neighbours, ambiguous)
}

/// Makes two triangles neighbours of each other.
fn join(neighbours: &mut [[Option<Neighbour>; 3]], a: &EdgeUse, b: &EdgeUse) {
    for (from, to) in [(a, b), (b, a)] {
        // A triangle has three edges, so a place is free.
        let mut places = neighbours[from.triangle as usize].iter_mut();
        if let Some(place) = places.find(|place| place.is_none()) {
            *place = Some(Neighbour {
                triangle: to.triangle,
                same_direction: from.ascending == to.ascending,
            });
        }
    }
}

/// For each triangle the piece that it belongs to: what hangs together over neighbours.
fn pieces(neighbours: &[[Option<Neighbour>; 3]]) -> Vec<u32> {
    let mut piece_of = vec![u32::MAX; neighbours.len()];
    let mut open = Vec::new();
    for seed in 0..neighbours.len() {
        if piece_of[seed] != u32::MAX {
            continue;
        }
        piece_of[seed] = seed as u32;
        open.push(seed);
        while let Some(at) = open.pop() {
            for next in neighbours[at].iter().flatten() {
                let there = next.triangle as usize;
                if piece_of[there] == u32::MAX {
                    piece_of[there] = seed as u32;
                    open.push(there);
                }
            }
        }
    }
    piece_of
}
