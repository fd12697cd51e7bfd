//! What a client asks for.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::openapi::schema::{AdditionalProperties, Schema, SchemaType, Type};
use utoipa::openapi::{ObjectBuilder, OneOfBuilder, RefOr};
use utoipa::{PartialSchema, ToSchema};

use super::FieldError;
use super::constraints::Constraints;
use super::priority::Priority;
use super::settings::{
    MAX_DOCUMENT_BYTES, SETTINGS, Scope, fault, members, object_of_form, rules, schema, typed,
};
use super::surface::SurfaceSettings;
use graspd_core::analysis::AnalysisSettings;
use graspd_core::plan::{CandidateSource, Method, WrenchSettings};
use graspd_core::search::InitialMode;

/// A planning request with every default filled in and the seed fixed: the effective settings that are stored
/// with the job, echoed to the client and enough to repeat the run. What each setting means stands in
/// [`SETTINGS`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanRequest {
    pub contacts: u32,
    #[serde(flatten)]
    pub quality: QualitySettings,
    #[serde(flatten)]
    pub surface: SurfaceSettings,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub constraints: Option<Constraints>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub candidates: Option<CandidateSource>,
    pub method: Method,
    pub population: u32,
    pub generations: u32,
    pub crossover_probability: f64,
    pub mutation_probability: f64,
    pub elitism: u32,
    pub initial: InitialMode,
    #[serde(default)]
    pub polish: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_limit_s: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evaluation_limit: Option<u64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target_quality: Option<f64>,
    #[serde(flatten)]
    pub analyses: AnalysisSettings,
    #[serde(default = "one")]
    pub trials: u32,
    #[serde(default = "one")]
    pub top: u32,
    pub seed: u64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    #[serde(default)]
    pub priority: Priority,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub callback_url: Option<String>,
}

/// Requests of earlier versions have no such setting.
fn one() -> u32 {
    1
}

/// The settings that the quality of a grasp depends on, besides mesh and contacts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct QualitySettings {
    #[serde(flatten)]
    pub wrench: WrenchSettings,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub units: Option<Units>,
}

impl PlanRequest {
    /// Validates a JSON object, fills in the defaults, and reports every field at fault.
    pub fn from_json(value: &Value, default_seed: u64) -> Result<Self, Vec<FieldError>> {
        let Value::Object(object) = value else {
            return Err(vec![fault(
                "",
                "the planning request must be a JSON object",
            )]);
        };
        Self::read(object, default_seed, Vec::new())
    }

    /// Validates form fields or flags: each text becomes the JSON value that its setting takes, then the rules
    /// of [`Self::from_json`] hold.
    pub fn from_form(
        fields: impl IntoIterator<Item = (String, String)>,
        default_seed: u64,
    ) -> Result<Self, Vec<FieldError>> {
        let mut faults = Vec::new();
        let settings = SETTINGS.iter();
        let object = object_of_form(settings, fields, MAX_DOCUMENT_BYTES, &mut faults)
            .map_err(|fault| vec![fault])?;
        Self::read(&object, default_seed, faults)
    }

    fn read(
        object: &Map<String, Value>,
        default_seed: u64,
        mut faults: Vec<FieldError>,
    ) -> Result<Self, Vec<FieldError>> {
        let before = faults.len();
        let mut read = members(SETTINGS.iter(), rules::request, object, "", &mut faults);
        faults[before..].sort_by_key(rank);
        read.entry("seed").or_insert_with(|| default_seed.into());
        typed(read, faults)
    }
}

/// Where a fault of a planning request stands among the others: unknown fields first, then the settings that
/// evaluations have too, then the others. Within these it is the order of the table, except that contacts,
/// constraints and candidates follow the settings that say how large the search is.
fn rank(fault: &FieldError) -> Option<(Scope, usize, usize)> {
    let name = fault.pointer.split('/').nth(1)?;
    let (after, place) = match name {
        "contacts" => ("generations", 1),
        "constraints" => ("elitism", 1),
        "candidates" => ("elitism", 2),
        _ => (name, 0),
    };
    let index = SETTINGS.iter().position(|setting| setting.name == after)?;
    Some((SETTINGS[index].scope, index, place))
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

/// Schema of a [`TorqueScale`](graspd_core::wrench::TorqueScale).
pub struct TorqueScaleSchema;

impl PartialSchema for TorqueScaleSchema {
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

impl ToSchema for TorqueScaleSchema {
    fn name() -> std::borrow::Cow<'static, str> {
        "TorqueScale".into()
    }
}

impl PartialSchema for PlanRequest {
    fn schema() -> RefOr<Schema> {
        let object = schema::object(SETTINGS.iter());
        let description = "A planning request with every default filled in and the seed fixed: the effective \
                           settings that are stored with the job and enough to repeat the run.";
        object.description(Some(description)).into()
    }
}

impl ToSchema for PlanRequest {
    fn name() -> std::borrow::Cow<'static, str> {
        "PlanRequest".into()
    }

    fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
        schema::add_types(SETTINGS.iter(), schemas);
    }
}

/// Schema of a planning request as a client may send it: [`PlanRequest`] with every field
/// optional and none besides them.
pub struct PlanRequestInput;

impl PartialSchema for PlanRequestInput {
    fn schema() -> RefOr<Schema> {
        let mut object = schema::object(SETTINGS.iter()).build();
        object.required.clear();
        object.description = Some("What to plan. Every field is optional.".to_owned());
        object.additional_properties = Some(Box::new(AdditionalProperties::FreeForm(false)));
        Schema::Object(object).into()
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
