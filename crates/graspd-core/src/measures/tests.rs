//! Closed forms, invariances and a sampled oracle.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Matrix6, Matrix6xX, Point3, Unit, Vector3};
use proptest::prelude::*;

use super::*;
use crate::contact::{Cone, ContactModel, Friction, Torsion};
use crate::wrench::{EdgeNorm, Wrench, WrenchSpace};

fn hard() -> ContactModel {
    ContactModel::Hard {
        friction: Friction::new(0.5).unwrap(),
        cone: Cone::Round,
    }
}

fn soft() -> ContactModel {
    ContactModel::Soft {
        friction: Friction::new(0.5).unwrap(),
        torsion: Torsion::new(0.1).unwrap(),
        cone: Cone::Round,
    }
}

fn model(contact_model: ContactModel) -> WrenchModel {
    WrenchModel {
        contact_model,
        edge_norm: EdgeNorm::UnitEdge,
        space: WrenchSpace::L1,
        center: Point3::origin(),
        torque_scale: 1.0,
    }
}

/// A contact at a point, facing the origin.
fn facing(x: f64, y: f64, z: f64) -> Contact {
    let position = Point3::new(x, y, z);
    Contact {
        position,
        normal: Unit::new_normalize(-position.coords),
    }
}

fn tetrahedron() -> Vec<Contact> {
    let r = 3_f64.sqrt().recip();
    [[1., 1., 1.], [1., -1., -1.], [-1., 1., -1.], [-1., -1., 1.]]
        .map(|[x, y, z]| facing(x * r, y * r, z * r))
        .to_vec()
}

fn octahedron() -> Vec<Contact> {
    (0..6)
        .map(|i| Vector3::ith(i / 2, if i % 2 == 0 { 1.0 } else { -1.0 }))
        .map(|v: Vector3<f64>| facing(v.x, v.y, v.z))
        .collect()
}

/// A polygon in the plane x + y + z = 3 from its corners in the x-y plane.
fn flat(corners: &[[f64; 2]]) -> Vec<Contact> {
    let normal = Unit::new_normalize(Vector3::new(1.0, 1.0, 1.0));
    let u = Vector3::new(1.0, -1.0, 0.0).normalize();
    let v = normal.cross(&u);
    corners
        .iter()
        .map(|[x, y]| Contact {
            position: Point3::new(1.0, 1.0, 1.0) + u * *x + v * *y,
            normal,
        })
        .collect()
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * b.abs().max(1.0)
}

/// G·Gᵀ of contacts on the unit sphere that are spread evenly is m for forces and Σ(1 − ppᵀ) = 2m/3
/// for torques, the arm along the normal having no torque; the torsion of soft fingers adds
/// Σ ppᵀ = m/3.
#[test]
fn even_contacts_on_a_sphere_have_the_singular_values_of_the_formula() {
    for contacts in [tetrahedron(), octahedron()] {
        let m = contacts.len() as f64;
        let hard = Measures::geometric(&model(hard()), &contacts);
        assert!(close(hard.smallest_singular_value, (m * 2.0 / 3.0).sqrt()));
        assert!(close(hard.isotropy, (2.0_f64 / 3.0).sqrt()));
        let volume = m.powf(1.5) * (m * 2.0 / 3.0).powf(1.5);
        assert!(close(hard.ellipsoid_volume, volume));
        let soft = Measures::geometric(&model(soft()), &contacts);
        assert!(close(soft.smallest_singular_value, m.sqrt()));
        assert!(close(soft.isotropy, 1.0));
        assert!(close(soft.ellipsoid_volume, m.powi(3)));
        // Without friction no torque at all.
        let bare = Measures::geometric(&model(ContactModel::Frictionless), &contacts);
        assert!(bare.smallest_singular_value < 1e-15);
        assert!(bare.isotropy < 1e-15 && bare.ellipsoid_volume < 1e-15);
        assert!(close(hard.centroid_distance, 0.0));
        // No plane fits them better than another.
        assert_eq!((hard.polygon_area, hard.polygon_shape), (None, None));
    }
}

