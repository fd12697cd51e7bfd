//! Where a finger is, as a client says it.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::openapi::schema::{AdditionalProperties, ArrayBuilder, Schema, SchemaType, Type};
use utoipa::openapi::{ObjectBuilder, RefOr};
use utoipa::{PartialSchema, ToSchema};

use super::settings::{is_direction, numbers, whole};

/// Where a finger is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(into = "Written", try_from = "Written")]
pub enum ContactSpec {
    /// The centroid of a triangle, counted from 0 in the order of the file.
    Triangle(u32),
    /// The place on the surface nearest to a point.
    Projected([f64; 3]),
    /// A point with a normal into the body, of any length but zero, wherever the surface is.
    Free { point: [f64; 3], normal: [f64; 3] },
}

/// The same in JSON.
#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    triangle: Option<u32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    point: Option<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    normal: Option<[f64; 3]>,
}

impl From<ContactSpec> for Written {
    fn from(contact: ContactSpec) -> Self {
        let mut written = Self::default();
        match contact {
            ContactSpec::Triangle(triangle) => written.triangle = Some(triangle),
            ContactSpec::Projected(point) => written.point = Some(point),
            ContactSpec::Free { point, normal } => {
                (written.point, written.normal) = (Some(point), Some(normal));
            }
        }
        written
    }
}

impl TryFrom<Written> for ContactSpec {
    type Error = &'static str;

    fn try_from(written: Written) -> Result<Self, Self::Error> {
        match (written.triangle, written.point, written.normal) {
            (Some(triangle), None, None) => Ok(Self::Triangle(triangle)),
            (None, Some(point), None) => Ok(Self::Projected(point)),
            (None, Some(point), Some(normal)) => Ok(Self::Free { point, normal }),
            _ => Err("a contact is a triangle, a point, or a point with a normal"),
        }
    }
}

/// What a contact may be, for messages.
const FORMS: &str = "a contact is {\"triangle\": n}, {\"point\": [x, y, z]}, or a point with {\"normal\": \
                     [x, y, z]} into the body";

impl ContactSpec {
    /// A contact, or the pointer of the member at fault and what is wrong with it. There may be very many, so
    /// they are read at once and not through a definition.
    pub(super) fn read(value: &Value) -> Result<Self, (String, String)> {
        let fault = |member: &str, detail: &str| (super::text::pointer(member), detail.to_owned());
        let Some(object) = value.as_object() else {
            return Err((String::new(), FORMS.to_owned()));
        };
        let known = ["triangle", "point", "normal"];
        if let Some(name) = object.keys().find(|name| !known.contains(&name.as_str())) {
            return Err(fault(name, &format!("unknown member; {FORMS}")));
        }
        let vector = |member: &str| match object.get(member).map(numbers) {
            Some(Some(vector)) => Ok(vector),
            _ => Err(fault(member, COORDINATES)),
        };
        let has = |member: &str| object.contains_key(member);
        match (object.get("triangle"), has("point"), has("normal")) {
            (Some(triangle), false, false) => {
                let number = whole(triangle).and_then(|n| u32::try_from(n).ok());
                number.map(Self::Triangle).ok_or_else(|| {
                    fault(
                        "triangle",
                        "must be the number of a triangle, counted from 0 in the order of the file",
                    )
                })
            }
            (None, true, false) => Ok(Self::Projected(vector("point")?)),
            (None, true, true) => {
                let (point, normal) = (vector("point")?, vector("normal")?);
                match is_direction(&normal) {
                    true => Ok(Self::Free { point, normal }),
                    false => Err(fault("normal", "must not be zero")),
                }
            }
            (Some(_), _, _) => Err(fault(
                "triangle",
                "a triangle goes without point and normal; give one or the other",
            )),
            (None, false, _) => Err((String::new(), FORMS.to_owned())),
        }
    }
}

/// What a vector must be.
pub(super) const COORDINATES: &str = "must be three numbers from -1e12 to 1e12, [x, y, z]";

impl PartialSchema for ContactSpec {
    fn schema() -> RefOr<Schema> {
        let number = || ObjectBuilder::new().schema_type(SchemaType::new(Type::Number));
        let vector = || {
            ArrayBuilder::new()
                .items(number())
                .min_items(Some(3))
                .max_items(Some(3))
        };
        ObjectBuilder::new()
            .description(Some(
                "`triangle` alone, counted from 0 in the order of the file: its centroid. `point` alone: the \
                 nearest place on the surface. `point` with `normal`, into the body and of any length but zero: \
                 as it is.",
            ))
            .property(
                "triangle",
                ObjectBuilder::new()
                    .schema_type(SchemaType::new(Type::Integer))
                    .minimum(Some(0)),
            )
            .property("point", vector())
            .property("normal", vector())
            .additional_properties(Some(AdditionalProperties::FreeForm(false)))
            .into()
    }
}

impl ToSchema for ContactSpec {
    fn name() -> std::borrow::Cow<'static, str> {
        "ContactSpec".into()
    }
}
