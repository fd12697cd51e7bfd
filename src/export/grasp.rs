//! A grasp on its body as GLB.

use nalgebra::{Point3, Unit, UnitVector3, Vector3};
use serde_json::{Value, json};

use super::glb::Glb;
use super::mesh::{body_node, root};
use super::solids::{self, Solid};
use super::surface::Surface;
use crate::picture::marks::{self, ARROW, BENT, CONE, NEGLIGIBLE, WEAKEST};
use crate::picture::{CENTER, CONTACT_COLORS, FORCE, TORQUE};
use crate::wire::{ChosenGrasp, PlanResult};
use graspd_core::mesh::Mesh;

/// The radii of an arrow and of the centre of mass, relative to the radius of the body.
const SHAFT: f64 = 0.012;
const DOT: f64 = 0.03;

/// Writes the body with the contacts of a grasp, one node each: an arrow that ends in the contact along the inward
/// normal, and the friction cone, mirrored to the outside, where it can be seen. Also the centre of mass and the weakest
/// wrench.
///
/// Coordinates are in the mesh's frame and unit. The root node scales them to metres where the unit is known; nothing is
/// rotated. The `extras` of the nodes have the numbers.
///
/// # Errors
/// None that a caller can do something about.
pub fn grasp_glb(
    mesh: &Mesh,
    result: &PlanResult,
    grasp: &ChosenGrasp<'_>,
) -> Result<Vec<u8>, serde_json::Error> {
    let mut glb = Glb::default();
    let body = Surface::of(mesh, usize::MAX);
    let center = Point3::from(result.center_of_mass);
    let radius = mesh.radius_about(&mesh.report().center_of_mass);
    let mut children = vec![body_node(&mut glb, &body)];
    for (index, contact) in grasp.contacts.iter().enumerate() {
        let number = index + 1;
        let color = CONTACT_COLORS[index % CONTACT_COLORS.len()];
        let inward = Unit::new_normalize(Vector3::from(contact.normal));
        let arrow = solids::arrow(&inward, ARROW * radius, SHAFT * radius);
        let material = glb.material(&format!("contact {number}"), linear(color, 1.0));
        let name = format!("contact {number}/arrow");
        let mut parts = vec![solid_node(&mut glb, &name, &arrow, material)];
        if let Some(friction) = result.friction.filter(|friction| *friction > 0.0) {
            let (height, tangent) = marks::cone(friction, CONE * radius);
            let cone = solids::cone(&-inward, height, tangent);
            // With next to no friction the cone is a line, which has no surface.
            if !cone.triangles.is_empty() {
                let name = format!("contact {number}/cone");
                let material = glb.material(&name, linear(color, 0.35));
                parts.push(solid_node(&mut glb, &name, &cone, material));
            }
        }
        let mut extras = serde_json::to_value(contact)?;
        extras["contact"] = number.into();
        children.push(glb.node(json!({
            "name": format!("contact {number}"), "translation": contact.position, "children": parts,
            "extras": extras,
        })));
    }
    let material = glb.material("center of mass", linear(CENTER, 1.0));
    let dot = solids::sphere(DOT * radius);
    children.push(placed(
        &mut glb,
        "center of mass",
        &dot,
        material,
        &center,
        json!({
            "position": result.center_of_mass,
        }),
    ));
    if let Some(weakest) = grasp.weakest {
        let (force, torque) = (Vector3::from(weakest.force), Vector3::from(weakest.torque));
        if let Some(direction) = direction(&force) {
            let length = WEAKEST * radius * force.norm();
            let arrow = solids::arrow(&direction, length, SHAFT * radius);
            let material = glb.material("weakest force", linear(FORCE, 1.0));
            // This arrow starts at the point where the force acts.
            let tip = center + direction.into_inner() * length;
            children.push(placed(
                &mut glb,
                "weakest force",
                &arrow,
                material,
                &tip,
                json!({
                    "force": weakest.force,
                }),
            ));
        }
        if let Some(axis) = direction(&torque) {
            let bent = solids::bent_arrow(&axis, BENT * radius, SHAFT * radius);
            let material = glb.material("weakest torque", linear(TORQUE, 1.0));
            children.push(placed(
                &mut glb,
                "weakest torque",
                &bent,
                material,
                &center,
                json!({
                    "scaled_torque": weakest.torque,
                }),
            ));
        }
    }
    let root = root(result.units, &children, extras(result, grasp));
    let root = glb.node(root);
    glb.finish(root)
}

