//! The least contact forces that resist an external wrench.
//!
//! The problem: among all contact forces within their friction cones that balance the wrench w, find those
//! with the least sum of normal forces (Roa & Suárez 2015, section 2.3; Han, Trinkle & Li 2000 for the conic
//! form).
//!
//! Solved the other way round, it is a ray through the wrench space: among all contact forces whose normal
//! components sum to one, find those that balance the greatest multiple t of w/‖w‖. If f solves the second
//! problem, then f·‖w‖/t solves the first, because scaling forces leaves them in their cones. The second
//! problem stays well scaled however weak the grasp is: its unknowns are shares of one, while the forces of
//! the first grow without bound as ε approaches zero. `max_resistible.rs` solves it as a linear program for pyramids and
//! as a second-order cone program for round cones, in at most 100 steps of O(columns) each.

use nalgebra::Vector3;

use super::contact::Contact;
use super::max_resistible::{Balance, Columns, LEAST_REACH, Resistible};
use super::wrench::{Wrench, WrenchModel, WrenchSpace};

/// A wrench counts as not resisted when forces of this many times its size do not suffice. Beyond it, the
/// duality gap of the solution is no longer small compared with the forces.
pub const GREATEST_EFFORT: f64 = 1.0 / LEAST_REACH;

/// A force and a torque about the centre of mass that act on the body from outside, in the mesh's
/// frame: any unit of force, torques in that times the mesh's unit of length.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct ExternalWrench {
    #[cfg_attr(feature = "serde", serde(default))]
    #[cfg_attr(feature = "schema", schema(value_type = [f64; 3]))]
    pub force: Vector3<f64>,
    // Not scaled by λ, as the torques of the wrench space are.
    #[cfg_attr(feature = "serde", serde(default))]
    #[cfg_attr(feature = "schema", schema(value_type = [f64; 3]))]
    pub torque: Vector3<f64>,
}

impl ExternalWrench {
    /// Converts a wrench of the scaled space to unscaled units.
    pub fn of_wrench(model: &WrenchModel, wrench: &Wrench) -> Self {
        Self {
            force: wrench.fixed_rows::<3>(0).into_owned(),
            torque: wrench.fixed_rows::<3>(3) / model.torque_scale,
        }
    }

    /// Converts it to the scaled space.
    pub fn wrench(&self, model: &WrenchModel) -> Wrench {
        let (f, t) = (self.force, self.torque * model.torque_scale);
        Wrench::new(f.x, f.y, f.z, t.x, t.y, t.z)
    }
}

/// The force and torque of one finger on the body, in the mesh's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactForce {
    /// In the unit of the external force.
    pub force: Vector3<f64>,
    /// Torque about the inward normal, in that unit times the mesh's unit of length; zero except for soft
    /// fingers.
    pub torsion: f64,
}

/// Contact forces that balance an external wrench with the least sum of normal forces.
#[derive(Debug, Clone, PartialEq)]
pub struct Effort {
    /// One per contact, in their order.
    pub forces: Vec<ContactForce>,
    /// Sum of the normal forces, in the unit of the external force.
    pub total: f64,
}

