//! Evaluations of given grasps: requests and answers.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::FieldError;
use super::contact::{COORDINATES, ContactSpec};
use super::request::{QualitySettings, Units};
use super::result::{TorqueScaleValue, WeakestWrench};
use super::settings::{
    Kind, MAX_CONTACTS, SETTINGS, Scope, Setting, fault, members, numbers, object_of_form, rules,
    typed,
};
use super::surface::SurfaceSettings;
use graspd_core::analysis::AnalysisSettings;
use graspd_core::effort::ExternalWrench;
use graspd_core::independent::IndependentRegion;
use graspd_core::measures::Measures;
use graspd_core::mesh::MeshWarning;
use graspd_core::motion::Motion;
use graspd_core::plan::ContactKind;
use graspd_core::robustness::Robustness;
use graspd_core::task::TaskQuality;
use graspd_core::wrench::{EdgeNorm, WrenchSpace};

/// Most grasps of one call.
pub const MAX_GRASPS: usize = 10_000;
/// Most bytes of the JSON of one call.
pub const MAX_EVALUATION_BYTES: usize = 8 << 20;
/// Most external wrenches of one call.
const MAX_EXTERNAL: usize = 16;
/// Faults of grasps that are looked for before the rest is left alone.
const MAX_FAULTS: usize = 20;

/// Grasps to evaluate, validated.
#[derive(Debug, Clone, PartialEq)]
pub struct EvaluationRequest {
    pub quality: QualitySettings,
    pub surface: SurfaceSettings,
    pub grasps: Vec<Vec<ContactSpec>>,
    pub external: Vec<ExternalWrench>,
    pub analyses: AnalysisSettings,
}

/// The evaluations of grasps, in the order of the request, with every number that they depend on. The same
/// mesh and request give the same bytes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Evaluations {
    pub evaluations: Vec<GraspEvaluation>,
    /// The frame of positions, normals and torques: `mesh`, that of the uploaded file.
    #[schema(example = "mesh")]
    pub frame: String,
    /// The unit of lengths, if the request named it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<Units>,
    /// The factor that made torques comparable with forces.
    pub torque_scale: TorqueScaleValue,
    /// The point torques are taken about.
    pub center_of_mass: [f64; 3],
    pub contact_model: ContactKind,
    /// Coefficient of friction μ.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Edges of the pyramid that replaces the friction cone; 0 is the round cone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cone_edges: Option<u32>,
    /// Torsional friction μ_t of soft contacts, a length in the mesh's unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torsional_friction: Option<f64>,
    pub edge_norm: EdgeNorm,
    pub wrench_space: WrenchSpace,
    /// Warnings about the mesh without which the answer should not be believed.
    #[schema(nullable = false)]
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub mesh_warnings: Vec<MeshWarning>,
    /// Version of graspd that made this answer.
    #[schema(example = "0.1.0")]
    pub version: String,
}

/// The evaluation of one given grasp.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct GraspEvaluation {
    /// Whether the contacts hold the body against every small force and torque.
    pub force_closure: bool,
    /// The quality ε, as in a planning result; where the wrench space is no polytope, the certified
    /// lower end of an interval. Absent without force closure.
    pub quality: Option<f64>,
    /// Signed distance from the origin to the plane of the nearest facet of the wrench space, as in a planning
    /// result.
    pub margin: Option<f64>,
    /// Whether `margin`, and with it `quality`, is exact to rounding or, where the wrench space is no
    /// polytope, to 1e-6 of itself. If not, `quality` is a lower bound, and `weakest_wrench` and the forces are those of
    /// the weakest direction found.
    pub exact: Option<bool>,
    /// [lower, upper]: a certified interval on the ε that the same contacts have with the round
    /// friction cone itself. Absent without force closure.
    pub bounds: Option<[f64; 2]>,
    /// Whether `bounds` differ by at most 1e-6 of the upper one. `false` when the facet limit ended the interval earlier; it
    /// is certified all the same. Absent without force closure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bounds_exact: Option<bool>,
    pub contacts: Vec<EvaluatedContact>,
    /// The direction in which the grasp is weakest.
    pub weakest_wrench: Option<WeakestWrench>,
    /// Why there is no force closure. Absent with force closure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub explanation: Option<ExplainedObstacle>,
    pub measures: Measures,
    /// The quality to expect when the fingers miss their places, if it was requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robustness: Option<Robustness>,
    /// Where each finger may be while the others stay, in the order of the contacts, if it was requested.
    /// Absent without force closure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub independent_regions: Option<Vec<IndependentRegion>>,
    /// Quality against the task wrenches of the request.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub task_quality: Option<TaskQuality>,
    /// Quality against a force along the gravity of the request, at the centre of mass: the largest such
    /// force that is resisted, in the unit of ε.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity_quality: Option<f64>,
    /// For each external wrench of the request, in order, whether and how it is resisted.
    pub resisted: Vec<Resistance>,
}

