//! Distances, ranks and what is said of their accuracy, on grasps whose numbers are known.

use std::f64::consts::TAU;

use nalgebra::{Point3, Unit, Vector3};

use super::*;
use crate::contact::{ConeEdges, ContactModel, Friction};
use crate::wrench::EdgeNorm;

fn contact(position: [f64; 3], normal: [f64; 3]) -> Contact {
    Contact {
        position: position.into(),
        normal: Unit::new_normalize(normal.into()),
    }
}

fn model(friction: f64, edges: u32, torque_scale: f64) -> WrenchModel {
    WrenchModel {
        contact_model: ContactModel::Hard {
            friction: Friction::new(friction).unwrap(),
            cone: ConeEdges::new(edges).map_or(Cone::Round, Cone::Pyramid),
        },
        edge_norm: EdgeNorm::UnitEdge,
        space: WrenchSpace::L1,
        center: Point3::origin(),
        torque_scale,
    }
}

/// Fingers evenly around the z axis, pressing towards it.
fn ring(count: usize, radius: f64, height: f64) -> Vec<Contact> {
    (0..count)
        .map(|i| (TAU * i as f64 / count as f64).sin_cos())
        .map(|(sin, cos)| contact([radius * cos, radius * sin, height], [-cos, -sin, 0.0]))
        .collect()
}

fn outside(found: &Evaluation) -> (f64, bool) {
    match found.obstacle {
        Some(Obstacle::Outside {
            distance,
            on_border,
            ..
        }) => (distance, on_border),
        other => panic!("{other:?}"),
    }
}

/// Distances by quadratic programming, whatever the facets are; those of finer pyramids come down to that of the cone.
#[test]
fn the_distance_is_that_of_the_nearest_wrench_and_no_offset_of_a_plane() {
    let three = [
        contact([0.162, 0.283, 0.011], [-1.0205, -0.8859, -0.017]),
        contact([0.117, 0.1766, 0.0411], [-1.9963, -6.0608, -2.0566]),
        contact([-0.1517, -0.6121, 0.3035], [0.2411, 0.886, -0.3541]),
    ];
    for (edges, expected) in [(8, 0.2270), (32, 0.2244), (0, 0.2242)] {
        let found = evaluate(&model(0.1, edges, 1.6222142), &three, 1e-6, &[]);
        let (distance, on_border) = outside(&found);
        assert!((distance - expected).abs() < 1e-4, "{edges}: {distance}");
        assert!(!on_border && distance >= -found.margin.unwrap().value - 1e-6);
    }
}

#[test]
fn two_hard_fingers_are_deficient_in_every_space_and_with_every_cone() {
    let two = [
        contact([1.0, 0.4, 0.25], [-1.0, 0.0, 0.0]),
        contact([0.0, 0.4, 0.25], [1.0, 0.0, 0.0]),
    ];
    for space in [WrenchSpace::L1, WrenchSpace::Linf] {
        for edges in [0, 8] {
            let model = WrenchModel {
                space,
                ..model(0.5, edges, 1.0)
            };
            let found = evaluate(&model, &two, 1e-6, &[]);
            let rank = match found.obstacle {
                Some(Obstacle::RankDeficient { rank, .. }) => rank,
                other => panic!("{space:?} {edges}: {other:?}"),
            };
            assert_eq!((rank, found.margin.is_err()), (5, true));
        }
    }
}

/// Torques scaled down to nothing do not bring the origin to the border.
#[test]
fn a_small_torque_scale_puts_nothing_on_the_border() {
    let apart = [
        contact([1.0, 0.59, 0.25], [-1.0, 0.0, 0.1]),
        contact([0.0, 0.01, 0.25], [1.0, 0.0, 0.1]),
        contact([0.5, 0.3, 0.0], [0.0, 0.0, 1.0]),
    ];
    for torque_scale in [1.0, 1e-2, 1e-5] {
        let floor = 1e-6 * torque_scale;
        let found = evaluate(&model(0.02, 8, torque_scale), &apart, floor, &[]);
        let (distance, on_border) = outside(&found);
        assert!(
            distance > 10.0 * floor && !on_border,
            "{torque_scale}: {distance}"
        );
    }
}

