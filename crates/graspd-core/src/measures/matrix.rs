//! The grasp matrix and its singular values.

use nalgebra::{Matrix6xX, SVD};

use crate::contact::{Contact, ContactModel};
use crate::wrench::{Wrench, WrenchModel};

/// Greatest number of steps in the search for singular values; six values need a dozen or two.
const MAX_STEPS: usize = 200;

/// The singular values of the grasp matrix G, which takes contact forces to the wrench that they
/// exert together.
///
/// G has 6 rows, force and torque about the centre of mass times λ, and per contact 1 column when
/// frictionless (along the inward normal), 3 when hard (an orthonormal frame of normal and tangents),
/// and 4 when soft: the last is the torque about the normal, measured in λ times itself so that the
/// column (0; n) has no unit either. The limits of friction play no part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GraspMatrix {
    /// Descending; zeros make up for missing columns.
    singular_values: [f64; 6],
}

impl GraspMatrix {
    /// Computes the singular values: O(m) for m contacts, some microseconds for 4.
    pub fn new(model: &WrenchModel, contacts: &[Contact]) -> Self {
        let mut columns: Vec<Wrench> = Vec::with_capacity(4 * contacts.len());
        for contact in contacts {
            let normal = contact.normal.into_inner();
            columns.push(model.wrench(&contact.position, &normal));
            if model.contact_model == ContactModel::Frictionless {
                continue;
            }
            let (t1, t2) = model.tangents(contact);
            columns.push(model.wrench(&contact.position, &t1));
            columns.push(model.wrench(&contact.position, &t2));
            if matches!(model.contact_model, ContactModel::Soft { .. }) {
                columns.push(Wrench::new(0.0, 0.0, 0.0, normal.x, normal.y, normal.z));
            }
        }
        Self::of_columns(&columns)
    }

    fn of_columns(columns: &[Wrench]) -> Self {
        let mut singular_values = [0.0; 6];
        if !columns.is_empty() {
            let matrix = Matrix6xX::from_columns(columns);
            if let Some(svd) = SVD::try_new(matrix, false, false, f64::EPSILON, MAX_STEPS) {
                for (slot, value) in singular_values.iter_mut().zip(&svd.singular_values) {
                    *slot = *value;
                }
            }
        }
        Self { singular_values }
    }

    /// Returns σ_min, zero when there are fewer than six columns.
    pub fn smallest_singular_value(&self) -> f64 {
        self.singular_values[5]
    }

    /// Returns σ_min/σ_max, from 0 to 1.
    pub fn isotropy(&self) -> f64 {
        let [greatest, .., least] = self.singular_values;
        if greatest > 0.0 {
            least / greatest
        } else {
            0.0
        }
    }

    /// Returns √det(G·Gᵀ).
    pub fn ellipsoid_volume(&self) -> f64 {
        self.singular_values.iter().product()
    }
}
