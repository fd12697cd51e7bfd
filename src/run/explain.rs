//! Results in words: why there is no force closure, where a grasp is weakest, how a body can still move.

use nalgebra::{Point3, Vector3};

use crate::wire::{
    Constraints, ExplainedObstacle, Explanation, ObstacleReason, PlanRequest, Reason,
    TorqueScaleValue, WeakestWrench,
};
use graspd_core::contact::ContactModel;
use graspd_core::evaluation::{Effort, Motion, MotionKind, Obstacle};
use graspd_core::plan::{ContactFields, ContactKind, Infeasible, Plan};
use graspd_core::quality::Margin;
use graspd_core::search::{Impossible, StopReason};
use graspd_core::wrench::{TorqueScale, Wrench, WrenchModel};

/// Share of the squared length of a unit wrench above which the wrench is called a force, or a torque.
const DOMINANT_SHARE: f64 = 0.8;

pub(super) fn torque_scale(kind: TorqueScale, value: f64) -> TorqueScaleValue {
    let kind = match kind {
        TorqueScale::MaxRadius => "max_radius",
        TorqueScale::None => "none",
        TorqueScale::Custom(_) => "custom",
    };
    TorqueScaleValue {
        kind: kind.to_owned(),
        value,
    }
}

/// Torsional friction μ_t of soft contacts.
pub(super) fn torsion(model: &WrenchModel) -> Option<f64> {
    match model.contact_model {
        ContactModel::Soft { torsion, .. } => Some(torsion.get()),
        ContactModel::Hard { .. } | ContactModel::Frictionless => None,
    }
}

/// Force and, for a soft contact, torsion of the finger with this index.
pub(super) fn contact_force(
    model: &WrenchModel,
    effort: Option<&Effort>,
    index: usize,
) -> Option<([f64; 3], Option<f64>)> {
    let force = effort?.forces.get(index)?;
    Some((force.force.into(), torsion(model).map(|_| force.torsion)))
}

/// Explains why given contacts are not force closure.
pub(super) fn obstacle(obstacle: &Obstacle) -> ExplainedObstacle {
    let (motion, reason, rank, distance, what) = match *obstacle {
        Obstacle::RankDeficient { rank, motion } => (
            motion,
            ObstacleReason::RankDeficient,
            Some(rank as u32),
            None,
            format!(
                "The wrenches of these contacts span only {rank} of 6 dimensions, so some \
                 disturbances cannot be resisted at all."
            ),
        ),
        Obstacle::Outside {
            distance,
            on_border,
            motion,
        } => (
            motion,
            ObstacleReason::OriginOutside,
            None,
            Some(distance),
            if on_border {
                "The origin is on the border of the wrench space of these contacts, not inside."
                    .to_owned()
            } else {
                format!(
                    "The origin is outside the wrench space of these contacts, by {distance:.6}."
                )
            },
        ),
    };
    ExplainedObstacle {
        reason,
        rank,
        distance,
        motion,
        detail: match motion {
            Some(motion) => format!("{what} Nothing hinders {}.", in_words(&motion)),
            None => what,
        },
    }
}

fn in_words(motion: &Motion) -> String {
    let place = |point: &Point3<f64>| format!("({:.4}, {:.4}, {:.4})", point.x, point.y, point.z);
    let axis = axis(&motion.axis);
    let through = motion.point.map_or_else(String::new, |point| place(&point));
    match motion.kind {
        MotionKind::Translation => format!("a translation along {axis}"),
        MotionKind::Rotation => format!("a rotation about the axis along {axis} through {through}"),
        MotionKind::Screw => format!(
            "a screw motion about the axis along {axis} through {through} with an advance of {:.4} per \
             radian",
            motion.pitch.unwrap_or_default()
        ),
    }
}

pub(super) fn weakest_wrench(margin: &Margin, force_closure: bool) -> WeakestWrench {
    let (force, torque) = parts(&margin.direction);
    let what = wrench(&margin.direction);
    WeakestWrench {
        force: force.into(),
        torque: torque.into(),
        description: if force_closure {
            format!("The grasp is weakest when it has to exert {what}.")
        } else {
            format!("The grasp cannot exert {what}.")
        },
    }
}

