//! Lists of a bounded length in the analyses of a grasp.

use graspd_core::independent::IndependentRegion;

/// Triangles of regions that one answer lists.
const MAX_TRIANGLES: usize = 100_000;

/// Cuts the lists of triangles short, so that an answer with `grasps` grasps lists at most
/// [`MAX_TRIANGLES`], the same number for every contact.
pub(super) fn shorten(regions: &mut Option<Vec<IndependentRegion>>, grasps: usize) {
    let Some(regions) = regions else {
        return;
    };
    let share = MAX_TRIANGLES / (grasps * regions.len()).max(1);
    for region in regions {
        region.truncate(share);
    }
}