#[test]
fn an_interval_is_called_exact_only_when_it_is_narrow() {
    let contacts = [
        contact([1.0, 0.4, 0.25], [-1.0, 0.0, 0.0]),
        contact([1.0, 0.2, 0.25], [-1.0, 0.0, 0.0]),
        contact([0.0, 0.2, 0.25], [1.0, 0.0, 0.0]),
        contact([0.0, 0.4, 0.45], [1.0, 0.0, 0.0]),
    ];
    let (mut exact, mut wide) = (0, 0);
    for torque_scale in [1.0, 1e-2, 1e-4, 2e-6] {
        for space in [WrenchSpace::L1, WrenchSpace::Linf] {
            let model = WrenchModel {
                space,
                center: Point3::new(0.5, 0.3, 0.2),
                ..model(0.05, 0, torque_scale)
            };
            let found = evaluate(&model, &contacts, 1e-9 * torque_scale, &[]);
            let margin = found.margin.unwrap();
            if !found.force_closure {
                continue;
            }
            let narrow = margin.upper - margin.value <= 1.000001 * ACCURACY * margin.upper;
            assert_eq!(margin.exact, narrow, "{margin:?}");
            assert_eq!(found.bounds_exact, Some(margin.exact));
            exact += usize::from(narrow);
            wide += usize::from(!narrow);
        }
    }
    assert!(exact >= 2 && wide >= 1, "{exact} {wide}");
}

/// The hull of eight pyramids in L∞ takes more facets than the limit allows; its ε is 1.6964178537.
#[test]
fn a_lower_bound_is_said_to_be_one() {
    let (model, contacts) = (model(0.5, 4, 1.6222142), ring(8, 0.5, 0.1));
    let measures = evaluate(&model, &contacts, 1e-6, &[]).measures;
    let linf = measures.epsilon_linf.unwrap();
    assert!(linf <= 1.6964178538 && linf > 1.6, "{linf}");
    assert_eq!(measures.epsilon_exact, Some(linf > 1.69641));
    // Wherever the facets run out, the flag says so.
    let few = &mut Evaluator::with_facet_limit(1 << 10);
    let found = evaluate_with(few, &model, &contacts, 1e-6, &[], Interrupt::never());
    assert_eq!(found.unwrap().measures.epsilon_exact, Some(false));
}

#[test]
fn a_grasp_that_is_force_closure_resists_everything() {
    let mut contacts = ring(3, 1.0, 0.3);
    contacts.extend(ring(3, 1.0, -0.4).into_iter().map(|c| {
        let (p, n) = (c.position, c.normal);
        contact([p.y, p.x, p.z], [n.y, n.x, 0.05])
    }));
    let wave = |seed: f64| Vector3::new((seed * 1.7).sin(), (seed * 2.9).cos(), (seed * 4.3).sin());
    let external: Vec<ExternalWrench> = (0..100)
        .map(|i| ExternalWrench {
            force: wave(f64::from(i)),
            torque: wave(f64::from(i) + 0.5) * f64::from(i % 3) * 0.5,
        })
        .collect();
    for (edges, space, torque_scale) in [
        (0, WrenchSpace::L1, 1e-4),
        (0, WrenchSpace::L1, 1e2),
        (0, WrenchSpace::Linf, 1e2),
        (8, WrenchSpace::Linf, 1e4),
        (0, WrenchSpace::L1, 1e4),
    ] {
        let model = WrenchModel {
            space,
            ..model(0.4, edges, torque_scale)
        };
        let found = evaluate(&model, &contacts, 1e-9, &external);
        assert!(found.force_closure, "{:?}", found.margin);
        assert!(found.resisted.iter().all(Option::is_some));
    }
}