/// Explains why the plan has no force-closure grasp.
pub(super) fn explanation(plan: &Plan, request: &PlanRequest) -> Explanation {
    if let Some(infeasible) = plan.infeasible {
        return infeasibility(plan, infeasible, request.constraints.as_ref());
    }
    let constrained = plan.removals.iter().any(|removal| removal.removed > 0);
    let contact = ContactFields::from(request.quality.wrench.contact);
    let advice = match (contact.contact_model, constrained) {
        (ContactKind::Frictionless, false) => "Allow friction",
        (ContactKind::Frictionless, true) => "Loosen the constraints, allow friction",
        (_, false) => "Allow more friction",
        (_, true) => "Loosen the constraints, allow more friction",
    };
    let places = match constrained {
        true => "at the places left by the constraints",
        false => "on this mesh",
    };
    let spaced = distances(request.constraints.as_ref());
    let (reason, detail) = match plan.impossible {
        Some(Impossible::TooFewContacts { least }) => (
            Reason::TooFewContacts,
            format!(
                "At least {least} contacts of this model are needed to hold any body against \
                 every force and torque; ask for {least} or more."
            ),
        ),
        Some(Impossible::Exhausted { grasps }) => {
            let keeps = spaced.map_or_else(String::new, |names| format!(" and keeps {names}"));
            (
                Reason::Exhausted,
                format!(
                    "None of the {grasps} grasps that there are with so many contacts {places} is force \
                     closure{keeps}. {advice}, ask for more contacts, or send a finer mesh."
                ),
            )
        }
        Some(Impossible::Deficient { rank, direction }) => {
            let like = match constrained {
                true => "",
                false => ", as on a body that is symmetric about an axis",
            };
            (
                Reason::RankDeficient,
                format!(
                    "The wrenches of all contacts {places} together fill only {rank} of 6 \
                     dimensions: no choice of contacts can exert {} one way and the other{like}. {advice}.",
                    wrench(&direction)
                ),
            )
        }
        Some(Impossible::OneSided { direction }) => {
            let (nowhere, or) = match constrained {
                true => ("at any of the places left by the constraints", ""),
                false => (
                    "anywhere on this mesh",
                    ", or check that the mesh is closed",
                ),
            };
            (
                Reason::OneSided,
                format!(
                    "No contact {nowhere} can exert {}, so no choice of contacts holds \
                     the body. {advice}{or}.",
                    wrench(&direction)
                ),
            )
        }
        None if matches!(plan.stop, StopReason::Cancelled | StopReason::TimeLimit) => (
            Reason::Stopped,
            "The search was stopped before it found a force-closure grasp; give it more time."
                .to_owned(),
        ),
        None if plan.stop == StopReason::EvaluationLimit => (
            Reason::Stopped,
            "The search used up its evaluations before it found a force-closure grasp; raise \
             evaluation_limit."
                .to_owned(),
        ),
        None => (
            Reason::NoneFound,
            format!(
                "None of the grasps tried in {} evaluations is force closure, though that does not prove \
                 that there is none. {advice}, contacts, individuals or generations.",
                plan.evaluations
            ),
        ),
    };
    Explanation {
        reason,
        proven: plan.impossible.is_some(),
        detail: match removals(plan) {
            Some(removals) if reason != Reason::TooFewContacts => format!("{detail} {removals}"),
            _ => detail,
        },
    }
}

/// The fields that bound the distances between contacts.
fn distances(constraints: Option<&Constraints>) -> Option<&'static str> {
    let constraints = constraints?;
    let bounds = (
        constraints.min_contact_distance,
        constraints.max_contact_distance,
    );
    match bounds {
        (Some(_), Some(_)) => Some("min_contact_distance and max_contact_distance"),
        (Some(_), None) => Some("min_contact_distance"),
        (None, Some(_)) => Some("max_contact_distance"),
        (None, None) => None,
    }
}

/// Explains why the constraints leave no grasp to try.
fn infeasibility(
    plan: &Plan,
    infeasible: Infeasible,
    constraints: Option<&Constraints>,
) -> Explanation {
    let left = plan.candidates;
    let (proven, detail) = match infeasible {
        Infeasible::TooFewLeft { planned } => (
            true,
            format!(
                "{planned} contacts are to be planned, but {left} candidates are left for them."
            ),
        ),
        Infeasible::NoneApart => (
            true,
            format!("No two of {left} candidates are as far apart as min_contact_distance."),
        ),
        Infeasible::NoneFits { planned } => (
            false,
            format!(
                "No {planned} of {left} candidates were found that keep {}, though that does not prove that \
                 there are none.",
                distances(constraints).unwrap_or("the constraints")
            ),
        ),
    };
    let removals = removals(plan).map_or_else(String::new, |removals| format!(" {removals}"));
    let advice = match infeasible {
        Infeasible::NoneApart => "Make min_contact_distance less.",
        Infeasible::TooFewLeft { .. } | Infeasible::NoneFits { .. } => {
            "Loosen the constraints, or send a finer mesh."
        }
    };
    Explanation {
        reason: Reason::Constraints,
        proven,
        detail: format!("{detail}{removals} {advice}"),
    }
}

/// Counts the candidates that the constraints removed; `None` when no rule is about single candidates.
fn removals(plan: &Plan) -> Option<String> {
    if plan.removals.is_empty() {
        return None;
    }
    let removed: usize = plan.removals.iter().map(|removal| removal.removed).sum();
    let rules: Vec<String> = plan
        .removals
        .iter()
        .map(|removal| format!("{} {}", removal.rule, removal.removed))
        .collect();
    Some(format!(
        "The constraints removed {removed} of {} candidates ({}) and left {}.",
        plan.candidates + removed,
        rules.join(", "),
        plan.candidates
    ))
}

fn parts(wrench: &Wrench) -> (Vector3<f64>, Vector3<f64>) {
    (
        wrench.fixed_rows::<3>(0).into_owned(),
        wrench.fixed_rows::<3>(3).into_owned(),
    )
}

fn wrench(wrench: &Wrench) -> String {
    let (force, torque) = parts(wrench);
    let share = force.norm_squared();
    if share >= DOMINANT_SHARE {
        format!("a force along {}", axis(&force))
    } else if share <= 1.0 - DOMINANT_SHARE {
        format!("a torque about {}", axis(&torque))
    } else {
        format!(
            "a force along {} together with a torque about {}",
            axis(&force),
            axis(&torque)
        )
    }
}

/// A direction to two decimals, with the axis it is close to.
fn axis(vector: &Vector3<f64>) -> String {
    let unit = vector.normalize();
    let shown: Vec<String> = unit
        .iter()
        .map(|c| format!("{:.2}", if c.abs() < 0.005 { 0.0 } else { *c }))
        .collect();
    let main = unit.iamax();
    let name = ["x", "y", "z"][main];
    let sign = if unit[main] < 0.0 { '-' } else { '+' };
    if unit[main].abs() > 0.99 {
        format!("{sign}{name}")
    } else {
        format!("({})", shown.join(", "))
    }
}
