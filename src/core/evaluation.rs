//! Everything that is told of one given grasp.

use super::contact::Contact;
use super::effort::least_effort;
pub use super::effort::{ContactForce, Effort, External};
pub use super::measures::Measures;
pub use super::motion::Motion;
use super::quality::{Degenerate, Evaluator, Margin};
use super::wrench::{WrenchModel, WrenchSpace};

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

/// Why a grasp is not force closure. The motion is one that the contacts leave free; there may be others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Obstacle {
    /// The wrenches span only `rank` of 6 dimensions.
    RankDeficient { rank: usize, motion: Option<Motion> },
    /// The origin is outside the wrench space by `distance`, in the unit of the margin; zero on its
    /// border, and where the margin is positive but no more than rounding of the mesh can feign.
    Outside {
        distance: f64,
        motion: Option<Motion>,
    },
}

/// Relative width of the interval on ε where the wrench space is no polytope.
pub const ACCURACY: f64 = 1e-6;

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
    let closed = margin.ok().filter(|margin| margin.value > closure_floor);
    let motion = |direction| Motion::unhindered(model, contacts, direction);
    let obstacle = match &margin {
        _ if closed.is_some() => None,
        Ok(margin) => Some(Obstacle::Outside {
            distance: (-margin.value).max(0.0),
            motion: motion(&margin.direction),
        }),
        Err(Degenerate { rank, direction }) => Some(Obstacle::RankDeficient {
            rank: *rank,
            motion: motion(direction),
        }),
    };
    let mut measures = Measures::geometric(model, contacts);
    measures.volume_l1 = evaluator.volume(&wrenches);
    if let (Some(margin), WrenchSpace::L1) = (closed, model.space) {
        measures.epsilon_l1 = Some(margin.value);
    }
    let weakest = closed.and_then(|margin| {
        let disturbance = External::of_wrench(model, &-margin.direction);
        least_effort(model, contacts, &disturbance)
    });
    Evaluation {
        margin,
        force_closure: closed.is_some(),
        bounds: None,
        obstacle,
        measures,
        weakest,
        resisted: external
            .iter()
            .map(|external| least_effort(model, contacts, external))
            .collect(),
    }
}
