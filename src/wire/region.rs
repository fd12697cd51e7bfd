//! Parts of the surface that a request names.

use serde::{Deserialize, Serialize};

/// A part of the surface, in the mesh's frame and unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Region {
    /// Inside an axis-aligned box.
    Box(Corners),
    /// On the side of the plane through `point` that `normal` points to.
    HalfSpace(HalfSpace),
    /// Inside a sphere.
    Sphere(Sphere),
    /// On these triangles, counted from 0 in the order of the uploaded file; all regions together may name
    /// 100,000.
    Triangles(Vec<u32>),
}

/// An axis-aligned box.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Corners {
    /// Lowest corner.
    pub min: [f64; 3],
    /// Highest corner.
    pub max: [f64; 3],
}

/// All on one side of a plane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HalfSpace {
    /// Somewhere on the plane.
    pub point: [f64; 3],
    /// Into the half-space, of any length but zero.
    pub normal: [f64; 3],
}

/// A solid sphere.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sphere {
    pub center: [f64; 3],
    pub radius: f64,
}