/// A contact as it was evaluated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct EvaluatedContact {
    /// Position in the mesh's frame and unit.
    pub position: [f64; 3],
    /// Unit normal pointing into the body: the direction a finger pushes in.
    pub normal: [f64; 3],
    /// Unit normal pointing out of the body: the side a finger comes from.
    pub approach: [f64; 3],
    /// The triangle it touches, counted from 0 in the order of the file; absent for free points.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub triangle: Option<u32>,
    /// Barycentric coordinates of the position in that triangle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub barycentric: Option<[f64; 3]>,
    /// Distance by which projection moved the point.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance: Option<f64>,
    /// The force this finger exerts in the least-effort answer to the disturbance that the grasp
    /// resists worst: the opposite of `weakest_wrench`, at unit size. Absent without force closure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub forces: Option<[f64; 3]>,
    /// The torque about the inward normal that goes with the force, for soft contacts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torsion: Option<f64>,
}

/// Contact forces against one external wrench.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Resistance {
    /// Whether the grasp can resist it, with forces of at most 10^7 times its size, torques measured over the longest lever
    /// arm. A grasp that is force closure resists everything.
    pub resisted: bool,
    /// The least sum of normal forces that resists it, in the unit of the external force.
    pub effort: Option<f64>,
    /// The force of each finger, in the order of the contacts.
    pub forces: Option<Vec<[f64; 3]>>,
    /// The torque of each finger about its inward normal, for soft contacts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torsions: Option<Vec<f64>>,
}

/// Why a grasp is not force closure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Obstacle)]
pub struct ExplainedObstacle {
    pub reason: ObstacleReason,
    /// Number of dimensions that the wrenches span, if fewer than 6.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rank: Option<u32>,
    /// Distance of the origin from the wrench space, in the unit of `margin`, to 1e-6 of itself. It is at least minus
    /// the `margin`, which is the offset of one facet.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance: Option<f64>,
    /// A motion of the body that the contacts leave free; there may be others.
    pub motion: Option<Motion>,
    /// The obstacle in plain words.
    pub detail: String,
}

/// The kind of the obstacle to force closure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ObstacleReason {
    /// The wrenches of the contacts span fewer than 6 dimensions.
    RankDeficient,
    /// The origin is not inside the wrench space.
    OriginOutside,
}

/// What only a request for an evaluation has. There may be very many grasps, so they are read at once and not
/// through a definition.
const OWN_SETTINGS: &[Setting] = &[
    Setting::new(
        "grasps",
        Kind::Document,
        "The grasps, each a list of contacts.",
    ),
    Setting::new("external_wrench", Kind::Document, "One external wrench."),
    Setting::new(
        "external_wrenches",
        Kind::Document,
        "The external wrenches.",
    ),
];

/// Every setting of an evaluation.
fn settings() -> impl Iterator<Item = &'static Setting> + Clone {
    let shared = |setting: &&Setting| matches!(setting.scope, Scope::Quality | Scope::Analysis);
    OWN_SETTINGS.iter().chain(SETTINGS.iter().filter(shared))
}

/// The settings of an evaluation as they are read.
#[derive(Deserialize)]
struct Shared {
    #[serde(flatten)]
    quality: QualitySettings,
    #[serde(flatten)]
    surface: SurfaceSettings,
    #[serde(flatten)]
    analyses: AnalysisSettings,
}

