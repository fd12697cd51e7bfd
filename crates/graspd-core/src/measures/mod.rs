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

/// The standard quality measures besides ε, after Roa & Suárez, "Grasp quality measures: review and
/// performance" (Autonomous Robots 38, 2015). Torques are scaled by the torque scale λ.
///
/// No measure changes when the body is moved or turned together with its contacts, or when the contacts are
/// renumbered. When the body is scaled and λ = 1/radius, only lengths and areas change.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct Measures {
    /// ε in the L1 space: radius of the largest origin-centred ball in the convex hull of the contacts'
    /// wrenches, min over unit u of max over contacts i of h_i(u). In the unit of the cone's edges, from 0
    /// to √(1+(λr)²) for contacts within r of the centre of mass and unit edges; greater is better. A lower
    /// bound where the cone is round. Absent without force closure. Ferrari & Canny 1992.
    pub epsilon_l1: Option<f64>,
    /// ε in the L∞ space: the same of the Minkowski sum, min over unit u of the sum of max(0, h_i(u)).
    /// At least the L1 value, at most that times the number of contacts. Ferrari & Canny 1992.
    pub epsilon_linf: Option<f64>,
    /// Whether `epsilon_l1` and `epsilon_linf` are exact to 1e-6 of themselves. `false` when one of them is only a lower
    /// bound, because the facet limit ended its hull: for many contacts, above all with round cones and in L∞. Absent
    /// without force closure.
    #[cfg_attr(
        feature = "serde",
        serde(default, skip_serializing_if = "Option::is_none")
    )]
    pub epsilon_exact: Option<bool>,
    /// Volume of the convex hull of the contacts' wrenches (L1), in the sixth power of their unit, from 0;
    /// greater is better. Zero when they span fewer than 6 dimensions; positive also without force closure.
    /// For a round cone, the volume with an inscribed pyramid of 16 edges. Absent when the hull is too large
    /// to finish. Miller & Allen 1999.
    pub volume_l1: Option<f64>,
    /// σ_min of the grasp matrix G (6 rows; a column for each force and torque component that a
    /// contact transmits): the length of the shortest wrench that contact forces of unit length, taken
    /// together, exert. No unit, from 0, where some wrench cannot be exerted even by fingers that pull;
    /// greater is better. Li & Sastry 1988.
    pub smallest_singular_value: f64,
    /// Grasp isotropy index σ_min/σ_max of G. No unit, 0 (singular) to 1 (contact forces count the same in
    /// every direction). Kim et al. 2001.
    pub isotropy: f64,
    /// √det(G·Gᵀ), the product of the singular values of G: proportional to the volume of the ellipsoid of
    /// wrenches that contact forces of unit length, taken together, exert. No unit, from 0; greater is
    /// better. Li & Sastry 1988.
    pub ellipsoid_volume: f64,
    /// Distance from the mean of the contacts' positions to the centre of mass, in the mesh's unit, from 0;
    /// less is better, because gravity and inertia then load the fingers less. Ponce et al. 1997.
    pub centroid_distance: f64,
    /// Area of the polygon of the contacts, projected on the plane that fits them best, in the mesh's
    /// unit squared; greater is better. Absent where there is no polygon. Mirtich & Canny 1994.
    pub polygon_area: Option<f64>,
    /// Sum of the deviations of that polygon's m inner angles from the regular polygon's, θ̄ = π(m−2)/m, over
    /// the greatest that is possible, (m−2)(π−θ̄) + 2θ̄: 0 (regular) to 1 (squeezed to a line); less is
    /// better. Absent where there is no polygon. Park & Starr 1992, Kim et al. 2001.
    pub polygon_shape: Option<f64>,
}

impl Measures {
    /// The measures that follow from the positions of the contacts and from what they can transmit. The
    /// ones that need a wrench space stay `None`. O(m) for m contacts, some microseconds for 4.
    pub fn geometric(model: &WrenchModel, contacts: &[Contact]) -> Self {
        let matrix = GraspMatrix::new(model, contacts);
        let sum: Vector3<f64> = contacts.iter().map(|c| c.position - model.center).sum();
        let polygon = Polygon::new(contacts);
        Self {
            epsilon_l1: None,
            epsilon_linf: None,
            epsilon_exact: None,
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
