//! Everything that is told of one given grasp.

use nalgebra::{Point3, UnitVector3, Vector3};

use super::contact::Contact;
pub use super::effort::{ContactForce, Effort, External};
pub use super::measures::Measures;
use super::quality::{Degenerate, Evaluator, Margin};
use super::wrench::{Wrench, WrenchModel};

/// Everything that is told of one given grasp.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    /// Where the origin stands in the wrench space asked for, exactly or as an interval, or why the
    /// contacts span none.
    pub margin: Result<Margin, Degenerate>,
    /// Whether the margin is above what rounding of the mesh can feign.
    pub force_closure: bool,
    /// [lower, upper] on ε with the true round cone, in the space asked for; `None` without force
    /// closure.
    pub bounds: Option<[f64; 2]>,
    /// Why there is no force closure; `None` when there is.
    pub obstacle: Option<Obstacle>,
    pub measures: Measures,
    /// The least contact forces against the disturbance that the grasp resists worst; `None` without
    /// force closure.
    pub weakest: Option<Effort>,
    /// One per external wrench asked for, in order: `None` when the grasp cannot resist it.
    pub resisted: Vec<Option<Effort>>,
}

/// Why a grasp is not force closure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Obstacle {
    /// Too few dimensions: the wrenches span only `rank` of 6.
    RankDeficient { rank: usize, motion: Motion },
    /// The origin is outside the wrench space, or on its border, by `distance` in the direction whose
    /// motion is `motion`.
    Outside { distance: f64, motion: Motion },
}

/// A motion of the body that the contacts do not hinder.
///
/// Dual to a wrench direction (a; b) along which the grasp exerts nothing: velocity v = a of the
/// centre of mass and angular velocity ω = λ·b, in the mesh's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    Translation {
        direction: UnitVector3<f64>,
    },
    /// About a line through `point`, right-handed.
    Rotation {
        axis: UnitVector3<f64>,
        point: Point3<f64>,
    },
    /// A rotation with an advance along its axis of `pitch` mesh units per radian.
    Screw {
        axis: UnitVector3<f64>,
        point: Point3<f64>,
        pitch: f64,
    },
}

/// Evaluates one grasp; see [`evaluate_with`], which spares the working memory.
pub fn evaluate(
    model: &WrenchModel,
    contacts: &[Contact],
    closure_floor: f64,
    external: &[External],
) -> Evaluation {
    evaluate_with(
        &mut Evaluator::new(),
        model,
        contacts,
        closure_floor,
        external,
    )
}

/// Evaluates one grasp. A margin above `closure_floor` is called force closure.
pub fn evaluate_with(
    evaluator: &mut Evaluator,
    model: &WrenchModel,
    contacts: &[Contact],
    closure_floor: f64,
    external: &[External],
) -> Evaluation {
    let mut wrenches = Vec::new();
    for contact in contacts {
        model.push_wrenches(contact, &mut wrenches);
    }
    let margin = evaluator.margin(&wrenches);
    let force_closure = margin.is_ok_and(|margin| margin.value > closure_floor);
    let obstacle = match margin {
        Ok(_) if force_closure => None,
        Ok(margin) => Some(Obstacle::Outside {
            distance: -margin.value,
            motion: motion(model, &margin.direction),
        }),
        Err(Degenerate { rank, direction }) => Some(Obstacle::RankDeficient {
            rank,
            motion: motion(model, &direction),
        }),
    };
    Evaluation {
        margin,
        force_closure,
        bounds: None,
        obstacle,
        measures: Measures::default(),
        weakest: None,
        resisted: vec![None; external.len()],
    }
}

fn motion(model: &WrenchModel, direction: &Wrench) -> Motion {
    let velocity: Vector3<f64> = direction.fixed_rows::<3>(0).into_owned();
    let spin: Vector3<f64> = direction.fixed_rows::<3>(3) * model.torque_scale;
    if spin.norm() == 0.0 {
        return Motion::Translation {
            direction: UnitVector3::new_normalize(velocity),
        };
    }
    let axis = UnitVector3::new_normalize(spin);
    let point = model.center + spin.cross(&velocity) / spin.norm_squared();
    match velocity.dot(&axis) / spin.norm() {
        0.0 => Motion::Rotation { axis, point },
        pitch => Motion::Screw { axis, point, pitch },
    }
}
