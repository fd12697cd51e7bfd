//! Where a finger may be put, and the one such place that each triangle has: its centroid (Rakesh et al. 2016).
//!
//! A centroid that is buried in matter or enclosed in a cavity can be touched by nothing, and is no candidate.

use nalgebra::{Point3, UnitVector3};

use super::cover::{Cover, State};
use super::{BLOCK, Mesh, triangle};
use crate::interrupt::{Interrupt, Interrupted, uninterrupted};

/// A place on the surface where a finger may be put.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Position in the mesh's frame and unit.
    pub position: Point3<f64>,
    /// Unit normal pointing INTO the body.
    pub normal: UnitVector3<f64>,
    /// Index of the triangle in the file as uploaded, from 0.
    pub triangle: u32,
    /// Weights of the triangle's corners that make the position, each from 0 to 1, with sum 1. The corners are in the
    /// order of [`Mesh::triangles`]: outward winding.
    pub barycentric: [f64; 3],
}

/// Why a triangle of the file is no candidate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NoCandidate {
    #[error("the mesh has no triangle {triangle}; its triangles are 0 to {last}")]
    NoSuchTriangle { triangle: u32, last: usize },
    #[error("triangle {0} is degenerate and has no normal; choose one of its neighbours")]
    Degenerate(u32),
    #[error("triangle {0} is not in the component that was chosen; choose another")]
    OtherComponent(u32),
    #[error(
        "the centroid of triangle {0} is buried in another solid; choose another, or set enclosed to allow it"
    )]
    Buried(u32),
    #[error(
        "triangle {0} is in a sealed cavity, which no finger can reach; choose another, or set enclosed to allow it"
    )]
    Enclosed(u32),
}

impl Mesh {
    /// Returns one candidate for each triangle that is not degenerate, buried or enclosed, in the order of the file; there are
    /// [`MeshReport::candidates`](super::MeshReport::candidates) of them, at least one.
    ///
    /// ```
    /// use graspd_core::mesh::{Mesh, solids};
    ///
    /// let mesh = Mesh::prepare(solids::cube(2.0))?;
    /// let candidates = mesh.candidates();
    /// assert_eq!(candidates.len(), 12);
    /// // One step inward from the middle of any face is inside the cube.
    /// for candidate in candidates {
    ///     let inside = candidate.position + candidate.normal.into_inner();
    ///     assert!(inside.iter().all(|x| (0.0..=2.0).contains(x)));
    /// }
    /// # Ok::<(), graspd_core::mesh::PrepareError>(())
    /// ```
    pub fn candidates(&self) -> Vec<Candidate> {
        uninterrupted(|interrupt| self.candidates_interruptible(interrupt))
    }

    /// The same as [`candidates`](Self::candidates); `interrupt` is checked every few milliseconds.
    pub fn candidates_interruptible(
        &self,
        interrupt: Interrupt<'_>,
    ) -> Result<Vec<Candidate>, Interrupted> {
        let mut candidates = Vec::with_capacity(self.triangles.len());
        for index in 0..self.triangles.len() {
            if index.is_multiple_of(BLOCK) {
                interrupt.check()?;
            }
            candidates.extend(self.candidate(index));
        }
        Ok(candidates)
    }

    /// Returns the candidate on a triangle, given by its index in the file as uploaded, from 0. O(log n).
    ///
    /// # Errors
    /// See [`NoCandidate`].
    pub fn candidate_of(&self, triangle: u32) -> Result<Candidate, NoCandidate> {
        let read = self.report.triangles_read;
        if triangle as usize >= read {
            return Err(NoCandidate::NoSuchTriangle {
                triangle,
                last: read.saturating_sub(1),
            });
        }
        let index = self.source.binary_search(&triangle).ok();
        let found = index.and_then(|index| self.candidate(index));
        found.ok_or_else(|| {
            let state = index.map(|index| self.cover.state(index, &triangle::CENTROID));
            match state {
                Some(State::Buried) => NoCandidate::Buried(triangle),
                Some(State::Enclosed) => NoCandidate::Enclosed(triangle),
                None if self.is_component => NoCandidate::OtherComponent(triangle),
                _ => NoCandidate::Degenerate(triangle),
            }
        })
    }

    /// Whether a place, given by the index of its triangle in [`Self::triangles`] and the weights of the corners, is open
    /// to the surroundings: neither buried in matter nor enclosed in a cavity.
    pub fn is_exposed(&self, triangle: usize, barycentric: &[f64; 3]) -> bool {
        self.cover.state(triangle, barycentric) == State::Exposed
    }

    /// The same mesh with every triangle that is not degenerate a candidate, also those that are buried or enclosed.
    ///
    /// ```
    /// use graspd_core::mesh::{Mesh, solids};
    ///
    /// // The walls of the cavity of a hollow cube can be reached by nothing.
    /// let mesh = Mesh::prepare(solids::hollow_cube())?;
    /// assert_eq!(mesh.candidates().len(), 12);
    /// assert_eq!(mesh.with_enclosed().candidates().len(), 24);
    /// # Ok::<(), graspd_core::mesh::PrepareError>(())
    /// ```
    pub fn with_enclosed(&self) -> Self {
        let mut mesh = self.clone();
        mesh.cover = Cover::default();
        let hidden = mesh.report.buried_triangles + mesh.report.enclosed_triangles;
        mesh.report.candidates += hidden;
        mesh
    }

    /// The candidate on one of [`Self::triangles`], `None` when that is degenerate.
    fn candidate(&self, index: usize) -> Option<Candidate> {
        let corners = triangle::corners(&self.vertices, self.triangles[index]);
        let usable = !triangle::is_degenerate(&corners, self.tolerance)
            && self.is_exposed(index, &triangle::CENTROID);
        usable.then(|| Candidate {
            position: triangle::centroid(&corners),
            normal: UnitVector3::new_normalize(-triangle::normal(&corners)),
            triangle: self.source[index],
            barycentric: triangle::CENTROID,
        })
    }
}
