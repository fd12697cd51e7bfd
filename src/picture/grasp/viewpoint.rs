//! The directions from which a grasp is drawn.

use nalgebra::Vector3;

use crate::picture::EYE;

/// The directions from which a grasp is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Viewpoint {
    /// From the front, right and above, and from the opposite side.
    #[default]
    Both,
    /// The first of these two.
    Oblique,
    /// From a direction in degrees: around z, 0 from the front (−y) and 90 from the right (+x); and above the horizon, −90 to
    /// 90.
    Angles { azimuth: f64, elevation: f64 },
}

impl Viewpoint {
    /// The names, for messages.
    pub const NAMES: &str = "both, iso, front, back, left, right, top, bottom, or azimuth and elevation in degrees such as 30,20,";

    /// Parses a name.
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

    /// The directions to the viewer, from left to right.
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
