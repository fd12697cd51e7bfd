//! Forces, and what keeps a grasp from force closure.

use super::*;

#[tokio::test(flavor = "multi_thread")]
async fn forces_balance_what_they_resist() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let wrench = json!({"force": [1, -2, 3], "torque": [0.3, 0.2, -0.1]});
    let body = json!({
        "mesh_id": mesh, "external_wrench": wrench,
        "grasps": [four(), [{"point": [0, 0, 2]}]]
    });
    let found = evaluations(&server, &body).await;
    let center = vector(&found["center_of_mass"]);
    let total = |grasp: &Value, forces: Vec<[f64; 3]>| {
        let (mut force, mut torque, mut pushed) = ([0.0; 3], [0.0; 3], 0.0);
        for (contact, f) in grasp["contacts"].as_array().unwrap().iter().zip(forces) {
            let (at, normal) = (vector(&contact["position"]), vector(&contact["normal"]));
            let arm: Vec<f64> = at.iter().zip(center).map(|(p, c)| p - c).collect();
            for k in 0..3 {
                force[k] += f[k];
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                torque[k] += arm[i] * f[j] - arm[j] * f[i];
                pushed += f[k] * normal[k];
            }
        }
        (force, torque, pushed)
    };
    let grasp = &found["evaluations"][0];
    let forces = serde_json::from_value(grasp["resisted"][0]["forces"].clone()).unwrap();
    let (force, torque, pushed) = total(grasp, forces);
    assert!(distance(force, [-1.0, 2.0, -3.0]) < 1e-6, "{force:?}");
    assert!(distance(torque, [-0.3, -0.2, 0.1]) < 1e-6, "{torque:?}");
    assert!((pushed - number(&grasp["resisted"][0]["effort"])).abs() < 1e-6);

    let shown = grasp["contacts"].as_array().unwrap();
    let forces = shown
        .iter()
        .map(|contact| vector(&contact["forces"]))
        .collect();
    let (force, torque, pushed) = total(grasp, forces);
    let scale = number(&found["torque_scale"]["value"]);
    let weakest = &grasp["weakest_wrench"];
    assert!(distance(force, vector(&weakest["force"])) < 1e-6);
    assert!(distance(torque.map(|t| t * scale), vector(&weakest["torque"])) < 1e-6);
    // Edges of unit length that sum to one exert ε in that direction.
    let least = (1.25f64.sqrt() * number(&grasp["quality"])).recip();
    assert!((pushed / least - 1.0).abs() < 1e-6, "{pushed} {least}");

    let alone = &found["evaluations"][1]["resisted"][0];
    assert_eq!(
        alone,
        &json!({"resisted": false, "effort": null, "forces": null})
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn the_obstacle_to_force_closure_is_reported() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let pinch = json!([
        {"point": [0.1, 0.2, 1.5], "normal": [0, 0, -2]},
        {"point": [0.1, 0.2, -1.5], "normal": [0, 0, 1]}
    ]);
    let corner =
        json!([{"point": [0.6, 0.1, 0.2]}, {"point": [0.1, 1.2, -0.3]}, {"point": [0.2, 0.3, 2]}]);
    let body = |settings: Value, grasps: &[&Value]| {
        let mut body = settings;
        body["mesh_id"] = mesh.as_str().into();
        body["grasps"] = json!(grasps);
        body
    };
    let found = evaluations(&server, &body(json!({}), &[&pinch, &corner])).await;
    let [pinched, pressed] = &found["evaluations"].as_array().unwrap()[..] else {
        panic!("{found}");
    };
    for grasp in [pinched, pressed] {
        assert_eq!(grasp["force_closure"], false);
        assert_eq!([&grasp["quality"], &grasp["bounds"]], [&Value::Null; 2]);
        let words = grasp["explanation"]["detail"].as_str().unwrap();
        assert!(words.contains("Nothing hinders a "), "{words}");
        assert!(grasp["contacts"][0].get("forces").is_none());
    }
    let motion = &pinched["explanation"]["motion"];
    assert_eq!(pinched["explanation"]["reason"], "rank_deficient");
    assert_eq!(pinched["explanation"]["rank"], 5);
    assert_eq!(motion["kind"], "rotation");
    assert!((vector(&motion["axis"])[2].abs() - 1.0).abs() < 1e-9);
    let [x, y, _] = vector(&motion["point"]);
    assert!(distance([x, y, 0.0], [0.1, 0.2, 0.0]) < 1e-6, "{motion}");

    assert_eq!(pressed["explanation"]["reason"], "origin_outside");
    let outside = number(&pressed["explanation"]["distance"]);
    assert!(outside > 0.1);
    // The margin is the offset of one plane; the nearest wrench may be farther.
    let offset = -number(&pressed["margin"]);
    assert!(0.1 < offset && offset <= outside, "{offset} {outside}");

    let soft = body(json!({"contact_model": "soft"}), &[&pinch]);
    let soft = evaluations(&server, &soft).await;
    assert_eq!(soft["evaluations"][0]["force_closure"], true);
    assert!(soft["evaluations"][0]["contacts"][0]["torsion"].is_number());
}