#[test]
fn regular_polygons_are_of_shape_zero_and_of_known_area() {
    for m in 3..12 {
        let corners: Vec<[f64; 2]> = (0..m)
            .map(|i| 2.0 * PI * f64::from(i) / f64::from(m))
            .map(|angle| [2.0 * angle.cos(), 2.0 * angle.sin()])
            .collect();
        let polygon = Polygon::new(&flat(&corners)).unwrap();
        let area = 2.0 * f64::from(m) * (2.0 * PI / f64::from(m)).sin();
        assert!(close(polygon.area, area));
        assert!(polygon.shape < 1e-12);
    }
}

#[test]
fn other_polygons_have_the_shape_that_their_angles_say() {
    // Angles 90, 45, 45 against 60; worst 1·120 + 2·60.
    let right = Polygon::new(&flat(&[[0., 0.], [1., 0.], [0., 1.]])).unwrap();
    assert!(close(right.area, 0.5));
    assert!(close(right.shape, 60.0 / 240.0));
    // A square with a contact in its middle, on a side, or twice at a corner: 4 × 90 and 180 against
    // 108; worst 3·72 + 2·108.
    let square = [[0., 0.], [1., 0.], [1., 1.], [0., 1.]];
    for fifth in [[0.4, 0.5], [0.5, 0.0], [1.0, 1.0]] {
        let five: Vec<[f64; 2]> = square.iter().copied().chain([fifth]).collect();
        let polygon = Polygon::new(&flat(&five)).unwrap();
        assert!(close(polygon.area, 1.0));
        assert!(close(polygon.shape, (4.0 * 18.0 + 72.0) / 432.0));
    }
    let thin = Polygon::new(&flat(&[[0., 0.], [1., 0.], [2., 1e-3], [3., 0.]])).unwrap();
    assert!(thin.shape > 0.99 && thin.shape <= 1.0);
}

#[test]
fn points_and_lines_are_no_polygons() {
    assert_eq!(Polygon::new(&[]), None);
    assert_eq!(Polygon::new(&flat(&[[0., 0.], [1., 2.]])), None);
    assert_eq!(Polygon::new(&flat(&[[0., 0.], [1., 2.], [2., 4.]])), None);
    assert_eq!(Polygon::new(&flat(&[[0.5, 0.5]; 4])), None);
}

#[test]
fn no_contacts_and_few_contacts_measure_zero() {
    for (contacts, contact_model) in [
        (vec![], hard()),
        (tetrahedron()[..1].to_vec(), hard()),
        (tetrahedron(), ContactModel::Frictionless),
    ] {
        let measures = Measures::geometric(&model(contact_model), &contacts);
        assert_eq!(measures.smallest_singular_value, 0.0);
        assert_eq!(measures.isotropy, 0.0);
        assert_eq!(measures.ellipsoid_volume, 0.0);
    }
    // Two hard contacts exert no torque about the line between them.
    let two = Measures::geometric(&model(hard()), &octahedron()[..2]);
    assert!(two.smallest_singular_value < 1e-15);
}

