//! Which part of a mesh is grasped, and whether fingers may be where nothing reaches.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use utoipa::openapi::schema::{Schema, SchemaType, Type};
use utoipa::openapi::{ObjectBuilder, OneOfBuilder, RefOr};
use utoipa::{PartialSchema, ToSchema};

/// Most characters of the name of a component.
pub const MAX_NAME_CHARS: usize = 200;

/// Which of the mesh's surface contacts may be on.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SurfaceSettings {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub component: Option<Component>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub enclosed: Option<bool>,
}

/// A body of the mesh, or all of them.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Component {
    /// A body by its place in the report, from 0.
    Number(u32),
    /// The parts of the file with this name; [`Self::ALL`] is the whole mesh.
    Name(String),
}

impl Component {
    pub const ALL: &str = "all";
}

impl PartialSchema for Component {
    fn schema() -> RefOr<Schema> {
        OneOfBuilder::new()
            .description(Some(
                "The number of a body, counted from 0 in the order of the report, or the name of parts of the file. \
                 `all` takes all bodies as one rigid body.",
            ))
            .item(
                ObjectBuilder::new()
                    .schema_type(SchemaType::new(Type::Integer))
                    .minimum(Some(0))
                    .maximum(Some(u32::MAX)),
            )
            .item(
                ObjectBuilder::new()
                    .schema_type(SchemaType::new(Type::String))
                    .min_length(Some(1))
                    .max_length(Some(MAX_NAME_CHARS)),
            )
            .into()
    }
}

impl ToSchema for Component {
    fn name() -> Cow<'static, str> {
        "Component".into()
    }
}
