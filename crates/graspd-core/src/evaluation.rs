//! The evaluation of one grasp: margin, obstacle to force closure, measures and contact forces.
//!
//! The margin says how far inside or outside the wrench space the origin is. Inside, the grasp is force
//! closure, the margin is its quality ε, and [`Evaluation::weakest`] holds the least contact forces against the
//! unit disturbance that the grasp resists worst. Outside, [`Evaluation::obstacle`] names a motion of the body
//! that the contacts leave free.
//!
//! # Examples
//!
//! Four fingers with friction hold a ball:
//!
//! ```
//! use graspd_core::contact::{Cone, ConeEdges, Contact, ContactModel, Friction};
//! use graspd_core::evaluation::evaluate;
//! use graspd_core::wrench::{EdgeNorm, WrenchModel, WrenchSpace};
//! use nalgebra::{Point3, Unit, Vector3};
//!
//! let model = WrenchModel {
//!     contact_model: ContactModel::Hard {
//!         friction: Friction::new(0.5).unwrap(),
//!         cone: Cone::Pyramid(ConeEdges::new(8).unwrap()),
//!     },
//!     edge_norm: EdgeNorm::UnitEdge,
//!     space: WrenchSpace::L1,
//!     center: Point3::origin(),
//!     torque_scale: 1.0,
//! };
//! // Normals point into the body.
//! let finger = |direction: [f64; 3]| {
//!     let outward = Vector3::from(direction).normalize();
//!     Contact { position: outward.into(), normal: Unit::new_normalize(-outward) }
//! };
//! let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
//! let grasp = evaluate(&model, &corners.map(finger), 1e-6, &[]);
//!
//! assert!(grasp.force_closure && grasp.obstacle.is_none());
//! let margin = grasp.margin?;
//! assert!(margin.exact && margin.value > 0.1);
//! assert_eq!(grasp.measures.epsilon_l1, Some(margin.value));
//! # Ok::<(), graspd_core::quality::Degenerate>(())
//! ```
//!
//! When all fingers press from above, the margin is negative and the body is free to move down:
//!
//! ```
//! # use graspd_core::contact::{Cone, ConeEdges, Contact, ContactModel, Friction};
//! # use graspd_core::evaluation::evaluate;
//! # use graspd_core::wrench::{EdgeNorm, WrenchModel, WrenchSpace};
//! # use nalgebra::{Point3, Unit, Vector3};
//! use graspd_core::evaluation::Obstacle;
//! # let model = WrenchModel {
//! #     contact_model: ContactModel::Hard {
//! #         friction: Friction::new(0.5).unwrap(),
//! #         cone: Cone::Pyramid(ConeEdges::new(8).unwrap()),
//! #     },
//! #     edge_norm: EdgeNorm::UnitEdge,
//! #     space: WrenchSpace::L1,
//! #     center: Point3::origin(),
//! #     torque_scale: 1.0,
//! # };
//! # let finger = |direction: [f64; 3]| {
//! #     let outward = Vector3::from(direction).normalize();
//! #     Contact { position: outward.into(), normal: Unit::new_normalize(-outward) }
//! # };
//!
//! let above = [[1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [-1.0, 1.0, 1.0], [-1.0, -1.0, 1.0]];
//! let grasp = evaluate(&model, &above.map(finger), 1e-6, &[]);
//!
//! assert!(!grasp.force_closure);
//! let margin = grasp.margin?;
//! assert!(margin.value < 0.0);
//! let Some(Obstacle::Outside { distance, on_border, motion: Some(motion) }) = grasp.obstacle else {
//!     panic!("the wrenches span all six dimensions");
//! };
//! // The margin is the offset of the nearest facet; the origin may be beyond several of them.
//! assert!(distance >= -margin.value && !on_border);
//! assert!(motion.velocity_at(&model.center).z < 0.0);
//! # Ok::<(), graspd_core::quality::Degenerate>(())
//! ```

use super::contact::{Cone, Contact};
use super::effort::least_effort;
pub use super::effort::{ContactForce, Effort, ExternalWrench};
use super::interrupt::{Interrupt, Interrupted, uninterrupted};
pub use super::measures::Measures;
pub use super::motion::{Motion, MotionKind};
use super::quality::{ACCURACY, Degenerate, Evaluator, Margin};
use super::wrench::{WrenchModel, WrenchSpace};

