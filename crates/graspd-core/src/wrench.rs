//! Forces and torques as points of a 6-D space.

use nalgebra::{Point3, Unit, UnitVector3, Vector3, Vector6};

use super::contact::{Cone, Contact, ContactModel, Friction};
pub use super::torque_scale::TorqueScale;

/// (f; λ·(p−c)×f): force, then torque scaled by λ so that both share one unit.
pub type Wrench = Vector6<f64>;

/// How long the edges of a linearised friction cone are.
///
/// With one friction coefficient μ for all contacts, every wrench and so ε under `UnitNormal` is
/// √(1+μ²) times that under `UnitEdge`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub enum EdgeNorm {
    /// Unit vectors (paper, eq. 3).
    UnitEdge,
    /// Unit normal component: n + μt (GraspIt!, Dex-Net).
    UnitNormal,
}

/// How the wrenches of all contacts add up to the grasp wrench space (Ferrari & Canny 1992).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub enum WrenchSpace {
    /// Convex hull of the contacts' wrenches: the normal forces sum to one.
    #[default]
    L1,
    /// Minkowski sum of the contacts' wrenches, each with zero: every normal force is at most one.
    Linf,
}

/// Everything that turns contacts into a grasp wrench space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WrenchModel {
    pub contact_model: ContactModel,
    pub edge_norm: EdgeNorm,
    pub space: WrenchSpace,
    /// The point c that torques are taken about.
    pub center: Point3<f64>,
    /// The number λ, 1/length.
    pub torque_scale: f64,
}

/// Edges of the pyramid that stands in for a round cone where a finite set of wrenches is needed:
/// in the search for a first grasp, whose force closure does not depend on it but near the border.
pub const STAND_IN_EDGES: usize = 16;

/// Below this ratio of its tangential part to its length the lever arm does not define a
/// direction in the tangent plane: rounding of the subtraction that makes it (one part in 2⁵²)
/// would turn the cone by more than 10⁻⁶ rad.
const LEVER_TOLERANCE: f64 = 1e-10;

impl WrenchModel {
    /// The wrench of a force at a point.
    pub fn wrench(&self, position: &Point3<f64>, force: &Vector3<f64>) -> Wrench {
        let torque = (position - self.center).cross(force) * self.torque_scale;
        Wrench::new(force.x, force.y, force.z, torque.x, torque.y, torque.z)
    }

    /// Appends the primitive wrenches of one contact (paper, eqs. 1 and 4).
    ///
    /// Of a round cone those of the pyramid with [`STAND_IN_EDGES`] edges.
    pub fn push_wrenches(&self, contact: &Contact, out: &mut Vec<Wrench>) {
        match self.contact_model {
            ContactModel::Frictionless => {
                out.push(self.wrench(&contact.position, &contact.normal));
            }
            ContactModel::Hard { friction, cone } => {
                self.push_edges(contact, friction, cone, out);
            }
            ContactModel::Soft {
                friction,
                torsion,
                cone,
            } => {
                self.push_edges(contact, friction, cone, out);
                let length = self.edge_length(friction);
                let center = self.wrench(&contact.position, &contact.normal) * length;
                let twist = self.twist(contact) * (torsion.get() * length);
                out.extend([center + twist, center - twist]);
            }
        }
    }

    fn push_edges(&self, contact: &Contact, friction: Friction, cone: Cone, out: &mut Vec<Wrench>) {
        let edges = cone.edges().unwrap_or(STAND_IN_EDGES);
        let length = self.edge_length(friction);
        let (t1, t2) = self.tangents(contact);
        let normal = contact.normal.into_inner();
        let (step_sin, step_cos) = (std::f64::consts::TAU / edges as f64).sin_cos();
        let (mut sin, mut cos) = (0.0, 1.0);
        for _ in 0..edges {
            let edge = (normal + (t1 * cos + t2 * sin) * friction.get()) * length;
            out.push(self.wrench(&contact.position, &edge));
            (sin, cos) = (
                sin * step_cos + cos * step_sin,
                cos * step_cos - sin * step_sin,
            );
        }
    }

    /// Whether the wrench space is the hull of finitely many primitive wrenches.
    pub fn is_finite_hull(&self) -> bool {
        self.space == WrenchSpace::L1 && !self.contact_model.is_round()
    }

    /// What an evaluation of the quality costs, in wrenches of a finite hull: an interval takes some four
    /// times the facets.
    pub(super) fn effort(&self, contacts: usize) -> usize {
        let finite = self.contact_model.wrenches_per_contact();
        let times = if self.is_finite_hull() { 1 } else { 4 };
        (times * contacts * finite.unwrap_or(STAND_IN_EDGES)).max(1)
    }

