//! From where a grasp is seen.

use nalgebra::Vector3;

use crate::picture::EYE;

/// From where a grasp is seen.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Viewpoint {
    /// From the front, right and above, and from the opposite side.
    #[default]
    Both,
    /// The first of these.
    Oblique,
    /// From a direction in degrees: round z, 0 from the front (−y) and 90 from the right (+x), and up from the
    /// horizon, −90 to 90.
    Angles { azimuth: f64, elevation: f64 },
}

impl Viewpoint {
    /// How it is named, for messages.
    pub const NAMES: &str = "both, iso, front, back, left, right, top, bottom, or azimuth and elevation in degrees such as 30,20,";

    /// The one of that name.
    pub fn named(name: &str) -> Option<Self> {
        let angles = |azimuth, elevation| Self::Angles { azimuth, elevation };
        Some(match name {
            "both" => Self::Both,
            "iso" => Self::Oblique,
            "front" => angles(0.0, 0.0),
            "right" => angles(90.0, 0.0),
            "back" => angles(180.0, 0.0),
            "left" => angles(270.0, 0.0),
            "top" => angles(0.0, 90.0),
            "bottom" => angles(0.0, -90.0),
            pair => {
                let (azimuth, elevation) = pair.split_once(',')?;
                let azimuth = azimuth.parse().ok()?;
                let elevation = elevation.parse().ok()?;
                let fits =
                    (-360.0..=360.0).contains(&azimuth) && (-90.0..=90.0).contains(&elevation);
                return fits.then(|| angles(azimuth, elevation));
            }
        })
    }

    /// Directions to the eye, from left to right.
    pub(super) fn eyes(self) -> Vec<Vector3<f64>> {
        match self {
            Self::Both => vec![EYE, -EYE],
            Self::Oblique => vec![EYE],
            Self::Angles { azimuth, elevation } => {
                let (sine, cosine) = azimuth.to_radians().sin_cos();
                let (up, level) = elevation.to_radians().sin_cos();
                vec![Vector3::new(sine * level, -cosine * level, up)]
            }
        }
    }
}
