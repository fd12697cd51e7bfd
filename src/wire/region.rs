//! Parts of the surface that a request names.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::contact::MIN_NORMAL;
use super::read::{MAX_COORDINATE, Reader};

/// Most triangles that all regions of a request may name.
pub(super) const MAX_TRIANGLES: usize = 100_000;

/// A part of the surface, in the mesh's frame and unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Region {
    /// Inside an axis-aligned box.
    #[schema(title = "BoxRegion")]
    Box(Corners),
    /// On the side of the plane through `point` that `normal` points to.
    #[schema(title = "HalfSpaceRegion")]
    HalfSpace(HalfSpace),
    /// Inside a sphere.
    #[schema(title = "SphereRegion")]
    Sphere(Sphere),
    /// On these triangles, counted from 0 in the order of the uploaded file; all regions together may name
    /// 100,000.
    #[schema(title = "TrianglesRegion")]
    Triangles(Vec<u32>),
}

/// An axis-aligned box.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Corners {
    /// Lowest corner.
    pub min: [f64; 3],
    /// Highest corner.
    pub max: [f64; 3],
}

/// All on one side of a plane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct HalfSpace {
    /// Somewhere on the plane.
    pub point: [f64; 3],
    /// Into the half-space, of any length but zero.
    pub normal: [f64; 3],
}

/// A solid sphere.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Sphere {
    pub center: [f64; 3],
    pub radius: f64,
}

/// Reads one region at `place`, and counts the triangles that all regions may still name.
pub(super) fn region(
    reader: &mut Reader,
    place: String,
    value: &Value,
    triangles: &mut usize,
) -> Option<Region> {
    let members = value.as_object().filter(|object| object.len() == 1);
    let Some((kind, shape)) = members.and_then(|object| object.iter().next()) else {
        reader.fail_at(
            place,
            "a region is {\"box\": {\"min\", \"max\"}}, {\"half_space\": {\"point\", \"normal\"}}, \
             {\"sphere\": {\"center\", \"radius\"}} or {\"triangles\": [...]}",
        );
        return None;
    };
    let known: [&str; 2] = match kind.as_str() {
        "box" => ["min", "max"],
        "half_space" => ["point", "normal"],
        "sphere" => ["center", "radius"],
        "triangles" => return triangle_list(reader, place + "/triangles", shape, triangles),
        unknown => {
            let place = place + &super::text::pointer(unknown);
            reader.fail_at(
                place,
                "unknown region; use box, half_space, sphere or triangles",
            );
            return None;
        }
    };
    let place = format!("{place}/{kind}");
    let Some(object) = shape.as_object() else {
        let [a, b] = known;
        reader.fail_at(place, format!("must be an object with {a} and {b}"));
        return None;
    };
    let mut shape = Reader::within(object, place);
    shape.refuse_unknown(&known);
    for name in known {
        if shape.value(name).is_none() {
            shape.fail(name, "is missing");
        }
    }
    let region = match known {
        ["min", "max"] => corners(&mut shape),
        ["point", "normal"] => half_space(&mut shape),
        _ => sphere(&mut shape),
    };
    reader.absorb(shape);
    region
}

fn corners(shape: &mut Reader) -> Option<Region> {
    let (min, max) = (shape.point("min"), shape.point("max"));
    let (min, max) = (min?, max?);
    if (0..3).any(|axis| min[axis] > max[axis]) {
        shape.fail(
            "min",
            "must not be greater than max on any axis: the box is empty",
        );
    }
    Some(Region::Box(Corners { min, max }))
}

fn half_space(shape: &mut Reader) -> Option<Region> {
    let (point, normal) = (shape.point("point"), shape.point("normal"));
    let (point, normal) = (point?, normal?);
    if is_zero(&normal) {
        shape.fail("normal", "must not be zero");
    }
    Some(Region::HalfSpace(HalfSpace { point, normal }))
}

fn sphere(shape: &mut Reader) -> Option<Region> {
    let center = shape.point("center");
    let radius = shape.number("radius", "above 0, up to 1e12", |x| {
        x > 0.0 && x <= MAX_COORDINATE
    });
    Some(Region::Sphere(Sphere {
        center: center?,
        radius: radius?,
    }))
}

fn triangle_list(
    reader: &mut Reader,
    place: String,
    value: &Value,
    left: &mut usize,
) -> Option<Region> {
    let Some(items) = value.as_array().filter(|items| items.len() <= *left) else {
        let detail = format!(
            "must be a list of the numbers of triangles, counted from 0; all regions together may name \
             {MAX_TRIANGLES}"
        );
        reader.fail_at(place, detail);
        return None;
    };
    *left -= items.len();
    let mut indices = Vec::with_capacity(items.len());
    for (i, item) in items.iter().enumerate() {
        match item.as_u64().and_then(|index| u32::try_from(index).ok()) {
            Some(index) => indices.push(index),
            // One is enough where the list is long.
            None => {
                let detail = "must be the number of a triangle, counted from 0";
                reader.fail_at(format!("{place}/{i}"), detail);
                return None;
            }
        }
    }
    Some(Region::Triangles(indices))
}

/// Whether a direction has no length to speak of.
pub(super) fn is_zero(direction: &[f64; 3]) -> bool {
    let length = direction.iter().fold(0.0, |sum: f64, x| sum.hypot(*x));
    length < MIN_NORMAL
}