    /// Appends what the slice of a round cone at the normal component of its edges consists of: its
    /// centre c, then the columns of A, two of a hard and three of a soft contact, so that the slice is
    /// c + A·z for ‖z‖ ≤ 1. Of other contacts the centre only.
    pub fn push_slice(&self, contact: &Contact, out: &mut Vec<Wrench>) {
        let (friction, torsion) = match self.contact_model {
            ContactModel::Frictionless => (None, None),
            ContactModel::Hard { friction, .. } => (Some(friction), None),
            ContactModel::Soft {
                friction, torsion, ..
            } => (Some(friction), Some(torsion)),
        };
        let length = friction.map_or(1.0, |friction| self.edge_length(friction));
        let along = |force: &Vector3<f64>| self.wrench(&contact.position, force) * length;
        out.push(along(&contact.normal));
        if let Some(friction) = friction {
            let (t1, t2) = self.tangents(contact);
            out.extend([t1, t2].map(|t| along(&t) * friction.get()));
        }
        out.extend(torsion.map(|torsion| self.twist(contact) * (torsion.get() * length)));
    }

    /// How far the slice of a contact's round cone at the normal component of its edges reaches along u, its
    /// support n·v + √(μ²‖v_t‖² + (μ_t·λ·n·b)²) times that component, with u = (a; b) and v = a + b × λ·(p−c)
    /// in parts along the normal n and across. Of a pyramid, which is inscribed, an upper bound. O(1).
    pub fn reach_bound(&self, contact: &Contact, direction: &Wrench) -> f64 {
        let normal = contact.normal.into_inner();
        let (a, b) = (
            direction.fixed_rows::<3>(0),
            direction.fixed_rows::<3>(3) * self.torque_scale,
        );
        let v = a + b.cross(&(contact.position - self.center));
        let along = normal.dot(&v);
        let (friction, twist) = match self.contact_model {
            ContactModel::Frictionless => return along,
            ContactModel::Hard { friction, .. } => (friction, 0.0),
            ContactModel::Soft {
                friction, torsion, ..
            } => (friction, torsion.get() * normal.dot(&b)),
        };
        let across = (v - normal * along).norm() * friction.get();
        (along + across.hypot(twist)) * self.edge_length(friction)
    }

    /// How far the generator of one contact reaches along a direction u = (a, b): with the force
    /// v = a + b × λ(p − c) it is n·v for the normal, and what the cone has beside it (Coulomb's cone:
    /// μ times the tangential part of v) on top. In L∞ contacts may push with no force, and what is below
    /// zero is none.
    pub fn reach(&self, contact: &Contact, direction: &Wrench) -> f64 {
        let a = direction.fixed_rows::<3>(0).into_owned();
        let b = direction.fixed_rows::<3>(3).into_owned();
        let force = a + b.cross(&((contact.position - self.center) * self.torque_scale));
        let normal = contact.normal.into_inner();
        let along = normal.dot(&force);
        let (friction, torsion, cone) = match self.contact_model {
            ContactModel::Frictionless => return along,
            ContactModel::Hard { friction, cone } => (friction, 0.0, cone),
            ContactModel::Soft {
                friction,
                torsion,
                cone,
            } => (friction, torsion.get() * self.torque_scale, cone),
        };
        let twist = torsion * normal.dot(&b);
        let mu = friction.get();
        let beside = match cone.edges() {
            None => {
                let across = (force - normal * along).norm() * mu;
                across.hypot(twist)
            }
            Some(edges) => {
                let (t1, t2) = self.tangents(contact);
                let (x, y) = (t1.dot(&force), t2.dot(&force));
                let (step_sin, step_cos) = (std::f64::consts::TAU / edges as f64).sin_cos();
                let (mut sin, mut cos) = (0.0, 1.0);
                let mut most = f64::NEG_INFINITY;
                for _ in 0..edges {
                    most = most.max(x * cos + y * sin);
                    (sin, cos) = (
                        sin * step_cos + cos * step_sin,
                        cos * step_cos - sin * step_sin,
                    );
                }
                let most = most * mu;
                if torsion > 0.0 {
                    most.max(twist.abs())
                } else {
                    most
                }
            }
        };
        (along + beside) * self.edge_length(friction)
    }

    /// Normal component of an edge of the cone.
    pub fn edge_length(&self, friction: Friction) -> f64 {
        match self.edge_norm {
            EdgeNorm::UnitEdge => friction.get().hypot(1.0).recip(),
            EdgeNorm::UnitNormal => 1.0,
        }
    }

    /// The wrench of a torque of one length unit times unit force about the normal.
    pub fn twist(&self, contact: &Contact) -> Wrench {
        let torque = contact.normal.into_inner() * self.torque_scale;
        Wrench::new(0.0, 0.0, 0.0, torque.x, torque.y, torque.z)
    }