/// Returns everything that the quality depends on.
fn extras(result: &PlanResult, grasp: &ChosenGrasp<'_>) -> Value {
    json!({
        "frame": result.frame, "units": result.units, "grasp": grasp.chosen.name(),
        "force_closure": grasp.quality.is_some(), "quality": grasp.quality,
        "contact_model": result.contact_model, "friction": result.friction,
        "cone_edges": result.cone_edges, "torsional_friction": result.torsional_friction,
        "edge_norm": result.edge_norm, "wrench_space": result.wrench_space,
        "torque_scale": result.torque_scale, "center_of_mass": result.center_of_mass,
        "method": result.method, "seed": result.seed, "version": result.version,
    })
}

fn direction(vector: &Vector3<f64>) -> Option<UnitVector3<f64>> {
    Unit::try_new(*vector, NEGLIGIBLE)
}

fn solid_node(glb: &mut Glb, name: &str, solid: &Solid, material: usize) -> usize {
    let mesh = solid_mesh(glb, name, solid, material);
    glb.node(json!({"name": name, "mesh": mesh}))
}

fn placed(
    glb: &mut Glb,
    name: &str,
    solid: &Solid,
    material: usize,
    at: &Point3<f64>,
    extras: Value,
) -> usize {
    let mesh = solid_mesh(glb, name, solid, material);
    glb.node(json!({
        "name": name, "mesh": mesh, "translation": at.coords.as_slice(), "extras": extras,
    }))
}

fn solid_mesh(glb: &mut Glb, name: &str, solid: &Solid, material: usize) -> usize {
    let positions = glb.positions(&solid.vertices, &Vector3::zeros());
    let corners = glb.corners(&solid.triangles);
    glb.mesh(
        name,
        json!({
            "attributes": {"POSITION": positions}, "indices": corners, "material": material,
        }),
    )
}

/// Converts a colour from sRGB to the linear values of glTF.
fn linear(color: [u8; 3], opacity: f64) -> [f64; 4] {
    let part = |part: u8| {
        let part = f64::from(part) / 255.0;
        match part <= 0.040_45 {
            true => part / 12.92,
            false => ((part + 0.055) / 1.055).powf(2.4),
        }
    };
    let [red, green, blue] = color.map(part);
    [red, green, blue, opacity]
}

#[cfg(test)]
mod tests {
    use super::super::samples::{Parts, best, contact, result};
    use super::*;
    use crate::wire::{Chosen, ContactPoint, InitialGrasp, Units};
    use graspd_core::mesh::solids;

    fn ball() -> Mesh {
        Mesh::prepare(solids::sphere(2.0, 12, 24)).unwrap()
    }

    fn contacts() -> Vec<ContactPoint> {
        vec![
            contact([2.0, 0.0, 0.0], [-1.0, 0.0, 0.0]),
            contact([0.0, 2.0, 0.0], [0.0, -1.0, 0.0]),
            contact([0.0, -1.2, -1.6], [0.0, 1.2, 1.6]),
        ]
    }

    fn drawn(result: &PlanResult, grasp: &ChosenGrasp<'_>) -> Parts {
        Parts::of(&grasp_glb(&ball(), result, grasp).unwrap())
    }

