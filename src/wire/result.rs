//! The result of a planning run.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::candidates::SearchedCandidates;
use super::request::Units;
use super::trials::Trials;
use graspd_core::constraints::RuleReport;
use graspd_core::independent::IndependentRegion;
use graspd_core::measures::Measures;
use graspd_core::mesh::MeshWarning;
use graspd_core::plan::{ContactKind, Method, Polish};
use graspd_core::robustness::Robustness;
use graspd_core::search::StopReason;
use graspd_core::task::TaskQuality;
use graspd_core::wrench::{EdgeNorm, WrenchSpace};

/// The result of a planning run, with every number that the quality depends on.
///
/// The same mesh, request and seed give the same bytes, except for the elapsed times.
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
    /// Whether `margin`, and with it `quality`, is exact to rounding or, where the wrench space is no
    /// polytope (round cones, L∞), to 1e-6 of itself; `quality` is then the certified lower end. False for
    /// grasps with so many wrenches that their hull could not be finished; `quality` is then a lower
    /// bound.
    pub exact: Option<bool>,
    /// [lower, upper]: a certified interval on the ε that the same contacts have with the round
    /// friction cone itself. Absent without force closure and, like `measures` and the forces of contacts,
    /// when a run of many wrenches was cancelled.
    #[serde(default)]
    pub bounds: Option<[f64; 2]>,
    /// Whether `bounds` differ by at most 1e-6 of the upper one. `false` when the facet limit ended the interval earlier; it
    /// is certified all the same.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bounds_exact: Option<bool>,
    /// The contacts of the best grasp, fixed ones first; without force closure, those of the best of the
    /// random grasps that were tried first. Empty when the run was stopped before these, or when all of them
    /// are degenerate.
    pub contacts: Vec<ContactPoint>,
    /// The direction in which the grasp is weakest.
    pub weakest_wrench: Option<WeakestWrench>,
    /// Other measures of the grasp.
    #[serde(default)]
    pub measures: Option<Measures>,
    /// The quality to expect when the fingers miss their places, if it was requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robustness: Option<Robustness>,
    /// Where each finger may be while the others stay, in the order of the contacts, if it was requested.
    /// Absent without force closure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub independent_regions: Option<Vec<IndependentRegion>>,
    /// Quality against the task wrenches of the request.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub task_quality: Option<TaskQuality>,
    /// Quality against a force along the gravity of the request, at the centre of mass: the largest such
    /// force that is resisted, in the unit of ε.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity_quality: Option<f64>,
    /// Why there is no force closure, in plain words. Absent with force closure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub explanation: Option<Explanation>,
    /// The first force-closure grasp, by Roa & Suárez's Algorithm 1, that the search started from.
    pub initial: Option<InitialGrasp>,
    /// The frame of positions, normals and torques: `mesh`, that of the uploaded file.
    #[schema(example = "mesh")]
    pub frame: String,
    /// The unit of lengths, if the request named it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<Units>,
    /// The factor that made torques comparable with forces.
    pub torque_scale: TorqueScaleValue,
    /// The point torques are taken about.
    pub center_of_mass: [f64; 3],
    pub contact_model: ContactKind,
    /// Coefficient of friction μ.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Edges of the pyramid that replaces the friction cone; 0 is the round cone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cone_edges: Option<u32>,
    /// Torsional friction μ_t of soft contacts, a length in the mesh's unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torsional_friction: Option<f64>,
    pub edge_norm: EdgeNorm,
    #[serde(default)]
    pub wrench_space: WrenchSpace,
    /// Number n of places on the surface that were searched: those that the constraints leave.
    pub candidates: u64,
    /// The candidates before the constraints, and why these were chosen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub candidates_from: Option<SearchedCandidates>,
    /// The number of candidates that each rule of the constraints removed, of those that the rules before it
    /// left: one entry for each rule that decides about single places, in the order of application. Absent
    /// without constraints.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub constraints: Option<Vec<RuleReport>>,
    pub method: Method,
    pub seed: u64,
    pub stopped_because: StopReason,
    /// Statistics over the trials, if more than one was requested. All other members describe the best trial,
    /// except `evaluations` and `elapsed_s`, which are totals.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trials: Option<Trials>,
    /// Distinct grasps, the best first, if more than one was requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub top: Option<Vec<TopGrasp>>,
    /// The improvement by sliding the contacts from the centroids of their triangles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub polish: Option<Polish>,
    /// Whether it is proven that moving one finger to any other candidate of the mesh does not improve the
    /// quality (before any polish) by more than one part in a million, or one in a thousand where cones are
    /// round or the space is L∞. Only `memetic` proves that.
    #[serde(default)]
    pub single_exchange_optimal: bool,
    /// Whether the same request gives the same result again. False when a time limit or a cancellation ended
    /// the run; a request with `evaluations` as its `evaluation_limit` then comes closest.
    #[serde(default = "repeats")]
    pub reproducible: bool,
    /// Quality evaluations made.
    pub evaluations: u64,
    /// State of the population after each generation. Entry 0 is the initial population; the last may be a
    /// generation in which the search was stopped. Of more than 1,000 generations, 1,000 are listed, evenly
    /// spread.
    pub history: Vec<HistoryEntry>,
    /// Seconds that planning took, without reading the mesh.
    pub elapsed_s: f64,
    /// Warnings about the mesh without which the result should not be believed.
    #[schema(nullable = false)]
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub mesh_warnings: Vec<MeshWarning>,
    /// Version of graspd that made this result.
    #[schema(example = "0.1.0")]
    pub version: String,
}

