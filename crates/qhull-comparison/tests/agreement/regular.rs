//! Regular grasps, moved by a little more than rounding: many wrenches lie in common flats but for 10⁻¹³ to 10⁻⁹ of their
//! length, where hull algorithms lose their way.

use std::f64::consts::TAU;

use graspd_core::contact::{Cone, ConeEdges, Contact, ContactModel, Friction, Torsion};
use graspd_core::quality::{ACCURACY, CLOSURE_TOLERANCE, Evaluator, Margin};
use graspd_core::wrench::{EdgeNorm, Wrench, WrenchModel, WrenchSpace};
use nalgebra::{Point3, Rotation3, Unit, Vector3};
use qhull_comparison::{PLAIN, Silence, points};
use testkit::grasps::Sampler;

use crate::arbiter::{exact_support, support};

/// Largest difference of two values of ε, over the scale, that rounding explains.
const TOLERANCE: f64 = 1e-11;

/// Facet limit of an interval. The spaces of regular grasps that are no finite hull can take many more than the time of a
/// test allows.
const INTERVAL_FACETS: usize = 1 << 12;

/// Least lower end of an interval that the facet limit ended, over its upper end.
const LEAST_SHARE: f64 = 0.5;

/// A regular grasp and the model to evaluate it under.
#[derive(Debug, Clone)]
pub struct Case {
    pub contacts: Vec<Contact>,
    pub model: WrenchModel,
}

/// What came of one comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    Closure,
    NoClosure,
    /// An interval that the facet limit ended before it was as narrow as it should be.
    Wide,
    /// The facets that Qhull gives are farther than a support value of the set, in rational arithmetic.
    QhullWrong,
    Flat,
}

fn share(sampler: &mut Sampler) -> f64 {
    sampler.below(1 << 40) as f64 / (1_u64 << 40) as f64
}

fn between(sampler: &mut Sampler, least: f64, most: f64) -> f64 {
    least + (most - least) * share(sampler)
}

fn power(sampler: &mut Sampler, least: f64, most: f64) -> f64 {
    10_f64.powf(between(sampler, least, most))
}

/// A point with its outward normal.
type Spot = (Vector3<f64>, Vector3<f64>);

fn ring(count: usize, height: f64, start: f64) -> impl Iterator<Item = Spot> {
    (0..count).map(move |i| {
        let (sin, cos) = (start + TAU * i as f64 / count as f64).sin_cos();
        let out = Vector3::new(cos, sin, 0.0);
        (out + Vector3::new(0.0, 0.0, height), out)
    })
}

/// Places of one of five regular kinds: a ring, two rings, a ring and the ends, corners of a cube, and a zigzag ring.
fn spots(sampler: &mut Sampler) -> Vec<Spot> {
    let count = 3 + sampler.below(4);
    let start = TAU * sampler.below(24) as f64 / 24.0;
    let height = [0.25, 0.5, 1.0][sampler.below(3)];
    match sampler.below(5) {
        0 => ring(count, 0.0, start).collect(),
        1 => ring(count, height, start)
            .chain(ring(count, -height, start + TAU / 2.0 / count as f64))
            .collect(),
        2 => {
            let ends = [1.0, -1.0].map(|z| (Vector3::new(0.0, 0.0, z), Vector3::new(0.0, 0.0, z)));
            ring(count, 0.0, start).chain(ends).collect()
        }
        3 => (0..8)
            .filter(|corner: &u32| count > 4 || corner.count_ones().is_multiple_of(2))
            .map(|corner| Vector3::from_fn(|axis, _| f64::from(corner >> axis & 1) * 2.0 - 1.0))
            .map(|corner| (corner, corner.normalize()))
            .collect(),
        _ => ring(2 * count.min(4), 0.0, start)
            .enumerate()
            .map(|(i, (p, n))| {
                let z = if i % 2 == 0 { height } else { -height };
                (p + Vector3::new(0.0, 0.0, z), n)
            })
            .collect(),
    }
}

fn contact_model(sampler: &mut Sampler, contacts: usize) -> ContactModel {
    let friction = Friction::new([0.2, 0.5, 0.8, 1.0][sampler.below(4)]).expect("in range");
    let edges = ConeEdges::new([3, 4, 5, 6, 8][sampler.below(5)]).expect("in range");
    let cone = match sampler.below(4) {
        0 => Cone::Round,
        _ => Cone::Pyramid(edges),
    };
    match sampler.below(4) {
        0 if contacts >= 7 => ContactModel::Frictionless,
        1 => ContactModel::Soft {
            friction,
            torsion: Torsion::new(between(sampler, 0.05, 0.5)).expect("in range"),
            cone,
        },
        _ => ContactModel::Hard { friction, cone },
    }
}

/// A random case.
pub fn case(sampler: &mut Sampler) -> Case {
    let spots = spots(sampler);
    let size = power(sampler, -2.0, 3.0);
    let noise = power(sampler, -13.0, -9.0);
    let turn = match sampler.below(2) {
        0 => Rotation3::identity(),
        _ => Rotation3::from_scaled_axis(Vector3::from_fn(|_, _| between(sampler, -3.0, 3.0))),
    };
    let moved = |v: Vector3<f64>, sampler: &mut Sampler| {
        turn * v + Vector3::from_fn(|_, _| between(sampler, -noise, noise))
    };
    let contacts: Vec<Contact> = spots
        .into_iter()
        .map(|(place, out)| Contact {
            position: Point3::from(moved(place, sampler) * size),
            normal: Unit::new_normalize(moved(-out, sampler)),
        })
        .collect();
    let radius = 2_f64.sqrt() * size;
    let model = WrenchModel {
        contact_model: contact_model(sampler, contacts.len()),
        edge_norm: [EdgeNorm::UnitEdge, EdgeNorm::UnitNormal][sampler.below(2)],
        space: match sampler.below(4) {
            0 => WrenchSpace::Linf,
            _ => WrenchSpace::L1,
        },
        center: Point3::origin(),
        torque_scale: power(sampler, -4.0, 4.0) / radius,
    };
    Case { contacts, model }
}