    #[test]
    fn arrows_end_in_the_contacts_and_cones_are_as_wide_as_friction() {
        let result = result(contacts());
        let parts = drawn(&result, &best(&result));
        for (index, contact) in result.contacts.iter().enumerate() {
            let name = format!("contact {}", index + 1);
            let node = parts.node(&name).expect("a node");
            assert_eq!(node["translation"], json!(contact.position));
            assert_eq!(node["extras"]["normal"], json!(contact.normal));
            assert_eq!(node["extras"]["contact"], index + 1);
            assert_eq!(node["children"].as_array().unwrap().len(), 2);
            let inward = Vector3::from(contact.normal);
            let along = |vertex: &[f64; 3]| Vector3::from(*vertex).dot(&inward);
            let arrow = parts.vertices(&format!("{name}/arrow"));
            let depths = arrow.iter().map(along);
            let (low, high) = depths.fold((0.0_f64, -1.0_f64), |(l, h), x| (l.min(x), h.max(x)));
            assert!((low + ARROW * 2.0).abs() < 1e-5 && high.abs() < 1e-6);
            // Outside the body, its rim as far off the axis as friction lets a force lean.
            for vertex in parts.vertices(&format!("{name}/cone")) {
                let depth = along(&vertex);
                let off = (Vector3::from(vertex) - inward * depth).norm();
                assert!(depth < 1e-6 && (off + 0.5 * depth).abs() < 1e-5);
            }
        }
        let dot = parts.node("center of mass").unwrap();
        assert_eq!(dot["translation"], json!([0.0, 0.0, 0.0]));
        assert_eq!(
            parts.node("weakest force").unwrap()["extras"]["force"][0],
            0.6
        );
        assert_eq!(
            parts.node("weakest torque").unwrap()["extras"]["scaled_torque"][2],
            0.8
        );
        let mesh = parts.vertices("mesh");
        assert_eq!(mesh.len(), ball().vertices().len());
        let extras = &parts.node("graspd").unwrap()["extras"];
        assert_eq!(extras["quality"], 0.125);
        assert_eq!(extras["torque_scale"]["value"], 0.5);
        assert_eq!([&extras["frame"], &extras["grasp"]], ["mesh", "best"]);
    }

    #[test]
    fn what_is_not_there_is_not_drawn() {
        let mut result = result(contacts());
        result.friction = None;
        result.initial = Some(InitialGrasp {
            quality: 0.0625,
            contacts: contacts(),
        });
        let weakest = result.weakest_wrench.as_mut().unwrap();
        (weakest.force, weakest.torque) = ([0.0, 0.0, 1.0], [0.0; 3]);
        let parts = drawn(&result, &best(&result));
        assert!(parts.node("contact 1/arrow").is_some());
        assert!(parts.node("contact 1/cone").is_none());
        assert!(parts.node("weakest force").is_some());
        assert!(parts.node("weakest torque").is_none());
        assert!(parts.node("graspd").unwrap().get("scale").is_none());
        let initial = Chosen::Initial.of(&result).unwrap();
        let parts = drawn(&result, &initial);
        assert!(parts.node("weakest force").is_none());
        let extras = &parts.node("graspd").unwrap()["extras"];
        assert_eq!(extras["quality"], 0.0625);
    }

    #[test]
    fn a_cone_of_hardly_any_friction_is_left_out_and_every_mesh_has_triangles() {
        let mut result = result(contacts());
        for friction in [1e-12, 1e-8, 10.0] {
            result.friction = Some(friction);
            let parts = drawn(&result, &best(&result));
            let cone = parts.node("contact 1/cone");
            assert_eq!(cone.is_some(), friction > 1e-10, "{friction}");
            for accessor in parts.scene["accessors"].as_array().unwrap() {
                assert!(accessor["count"].as_u64().unwrap() > 0, "{friction}");
            }
        }
    }

    #[test]
    fn a_known_unit_scales_the_root_and_nothing_else() {
        let mut result = result(contacts());
        let plain = drawn(&result, &best(&result));
        result.units = Some(Units::In);
        let parts = drawn(&result, &best(&result));
        let root = parts.node("graspd").unwrap();
        assert_eq!(root["scale"], json!([0.0254, 0.0254, 0.0254]));
        assert_eq!(root["extras"]["units"], "in");
        for name in ["mesh", "contact 3/arrow", "contact 3/cone"] {
            assert_eq!(parts.vertices(name), plain.vertices(name));
        }
        for node in parts.scene["nodes"].as_array().unwrap() {
            assert!(node.get("rotation").is_none() && node.get("matrix").is_none());
        }
    }

    #[test]
    fn more_contacts_than_colours_are_drawn_too() {
        let many = contacts().into_iter().cycle().take(20).collect();
        let result = result(many);
        let parts = drawn(&result, &best(&result));
        assert!(parts.node("contact 20/cone").is_some());
        let color = |number: usize| {
            let materials = parts.scene["materials"].as_array().unwrap();
            let name = format!("contact {number}");
            let found = materials.iter().find(|material| material["name"] == name);
            found.unwrap()["pbrMetallicRoughness"]["baseColorFactor"].clone()
        };
        assert_eq!(color(1), color(8));
        assert_ne!(color(1), color(2));
    }
}