/// The evaluation of one grasp.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    /// The position of the origin in the wrench space of the model, exactly or as an interval; an error when
    /// the contacts do not span the space.
    pub margin: Result<Margin, Degenerate>,
    /// Whether the margin is greater than rounding of the mesh can make it.
    pub force_closure: bool,
    /// [lower, upper]: an interval that contains the ε with round friction cones, in the space of the model;
    /// `None` without force closure.
    pub bounds: Option<[f64; 2]>,
    /// Whether `bounds` differ by at most 1e-6 of the upper one; `false` when the facet limit ended them earlier.
    pub bounds_exact: Option<bool>,
    /// Why there is no force closure; `None` with force closure.
    pub obstacle: Option<Obstacle>,
    pub measures: Measures,
    /// The least contact forces against the disturbance that the grasp resists worst; `None` without
    /// force closure.
    pub weakest: Option<Effort>,
    /// The least contact forces against each external wrench, in order; `None` for one that the grasp cannot
    /// resist.
    pub resisted: Vec<Option<Effort>>,
}

/// Why a grasp is not force closure. The motion is one that the contacts leave free; there may be others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Obstacle {
    /// The wrenches span only `rank` of 6 dimensions.
    RankDeficient { rank: usize, motion: Option<Motion> },
    /// The origin is not inside the wrench space.
    Outside {
        /// Distance of the origin from the wrench space, in the unit of the margin, to 1e-6 of itself; zero on the border,
        /// and when the margin is positive but no greater than rounding of the mesh can make it.
        distance: f64,
        /// Whether the distance is no greater than rounding of the mesh can make it.
        on_border: bool,
        motion: Option<Motion>,
    },
}

/// Greatest number of facets of a hull before it is abandoned. The largest grasps then take about a tenth of a
/// second.
pub const FACET_LIMIT: usize = 1 << 16;

/// Evaluates one grasp. A margin above `closure_floor` counts as force closure;
/// [`closure_floor`](super::search::closure_floor) computes one for a mesh.
///
/// [`evaluate_with`] does the same with a reused evaluator and can be interrupted.
pub fn evaluate(
    model: &WrenchModel,
    contacts: &[Contact],
    closure_floor: f64,
    external: &[ExternalWrench],
) -> Evaluation {
    uninterrupted(|interrupt| {
        let evaluator = &mut Evaluator::with_facet_limit(FACET_LIMIT);
        evaluate_with(
            evaluator,
            model,
            contacts,
            closure_floor,
            external,
            interrupt,
        )
    })
}

/// Evaluates one grasp, as [`evaluate`] does, in the working memory of `evaluator`. `interrupt` is checked
/// between hulls.
pub fn evaluate_with(
    evaluator: &mut Evaluator,
    model: &WrenchModel,
    contacts: &[Contact],
    closure_floor: f64,
    external: &[ExternalWrench],
    interrupt: Interrupt<'_>,
) -> Result<Evaluation, Interrupted> {
    let margin = evaluator.grasp_margin(model, contacts, ACCURACY);
    let closed = margin
        .ok()
        .filter(|margin| margin.value > closure_floor && margin.is_force_closure());
    let motion = |direction| Motion::unhindered(model, contacts, direction);
    let obstacle = match &margin {
        _ if closed.is_some() => None,
        Ok(margin) => {
            let distance = match margin.value < 0.0 {
                true => evaluator.distance(model, contacts, &margin.direction, ACCURACY),
                false => 0.0,
            };
            Some(Obstacle::Outside {
                distance,
                on_border: distance <= closure_floor,
                motion: motion(&margin.direction),
            })
        }
        Err(Degenerate { rank, direction }) => Some(Obstacle::RankDeficient {
            rank: *rank,
            motion: motion(direction),
        }),
    };
    interrupt.check()?;
    // The volume has a hull of its own: it is defined without force closure too, and for round cones it is
    // that of a pyramid.
    let mut measures = Measures::geometric(model, contacts);
    let mut wrenches = Vec::new();
    for contact in contacts {
        model.push_wrenches(contact, &mut wrenches);
    }
    measures.volume_l1 = evaluator.volume(&wrenches);
    let mut epsilon = |other: WrenchModel| {
        interrupt.check()?;
        Ok(match closed {
            // The margin is already the answer for the model itself.
            Some(margin) if other == *model => Some(margin),
            Some(_) => evaluator
                .grasp_quality(&other, contacts, ACCURACY)
                .ok()
                .filter(Margin::is_force_closure),
            None => None,
        })
    };
    let within = |space| WrenchModel { space, ..*model };
    let [l1, linf] = [WrenchSpace::L1, WrenchSpace::Linf].map(|space| epsilon(within(space)));
    let (l1, linf) = (l1?, linf?);
    measures.epsilon_l1 = l1.map(|margin| margin.value);
    measures.epsilon_linf = linf.map(|margin| margin.value);
    measures.epsilon_exact = l1.zip(linf).map(|(l1, linf)| l1.exact && linf.exact);
    let round = epsilon(WrenchModel {
        contact_model: model.contact_model.with_cone(Cone::Round),
        ..*model
    })?;
    let weakest = closed.and_then(|margin| {
        let disturbance = ExternalWrench::of_wrench(model, &-margin.direction);
        least_effort(model, contacts, &disturbance)
    });
    let mut resisted = Vec::with_capacity(external.len());
    for external in external {
        interrupt.check()?;
        resisted.push(least_effort(model, contacts, external));
    }
    Ok(Evaluation {
        margin,
        force_closure: closed.is_some(),
        bounds: round.map(|margin| [margin.value, margin.upper]),
        bounds_exact: round.map(|margin| margin.exact),
        obstacle,
        measures,
        weakest,
        resisted,
    })
}

