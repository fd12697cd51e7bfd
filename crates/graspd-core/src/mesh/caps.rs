//! Caps that close the holes of a surface, to weigh what it would then enclose.
//!
//! The rim of a surface, in the sense of homology, is what is left of its directed edges when those that run both
//! ways cancel: an edge that is run along twice up and once down counts once, up. As many of these edges arrive at
//! every vertex as leave it, because each triangle arrives and leaves once at each of its corners. So the rim falls
//! into closed lines, also where more than two triangles meet. Around the middle of each line a fan of triangles
//! closes the hole:
//!
//! ```text
//! rim = for each edge the surplus of one direction over the other, reversed
//! for each closed line of the rim:
//!     middle = the mean of its vertices
//!     for each of its edges: a triangle of the edge and middle
//! ```
//!
//! **Invariant:** with the caps every edge is run along as often in one direction as in the other. The capped surface
//! is closed, so its signed volume does not depend on where the fans meet for a flat hole, and hardly for any other
//! hole that is small.
//!
//! **Cost:** O(n log n) to sort edges, O(r log r) for r edges of the rim.

use nalgebra::Point3;

use super::edges::Edges;
use super::triangle;

/// Triangles that close a surface: around each hole a fan about the middle of its rim.
#[derive(Debug)]
pub(super) struct Caps {
    middles: Vec<Point3<f64>>,
    /// Corners are vertices of the surface, and behind them the middles.
    triangles: Vec<[u32; 3]>,
}

impl Caps {
    /// The caps of a consistently wound surface; none when it is closed. `None` when two triangles run along a
    /// common edge in the same direction, so that the surface has no inside.
    pub(super) fn of(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Option<Self> {
        let mut rim: Vec<[u32; 2]> = Vec::new();
        for uses in Edges::new(triangles).iter() {
            let ascending = uses.iter().filter(|edge| edge.ascending).count();
            let descending = uses.len() - ascending;
            if uses.len() == 2 && ascending != descending {
                return None;
            }
            let surplus = ascending > descending;
            let open = uses.iter().find(|edge| edge.ascending == surplus);
            // The cap runs along the edge the other way.
            let [from, to] = open?.vertices();
            rim.extend((0..ascending.abs_diff(descending)).map(|_| [to, from]));
        }
        let mut caps = Self {
            middles: Vec::new(),
            triangles: Vec::new(),
        };
        for line in closed_lines(rim) {
            let middle = (vertices.len() + caps.middles.len()) as u32;
            let first = vertices[line[0] as usize];
            let arms = line.iter().map(|&index| vertices[index as usize] - first);
            let mean: nalgebra::Vector3<f64> = arms.sum();
            caps.middles.push(first + mean / line.len() as f64);
            let next = line.iter().cycle().skip(1);
            let fan = line.iter().zip(next).map(|(&from, &to)| [from, to, middle]);
            caps.triangles.extend(fan);
        }
        Some(caps)
    }

    /// How many holes there are.
    pub(super) fn count(&self) -> usize {
        self.middles.len()
    }

    /// The area of all caps.
    pub(super) fn area(&self, vertices: &[Point3<f64>]) -> f64 {
        let corner = |index: u32| match vertices.get(index as usize) {
            Some(vertex) => *vertex,
            None => self.middles[index as usize - vertices.len()],
        };
        let areas = self.triangles.iter();
        areas
            .map(|corners| triangle::area(&corners.map(corner)))
            .sum()
    }

    /// The surface together with the caps.
    pub(super) fn applied(
        &self,
        vertices: &[Point3<f64>],
        triangles: &[[u32; 3]],
    ) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
        (
            [vertices, &self.middles].concat(),
            [triangles, &self.triangles].concat(),
        )
    }
}

