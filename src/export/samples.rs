//! Results for tests, and a reader of what is written that shares nothing with the writer.

use nalgebra::Vector3;
use serde_json::{Value, json};

use super::pose::GripperPose;
use crate::wire::{Chosen, ChosenGrasp, ContactPoint, PlanResult, Units};

/// A contact with a normal into the body that need not be of length one.
pub fn contact(position: [f64; 3], normal: [f64; 3]) -> ContactPoint {
    let length = normal.iter().fold(0.0, |sum: f64, x| sum.hypot(*x));
    let normal = normal.map(|x| x / length);
    ContactPoint {
        position,
        normal,
        approach: normal.map(|x| -x),
        triangle: Some(3),
        barycentric: Some([0.5, 0.25, 0.25]),
        fixed: false,
        forces: None,
        torsion: None,
    }
}

/// A result with these contacts, friction 0.5 and its centre of mass in the origin.
pub fn result(contacts: Vec<ContactPoint>) -> PlanResult {
    let result = json!({
        "force_closure": true, "quality": 0.125, "margin": 0.125, "exact": true, "contacts": contacts,
        "weakest_wrench": {"force": [0.6, 0.0, 0.0], "torque": [0.0, 0.0, 0.8], "description": ""},
        "frame": "mesh", "torque_scale": {"kind": "custom", "value": 0.5}, "center_of_mass": [0.0, 0.0, 0.0],
        "contact_model": "soft", "friction": 0.5, "cone_edges": 8, "edge_norm": "unit_edge",
        "candidates": 10, "method": "memetic", "seed": 7, "stopped_because": "generation_limit",
        "evaluations": 50, "history": [], "elapsed_s": 0.5, "version": "0",
    });
    serde_json::from_value(result).expect("a result")
}

/// The best grasp of a result.
pub fn best(result: &PlanResult) -> ChosenGrasp<'_> {
    Chosen::Best.of(result).expect("contacts")
}

/// The pose of jaws at `ends`, closing along the line between them on a body around `center`.
pub fn pose_of_jaws(ends: [[f64; 3]; 2], center: [f64; 3], units: Option<Units>) -> GripperPose {
    let [a, b] = ends.map(Vector3::from);
    let contacts = vec![
        contact(ends[0], (b - a).into()),
        contact(ends[1], (a - b).into()),
    ];
    let mut result = result(contacts);
    result.center_of_mass = center;
    GripperPose::of(&result, &best(&result), units).expect("a pose")
}

/// A GLB taken apart.
pub struct Parts {
    pub scene: Value,
    bytes: Vec<u8>,
}

impl Parts {
    pub fn of(file: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!(
            (&file[..4], word(4), word(8)),
            (&b"glTF"[..], 2, file.len())
        );
        let text = word(12);
        assert_eq!((&file[16..20], text % 4), (&b"JSON"[..], 0));
        let rest = 20 + text;
        assert_eq!(&file[rest + 4..rest + 8], b"BIN\0");
        let bytes = file[rest + 8..].to_vec();
        assert_eq!(bytes.len(), word(rest));
        Self {
            scene: serde_json::from_slice(&file[20..rest]).unwrap(),
            bytes,
        }
    }

    /// The node of that name.
    pub fn node(&self, name: &str) -> Option<&Value> {
        let nodes = self.scene["nodes"].as_array().unwrap();
        nodes.iter().find(|node| node["name"] == name)
    }

    /// The vertices of the node of that name, without any transformation.
    pub fn vertices(&self, name: &str) -> Vec<[f64; 3]> {
        let node = self.node(name).expect("a node");
        let mesh = &self.scene["meshes"][node["mesh"].as_u64().unwrap() as usize];
        let accessor = mesh["primitives"][0]["attributes"]["POSITION"].as_u64();
        let accessor = &self.scene["accessors"][accessor.unwrap() as usize];
        let view = &self.scene["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let start = view["byteOffset"].as_u64().unwrap() as usize;
        let length = 12 * accessor["count"].as_u64().unwrap() as usize;
        let words = self.bytes[start..start + length].chunks_exact(4);
        let numbers: Vec<f64> = words
            .map(|word| f64::from(f32::from_le_bytes(word.try_into().unwrap())))
            .collect();
        numbers
            .chunks_exact(3)
            .map(|point| point.try_into().unwrap())
            .collect()
    }
}