    /// Orthonormal tangents at a contact.
    ///
    /// The first points along the tangential part of the lever arm p − c, so that the edges of the
    /// cone turn with the body and ε does not change when the mesh is rotated, moved, scaled or
    /// renumbered. Where the lever arm is parallel to the normal an axis of the frame stands in.
    pub fn tangents(&self, contact: &Contact) -> (Vector3<f64>, Vector3<f64>) {
        let normal = contact.normal;
        let lever = contact.position - self.center;
        let along = lever - normal.into_inner() * lever.dot(&normal);
        let t1 = Unit::try_new(along, LEVER_TOLERANCE * lever.norm())
            .unwrap_or_else(|| any_tangent(&normal));
        (t1.into_inner(), normal.cross(&t1))
    }
}

/// A unit vector orthogonal to `normal`, made from the axis that is least aligned with it.
fn any_tangent(normal: &UnitVector3<f64>) -> UnitVector3<f64> {
    let axis = Vector3::ith(normal.iamin(), 1.0);
    Unit::new_normalize(axis - normal.into_inner() * normal.dot(&axis))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{ConeEdges, Friction, Torsion};

    fn contact() -> Contact {
        Contact {
            position: Point3::new(1.0, 2.0, -0.5),
            normal: Unit::new_normalize(Vector3::new(0.3, -0.7, 0.2)),
        }
    }

    fn model(edge_norm: EdgeNorm) -> WrenchModel {
        WrenchModel {
            contact_model: ContactModel::Hard {
                friction: Friction::new(0.4).unwrap(),
                cone: Cone::Pyramid(ConeEdges::new(8).unwrap()),
            },
            edge_norm,
            space: WrenchSpace::L1,
            center: Point3::new(0.1, 0.2, 0.3),
            torque_scale: 0.5,
        }
    }

    #[test]
    fn edges_lie_on_the_friction_cone_and_are_unit_vectors() {
        let mut wrenches = Vec::new();
        model(EdgeNorm::UnitEdge).push_wrenches(&contact(), &mut wrenches);
        assert_eq!(wrenches.len(), 8);
        for w in &wrenches {
            let force = Vector3::new(w[0], w[1], w[2]);
            assert!((force.norm() - 1.0).abs() < 1e-14);
            let normal = force.dot(&contact().normal);
            let tangential = (force - contact().normal.into_inner() * normal).norm();
            assert!((tangential - 0.4 * normal).abs() < 1e-14);
        }
    }

    #[test]
    fn unit_normal_edges_are_longer_by_the_root_of_one_plus_mu_squared() {
        let (mut unit_edge, mut unit_normal) = (Vec::new(), Vec::new());
        model(EdgeNorm::UnitEdge).push_wrenches(&contact(), &mut unit_edge);
        model(EdgeNorm::UnitNormal).push_wrenches(&contact(), &mut unit_normal);
        for (a, b) in unit_edge.iter().zip(&unit_normal) {
            assert!((a * 1.16f64.sqrt() - b).norm() < 1e-14);
        }
    }

    #[test]
    fn the_reach_is_that_of_the_slice_and_of_the_edges() {
        let friction = Friction::new(0.4).unwrap();
        let torsion = Torsion::new(0.3).unwrap();
        let pyramid = Cone::Pyramid(ConeEdges::new(32).unwrap());
        let mut model = model(EdgeNorm::UnitEdge);
        for seed in 0..40 {
            let direction = Wrench::from_fn(|i, _| (seed as f64 * 1.7 + i as f64 * 2.3).sin());
            for (contact_model, finer) in [
                (ContactModel::Frictionless, 1.0),
                (
                    ContactModel::Hard {
                        friction,
                        cone: pyramid,
                    },
                    0.99,
                ),
                (
                    ContactModel::Hard {
                        friction,
                        cone: Cone::Round,
                    },
                    1.0,
                ),
                (
                    ContactModel::Soft {
                        friction,
                        torsion,
                        cone: Cone::Round,
                    },
                    1.0,
                ),
            ] {
                model.contact_model = contact_model;
                let mut slice = Vec::new();
                model.push_slice(&contact(), &mut slice);
                let heights: Vec<f64> = slice.iter().map(|w| w.dot(&direction)).collect();
                let round = heights[1..].iter().map(|h| h * h).sum::<f64>().sqrt();
                let bound = model.reach_bound(&contact(), &direction);
                assert!((heights[0] + round - bound).abs() < 1e-14);
                let reach = model.reach(&contact(), &direction);
                assert!(reach <= bound + 1e-14);
                assert!(reach >= heights[0] + finer * round - 1e-14);
            }
        }
    }

    #[test]
    fn a_contact_facing_its_centre_still_has_a_cone() {
        let mut m = model(EdgeNorm::UnitEdge);
        let c = contact();
        m.center = c.position + c.normal.into_inner() * 3.0;
        let mut wrenches = Vec::new();
        m.push_wrenches(&c, &mut wrenches);
        let mean = wrenches.iter().sum::<Wrench>() / 8.0;
        let axis = Vector3::new(mean[0], mean[1], mean[2]).normalize();
        assert!((axis - c.normal.into_inner()).norm() < 1e-14);
    }
}
