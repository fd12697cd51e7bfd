//! Grasp quality measures besides ε: the standard list of Roa & Suárez, "Grasp quality measures:
//! review and performance" (Autonomous Robots 38, 2015), section by section.
//!
//! | file | subject |
//! |---|---|
//! | `matrix.rs` | the grasp matrix and its singular values |
//! | `polygon.rs` | the polygon that the contacts span |

mod matrix;
mod polygon;

use nalgebra::Vector3;

use super::contact::Contact;
use super::wrench::WrenchModel;
pub use matrix::GraspMatrix;
pub use polygon::{CORNER_TOLERANCE, PLANE_TOLERANCE, Polygon};

/// What is measured of a grasp. None of it changes when the body is moved or turned with its contacts
/// or the contacts are renumbered; scaled with the body and λ = 1/radius, only lengths and areas do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measures {
    /// ε in the L1 space: radius of the greatest ball about the origin in the convex hull of the
    /// contacts' wrenches, min over unit u of max over contacts i of h_i(u). Unit: that of the edges,
    /// torques scaled by λ; from 0 to √(1+(λr)²) for contacts within r of the centre of mass and unit
    /// edges, greater is better. A lower bound where the cone is round. `None` without force closure.
    /// Ferrari & Canny 1992; Roa & Suárez, section 2.2.
    pub epsilon_l1: Option<f64>,
    /// ε in the L∞ space: the same of the Minkowski sum, min over unit u of Σ max(0, h_i(u)). From the
    /// L1 value to as many times that as there are contacts. Unit, direction and source as there.
    pub epsilon_linf: Option<f64>,
    /// Volume of the convex hull of the contacts' wrenches (L1), in the sixth power of their unit;
    /// ≥ 0, greater is better. Zero when they span fewer than 6 dimensions, positive also without force
    /// closure. Of a round cone that of the pyramid with
    /// [`STAND_IN_EDGES`](super::wrench::STAND_IN_EDGES) edges in it. `None` when the hull is too large
    /// to finish. Miller & Allen 1999; Roa & Suárez, section 2.2.
    pub volume_l1: Option<f64>,
    /// σ_min of the [`GraspMatrix`]: least length of the wrench that contact forces of unit length,
    /// taken together, exert. No unit; ≥ 0, 0 when some wrench cannot be exerted at all even by fingers
    /// that pull; greater is better. Li & Sastry 1988; Roa & Suárez, section 2.1.
    pub smallest_singular_value: f64,
    /// σ_min/σ_max of the grasp matrix, the grasp isotropy index. No unit; 0 (singular) to 1 (contact
    /// forces count the same in every direction). Kim et al. 2001; Roa & Suárez, section 2.1.
    pub isotropy: f64,
    /// √det(G·Gᵀ) = the product of the six singular values: proportional to the volume of the
    /// ellipsoid of wrenches that contact forces of unit length, taken together, exert. No unit; ≥ 0,
    /// greater is better. Li & Sastry 1988; Roa & Suárez, section 2.1.
    pub ellipsoid_volume: f64,
    /// Distance from the mean of the contacts' positions to the point that torques are taken about,
    /// the centre of mass. In the mesh's unit; ≥ 0, less is better: gravity and inertia then load the
    /// fingers less. Ponce et al. 1997; Roa & Suárez, section 2.1.
    pub centroid_distance: f64,
    /// Area of the [`Polygon`], in the mesh's unit squared; > 0, greater is better. `None` when there
    /// is no polygon. Mirtich & Canny 1994; Roa & Suárez, section 2.1.
    pub polygon_area: Option<f64>,
    /// How far the inner angles θ_i of the [`Polygon`] are from those of the regular polygon with as
    /// many corners, θ̄ = π(m−2)/m: Σ|θ_i − θ̄| over what it is when the polygon is squeezed to a line,
    /// (m−2)(π−θ̄) + 2θ̄. No unit; 0 (regular) to 1, less is better. `None` when there is no polygon.
    /// Park & Starr 1992, Kim et al. 2001; Roa & Suárez, section 2.1.
    pub polygon_shape: Option<f64>,
}

impl Measures {
    /// Those that follow from where the contacts are and from what they can transmit; the three that
    /// need a wrench space are left `None`. Some microseconds for 4 contacts, O(m).
    pub fn geometric(model: &WrenchModel, contacts: &[Contact]) -> Self {
        let matrix = GraspMatrix::new(model, contacts);
        let sum: Vector3<f64> = contacts.iter().map(|c| c.position - model.center).sum();
        let polygon = Polygon::new(contacts);
        Self {
            epsilon_l1: None,
            epsilon_linf: None,
            volume_l1: None,
            smallest_singular_value: matrix.smallest_singular_value(),
            isotropy: matrix.isotropy(),
            ellipsoid_volume: matrix.ellipsoid_volume(),
            centroid_distance: sum.norm() / contacts.len().max(1) as f64,
            polygon_area: polygon.map(|polygon| polygon.area),
            polygon_shape: polygon.map(|polygon| polygon.shape),
        }
    }
}

#[cfg(test)]
mod tests;
