//! Regular grasps: fingers evenly around, coordinates rounded, so that wrenches lie in common flats but for rounding.

use nalgebra::{Point3, Unit, Vector3};

use super::{ACCURACY, Evaluator};
use crate::contact::{Cone, ConeEdges, Contact, ContactModel, Friction, Torsion};
use crate::wrench::{EdgeNorm, WrenchModel, WrenchSpace};

fn pyramids(edges: u32, torque_scale: f64) -> WrenchModel {
    WrenchModel {
        contact_model: ContactModel::Hard {
            friction: Friction::new(0.8).unwrap(),
            cone: Cone::Pyramid(ConeEdges::new(edges).unwrap()),
        },
        edge_norm: EdgeNorm::UnitEdge,
        space: WrenchSpace::L1,
        center: Point3::origin(),
        torque_scale,
    }
}

/// Five fingers evenly around, coordinates rounded to 11 digits.
fn five() -> Vec<Contact> {
    [
        [-0.61519234583, -0.03856601654, 0.99804079466, 0.06256654208],
        [-0.15342642833, -0.59700024379, 0.24890724908, 0.96852732607],
        [0.52036959835, -0.33040042542, -0.84420765468, 0.53601626447],
        [0.47503252683, 0.39280155099, -0.77065627324, -0.63725105611],
        [-0.22678335101, 0.57316513476, 0.36791588418, -0.92985907651],
    ]
    .map(|[x, y, nx, ny]| Contact {
        position: Point3::new(x, y, 0.0),
        normal: Unit::new_normalize(Vector3::new(nx, ny, 0.0)),
    })
    .to_vec()
}

/// The values are those of Qhull, whose every facet was verified in rational arithmetic; round cones are near.
#[test]
fn torques_greater_than_forces_do_not_hide_force_closure() {
    let mut evaluator = Evaluator::new();
    for (edges, truth) in [(6, 0.554515), (8, 0.576369)] {
        let model = pyramids(edges, 30.0);
        for margin in [
            evaluator.grasp_margin(&model, &five(), ACCURACY).unwrap(),
            evaluator.grasp_quality(&model, &five(), ACCURACY).unwrap(),
        ] {
            assert!((margin.value - truth).abs() < 1e-6, "{edges}: {margin:?}");
            assert!(margin.is_force_closure() && margin.exact, "{margin:?}");
        }
    }
}

fn contact([x, y, z]: [f64; 3], [nx, ny, nz]: [f64; 3]) -> Contact {
    Contact {
        position: Point3::new(x, y, z),
        normal: Unit::new_normalize(Vector3::new(nx, ny, nz)),
    }
}

/// The same contacts a little to the side, in a fixed pattern.
fn twins(contacts: &[Contact], by: f64, size: f64) -> Vec<Contact> {
    let numbered = contacts.iter().enumerate();
    let aside = |i: usize| Vector3::from_fn(|axis, _| by * (1.0 + (7 * i + 3 * axis) as f64).sin());
    numbered
        .map(|(i, c)| Contact {
            position: c.position + aside(i) * size,
            normal: Unit::new_normalize(c.normal.into_inner() + aside(i + 50)),
        })
        .collect()
}

/// More contacts make the hull no smaller, and contacts that nearly coincide with others hardly greater.
#[test]
fn contacts_that_nearly_coincide_hardly_change_the_volume() {
    let four = [
        contact([0.125, 0.0, 0.2], [0.0, 0.0, -1.0]),
        contact([0.25, 0.075, -0.2], [0.0, 0.0, 1.0]),
        contact([-0.125, 0.0, -0.2], [0.0, 0.0, 1.0]),
        contact([-0.25, -0.075, 0.2], [0.0, 0.0, -1.0]),
    ];
    let model = WrenchModel {
        contact_model: ContactModel::Soft {
            friction: Friction::new(0.5).unwrap(),
            torsion: Torsion::new(0.030935709544149783).unwrap(),
            cone: Cone::Pyramid(ConeEdges::new(8).unwrap()),
        },
        center: Point3::new(0.001, 0.002, -0.0015),
        ..pyramids(8, 1.6162551542140222)
    };
    let volume = |contacts: &[Contact]| {
        let mut wrenches = Vec::new();
        for contact in contacts {
            model.push_wrenches(contact, &mut wrenches);
        }
        Evaluator::new().volume(&wrenches).unwrap()
    };
    let alone = volume(&four);
    assert!((alone / 0.00759044 - 1.0).abs() < 1e-5, "{alone}");
    for by in [1e-13, 1e-12, 1e-11, 1e-10] {
        let with_twins = volume(&[&four[..], &twins(&four, by, 1.0)].concat());
        assert!(
            (with_twins / alone - 1.0).abs() < 1e-6,
            "{by}: {with_twins}"
        );
    }
}

/// A plane through wrenches that nearly coincide is uncertain by rounding over their distance, so the least offset is not
/// called exact; that the origin is outside is certain.
#[test]
fn the_margin_of_contacts_that_nearly_coincide_is_not_called_exact() {
    let model = WrenchModel {
        contact_model: ContactModel::Hard {
            friction: Friction::new(0.1).unwrap(),
            cone: Cone::Pyramid(ConeEdges::new(6).unwrap()),
        },
        ..pyramids(6, 34132.57949759229)
    };
    let three = [
        contact([0.00038889, 0.0003, 2.2222e-05], [0.0, -1.0, 0.0]),
        contact([0.0005, -0.00025, -0.00011111], [-1.0, 0.0, 0.0]),
        contact([-0.00027778, -0.0001, -0.0002], [0.0, 0.0, 1.0]),
    ];
    let mut evaluator = Evaluator::new();
    let alone = evaluator.grasp_margin(&model, &three, ACCURACY).unwrap();
    assert!(alone.exact && alone.value < 0.0, "{alone:?}");
    let both = [&three[..], &twins(&three, 1e-11, 5e-4)].concat();
    let margin = evaluator.grasp_margin(&model, &both, ACCURACY).unwrap();
    assert!(!margin.exact && !margin.is_force_closure(), "{margin:?}");
}
