//! How facets hang together: a facet with its neighbours, and a ridge between two.

/// A facet but for its plane, in one cache line. Slots 0 to 5 are used, and of the vertices slot
/// [`PARITY`].
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Facet {
    pub vertices: [u32; 8],
    /// Across from the vertex in slot i: number of the neighbour times eight, plus the slot by which it
    /// knows this facet.
    pub neighbors: [u32; 8],
}

/// Slot that holds 1 where the vertices, in their order, go around the facet the other way than around
/// those that hold 0. A new facet has the order, and so the parity, of the visible one below it.
pub(super) const PARITY: usize = 6;

/// An empty slot.
pub(super) const NONE: u32 = u32::MAX;

/// A ridge between a facet that the new vertex lies beyond and one that it does not.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Ridge {
    pub visible: u32,
    /// The slot of the other facet in the visible one.
    pub slot: u32,
    /// The other facet, times eight, and its slot for the visible one.
    pub hidden: u32,
}
