//! Which triangles hang together.
//!
//! A region that consists of triangles of the file falls into pieces where it is interrupted. Two triangles belong to
//! the same piece when a path over edges of the region joins them. At an edge where more than two triangles meet, all
//! of them are joined.
//!
//! ```text
//! open = the triangle to start from
//! while a triangle is open:
//!     for each of its edges that was not crossed before:
//!         open the triangles there that are members, or slivers, and were not visited
//! ```
//!
//! Slivers, which have no normal and can be no members, are passed through: a sliver between two members is a flaw of
//! the mesh and no gap in the surface.
//!
//! **Why it ends:** an edge is crossed once and a triangle visited once. **Cost:** O(n), also at an edge with very many
//! triangles, since only the first to come there looks at the others.

use super::edges::Edges;
use super::{BLOCK, Mesh, triangle};
use crate::interrupt::{Interrupt, Interrupted};

/// The triangles at each edge of a mesh. It takes O(n) memory, so build it once for a mesh.
#[derive(Debug)]
pub struct Adjacency<'a> {
    mesh: &'a Mesh,
    /// The triangles at the first edge, then those at the second, and so on.
    at_edges: Vec<u32>,
    /// For each edge where its triangles begin in `at_edges`, and after the last one the end of all.
    begins: Vec<u32>,
    /// The edges of each triangle.
    edges: Vec<[u32; 3]>,
    /// For each triangle whether it is degenerate.
    slivers: Vec<bool>,
}

impl<'a> Adjacency<'a> {
    /// O(n) where few triangles meet at a vertex; `interrupt` is checked every few milliseconds.
    pub fn new(mesh: &'a Mesh, interrupt: Interrupt<'_>) -> Result<Self, Interrupted> {
        let count = mesh.triangles.len();
        let mut at_edges = Vec::with_capacity(3 * count);
        let mut begins = vec![0];
        let mut edges = vec![[0; 3]; count];
        let mut known = vec![0_u8; count];
        for (edge, uses) in
            (0..=u32::MAX).zip(Edges::interruptible(&mesh.triangles, interrupt)?.iter())
        {
            if (edge as usize).is_multiple_of(BLOCK) {
                interrupt.check()?;
            }
            for at in uses {
                let triangle = at.triangle as usize;
                at_edges.push(at.triangle);
                if let Some(place) = edges[triangle].get_mut(usize::from(known[triangle])) {
                    *place = edge;
                    known[triangle] += 1;
                }
            }
            begins.push(at_edges.len() as u32);
        }
        let mut slivers = Vec::with_capacity(count);
        for block in mesh.triangles.chunks(BLOCK) {
            interrupt.check()?;
            slivers.extend(block.iter().map(|&indices| {
                let corners = triangle::corners(&mesh.vertices, indices);
                triangle::is_degenerate(&corners, mesh.tolerance)
            }));
        }
        Ok(Self {
            mesh,
            at_edges,
            begins,
            edges,
            slivers,
        })
    }

    /// Returns those of `members` that are reached from `from` over edges that members share, `from` included, in
    /// ascending order; none when `from` is not a member.
    ///
    /// Triangles without a normal, which are no [candidates](super::Candidate), are passed through as if they were
    /// members. All numbers are indices in the file as uploaded, and `members` must ascend. O(n); `interrupt` is checked
    /// every few milliseconds.
    pub fn reachable(
        &self,
        from: u32,
        members: &[u32],
        interrupt: Interrupt<'_>,
    ) -> Result<Vec<u32>, Interrupted> {
        let source = &self.mesh.source;
        interrupt.check()?;
        let mut members = members.iter().copied().peekable();
        let mut is_member = vec![false; source.len()];
        for (is_member, triangle) in is_member.iter_mut().zip(source) {
            while members.next_if(|member| member < triangle).is_some() {}
            *is_member = members.next_if_eq(triangle).is_some();
        }
        let start = source.binary_search(&from).ok();
        let start = start.filter(|&index| is_member[index]);
        let mut visited = vec![false; source.len()];
        let mut crossed = vec![false; self.begins.len()];
        let mut open: Vec<usize> = start.into_iter().collect();
        open.iter().for_each(|&index| visited[index] = true);
        let mut passed = 0_usize;
        while let Some(triangle) = open.pop() {
            if passed.is_multiple_of(BLOCK) {
                interrupt.check()?;
            }
            passed += 1;
            for edge in self.edges[triangle].map(|edge| edge as usize) {
                if std::mem::replace(&mut crossed[edge], true) {
                    continue;
                }
                let (begin, end) = (self.begins[edge] as usize, self.begins[edge + 1] as usize);
                for &there in &self.at_edges[begin..end] {
                    let there = there as usize;
                    if !visited[there] && (is_member[there] || self.slivers[there]) {
                        visited[there] = true;
                        open.push(there);
                    }
                }
            }
        }
        let reached = (0..source.len()).filter(|&i| visited[i] && is_member[i]);
        Ok(reached.map(|index| source[index]).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interrupt::uninterrupted;
    use crate::mesh::solids;

    /// Grows the set by every member that shares two vertices with one of it, until none does.
    fn slow(mesh: &Mesh, from: u32, members: &[u32]) -> Vec<u32> {
        let corners = |t: u32| mesh.triangles()[mesh.source().binary_search(&t).unwrap()];
        let touch = |a: u32, b: u32| {
            let other = corners(b);
            corners(a).iter().filter(|v| other.contains(v)).count() >= 2
        };
        let mut found: Vec<u32> = members.iter().copied().filter(|&t| t == from).collect();
        loop {
            let more = members
                .iter()
                .copied()
                .find(|&t| !found.contains(&t) && found.iter().any(|&there| touch(t, there)));
            match more {
                Some(more) => found.push(more),
                None => break,
            }
        }
        found.sort_unstable();
        found
    }

    fn reachable(mesh: &Mesh, from: u32, members: &[u32]) -> Vec<u32> {
        uninterrupted(|interrupt| {
            Adjacency::new(mesh, interrupt)?.reachable(from, members, interrupt)
        })
    }

    #[test]
    fn what_is_reached_is_what_a_slow_search_reaches() {
        for raw in [
            solids::sphere(1.0, 6, 9),
            solids::torus(2.0, 0.7, 10, 6),
            solids::hollow_cube(),
        ] {
            let mesh = Mesh::prepare(raw).unwrap();
            for step in 1..6_u32 {
                let kept = |t: &u32| t * step % 7 < 4;
                let members: Vec<u32> = mesh.source().iter().copied().filter(kept).collect();
                for from in [0, 3, 11] {
                    let found = reachable(&mesh, from, &members);
                    assert_eq!(found, slow(&mesh, from, &members));
                }
            }
            assert_eq!(reachable(&mesh, 0, &[]), [0; 0]);
            assert_eq!(reachable(&mesh, u32::MAX, mesh.source()), [0; 0]);
            let beyond = [mesh.source(), &[u32::MAX - 1, u32::MAX]].concat();
            assert_eq!(
                reachable(&mesh, 0, &beyond),
                reachable(&mesh, 0, mesh.source())
            );
        }
    }

    #[test]
    fn the_two_walls_of_a_hollow_body_are_apart() {
        let mesh = Mesh::prepare(solids::hollow_cube()).unwrap();
        let all = mesh.source();
        assert_eq!(reachable(&mesh, 0, all).len(), all.len() / 2);
    }
}
