//! The places that are searched.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::read::Reader;
use graspd_core::mesh::MAX_UNIFORM;

/// Candidates that are spread over a surface unless a request says how many.
pub const UNIFORM_COUNT: u32 = 10_000;

/// Where fingers may be put. In a form or as a flag also the kind alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct CandidateSettings {
    pub kind: CandidateKind,
    /// How many are spread over the surface, for `uniform`. Default 10000.
    #[schema(minimum = 1, maximum = 200_000, nullable = false, example = 10_000)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub count: Option<u32>,
}

/// Which places on the surface are candidates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum CandidateKind {
    /// The centroid of every triangle, as in the paper: as even as the triangles are.
    Triangles,
    /// Places spread evenly over the surface, whatever the triangles (Yuksel 2015), from the seed.
    Uniform,
}

/// Which candidates a run searched, and why.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct CandidateSource {
    pub kind: CandidateKind,
    /// How many there were before the constraints.
    pub count: u64,
    /// Why these, in words.
    pub because: String,
}

impl CandidateSettings {
    pub(super) fn read(reader: &mut Reader<'_>) -> Option<Self> {
        const NAME: &str = "candidates";
        let kinds = [CandidateKind::Triangles, CandidateKind::Uniform];
        if let Some(Value::String(_)) = reader.get(NAME) {
            return settings(reader.choice(NAME, &kinds)?, None);
        }
        reader.nested(NAME, &["kind", "count"], |reader| {
            let count = reader.integer("count", 1..=MAX_UNIFORM as u64);
            if reader.get("kind").is_none() {
                reader.fail("kind", "is missing; give triangles or uniform");
            }
            let kind = reader.choice("kind", &kinds)?;
            if kind == CandidateKind::Triangles && count.is_some() {
                reader.fail(
                    "count",
                    "every triangle is one; leave it out or use uniform",
                );
            }
            settings(kind, count)
        })?
    }
}

fn settings(kind: CandidateKind, count: Option<u64>) -> Option<CandidateSettings> {
    let count = match kind {
        CandidateKind::Triangles => None,
        CandidateKind::Uniform => Some(count.map_or(UNIFORM_COUNT, |count| count as u32)),
    };
    Some(CandidateSettings { kind, count })
}