impl EvaluationRequest {
    /// Validates a JSON object and reports every field at fault, and of grasps the first faults.
    pub fn from_json(value: &Value) -> Result<Self, Vec<FieldError>> {
        match value {
            Value::Object(object) => Self::read(object, Vec::new()),
            _ => Err(vec![fault(
                "",
                "the evaluation request must be a JSON object",
            )]),
        }
    }

    /// Validates simple form fields; grasps and external wrenches are JSON texts.
    pub fn from_form(
        fields: impl IntoIterator<Item = (String, String)>,
    ) -> Result<Self, Vec<FieldError>> {
        let mut faults = Vec::new();
        let object = object_of_form(settings(), fields, MAX_EVALUATION_BYTES, &mut faults)
            .map_err(|fault| vec![fault])?;
        Self::read(&object, faults)
    }

    fn read(
        object: &Map<String, Value>,
        mut faults: Vec<FieldError>,
    ) -> Result<Self, Vec<FieldError>> {
        let read = members(settings(), rules::contact, object, "", &mut faults);
        let external = external_wrenches(object, &mut faults);
        let grasps = grasps(object.get("grasps"), &mut faults);
        let Shared {
            quality,
            surface,
            analyses,
        } = typed(read, faults)?;
        Ok(Self {
            quality,
            surface,
            grasps,
            external,
            analyses,
        })
    }
}

fn grasps(value: Option<&Value>, faults: &mut Vec<FieldError>) -> Vec<Vec<ContactSpec>> {
    let items = value.and_then(Value::as_array);
    let Some(items) = items.filter(|items| (1..=MAX_GRASPS).contains(&items.len())) else {
        let detail = format!("must be a list of 1 to {MAX_GRASPS} grasps, each a list of contacts");
        faults.push(fault("/grasps", detail));
        return Vec::new();
    };
    let mut grasps = Vec::with_capacity(items.len());
    let before = faults.len();
    for (i, item) in items.iter().enumerate() {
        let contacts = item.as_array();
        let Some(contacts) = contacts.filter(|c| (1..=MAX_CONTACTS).contains(&c.len())) else {
            let detail = format!("must be a list of 1 to {MAX_CONTACTS} contacts");
            faults.push(fault(format!("/grasps/{i}"), detail));
            continue;
        };
        let mut grasp = Vec::with_capacity(contacts.len());
        for (j, contact) in contacts.iter().enumerate() {
            match ContactSpec::read(contact) {
                Ok(contact) => grasp.push(contact),
                Err((member, detail)) => {
                    faults.push(fault(format!("/grasps/{i}/{j}{member}"), detail));
                }
            }
        }
        grasps.push(grasp);
        if faults.len() - before > MAX_FAULTS {
            break;
        }
    }
    grasps
}

fn external_wrenches(
    object: &Map<String, Value>,
    faults: &mut Vec<FieldError>,
) -> Vec<ExternalWrench> {
    let items = match (
        object.get("external_wrench"),
        object.get("external_wrenches"),
    ) {
        (None, None) => return Vec::new(),
        (Some(_), Some(_)) => {
            let detail = "give this or external_wrenches, not both";
            faults.push(fault("/external_wrench", detail));
            return Vec::new();
        }
        (Some(one), None) => {
            let wrench = external_wrench("/external_wrench", one, faults);
            return wrench.into_iter().collect();
        }
        (None, Some(many)) => many.as_array().filter(|items| items.len() <= MAX_EXTERNAL),
    };
    let Some(items) = items else {
        let detail = format!("must be a list of at most {MAX_EXTERNAL} wrenches");
        faults.push(fault("/external_wrenches", detail));
        return Vec::new();
    };
    let wrenches = items.iter().enumerate();
    wrenches
        .filter_map(|(i, item)| external_wrench(&format!("/external_wrenches/{i}"), item, faults))
        .collect()
}

fn external_wrench(
    pointer: &str,
    value: &Value,
    faults: &mut Vec<FieldError>,
) -> Option<ExternalWrench> {
    let known = |name: &String| name == "force" || name == "torque";
    let object = value.as_object();
    let Some(object) = object.filter(|o| !o.is_empty() && o.keys().all(known)) else {
        faults.push(fault(
            pointer,
            "must be {\"force\": [x, y, z], \"torque\": [x, y, z]}, or one of the two",
        ));
        return None;
    };
    let mut part = |name: &str| match object.get(name) {
        None => Some(Vector3::zeros()),
        Some(value) => {
            let found = numbers(value).map(Vector3::from);
            if found.is_none() {
                faults.push(fault(format!("{pointer}/{name}"), COORDINATES));
            }
            found
        }
    };
    let (force, torque) = (part("force"), part("torque"));
    Some(ExternalWrench {
        force: force?,
        torque: torque?,
    })
}