/// Compares cases, one after the other.
pub struct Judge {
    evaluator: Evaluator,
    limited: Evaluator,
    silence: Silence,
}

impl Judge {
    pub fn new() -> Self {
        Self {
            evaluator: Evaluator::new(),
            limited: Evaluator::with_facet_limit(INTERVAL_FACETS),
            silence: Silence::new(),
        }
    }

    /// Holds the margin of a case against Qhull's hull where the space is one of finitely many wrenches, and else against
    /// that of the grasp turned. `Err` says what is wrong.
    pub fn compare(&mut self, case: &Case) -> Result<Outcome, String> {
        let Case { contacts, model } = case;
        let evaluator = match model.is_finite_hull() {
            true => &mut self.evaluator,
            false => &mut self.limited,
        };
        let Ok(margin) = evaluator.grasp_margin(model, contacts, ACCURACY) else {
            return Ok(Outcome::Flat);
        };
        let quality = evaluator.grasp_quality(model, contacts, ACCURACY);
        let quality = quality.map_err(|flat| format!("{flat} but {margin:?}"))?;
        if quality.is_force_closure() != margin.is_force_closure() {
            return Err(format!("{quality:?} but {margin:?}"));
        }
        if model.is_finite_hull() {
            self.against_qhull(case, &margin, &quality)
        } else {
            self.against_itself(case, &margin)
        }
    }

    fn against_qhull(
        &mut self,
        case: &Case,
        margin: &Margin,
        quality: &Margin,
    ) -> Result<Outcome, String> {
        let mut wrenches = Vec::new();
        for contact in &case.contacts {
            case.model.push_wrenches(contact, &mut wrenches);
        }
        let slack = TOLERANCE * margin.scale;
        // A plane is reported where the wrenches reach to, in whichever direction.
        for found in [margin, quality] {
            let reach = support(&wrenches, &found.direction);
            if (reach - found.upper).abs() > slack {
                return Err(format!("the wrenches reach to {reach}: {found:?}"));
            }
        }
        if !margin.is_force_closure() {
            let proof = exact_support(&wrenches, &quality.direction);
            return match proof <= 2.0 * CLOSURE_TOLERANCE * margin.scale {
                true => Ok(Outcome::NoClosure),
                false => Err(format!("no proof, {proof}: {quality:?}")),
            };
        }
        if !margin.exact || margin.upper - margin.value > slack {
            return Err(format!("unfinished: {margin:?}"));
        }
        let mut input = points(&wrenches);
        let Ok(hull) = self.silence.hull(&mut input, PLAIN) else {
            return Ok(Outcome::QhullWrong);
        };
        // Any support value is at least ε, so the least of those along Qhull's normals refutes whatever is greater.
        let normals = hull.facets().map(|(normal, _)| Wrench::from(normal));
        let heights = normals.map(|normal| support(&wrenches, &normal));
        let theirs = heights.fold(f64::INFINITY, f64::min);
        if margin.value > theirs + slack {
            return Err(format!("a plane at {theirs}: {margin:?}"));
        }
        if margin.value < theirs - slack {
            let exact = exact_support(&wrenches, &margin.direction);
            return match exact < theirs - slack / 2.0 {
                true => Ok(Outcome::QhullWrong),
                false => Err(format!("{exact}, Qhull {theirs}: {margin:?}")),
            };
        }
        Ok(Outcome::Closure)
    }

    /// The interval of the same grasp in the opposite order, and turned where that leaves the cones the same, has to overlap.
    fn against_itself(&mut self, case: &Case, margin: &Margin) -> Result<Outcome, String> {
        let turn = match case.model.contact_model.is_round() {
            true => Rotation3::from_scaled_axis(Vector3::new(0.3, -0.7, 0.4)),
            false => Rotation3::identity(),
        };
        let turned: Vec<Contact> = case
            .contacts
            .iter()
            .rev()
            .map(|contact| Contact {
                position: turn * contact.position,
                normal: turn * contact.normal,
            })
            .collect();
        let other = self
            .limited
            .grasp_margin(&case.model, &turned, ACCURACY)
            .map_err(|flat| format!("{flat} when turned: {margin:?}"))?;
        let slack = TOLERANCE * margin.scale;
        let apart = margin.value > other.upper + slack || other.value > margin.upper + slack;
        // What no contact hinders is found by different planes.
        let outside = !margin.is_force_closure() && !other.is_force_closure();
        if apart && !outside {
            return Err(format!("{margin:?}, turned {other:?}"));
        }
        if outside {
            return Ok(Outcome::NoClosure);
        }
        let width = ACCURACY * margin.upper + slack;
        let wide = margin.upper - margin.value > width;
        if wide && (margin.exact || margin.value < LEAST_SHARE * margin.upper) {
            return Err(format!("wide: {margin:?}"));
        }
        Ok(if wide {
            Outcome::Wide
        } else {
            Outcome::Closure
        })
    }
}
