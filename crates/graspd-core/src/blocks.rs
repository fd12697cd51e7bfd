//! How much of an analysis is done between two checks of an interrupt.

use super::wrench::WrenchModel;

/// Facets after which the hull of one of many grasps is given up; some 30 ms.
pub(crate) const FACET_LIMIT: usize = 1 << 14;

/// Wrenches of all grasps of a block: some 5 ms on one thread for grasps of few wrenches.
const BLOCK_WRENCHES: usize = 1 << 12;

/// Grasps to evaluate between two checks: of the largest some tens of milliseconds.
pub(crate) fn grasps_per_block(model: &WrenchModel, contacts: usize) -> usize {
    (BLOCK_WRENCHES / model.effort(contacts)).clamp(2, 512)
}
