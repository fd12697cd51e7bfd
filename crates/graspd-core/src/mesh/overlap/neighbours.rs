//! Pairs of boxes that meet, by a sweep along one axis.
//!
//! ```text
//! sort the boxes by their low ends along x
//! for each box: compare it with those that follow, up to the first that begins beyond its high end
//! ```
//!
//! **Cost:** O(n log n), plus the pairs that overlap along x. A file made to hurt has a hundred thousand boxes, each in
//! the next, so there is a [limit](MAX_COMPARED).

use crate::mesh::tree::Bounds;

/// Most pairs that are compared: some tenths of a second. Real bodies stay a thousand times below.
const MAX_COMPARED: usize = 1 << 26;

/// Most pairs that are found.
const MAX_FOUND: usize = 1 << 20;

/// The pairs of boxes that meet, each with the lesser number first, in ascending order; `None` when too many must be
/// compared.
pub(in crate::mesh) fn pairs(boxes: &[Bounds]) -> Option<Vec<[u32; 2]>> {
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    let low = |n: u32| boxes[n as usize].low.x;
    order.sort_by(|&a, &b| low(a).total_cmp(&low(b)).then(a.cmp(&b)));
    let (mut found, mut compared) = (Vec::new(), 0);
    for (at, &a) in order.iter().enumerate() {
        let bounds = &boxes[a as usize];
        for &b in order[at + 1..]
            .iter()
            .take_while(|&&b| low(b) <= bounds.high.x)
        {
            compared += 1;
            if bounds.meets(&boxes[b as usize]) {
                found.push([a.min(b), a.max(b)]);
            }
        }
        if compared > MAX_COMPARED || found.len() > MAX_FOUND {
            return None;
        }
    }
    found.sort_unstable();
    Some(found)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Vector3};

    use super::*;

    #[test]
    fn pairs_are_those_that_a_comparison_of_all_finds() {
        let at = |n: u32| f64::from(n * 7919 % 101) / 10.0;
        let boxes: Vec<Bounds> = (0..60)
            .map(|n| {
                let low = Point3::new(at(n), at(n + 400), at(n + 900));
                Bounds {
                    low,
                    high: low + Vector3::repeat(1.5),
                }
            })
            .collect();
        let mut all = Vec::new();
        for a in 0..60_u32 {
            all.extend((a + 1..60).map(|b| [a, b]));
        }
        all.retain(|&[a, b]| boxes[a as usize].meets(&boxes[b as usize]));
        assert!(all.len() > 10);
        assert_eq!(pairs(&boxes), Some(all));
    }
}
