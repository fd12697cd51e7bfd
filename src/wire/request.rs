//! What a client asks for.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use utoipa::openapi::schema::{AdditionalProperties, Schema, SchemaType, Type};
use utoipa::openapi::{ObjectBuilder, OneOfBuilder, RefOr};
use utoipa::{PartialSchema, ToSchema};

use super::analysis::{Analyses, RegionSettings, RobustnessSettings};
use super::candidates::CandidateSettings;
use super::constraints::Constraints;
use super::priority::Priority;

/// A planning request with every default filled in and the seed fixed: the effective settings
/// that are stored with the job, echoed to the client and enough to repeat the run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PlanRequest {
    /// Number of contacts, fixed ones included. Default 4 with friction, 7 without.
    #[schema(minimum = 1, maximum = 64, example = 4)]
    pub contacts: u32,
    /// How a finger touches the body. Default `hard`, or `frictionless` when `friction` is 0.
    pub contact_model: ContactModel,
    /// Coulomb's coefficient of friction. Default 0.5; absent when frictionless; 0 asks for
    /// frictionless contacts.
    #[schema(minimum = 0, maximum = 10, nullable = false, example = 0.5)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Edges of the pyramid that stands in for the friction cone, 3 to 32, or 0 for the round cone
    /// itself. Default 8; absent when frictionless.
    #[schema(minimum = 0, maximum = 32, nullable = false, example = 8)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cone_edges: Option<u32>,
    /// Torsional friction of a soft finger: greatest torque about the normal over normal force, a
    /// length in the mesh's unit. Default: a twentieth of the greatest distance of a vertex from the
    /// point torques are taken about. Only for soft contacts.
    #[schema(
        exclusive_minimum = 0,
        maximum = 1e12,
        nullable = false,
        example = 0.01
    )]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torsional_friction: Option<f64>,
    /// How long the edges of the friction cone are. Default `unit_edge`.
    pub edge_norm: EdgeNorm,
    /// How the wrenches of the contacts add up. Default `l1`.
    #[serde(default)]
    pub wrench_space: WrenchSpace,
    /// The factor (1/length) that makes torques comparable with forces. Default `max_radius`.
    pub torque_scale: TorqueScale,
    /// Torques are taken about this point, in the mesh's frame and unit. Default: the mesh's
    /// own centre of mass.
    #[schema(nullable = false, example = json!([0.0, 0.0, 0.0]))]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub center_of_mass: Option<[f64; 3]>,
    /// The unit of the mesh's coordinates: echoed, never used to rescale. Default: that of the mesh, where its
    /// upload named one.
    #[schema(nullable = false)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub units: Option<Units>,
    /// Where contacts may be, how far apart they are, how fingers come, and contacts that are given.
    /// Default: contacts anywhere.
    #[schema(nullable = false)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub constraints: Option<Constraints>,
    /// The places that are searched. Default: `triangles`, but `uniform` for `memetic` where the triangles are
    /// fewer than 1000 or their areas vary by more than a factor of 4 (95th over 5th percentile); the result
    /// says which in `candidates_from`.
    #[schema(nullable = false)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub candidates: Option<CandidateSettings>,
    /// Which search looks for the best grasp. Default `memetic`.
    pub method: Method,
    /// Individuals per generation; for `memetic`, grasps that climb side by side. Default 8 for `memetic`,
    /// else 200.
    #[schema(minimum = 2, maximum = 100_000, example = 200)]
    pub population: u32,
    /// Generations after the first population; `memetic` has each of the population arrive at an optimum
    /// that often. Default 25 for `memetic`, else 100; population times (generations + 1)
    /// may be at most 1,000,000,000.
    #[schema(minimum = 0, maximum = 100_000, example = 100)]
    pub generations: u32,
    /// Probability that two parents are crossed. Default 0.7 for `memetic`, else
    /// 0.9.
    #[schema(minimum = 0, maximum = 1, example = 0.9)]
    pub crossover_probability: f64,
    /// Probability that a child is mutated. Default 0.2.
    #[schema(minimum = 0, maximum = 1, example = 0.2)]
    pub mutation_probability: f64,
    /// Best individuals carried over unchanged; less than the population. For `modified_ga`. Default
    /// 1.
    #[schema(minimum = 0, maximum = 99_999, example = 1)]
    pub elitism: u32,
    /// Which candidates may complete the first force-closure grasp. Default `weak` for `memetic`, else
    /// `strict`, as in the paper. `random` starts from none.
    pub initial: InitialMode,
    /// Whether the contacts of the best grasp slide over the surface, within triangles and across edges, to
    /// where the quality is greater still; otherwise contacts are centroids, as in the paper. Default
    /// `true` for `memetic`, else `false`.
    #[serde(default)]
    pub polish: bool,
    /// Stop searching after this many seconds, and what else is asked to be told of the grasp after as
    /// many more. Default: only the server's own limit.
    #[schema(
        exclusive_minimum = 0,
        maximum = 3600,
        nullable = false,
        example = 60.0
    )]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_limit_s: Option<f64>,
    /// Stop after this many quality evaluations. Default: no limit.
    #[schema(
        minimum = 1,
        maximum = 1_000_000_000,
        nullable = false,
        example = 1_000_000
    )]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evaluation_limit: Option<u64>,
    /// Stop once this quality is reached. Default: never.
    #[schema(exclusive_minimum = 0, nullable = false, example = 0.2)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target_quality: Option<f64>,
    /// Tell how robust the grasp is against fingers that miss their places. Default: not told.
    #[schema(nullable = false)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robustness: Option<RobustnessSettings>,
    /// Tell where each finger may be while the others stay. Default: not told.
    #[schema(nullable = false)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub independent_regions: Option<RegionSettings>,
    /// Tell the quality against these disturbances: force and torque about the centre of mass, in the
    /// mesh's frame, in any unit of force and that times the mesh's unit of length. Only their directions
    /// matter, once torques are scaled. Default: none.
    #[schema(
        nullable = false,
        min_items = 1,
        max_items = 256,
        example = json!([[0.0, 0.0, -1.0, 0.0, 0.0, 0.0]])
    )]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub task_wrenches: Option<Vec<[f64; 6]>>,
    /// Tell the quality against a force in this direction at the centre of mass. Default: not told.
    #[schema(nullable = false, example = json!([0.0, 0.0, -1.0]))]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity: Option<[f64; 3]>,
    /// Repeat the run with the seeds seed, seed + 1, ..., and tell statistics over them beside the best.
    /// Default 1.
    #[schema(minimum = 1, maximum = 1000, example = 1)]
    #[serde(default = "one")]
    pub trials: u32,
    /// Tell so many distinct grasps, the best included, as far as there are. Default 1.
    #[schema(minimum = 1, maximum = 100, example = 1)]
    #[serde(default = "one")]
    pub top: u32,
    /// Fixes every random choice: same mesh, request and seed give the same result. Default: a
    /// random number below 2^53.
    #[schema(minimum = 0, example = 7)]
    pub seed: u64,
    /// A name for people to recognise the job by, without control characters.
    #[schema(max_length = 200, nullable = false, example = "duck, four fingers")]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// Whether the job goes before others in the queue. Default `interactive`.
    #[serde(default)]
    pub priority: Priority,
    /// Where the server posts a signed message once the job has ended: an https URL on a host that
    /// the operator of the server allows. Default: nowhere.
    #[schema(
        format = "uri",
        max_length = 2048,
        nullable = false,
        example = "https://hooks.example.com/grasps"
    )]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub callback_url: Option<String>,
}

