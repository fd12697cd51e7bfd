//! Triangles that are there more than once.
//!
//! Files repeat faces for three reasons, and each asks for something else. A copy with the same corners and winding
//! is a slip of the exporter: it goes. Two bodies that touch share a wall, once in each winding: both stay, since
//! each closes its own body. And a surface made for drawing may have two sides: every triangle is there in both
//! windings. If all stayed, no edge would have two triangles, so one side goes. Which of the last two it is, the
//! majority says: a shared wall is a small part of the bodies.
//!
//! ```text
//! sort the triangles by their corners in ascending order, then by winding, then by index
//! faces = the runs of equal corners
//! one_side = more than half of the faces have both windings
//! of each face keep the first triangle of each winding, or with one_side the first triangle alone
//! ```
//!
//! "First" is the order of the file, so the result depends on nothing else. **Cost:** O(n log n) on the current
//! rayon pool.

use rayon::prelude::*;

/// A triangle by its corners.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    /// The corners, ascending.
    corners: [u32; 3],
    /// Wound the other way round than ascending.
    turned: bool,
    index: u32,
}

/// Drops the copies of triangles, and one side of a surface that was written with two; returns how many went.
///
/// `source` has an entry for each triangle and loses those of the triangles that go. The three corners of each
/// triangle must differ.
pub(super) fn drop_duplicates(triangles: &mut Vec<[u32; 3]>, source: &mut Vec<u32>) -> usize {
    let mut entries: Vec<Entry> = (0..=u32::MAX)
        .zip(triangles.iter())
        .map(|(index, &triangle)| entry(index, triangle))
        .collect();
    entries.par_sort_unstable();
    let faces = || entries.chunk_by(|a, b| a.corners == b.corners);
    let two_sided = |face: &[Entry]| face.iter().any(|e| e.turned != face[0].turned);
    let (mut all, mut both) = (0_usize, 0_usize);
    for face in faces() {
        all += 1;
        both += usize::from(two_sided(face));
    }
    let one_side = 2 * both > all;
    let mut dropped = vec![false; triangles.len()];
    for face in faces() {
        let first = face.iter().map(|entry| entry.index).min();
        for (i, entry) in face.iter().enumerate() {
            // Of one winding, the entries of a face are in the order of the file.
            let repeats = i > 0 && face[i - 1].turned == entry.turned;
            dropped[entry.index as usize] = repeats || (one_side && first != Some(entry.index));
        }
    }
    let mut at = dropped.iter();
    triangles.retain(|_| at.next() == Some(&false));
    let mut at = dropped.iter();
    source.retain(|_| at.next() == Some(&false));
    dropped.iter().filter(|&&dropped| dropped).count()
}

fn entry(index: u32, [a, b, c]: [u32; 3]) -> Entry {
    let mut corners = [a, b, c];
    corners.sort_unstable();
    // The three rotations of a triangle are wound alike.
    let rotations = [[a, b, c], [b, c, a], [c, a, b]];
    Entry {
        corners,
        turned: !rotations.contains(&corners),
        index,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dropped(triangles: &[[u32; 3]]) -> (Vec<u32>, usize) {
        let mut kept = triangles.to_vec();
        let mut source: Vec<u32> = (0..triangles.len() as u32).map(|n| 10 + n).collect();
        let count = drop_duplicates(&mut kept, &mut source);
        assert_eq!(kept.len(), source.len());
        for (triangle, &n) in kept.iter().zip(&source) {
            assert_eq!(*triangle, triangles[n as usize - 10]);
        }
        (source, count)
    }

    #[test]
    fn copies_go_whatever_corner_they_begin_with() {
        let found = dropped(&[[0, 1, 2], [3, 1, 0], [1, 2, 0], [0, 1, 4], [0, 1, 2]]);
        assert_eq!(found, (vec![10, 11, 13], 2));
    }

    #[test]
    fn a_wall_between_two_bodies_stays() {
        let found = dropped(&[[0, 1, 2], [3, 1, 0], [0, 2, 1], [0, 1, 4], [2, 0, 1]]);
        assert_eq!(found, (vec![10, 11, 12, 13], 1));
    }

    #[test]
    fn of_a_surface_with_two_sides_one_stays() {
        let found = dropped(&[[2, 1, 0], [0, 1, 2], [3, 1, 0], [0, 1, 3], [4, 5, 6]]);
        assert_eq!(found, (vec![10, 12, 14], 2));
    }
}