/// Results of earlier versions have no such member.
fn repeats() -> bool {
    true
}

/// One of several distinct grasps. The Hausdorff distance of any two of them, the greatest distance of a
/// contact of one, fixed ones included, from the nearest contact of the other, is at least a twentieth of the mesh's bounding radius.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TopGrasp {
    /// The quality ε. Only the first grasp is polished.
    pub quality: f64,
    /// Hausdorff distance from the best grasp, in the mesh's unit.
    pub distance_to_best: f64,
    pub contacts: Vec<ContactPoint>,
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
    /// The triangle it touches, counted from 0 in the order of the uploaded file; absent for a fixed contact
    /// that was given with its normal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub triangle: Option<u32>,
    /// Barycentric coordinates of the position in that triangle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub barycentric: Option<[f64; 3]>,
    /// Whether the contact was given by the constraints; present only if it was.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub fixed: bool,
    /// The force this finger exerts in the least-effort answer to the disturbance that the grasp
    /// resists worst: the opposite of `weakest_wrench`, at unit size. Present in the best grasp only, and
    /// only with force closure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub forces: Option<[f64; 3]>,
    /// The torque about the inward normal that goes with the force, for soft contacts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torsion: Option<f64>,
}

/// The unit wrench (force; scaled torque) along which a grasp can exert less than along any other.
///
/// The grasp exerts at most `margin` along it with contact forces that sum to one, so a disturbance
/// in the opposite direction is the hardest to resist.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct WeakestWrench {
    pub force: [f64; 3],
    /// Torque about the centre of mass times the torque scale.
    pub torque: [f64; 3],
    /// The same in plain words.
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
    /// Whether it is proven that no choice of contacts on this mesh is force closure and keeps the
    /// constraints.
    pub proven: bool,
    pub detail: String,
}

/// The kind of the obstacle to force closure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// So few contacts of this model hold no body.
    TooFewContacts,
    /// All contacts together span fewer than 6 dimensions: some wrench cannot be exerted at all,
    /// as on a body of revolution without friction.
    RankDeficient,
    /// Contacts can push only to one side of some direction.
    OneSided,
    /// The constraints leave fewer places than contacts, or no grasp was found that keeps its distances.
    Constraints,
    /// All possible grasps were tried, which is done when they are few.
    Exhausted,
    /// None was found, although it is not proven that none exists.
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

/// State of the population after a generation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct HistoryEntry {
    pub generation: u64,
    /// Best quality ε so far.
    pub best: Option<f64>,
    /// Mean ε of the individuals that are force closure.
    pub mean: Option<f64>,
    /// Number of individuals that are force closure.
    pub force_closures: u64,
    /// Quality evaluations so far.
    pub evaluations: u64,
    /// Seconds since planning began.
    pub elapsed_s: f64,
}