/// Returns the least contact forces that balance `external`, in the friction cones of `model`: round ones as they are,
/// pyramids through their edges. Neither the edge norm nor the wrench space matters.
///
/// Returns `None` when the grasp cannot resist the wrench, or only with more than [`GREATEST_EFFORT`] times its size, and
/// when the solution fails a tolerance. Some 100 µs for four contacts.
pub fn least_effort(
    model: &WrenchModel,
    contacts: &[Contact],
    external: &ExternalWrench,
) -> Option<Effort> {
    let wrench = external.wrench(model);
    let size = wrench.norm();
    if size == 0.0 {
        let idle = ContactForce {
            force: Vector3::zeros(),
            torsion: 0.0,
        };
        return Some(Effort {
            forces: vec![idle; contacts.len()],
            total: 0.0,
        });
    }
    if !size.is_finite() || contacts.is_empty() {
        return None;
    }
    let columns = Columns::new(model, contacts);
    let Resistible::UpTo(Balance { reach, forces }) =
        columns.max_resistible(WrenchSpace::L1, &(wrench / size))
    else {
        return None;
    };
    let total = size / reach;
    let force = |(force, torsion): (Vector3<f64>, f64)| ContactForce {
        force: force * total,
        torsion: torsion * total,
    };
    Some(Effort {
        forces: forces.into_iter().map(force).collect(),
        total,
    })
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix6, Point3, Unit};
    use rand::{Rng, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::contact::{Cone as Shape, ConeEdges, ContactModel, Friction, Torsion};
    use crate::quality::Evaluator;
    use crate::wrench::EdgeNorm;

    const MU: f64 = 0.6;
    const TORSION: f64 = 0.15;

    fn uniform(rng: &mut Pcg64) -> f64 {
        (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn vector(rng: &mut Pcg64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| 2.0 * uniform(rng) - 1.0)
    }

    fn pyramid(edges: u32) -> Shape {
        Shape::Pyramid(ConeEdges::new(edges).unwrap())
    }

    fn hard(cone: Shape) -> ContactModel {
        ContactModel::Hard {
            friction: Friction::new(MU).unwrap(),
            cone,
        }
    }

    fn soft(cone: Shape) -> ContactModel {
        ContactModel::Soft {
            friction: Friction::new(MU).unwrap(),
            torsion: Torsion::new(TORSION).unwrap(),
            cone,
        }
    }

    fn model(contact_model: ContactModel) -> WrenchModel {
        WrenchModel {
            contact_model,
            edge_norm: EdgeNorm::UnitNormal,
            space: WrenchSpace::L1,
            center: Point3::new(0.1, 0.0, -0.1),
            torque_scale: 0.8,
        }
    }

    /// Contacts on a sphere whose normals lean up to some 15 degrees from its centre.
    fn grasp(rng: &mut Pcg64, m: usize) -> Vec<Contact> {
        (0..m)
            .map(|_| {
                let out = vector(rng).normalize();
                Contact {
                    position: Point3::from(out),
                    normal: Unit::new_normalize(vector(rng) * 0.3 - out),
                }
            })
            .collect()
    }

    fn external(rng: &mut Pcg64) -> ExternalWrench {
        ExternalWrench {
            force: vector(rng),
            torque: vector(rng),
        }
    }

    /// Newton's and Coulomb's laws, from the forces alone.
    fn check(
        model: &WrenchModel,
        contacts: &[Contact],
        external: &ExternalWrench,
        effort: &Effort,
    ) {
        let mut force = external.force;
        let mut torque = external.torque;
        let mut total = 0.0;
        let allowed = 1e-7 * effort.total;
        for (contact, at) in contacts.iter().zip(&effort.forces) {
            force += at.force;
            torque += (contact.position - model.center).cross(&at.force)
                + contact.normal.into_inner() * at.torsion;
            let normal = at.force.dot(&contact.normal);
            let tangential = (at.force - contact.normal.into_inner() * normal).norm();
            total += normal;
            match model.contact_model {
                ContactModel::Frictionless => assert!(tangential <= allowed && normal >= -allowed),
                ContactModel::Hard { .. } => assert!(tangential <= MU * normal + allowed),
                ContactModel::Soft { .. } => assert!(
                    (tangential / MU).hypot(at.torsion / TORSION) <= normal + 1e-6 * effort.total
                ),
            }
            if !matches!(model.contact_model, ContactModel::Soft { .. }) {
                assert_eq!(at.torsion, 0.0);
            }
        }
        assert!(force.norm() <= allowed, "{force}");
        assert!(torque.norm() <= allowed, "{torque}");
        assert!((total - effort.total).abs() <= allowed);
    }

    #[test]
    fn forces_obey_newton_and_coulomb_in_every_model() {
        let mut rng = Pcg64::seed_from_u64(3);
        let mut resisted = [0; 5];
        for _ in 0..60 {
            for (kind, (contact_model, m)) in [
                (ContactModel::Frictionless, 9),
                (hard(pyramid(8)), 4),
                (hard(Shape::Round), 4),
                (soft(pyramid(8)), 3),
                (soft(Shape::Round), 3),
            ]
            .into_iter()
            .enumerate()
            {
                let model = model(contact_model);
                let contacts = grasp(&mut rng, m);
                let external = external(&mut rng);
                if let Some(effort) = least_effort(&model, &contacts, &external) {
                    resisted[kind] += 1;
                    check(&model, &contacts, &external, &effort);
                }
            }
        }
        assert!(resisted.iter().all(|&count| count >= 5), "{resisted:?}");
    }

    /// min Σ normal forces by trying every six edges: the optimum is at such a corner.
    fn slow_total(
        model: &WrenchModel,
        contacts: &[Contact],
        external: &ExternalWrench,
    ) -> Option<f64> {
        let mut edges = Vec::new();
        for contact in contacts {
            model.push_wrenches(contact, &mut edges);
        }
        let target = -external.wrench(model);
        let mut least: Option<f64> = None;
        let n = edges.len();
        for mask in 0_u32..1 << n {
            if mask.count_ones() != 6 {
                continue;
            }
            let chosen: Vec<Wrench> = (0..n)
                .filter(|i| mask >> i & 1 == 1)
                .map(|i| edges[i])
                .collect();
            let Some(inverse) = Matrix6::from_columns(&chosen).try_inverse() else {
                continue;
            };
            let amounts = inverse * target;
            if inverse.amax() < 1e8 && amounts.min() >= -1e-9 {
                let total = amounts.sum();
                least = Some(least.map_or(total, |least| least.min(total)));
            }
        }
        least
    }

    #[test]
    fn of_all_corners_none_takes_less() {
        let mut rng = Pcg64::seed_from_u64(5);
        let (mut resisted, mut unresisted) = (0, 0);
        for round in 0..60 {
            let (contact_model, m) = match round % 3 {
                0 => (ContactModel::Frictionless, 10),
                1 => (hard(pyramid(4)), 3),
                _ => (soft(pyramid(4)), 2),
            };
            let model = model(contact_model);
            let contacts = grasp(&mut rng, m);
            let external = external(&mut rng);
            let slow = slow_total(&model, &contacts, &external);
            let fast = least_effort(&model, &contacts, &external);
            match (slow, fast) {
                (Some(slow), Some(fast)) => {
                    resisted += 1;
                    assert!(
                        (slow - fast.total).abs() < 1e-7 * slow,
                        "{slow} {}",
                        fast.total
                    );
                }
                (None, None) => unresisted += 1,
                (slow, fast) => panic!("{slow:?} but {fast:?}"),
            }
        }
        assert!(resisted > 5 && unresisted > 5, "{resisted} {unresisted}");
    }

    #[test]
    fn the_weakest_wrench_takes_one_over_epsilon() {
        let mut rng = Pcg64::seed_from_u64(7);
        let mut closed = 0;
        for edge_norm in [EdgeNorm::UnitNormal, EdgeNorm::UnitEdge] {
            for _ in 0..40 {
                let mut model = model(hard(pyramid(8)));
                model.edge_norm = edge_norm;
                let contacts = grasp(&mut rng, 4);
                let mut wrenches = Vec::new();
                for contact in &contacts {
                    model.push_wrenches(contact, &mut wrenches);
                }
                let margin = Evaluator::new().quality(&wrenches).unwrap();
                if margin.value < 1e-3 {
                    continue;
                }
                closed += 1;
                let weakest = ExternalWrench::of_wrench(&model, &-margin.direction);
                let effort = least_effort(&model, &contacts, &weakest).unwrap();
                let length = model.edge_length(Friction::new(MU).unwrap());
                assert!((effort.total * margin.value / length - 1.0).abs() < 1e-7);
                // Everything else of unit length takes no more.
                let other = Wrench::from_fn(|_, _| 2.0 * uniform(&mut rng) - 1.0).normalize();
                let other = ExternalWrench::of_wrench(&model, &other);
                let easier = least_effort(&model, &contacts, &other).unwrap();
                assert!(easier.total <= effort.total * (1.0 + 1e-7));
            }
        }
        assert!(closed > 20, "{closed}");
    }

    /// Two opposite fingers that carry a weight: each bears half of it by friction.
    #[test]
    fn two_fingers_carry_a_weight_by_friction() {
        let finger = |x: f64| Contact {
            position: Point3::new(x, 0.0, 0.0),
            normal: Unit::new_normalize(Vector3::new(-x, 0.0, 0.0)),
        };
        let contacts = [finger(0.5), finger(-0.5)];
        let weight = |newton: f64| ExternalWrench {
            force: Vector3::new(0.0, 0.0, -newton),
            torque: Vector3::zeros(),
        };
        for contact_model in [hard(Shape::Round), soft(Shape::Round)] {
            let mut model = model(contact_model);
            model.center = Point3::origin();
            for newton in [1e-20, 3.0, 1e20] {
                let effort = least_effort(&model, &contacts, &weight(newton)).unwrap();
                assert!((effort.total / newton - 1.0 / MU).abs() < 1e-7);
                for at in &effort.forces {
                    assert!((at.force.z / newton - 0.5).abs() < 1e-6);
                }
            }
            // A torque about the line between them takes soft fingers.
            let twist = ExternalWrench {
                force: Vector3::zeros(),
                torque: Vector3::new(1.0, 0.0, 0.0),
            };
            let effort = least_effort(&model, &contacts, &twist);
            match contact_model {
                ContactModel::Soft { .. } => {
                    assert!((effort.unwrap().total - 1.0 / TORSION).abs() < 1e-6);
                }
                _ => assert_eq!(effort, None),
            }
        }
    }

    #[test]
    fn finer_pyramids_come_down_to_the_round_cone() {
        let mut rng = Pcg64::seed_from_u64(11);
        let contacts = grasp(&mut rng, 5);
        let external = external(&mut rng);
        for of in [hard, soft] {
            let total = |cone| {
                least_effort(&model(of(cone)), &contacts, &external)
                    .unwrap()
                    .total
            };
            let round = total(Shape::Round);
            let [coarse, fine] = [4, 32].map(|edges| total(pyramid(edges)));
            assert!(round <= fine * (1.0 + 1e-7) && fine <= coarse * (1.0 + 1e-7));
            if matches!(of(Shape::Round), ContactModel::Hard { .. }) {
                // The pyramid holds the round cone of cos(π/32) times the friction.
                assert!(fine - round < 0.02 * round);
            }
        }
    }

    #[test]
    fn unit_scale_and_edge_norm_play_no_part() {
        let mut rng = Pcg64::seed_from_u64(13);
        let contacts = grasp(&mut rng, 5);
        let external = external(&mut rng);
        let mut model = model(soft(Shape::Round));
        let total = least_effort(&model, &contacts, &external).unwrap().total;
        for torque_scale in [1e-2, 1.0, 1e2] {
            for edge_norm in [EdgeNorm::UnitEdge, EdgeNorm::UnitNormal] {
                (model.torque_scale, model.edge_norm) = (torque_scale, edge_norm);
                let there = least_effort(&model, &contacts, &external).unwrap();
                assert!((there.total / total - 1.0).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn nothing_needs_nothing_and_nonsense_is_not_resisted() {
        let contacts = grasp(&mut Pcg64::seed_from_u64(17), 4);
        let model = model(hard(Shape::Round));
        let of = |x: f64| ExternalWrench {
            force: Vector3::new(x, 0.0, 0.0),
            torque: Vector3::zeros(),
        };
        assert_eq!(
            least_effort(&model, &contacts, &of(0.0)).unwrap().total,
            0.0
        );
        assert_eq!(least_effort(&model, &contacts, &of(f64::NAN)), None);
        assert_eq!(least_effort(&model, &contacts, &of(f64::INFINITY)), None);
        assert_eq!(least_effort(&model, &[], &of(1.0)), None);
    }
}