/// Requests of earlier versions have no such setting.
fn one() -> u32 {
    1
}

/// The settings that the quality of a grasp depends on, beside mesh and contacts. Documented where a
/// [`PlanRequest`] has them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QualitySettings {
    pub contact_model: ContactModel,
    pub friction: Option<f64>,
    pub cone_edges: Option<u32>,
    pub torsional_friction: Option<f64>,
    pub edge_norm: EdgeNorm,
    pub wrench_space: WrenchSpace,
    pub torque_scale: TorqueScale,
    pub center_of_mass: Option<[f64; 3]>,
    pub units: Option<Units>,
}

impl PlanRequest {
    /// The settings that the quality of a grasp depends on.
    pub fn quality(&self) -> QualitySettings {
        QualitySettings {
            contact_model: self.contact_model,
            friction: self.friction,
            cone_edges: self.cone_edges,
            torsional_friction: self.torsional_friction,
            edge_norm: self.edge_norm,
            wrench_space: self.wrench_space,
            torque_scale: self.torque_scale,
            center_of_mass: self.center_of_mass,
            units: self.units,
        }
    }

    /// What else is to be told of the best grasp.
    pub fn analyses(&self) -> Analyses {
        Analyses {
            robustness: self.robustness,
            independent_regions: self.independent_regions,
            task_wrenches: self.task_wrenches.clone(),
            gravity: self.gravity,
        }
    }
}

/// How a finger touches the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ContactModel {
    /// Pushes along the inward normal only.
    Frictionless,
    /// A point contact with Coulomb friction.
    Hard,
    /// A hard contact that also resists torques about its normal, by an elliptic limit.
    Soft,
}

/// How the wrenches of the contacts add up to the grasp wrench space (Ferrari & Canny 1992).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum WrenchSpace {
    /// Convex hull: the contact forces sum to one.
    #[default]
    L1,
    /// Minkowski sum: each contact force is at most one.
    Linf,
}