#[cfg(test)]
mod tests {
    use graspd_core::plan::ContactFields;
    use serde_json::json;

    use super::*;

    fn pointers(value: Value) -> Vec<String> {
        let errors = EvaluationRequest::from_json(&value).expect_err("refused");
        errors.into_iter().map(|error| error.pointer).collect()
    }

    #[test]
    fn each_kind_of_contact_is_read() {
        let request = EvaluationRequest::from_json(&json!({
            "grasps": [[{"triangle": 17}, {"point": [0, 1, 2]}, {"point": [0, 1, 2], "normal": [0, 0, -3]}]],
            "external_wrench": {"force": [0, 0, -9.81]}, "friction": 0.3
        }))
        .unwrap();
        assert_eq!(
            request.grasps,
            [[
                ContactSpec::Triangle(17),
                ContactSpec::Projected([0.0, 1.0, 2.0]),
                ContactSpec::Free {
                    point: [0.0, 1.0, 2.0],
                    normal: [0.0, 0.0, -3.0]
                }
            ]]
        );
        assert_eq!(request.external[0].force, Vector3::new(0.0, 0.0, -9.81));
        let contact = ContactFields::from(request.quality.wrench.contact);
        assert_eq!(contact.friction, Some(0.3));
    }

    #[test]
    fn faults_are_told_with_their_place() {
        for (value, pointer) in [
            (json!({}), "/grasps"),
            (json!({"grasps": []}), "/grasps"),
            (json!({"grasps": [[]]}), "/grasps/0"),
            (
                json!({"grasps": [[{"triangle": 1}], [{"triangle": -1}]]}),
                "/grasps/1/0/triangle",
            ),
            (
                json!({"grasps": [[{"triangle": 1.5}]]}),
                "/grasps/0/0/triangle",
            ),
            (
                json!({"grasps": [[{"triangle": 1, "point": [0, 0, 0]}]]}),
                "/grasps/0/0/triangle",
            ),
            (
                json!({"grasps": [[{"point": [0, 0]}]]}),
                "/grasps/0/0/point",
            ),
            (
                json!({"grasps": [[{"point": [0, 0, 1e13]}]]}),
                "/grasps/0/0/point",
            ),
            (
                json!({"grasps": [[{"point": [0, 0, 0], "normal": [0, 0, 0]}]]}),
                "/grasps/0/0/normal",
            ),
            (json!({"grasps": [[{"normal": [0, 0, 1]}]]}), "/grasps/0/0"),
            (json!({"grasps": [[{"face": 1}]]}), "/grasps/0/0/face"),
            (json!({"grasps": [[7]]}), "/grasps/0/0"),
            (json!({"grasps": [[{"triangle": 1}]], "seed": 1}), "/seed"),
            (
                json!({"grasps": [[{"triangle": 1}]], "external_wrench": {"f": 1}}),
                "/external_wrench",
            ),
            (
                json!({"grasps": [[{"triangle": 1}]], "external_wrenches": [{"force": [1]}]}),
                "/external_wrenches/0/force",
            ),
        ] {
            assert_eq!(pointers(value.clone()), [pointer], "{value}");
        }
        assert_eq!(pointers(json!([])), [""]);
    }

    #[test]
    fn a_form_means_what_the_same_json_means() {
        let form = [("grasps", r#"[[{"triangle": 3}]]"#), ("friction", "0.25")];
        let owned = form.map(|(name, text)| (name.to_owned(), text.to_owned()));
        let json = json!({"grasps": [[{"triangle": 3}]], "friction": 0.25});
        assert_eq!(
            EvaluationRequest::from_form(owned),
            EvaluationRequest::from_json(&json)
        );
        let broken = [("grasps".to_owned(), "[[{".to_owned())];
        let errors = EvaluationRequest::from_form(broken).unwrap_err();
        assert_eq!(errors[0].pointer, "/grasps");
    }
}