/// Cuts directed edges, of which as many leave every vertex as arrive there, into closed lines that meet no
/// vertex twice.
///
/// A path follows unused edges. When it comes back to a vertex that is on it, everything since then is a closed line
/// and is cut off. It can only get stuck where it began, since elsewhere an edge out is left for every edge in, and
/// then the path is empty. Every edge is used once.
fn closed_lines(mut edges: Vec<[u32; 2]>) -> Vec<Vec<u32>> {
    edges.sort_unstable();
    let begin = |vertex: u32| edges.partition_point(|edge| edge[0] < vertex);
    // Of the edges from each vertex, how many are used up; counted at the first of them.
    let mut used = vec![0_usize; edges.len()];
    // Where each vertex is in the path, by the first edge from it.
    let mut at = vec![usize::MAX; edges.len()];
    let mut lines = Vec::new();
    let mut path: Vec<u32> = Vec::new();
    for start in 0..edges.len() {
        let mut vertex = edges[start][0];
        loop {
            let first = begin(vertex);
            if at[first] != usize::MAX {
                let line = path.split_off(at[first]);
                line.iter().for_each(|&v| at[begin(v)] = usize::MAX);
                lines.push(line);
            }
            let next = edges.get(first + used[first]);
            let Some(next) = next.filter(|edge| edge[0] == vertex) else {
                break;
            };
            used[first] += 1;
            at[first] = path.len();
            path.push(vertex);
            vertex = next[1];
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids;

    fn without(mut raw: crate::mesh::RawMesh, gone: &[usize]) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
        let mut index = 0;
        raw.triangles.retain(|_| {
            index += 1;
            !gone.contains(&(index - 1))
        });
        (raw.vertices, raw.triangles)
    }

    #[test]
    fn a_closed_surface_needs_no_cap() {
        let raw = solids::torus(2.0, 0.5, 9, 7);
        let caps = Caps::of(&raw.vertices, &raw.triangles).unwrap();
        assert_eq!((caps.count(), caps.triangles.len()), (0, 0));
    }

    #[test]
    fn capped_holes_leave_no_edge_open() {
        // Two holes far apart, one of two triangles, and two that touch at a vertex.
        let ball = solids::sphere(1.0, 8, 12);
        for (gone, holes) in [
            (vec![0], 1),
            (vec![0, 150], 2),
            (vec![0, 1], 1),
            (vec![0, 6], 2),
        ] {
            let (vertices, triangles) = without(ball.clone(), &gone);
            let found = Caps::of(&vertices, &triangles).unwrap();
            assert_eq!(found.count(), holes, "{gone:?}");
            let (vertices, triangles) = found.applied(&vertices, &triangles);
            assert!(Edges::new(&triangles).iter().all(|uses| uses.len() == 2));
            assert_eq!(Caps::of(&vertices, &triangles).unwrap().count(), 0);
        }
    }

    #[test]
    fn a_flat_hole_has_a_cap_of_its_own_area() {
        let (vertices, triangles) = without(solids::cube(2.0), &[4, 5]);
        let found = Caps::of(&vertices, &triangles).unwrap();
        assert!((found.area(&vertices) - 4.0).abs() < 1e-14);
    }

    #[test]
    fn a_fin_is_capped_onto_itself() {
        let mut raw = solids::cube(1.0);
        raw.vertices.push(Point3::new(3.0, 3.0, 3.0));
        raw.triangles.push([6, 7, 8]);
        let found = Caps::of(&raw.vertices, &raw.triangles).unwrap();
        assert_eq!((found.count(), found.triangles.len()), (1, 3));
    }

    #[test]
    fn a_twisted_band_has_no_inside() {
        let at = |i: f64, up: f64| Point3::new(i.cos() * 3.0, i.sin() * 3.0, up);
        let vertices = (0..6).flat_map(|i| [at(f64::from(i), -1.0), at(f64::from(i), 1.0)]);
        let vertices: Vec<Point3<f64>> = vertices.collect();
        let mut triangles = Vec::new();
        for i in 0..6_u32 {
            let (a, b) = (2 * i, 2 * i + 1);
            let (c, d) = if i == 5 { (1, 0) } else { (a + 2, b + 2) };
            triangles.extend([[a, c, b], [b, c, d]]);
        }
        assert!(Caps::of(&vertices, &triangles).is_none());
    }
}