fn contacts(m: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Contact>> {
    let number = || -1.0..1.0_f64;
    let vector = move || proptest::array::uniform3(number()).prop_map(Vector3::from);
    let contact = (
        vector(),
        vector().prop_filter("a direction", |v| v.norm() > 0.1),
    );
    proptest::collection::vec(
        contact.prop_map(|(p, n)| Contact {
            position: Point3::from(p),
            normal: Unit::new_normalize(n),
        }),
        m,
    )
}

fn models() -> impl Strategy<Value = ContactModel> {
    prop_oneof![Just(ContactModel::Frictionless), Just(hard()), Just(soft())]
}

/// All measures as numbers, lengths to the power that they have.
fn numbers(measures: &Measures, factor: f64) -> Vec<f64> {
    let missing = f64::MAX;
    vec![
        measures.smallest_singular_value,
        measures.isotropy,
        measures.ellipsoid_volume,
        measures.centroid_distance / factor,
        measures
            .polygon_area
            .map_or(missing, |area| area / factor.powi(2)),
        measures.polygon_shape.unwrap_or(missing),
    ]
}

/// Columns of the matrix, made the long way: from cross products with any frame.
fn columns(model: &WrenchModel, contacts: &[Contact]) -> Vec<Wrench> {
    let mut columns = Vec::new();
    for contact in contacts {
        let n = contact.normal.into_inner();
        let t = n.cross(&Vector3::new(0.3, 0.5, 0.7)).normalize();
        let frame = match model.contact_model {
            ContactModel::Frictionless => vec![n],
            _ => vec![n, t, n.cross(&t)],
        };
        for axis in frame {
            let torque = (contact.position - model.center).cross(&axis) * model.torque_scale;
            columns.push(Wrench::new(
                axis.x, axis.y, axis.z, torque.x, torque.y, torque.z,
            ));
        }
        if matches!(model.contact_model, ContactModel::Soft { .. }) {
            columns.push(Wrench::new(0.0, 0.0, 0.0, n.x, n.y, n.z));
        }
    }
    columns
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn singular_values_agree_with_determinant_and_samples(
        contacts in contacts(2..9), contact_model in models(),
        samples in proptest::collection::vec(proptest::array::uniform6(-1.0..1.0_f64), 40)
    ) {
        let model = model(contact_model);
        let measures = Measures::geometric(&model, &contacts);
        let matrix = Matrix6xX::from_columns(&columns(&model, &contacts));
        let square: Matrix6<f64> = &matrix * matrix.transpose();
        let volume = measures.ellipsoid_volume;
        prop_assert!((volume * volume - square.determinant()).abs() < 1e-9 * square.norm().powi(6));
        // σ_min is the least and σ_max the greatest stretch of Gᵀ over unit wrenches.
        let greatest = square.symmetric_eigenvalues().max().sqrt();
        let least = measures.smallest_singular_value;
        prop_assert!((measures.isotropy * greatest - least).abs() < 1e-12 * greatest);
        for sample in samples {
            let unit = Wrench::from(sample).normalize();
            let stretch = (matrix.transpose() * unit).norm();
            prop_assert!(stretch >= least - 1e-12 && stretch <= greatest + 1e-12);
        }
        let eigen = square.symmetric_eigen();
        let weakest = eigen.eigenvectors.column(eigen.eigenvalues.imin());
        prop_assert!(((matrix.transpose() * weakest).norm() - least).abs() < 1e-6);
    }

    #[test]
    fn frame_order_and_size_play_no_part(
        contacts in contacts(3..9), contact_model in models(),
        shift in proptest::array::uniform3(-5.0..5.0_f64), turn in proptest::array::uniform3(-2.0..2.0_f64),
        exponent in -3.0..3.0_f64, start in 0_usize..9
    ) {
        let mut here = model(contact_model);
        here.center = Point3::new(0.1, -0.2, 0.3);
        let motion = Isometry3::new(shift.into(), turn.into());
        let factor = 10_f64.powf(exponent);
        let place = |p: &Point3<f64>| motion * (p * factor);
        let mut moved: Vec<Contact> = contacts
            .iter()
            .map(|c| Contact { position: place(&c.position), normal: motion * c.normal })
            .collect();
        let length = moved.len();
        moved.rotate_left(start % length);
        let there = WrenchModel {
            center: place(&here.center),
            torque_scale: here.torque_scale / factor,
            ..here
        };
        let a = numbers(&Measures::geometric(&here, &contacts), 1.0);
        let b = numbers(&Measures::geometric(&there, &moved), factor);
        for (a, b) in a.iter().zip(&b) {
            // Moving far for a small body costs digits.
            let allowed = 1e-9 + 1e-13 * 10.0 / factor;
            prop_assert!((a - b).abs() <= allowed * a.abs().max(1.0), "{a} {b}");
        }
    }

    #[test]
    fn a_polygon_holds_its_triangles(points in proptest::collection::vec(proptest::array::uniform2(-1.0..1.0_f64), 3..9)) {
        if let Some(polygon) = Polygon::new(&flat(&points)) {
            for a in &points { for b in &points { for c in &points {
                let area = ((b[0]-a[0])*(c[1]-a[1]) - (c[0]-a[0])*(b[1]-a[1])) / 2.0;
                prop_assert!(area <= polygon.area + 1e-9);
            }}}
            prop_assert!(polygon.area <= 4.0 && (0.0..=1.0).contains(&polygon.shape));
        }
    }
}
