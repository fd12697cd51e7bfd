//! Quality of a grasp under any contact model and in either wrench space.

use super::evaluator::Evaluator;
use super::margin::{Degenerate, Margin};
use crate::contact::Contact;
use crate::wrench::{Wrench, WrenchModel};

/// Relative width of the interval on ε where the wrench space is no finite hull, unless the caller says
/// otherwise: the digits that coordinates in single precision leave.
pub const ACCURACY: f64 = 1e-6;

impl Evaluator {
    /// Returns ε of a grasp, or a hyperplane that proves that it is not force closure.
    ///
    /// The value is exact, as that of [`Self::quality`], for frictionless contacts and pyramids in L1. Otherwise it is an
    /// interval: ε lies between `value` and `upper`, which differ by at most `accuracy` times `upper` unless the margin is
    /// not exact; `direction` belongs to `upper`.
    ///
    /// ```
    /// use graspd_core::contact::{Cone, ConeEdges, Contact, ContactModel, Friction};
    /// use graspd_core::quality::{ACCURACY, Evaluator};
    /// use graspd_core::wrench::{EdgeNorm, WrenchModel, WrenchSpace};
    /// use nalgebra::{Point3, Unit, Vector3};
    ///
    /// // Four hard fingers at the corners of a regular tetrahedron, pushing towards its centre.
    /// let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    /// let contacts = corners.map(|corner| Contact {
    ///     position: Point3::from(corner),
    ///     normal: Unit::new_normalize(-Vector3::from(corner)),
    /// });
    /// let model = WrenchModel {
    ///     contact_model: ContactModel::Hard {
    ///         friction: Friction::new(0.3).expect("from above 0 to 10"),
    ///         cone: Cone::Pyramid(ConeEdges::new(8).expect("from 3 to 32")),
    ///     },
    ///     edge_norm: EdgeNorm::UnitEdge,
    ///     space: WrenchSpace::L1,
    ///     center: Point3::origin(),
    ///     torque_scale: 3.0_f64.sqrt().recip(), // one over the radius
    /// };
    /// let mut evaluator = Evaluator::new();
    /// let grasp = evaluator.grasp_quality(&model, &contacts, ACCURACY)?;
    /// assert!(grasp.exact && grasp.is_force_closure());
    ///
    /// // Three of them do not surround the body: the margin is negative, and nothing can be exerted along its direction.
    /// let three = evaluator.grasp_margin(&model, &contacts[..3], ACCURACY)?;
    /// assert!(three.value < 0.0);
    /// # Ok::<(), graspd_core::quality::Degenerate>(())
    /// ```
    pub fn grasp_quality(
        &mut self,
        model: &WrenchModel,
        contacts: &[Contact],
        accuracy: f64,
    ) -> Result<Margin, Degenerate> {
        self.grasp_quality_above(model, contacts, accuracy, f64::NEG_INFINITY)
    }

    /// As [`Self::grasp_quality`], but only where ε exceeds `threshold`: once it is known not to, the margin
    /// so far is returned, inexact, with `upper` at most the threshold.
    pub fn grasp_quality_above(
        &mut self,
        model: &WrenchModel,
        contacts: &[Contact],
        accuracy: f64,
        threshold: f64,
    ) -> Result<Margin, Degenerate> {
        if model.is_finite_hull() {
            return self.with_wrenches(model, contacts, |evaluator, wrenches| {
                evaluator.quality_above(wrenches, threshold)
            });
        }
        self.interval.quality(model, contacts, accuracy, threshold)
    }

    /// As [`Self::grasp_quality`] inside; outside, how far.
    ///
    /// For frictionless contacts and pyramids in L1 as [`Self::margin`] has it: the least offset of any
    /// facet, which is not the distance of the origin from the hull ([`Self::distance`]). The hull of round cones has no such thing; there the margin is minus the distance of the
    /// origin from the wrench space, from `value` to `upper`, and −direction leads from the origin to the
    /// nearest wrench that can be exerted. Every L∞ space contains the origin: without force closure
    /// `value` is zero to [`CLOSURE_TOLERANCE`](super::CLOSURE_TOLERANCE) and the direction one along which
    /// nothing can be exerted.
    pub fn grasp_margin(
        &mut self,
        model: &WrenchModel,
        contacts: &[Contact],
        accuracy: f64,
    ) -> Result<Margin, Degenerate> {
        if model.is_finite_hull() {
            return self.with_wrenches(model, contacts, Self::margin);
        }
        self.interval.margin(model, contacts, accuracy)
    }

    /// Returns the distance of the origin from the wrench space, with an error of at most `accuracy` times itself above and
    /// never too large; zero when that cannot be distinguished from zero. `direction` is one along which nothing can be exerted, as
    /// [`Margin::direction`] without force closure. Some microseconds.
    pub fn distance(
        &mut self,
        model: &WrenchModel,
        contacts: &[Contact],
        direction: &Wrench,
        accuracy: f64,
    ) -> f64 {
        self.interval.distance(model, contacts, direction, accuracy)
    }

    fn with_wrenches(
        &mut self,
        model: &WrenchModel,
        contacts: &[Contact],
        evaluate: impl FnOnce(&mut Self, &[Wrench]) -> Result<Margin, Degenerate>,
    ) -> Result<Margin, Degenerate> {
        let mut wrenches = std::mem::take(&mut self.wrenches);
        wrenches.clear();
        for contact in contacts {
            model.push_wrenches(contact, &mut wrenches);
        }
        let margin = evaluate(self, &wrenches);
        self.wrenches = wrenches;
        margin
    }
}
