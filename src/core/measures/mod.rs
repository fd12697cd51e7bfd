//! Grasp quality measures besides ε.

/// The standard list of Roa & Suárez, "Grasp quality measures: review and performance" (Autonomous
/// Robots 38, 2015).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Measures {
    pub epsilon_l1: Option<f64>,
    pub epsilon_linf: Option<f64>,
    pub volume_l1: Option<f64>,
    pub smallest_singular_value: f64,
    pub isotropy: f64,
    pub ellipsoid_volume: f64,
    pub centroid_distance: f64,
    pub polygon_area: Option<f64>,
    pub polygon_shape: Option<f64>,
}