/// How long the edges of a linearised friction cone are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum EdgeNorm {
    /// Unit vectors.
    UnitEdge,
    /// Unit normal component, as GraspIt! and Dex-Net have it.
    UnitNormal,
}

/// The unit of a mesh's coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Units {
    M,
    Cm,
    Mm,
    Um,
    In,
    Ft,
}

impl Units {
    pub const ALL: [Self; 6] = [Self::M, Self::Cm, Self::Mm, Self::Um, Self::In, Self::Ft];

    /// Their names, for messages.
    pub const NAMES: &str = "m, cm, mm, um, in or ft";

    /// The name in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::M => "m",
            Self::Cm => "cm",
            Self::Mm => "mm",
            Self::Um => "um",
            Self::In => "in",
            Self::Ft => "ft",
        }
    }

    /// The unit of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|unit| unit.name() == name)
    }

    /// Its length.
    pub fn meters(self) -> f64 {
        match self {
            Self::M => 1.0,
            Self::Cm => 0.01,
            Self::Mm => 0.001,
            Self::Um => 1e-6,
            Self::In => 0.0254,
            Self::Ft => 0.3048,
        }
    }
}

/// Which search improves the first grasp.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Exchange of single fingers with proofs, from the children of what that arrived at.
    Memetic,
    /// The modified genetic algorithm of Rakesh et al. (2016).
    ModifiedGa,
    /// Local optimum search of Roa & Suárez (2009), from Algorithm 1's grasp.
    Local,
    /// The best of random grasps.
    Random,
}

/// Which candidates Roa & Suárez's Algorithm 1 accepts as a replacement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum InitialMode {
    /// One primitive wrench of the new finger in the wanted region suffices.
    Weak,
    /// All of them must lie there.
    Strict,
}

/// The factor (1/length) that makes torques comparable with forces: `"max_radius"`, `"none"` or
/// a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TorqueScale {
    /// One over the greatest distance of a vertex from the point torques are taken about.
    MaxRadius,
    /// 1: torques as they are.
    None,
    /// This number, 1/length.
    Custom(f64),
}

impl Serialize for TorqueScale {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::MaxRadius => serializer.serialize_str("max_radius"),
            Self::None => serializer.serialize_str("none"),
            Self::Custom(value) => serializer.serialize_f64(*value),
        }
    }
}

impl<'de> Deserialize<'de> for TorqueScale {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Written {
            Number(f64),
            Name(String),
        }
        match Written::deserialize(deserializer)? {
            Written::Number(value) => Ok(Self::Custom(value)),
            Written::Name(name) if name == "max_radius" => Ok(Self::MaxRadius),
            Written::Name(name) if name == "none" => Ok(Self::None),
            Written::Name(name) => Err(de::Error::custom(format_args!(
                "unknown torque scale {name:?}"
            ))),
        }
    }
}

impl PartialSchema for TorqueScale {
    fn schema() -> RefOr<Schema> {
        OneOfBuilder::new()
            .description(Some(
                "The factor (1/length) that makes torques comparable with forces. `max_radius`: \
                 one over the greatest distance of a vertex from the point torques are taken \
                 about. `none`: 1. A number: itself.",
            ))
            .item(
                ObjectBuilder::new()
                    .schema_type(SchemaType::new(Type::String))
                    .enum_values(Some(["max_radius", "none"])),
            )
            .item(
                ObjectBuilder::new()
                    .schema_type(SchemaType::new(Type::Number))
                    .minimum(Some(1e-9))
                    .maximum(Some(1e9)),
            )
            .into()
    }
}

impl ToSchema for TorqueScale {
    fn name() -> std::borrow::Cow<'static, str> {
        "TorqueScale".into()
    }
}

/// Schema of a planning request as a client may send it: [`PlanRequest`] with every field
/// optional and none beside them.
pub struct PlanRequestInput;

impl PartialSchema for PlanRequestInput {
    fn schema() -> RefOr<Schema> {
        let mut schema = PlanRequest::schema();
        if let RefOr::T(Schema::Object(object)) = &mut schema {
            object.required.clear();
            object.description = Some("What to plan. Every field is optional.".to_owned());
            object.additional_properties = Some(Box::new(AdditionalProperties::FreeForm(false)));
        }
        schema
    }
}

impl ToSchema for PlanRequestInput {
    fn name() -> std::borrow::Cow<'static, str> {
        "PlanRequestInput".into()
    }

    fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
        PlanRequest::schemas(schemas);
    }
}

/// A seed for a request that names none: random, and exact in every JSON reader (< 2^53).
pub fn random_seed() -> u64 {
    (uuid::Uuid::new_v4().as_u128() as u64) & ((1 << 53) - 1)
}
