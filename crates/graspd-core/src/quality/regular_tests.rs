//! Regular grasps: fingers evenly around, coordinates rounded, so that wrenches lie in common flats but for rounding.

use nalgebra::{Point3, Unit, Vector3};

use super::{ACCURACY, Evaluator};
use crate::contact::{Cone, ConeEdges, Contact, ContactModel, Friction};
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