#[cfg(test)]
mod number_tests;

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Unit, UnitVector3, Vector3};

    use super::*;
    use crate::contact::{Cone, ConeEdges, ContactModel, Friction, Torsion};
    use crate::wrench::EdgeNorm;

    const FLOOR: f64 = 1e-6;

    fn cone() -> Cone {
        Cone::Pyramid(ConeEdges::new(8).unwrap())
    }

    fn hard() -> ContactModel {
        ContactModel::Hard {
            friction: Friction::new(0.5).unwrap(),
            cone: cone(),
        }
    }

    fn soft() -> ContactModel {
        ContactModel::Soft {
            friction: Friction::new(0.5).unwrap(),
            torsion: Torsion::new(0.2).unwrap(),
            cone: cone(),
        }
    }

    fn model(contact_model: ContactModel) -> WrenchModel {
        WrenchModel {
            contact_model,
            edge_norm: EdgeNorm::UnitEdge,
            space: WrenchSpace::L1,
            center: Point3::new(0.1, 0.2, -0.1),
            torque_scale: 0.7,
        }
    }

    fn contact(position: [f64; 3], normal: [f64; 3]) -> Contact {
        Contact {
            position: position.into(),
            normal: Unit::new_normalize(normal.into()),
        }
    }

    /// Places on the unit sphere about the origin, far from any symmetry.
    fn on_sphere(m: usize) -> Vec<Contact> {
        (0..m)
            .map(|i| {
                let i = i as f64;
                let v = Vector3::new(
                    (i * 2.1).sin(),
                    (i * 1.3 + 1.0).cos(),
                    (i * 3.7 + 0.5).sin(),
                )
                .normalize();
                contact(v.into(), (-v).into())
            })
            .collect()
    }

    /// Places on the unit cylinder about the z axis, ends included.
    fn on_cylinder(m: usize) -> Vec<Contact> {
        (0..m)
            .map(|i| {
                let angle = i as f64 * 2.4;
                let (x, y) = (angle.cos(), angle.sin());
                match i % 3 {
                    0 => contact([0.5 * x, 0.5 * y, 1.0], [0.0, 0.0, -1.0]),
                    1 => contact([0.5 * x, 0.5 * y, -1.0], [0.0, 0.0, 1.0]),
                    _ => contact([x, y, 0.1 * i as f64 - 0.5], [-x, -y, 0.0]),
                }
            })
            .collect()
    }

    fn motion(evaluation: &Evaluation) -> Motion {
        match evaluation.obstacle {
            Some(Obstacle::RankDeficient { motion, .. } | Obstacle::Outside { motion, .. }) => {
                motion.unwrap()
            }
            None => panic!("no obstacle"),
        }
    }

    fn rotation(evaluation: &Evaluation) -> (UnitVector3<f64>, Point3<f64>) {
        let motion = motion(evaluation);
        assert_eq!(motion.kind, MotionKind::Rotation, "{evaluation:?}");
        (motion.axis, motion.point.unwrap())
    }

    /// No force within a cone has negative power along the motion.
    fn assert_unhindered(model: &WrenchModel, contacts: &[Contact], motion: &Motion) {
        let spin = match motion.kind {
            MotionKind::Translation => Vector3::zeros(),
            MotionKind::Rotation | MotionKind::Screw => motion.axis.into_inner(),
        };
        for contact in contacts {
            let mut wrenches = Vec::new();
            model.push_wrenches(contact, &mut wrenches);
            for wrench in wrenches {
                let force = wrench.fixed_rows::<3>(0);
                let torque = wrench.fixed_rows::<3>(3) / model.torque_scale;
                let velocity = motion.velocity_at(&model.center);
                assert!(force.dot(&velocity) + torque.dot(&spin) > -1e-9);
            }
        }
    }

    fn evaluated(contact_model: ContactModel, contacts: &[Contact]) -> Evaluation {
        let evaluation = evaluate(&model(contact_model), contacts, FLOOR, &[]);
        assert_eq!(evaluation.force_closure, evaluation.obstacle.is_none());
        assert_eq!(evaluation.force_closure, evaluation.weakest.is_some());
        if !evaluation.force_closure {
            assert_unhindered(&model(contact_model), contacts, &motion(&evaluation));
        }
        evaluation
    }

    #[test]
    fn a_ball_without_friction_turns_about_its_centre() {
        for m in [7, 10] {
            let evaluation = evaluated(ContactModel::Frictionless, &on_sphere(m));
            let (axis, point) = rotation(&evaluation);
            assert!(axis.cross(&point.coords).norm() < 1e-9);
            assert!(matches!(
                evaluation.obstacle,
                Some(Obstacle::RankDeficient { rank: 3, .. })
            ));
        }
    }

    #[test]
    fn a_cylinder_without_friction_turns_about_its_axis() {
        let evaluation = evaluated(ContactModel::Frictionless, &on_cylinder(12));
        let (axis, point) = rotation(&evaluation);
        assert!(axis.cross(&Vector3::z()).norm() < 1e-9);
        assert!(point.coords.xy().norm() < 1e-9);
        assert!(evaluated(hard(), &on_cylinder(12)).force_closure);
    }

    #[test]
    fn without_its_ends_held_a_cylinder_also_slides() {
        let sides: Vec<Contact> = on_cylinder(24).into_iter().skip(2).step_by(3).collect();
        let evaluation = evaluated(ContactModel::Frictionless, &sides);
        let Motion { axis, point, .. } = motion(&evaluation);
        assert!(axis.cross(&Vector3::z()).norm() < 1e-9);
        if let Some(point) = point {
            assert!(point.coords.xy().norm() < 1e-9);
        }
    }

    #[test]
    fn a_body_between_two_hard_fingers_turns_about_the_line_through_them() {
        let two = [
            contact([0.5, 0.3, 1.0], [0.0, 0.0, -1.0]),
            contact([0.5, 0.3, -1.0], [0.0, 0.0, 1.0]),
        ];
        let evaluation = evaluated(hard(), &two);
        let (axis, point) = rotation(&evaluation);
        assert!(axis.cross(&Vector3::z()).norm() < 1e-9);
        assert!((point - Point3::new(0.5, 0.3, -0.1)).norm() < 1e-9);
        assert!(evaluated(soft(), &two).force_closure);
    }

    #[test]
    fn a_body_touched_from_one_side_moves_away() {
        let above: Vec<Contact> = (0..5)
            .map(|i| f64::from(i) * 1.3)
            .map(|angle| contact([angle.cos(), angle.sin(), 1.0], [0.0, 0.0, -1.0]))
            .collect();
        for contact_model in [ContactModel::Frictionless, hard(), soft()] {
            let evaluation = evaluated(contact_model, &above);
            let Some(motion) = evaluation.obstacle.map(|_| motion(&evaluation)) else {
                panic!("held");
            };
            // The middle of the contacts never goes up.
            assert!(motion.velocity_at(&Point3::new(0.0, 0.0, 1.0)).z < 1e-9);
        }
    }

    #[test]
    fn external_wrenches_are_answered_in_order_also_without_closure() {
        let external = |force: [f64; 3]| ExternalWrench {
            force: force.into(),
            torque: (Point3::origin() - model(hard()).center).cross(&Vector3::from(force)),
        };
        let below = [
            contact([1.0, 0.0, -1.0], [0.0, 0.0, 1.0]),
            contact([-1.0, 0.7, -1.0], [0.0, 0.0, 1.0]),
            contact([-1.0, -0.7, -1.0], [0.0, 0.0, 1.0]),
        ];
        let asked = [external([0.0, 0.0, 1.0]), external([0.0, 0.0, -2.0])];
        let evaluation = evaluate(&model(hard()), &below, FLOOR, &asked);
        assert!(!evaluation.force_closure);
        assert_eq!(evaluation.resisted.len(), 2);
        assert_eq!(evaluation.resisted[0], None);
        let effort = evaluation.resisted[1].as_ref().unwrap();
        assert!((effort.total - 2.0).abs() < 1e-7);
    }

    #[test]
    fn a_reused_evaluator_gives_the_same_to_the_last_bit() {
        let mut evaluator = Evaluator::new();
        for m in [4, 7, 5, 3] {
            for contact_model in [ContactModel::Frictionless, hard(), soft()] {
                let model = model(contact_model);
                let contacts = on_cylinder(m);
                let never = Interrupt::never();
                let reused = evaluate_with(&mut evaluator, &model, &contacts, FLOOR, &[], never);
                let fresh = evaluate(&model, &contacts, FLOOR, &[]);
                assert_eq!(reused, Ok(fresh));
            }
        }
    }
}
