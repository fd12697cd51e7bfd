//! What the algorithms of this folder ask of a polytope that grows.

use super::lanes::Lanes;

/// The polytope cannot grow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unfinished {
    /// The facet limit is reached.
    Limit,
    /// Rounding has folded the surface, so that its planes are no longer those of a convex polytope.
    Folded,
}

/// A facet of the current polytope: its outward unit normal (six lanes, then zeros) and signed distance from the origin.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nearest {
    pub normal: Lanes,
    pub offset: f64,
}

/// A polytope that grows by one vertex at a time. It is exact to [`super::COPLANAR_TOLERANCE`], unless rounding folds it.
pub(super) trait Growing {
    /// Starts over with a simplex. `planes[i]`, outward unit normal and minus the offset, is opposite corner i. Nothing
    /// below `tolerance` counts. At most `facet_limit` facets will be built, those replaced on the way included.
    fn start(
        &mut self,
        corners: &[Lanes; 7],
        planes: &[Lanes; 7],
        tolerance: f64,
        facet_limit: usize,
    );

    /// Returns the facet nearest to the origin, each facet once; the oldest among equals. O(facets).
    fn nearest(&mut self) -> Option<Nearest>;

    /// Returns some facet that was not returned yet, for a caller that visits all of them and passes the same `from`, zero
    /// at first.
    fn any(&mut self, from: &mut usize) -> Option<Nearest>;

    /// Adds a vertex (six components, one, and zero). Returns whether it lies beyond some facet by more than the tolerance;
    /// if not, nothing has changed.
    fn insert(&mut self, point: &Lanes) -> Result<bool, Unfinished>;

    /// Facets built so far.
    fn facet_count(&self) -> usize;

    /// Returns the volume that the surface encloses, in the sixth power of the unit of the vertices.
    fn volume(&self) -> f64;
}
