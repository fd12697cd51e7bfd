//! Triangles that are there more than once.

use rayon::prelude::*;

/// Triangles on the same three corners.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    /// The corners, ascending.
    corners: [u32; 3],
    /// Wound the other way round than ascending.
    turned: bool,
    index: u32,
}

/// Drops every triangle that is there before with the same corners and winding, and says how many.
///
/// Two of opposite windings stay, as the wall between two bodies that touch has them; but when most of the
/// surface is like that, it was written with two sides, as for drawing, and of each pair the first stays. The
/// three corners of each triangle must differ. O(n log n) on the current rayon pool.
pub(super) fn drop_copies(triangles: &mut Vec<[u32; 3]>, source: &mut Vec<u32>) -> usize {
    let mut entries: Vec<Entry> = (0..=u32::MAX)
        .zip(triangles.iter())
        .map(|(index, &triangle)| entry(index, triangle))
        .collect();
    entries.par_sort_unstable();
    let places = || entries.chunk_by(|a, b| a.corners == b.corners);
    let two_sided = |place: &[Entry]| place.iter().any(|e| e.turned != place[0].turned);
    let (mut all, mut pairs) = (0_usize, 0_usize);
    for place in places() {
        all += 1;
        pairs += usize::from(two_sided(place));
    }
    let one_side = 2 * pairs > all;
    let mut dropped = vec![false; triangles.len()];
    for place in places() {
        let first = place.iter().map(|entry| entry.index).min();
        for (i, entry) in place.iter().enumerate() {
            let repeats = i > 0 && place[i - 1].turned == entry.turned;
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
        let count = drop_copies(&mut kept, &mut source);
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
