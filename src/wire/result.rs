//! What a planning run found.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::request::{ContactModel, EdgeNorm, Method, Units};

/// The outcome of a run, with every number that the quality depends on.
///
/// All but the elapsed times is repeated to the byte by the same mesh, request and seed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PlanResult {
    /// Whether `contacts` hold the body against every small force and torque.
    pub force_closure: bool,
    /// The quality ε: radius of the largest origin-centred ball in the convex hull of the
    /// contacts' wrenches (Ferrari & Canny 1992). Absent without force closure.
    #[schema(example = 0.069)]
    pub quality: Option<f64>,
    /// Signed distance from the origin to the nearest facet of that hull: ε when positive; zero or
    /// negative when the origin is outside. Absent when the wrenches span fewer than 6 dimensions.
    pub margin: Option<f64>,
    /// Whether `margin`, and so `quality`, is exact to rounding. Not for grasps with so many
    /// wrenches that their hull could not be finished; `quality` is then a lower bound.
    pub exact: Option<bool>,
    /// The contacts of the best grasp found; without force closure, of the best of the random
    /// grasps tried first. Empty when the run was stopped before or when all of them are
    /// degenerate.
    pub contacts: Vec<ContactPoint>,
    /// The direction in which the grasp is weakest.
    pub weakest_wrench: Option<WeakestWrench>,
    /// Why there is no force closure, in plain words. Absent when there is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub explanation: Option<Explanation>,
    /// The first force-closure grasp, by Roa & Suárez's Algorithm 1, that the search started from.
    pub initial: Option<InitialGrasp>,
    /// The frame of positions, normals and torques: `mesh`, that of the uploaded file.
    #[schema(example = "mesh")]
    pub frame: String,
    /// The unit of lengths, when the request named it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<Units>,
    /// The factor that made torques comparable with forces.
    pub torque_scale: TorqueScaleValue,
    /// The point torques are taken about.
    pub center_of_mass: [f64; 3],
    pub contact_model: ContactModel,
    /// Coefficient of friction μ.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Edges of the pyramid in place of the friction cone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cone_edges: Option<u32>,
    pub edge_norm: EdgeNorm,
    /// Places on the surface that were searched, n.
    pub candidates: u64,
    pub method: Method,
    pub seed: u64,
    pub stopped_because: StoppedBecause,
    /// Quality evaluations made.
    pub evaluations: u64,
    /// State of the population after each generation; entry 0 is the initial population, and the
    /// last may be a generation that the search was stopped in. Of more than 1,000 generations,
    /// 1,000 are shown, evenly spread.
    pub history: Vec<HistoryEntry>,
    /// Seconds that planning took, reading the mesh not counted.
    pub elapsed_s: f64,
    /// Version of graspd that made this.
    #[schema(example = "0.1.0")]
    pub version: String,
}

/// A contact of a grasp.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ContactPoint {
    /// Position in the mesh's frame and unit.
    pub position: [f64; 3],
    /// Unit normal pointing into the body: the direction a finger pushes in.
    pub normal: [f64; 3],
    /// Unit normal pointing out of the body: the side a finger comes from.
    pub approach: [f64; 3],
    /// The triangle touched, counted from 0 in the order of the uploaded file.
    pub triangle: u32,
    /// Barycentric coordinates of the position in that triangle.
    pub barycentric: [f64; 3],
}

/// A unit wrench (force; scaled torque) along which a grasp can exert less than along any other.
///
/// The grasp exerts at most `margin` along it with contact forces that sum to one, so a disturbance
/// in the opposite direction is the hardest to resist.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct WeakestWrench {
    pub force: [f64; 3],
    /// Torque about the centre of mass times the torque scale.
    pub torque: [f64; 3],
    /// The same in words.
    pub description: String,
}

/// The first force-closure grasp.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct InitialGrasp {
    /// Its quality ε.
    pub quality: f64,
    pub contacts: Vec<ContactPoint>,
}

/// Why there is no force closure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Explanation {
    pub reason: Reason,
    /// Whether it is proven that no choice of contacts on this mesh is force closure.
    pub proven: bool,
    pub detail: String,
}

/// The kind of obstacle to force closure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// That few contacts of this model hold no body.
    TooFewContacts,
    /// All contacts together span fewer than 6 dimensions: some wrench cannot be exerted at all,
    /// as on a body of revolution without friction.
    RankDeficient,
    /// Contacts can push only to one side of some direction.
    OneSided,
    /// None was found, though none is proven not to exist.
    NoneFound,
    /// The run was stopped before a force-closure grasp was found.
    Stopped,
}

/// The torque scale λ.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TorqueScaleValue {
    /// How it was chosen: `max_radius`, `none` or `custom`.
    #[schema(example = "max_radius")]
    pub kind: String,
    /// Its value, 1/length.
    pub value: f64,
}

/// Why a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum StoppedBecause {
    GenerationLimit,
    EvaluationLimit,
    TargetQuality,
    TimeLimit,
    Cancelled,
    /// It is proven that there is nothing to find.
    Impossible,
}

/// State of the population after a generation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct HistoryEntry {
    pub generation: u64,
    /// Best quality ε so far.
    pub best: Option<f64>,
    /// Mean ε of the individuals that are force closure.
    pub mean: Option<f64>,
    /// How many individuals are force closure.
    pub force_closures: u64,
    /// Quality evaluations so far.
    pub evaluations: u64,
    /// Seconds since planning began.
    pub elapsed_s: f64,
}
