//! Numbers in words.

use nalgebra::Vector3;

use crate::core::plan::Plan;
use crate::core::quality::Margin;
use crate::core::search::{Impossible, Stop};
use crate::core::wrench::Wrench;
use crate::wire::{
    ContactModel, Explanation, Reason, TorqueScale, TorqueScaleValue, WeakestWrench,
};

/// Share of the squared length above which a unit wrench is called a force or a torque.
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

/// Why the plan has no force-closure grasp.
pub(super) fn explanation(plan: &Plan, model: ContactModel) -> Explanation {
    let advice = match model {
        ContactModel::Frictionless => "Allow friction",
        ContactModel::Hard => "Allow more friction",
    };
    let (reason, detail) = match plan.impossible {
        Some(Impossible::TooFewContacts { least }) => (
            Reason::TooFewContacts,
            format!(
                "At least {least} contacts of this model are needed to hold any body against \
                 every force and torque; ask for {least} or more."
            ),
        ),
        Some(Impossible::Deficient { rank, direction }) => (
            Reason::RankDeficient,
            format!(
                "The wrenches of all contacts on this mesh together fill only {rank} of 6 \
                 dimensions: no choice of contacts can exert {} one way and the other, as on a body \
                 that is symmetric about an axis. {advice}.",
                wrench(&direction)
            ),
        ),
        Some(Impossible::OneSided { direction }) => (
            Reason::OneSided,
            format!(
                "No contact anywhere on this mesh can exert {}, so no choice of contacts holds \
                 the body. {advice}, or check that the mesh is closed.",
                wrench(&direction)
            ),
        ),
        None if matches!(plan.stop, Stop::Cancelled | Stop::TimeLimit) => (
            Reason::Stopped,
            "The search was stopped before it found a force-closure grasp; give it more time."
                .to_owned(),
        ),
        None if plan.stop == Stop::EvaluationLimit => (
            Reason::Stopped,
            "The search used up its evaluations before it found a force-closure grasp; raise \
             evaluation_limit."
                .to_owned(),
        ),
        None => (
            Reason::NoneFound,
            format!(
                "None of {} grasps tried is force closure, though that does not prove there is \
                 none. Allow more friction, contacts, individuals or generations.",
                plan.evaluations
            ),
        ),
    };
    Explanation {
        reason,
        proven: plan.impossible.is_some(),
        detail,
    }
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
