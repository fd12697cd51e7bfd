//! The factor that makes torques comparable with forces.

use nalgebra::Point3;

use super::mesh::Mesh;

/// The factor λ (1/length) that makes torques comparable with forces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TorqueScale {
    /// 1/max‖v−c‖ over the mesh's vertices v: ε becomes free of units.
    MaxRadius,
    /// 1, the paper as written.
    None,
    /// A finite positive number, 1/length.
    Custom(f64),
}

impl TorqueScale {
    /// The number λ for torques about `center` on `mesh`. O(vertices) for `MaxRadius`.
    pub fn value(self, mesh: &Mesh, center: &Point3<f64>) -> f64 {
        match self {
            Self::MaxRadius => 1.0 / mesh.radius_about(center),
            Self::None => 1.0,
            Self::Custom(value) => value,
        }
    }
}

/// As JSON: the name, or the number.
#[cfg(feature = "serde")]
mod json {
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

    use super::TorqueScale;

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
}
