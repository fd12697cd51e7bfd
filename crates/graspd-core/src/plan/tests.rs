//! Whole runs under random constraints, checked by plain arithmetic on coordinates.

use rand::Rng;
use rand_pcg::Pcg64;

use nalgebra::{Point3, Unit, Vector3};
use rayon::prelude::*;

use super::*;
use crate::analysis::AnalysisSettings;
use crate::constraints::{Approach, Constraints, Region, Spacing};
use crate::contact::{Cone, ConeEdges, Contact, ContactModel, Friction, Torsion};
use crate::mesh::{Candidate, RawMesh, solids};
use crate::search::{Impossible, InitialMode, SearchSettings};
use crate::wrench::{EdgeNorm, TorqueScale, WrenchSpace};

mod ends;

/// Slack of the checks, which round differently.
const SLACK: f64 = 1e-9;

/// Requests of [`no_constraint_is_ever_violated`].
const REQUESTS: u64 = 12_000;

type Vector = [f64; 3];

/// A place with its normal and triangle, in plain numbers.
#[derive(Clone, Copy)]
struct Spot {
    position: Vector,
    normal: Vector,
    triangle: Option<u32>,
}

impl From<&Candidate> for Spot {
    fn from(candidate: &Candidate) -> Self {
        Self {
            position: candidate.position.coords.into(),
            normal: candidate.normal.into_inner().into(),
            triangle: Some(candidate.triangle),
        }
    }
}

enum Shape {
    Box(Vector, Vector),
    HalfSpace(Vector, Vector),
    Sphere(Vector, f64),
    Triangles(Vec<u32>),
}

/// A request as a client thinks of it.
struct Wanted {
    include: Vec<Shape>,
    exclude: Vec<Shape>,
    directions: Vec<Vector>,
    max_degrees: f64,
    min: Option<f64>,
    max: Option<f64>,
    fixed: Vec<Spot>,
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

impl Shape {
    fn holds(&self, spot: &Spot, slack: f64) -> bool {
        let p = spot.position;
        match self {
            Self::Box(low, high) => {
                (0..3).all(|axis| p[axis] > low[axis] - slack && p[axis] < high[axis] + slack)
            }
            Self::HalfSpace(q, n) => dot(p, *n) - dot(*q, *n) > -slack * length(*n),
            Self::Sphere(center, radius) => length(minus(p, *center)) < radius + slack,
            Self::Triangles(indices) => spot.triangle.is_some_and(|t| indices.contains(&t)),
        }
    }

    fn region(&self) -> Region {
        match self {
            Self::Box(min, max) => Region::Box {
                min: Point3::from(*min),
                max: Point3::from(*max),
            },
            Self::HalfSpace(point, normal) => Region::HalfSpace {
                point: Point3::from(*point),
                normal: Unit::new_normalize(Vector3::from(*normal)),
            },
            Self::Sphere(center, radius) => Region::Sphere {
                center: Point3::from(*center),
                radius: *radius,
            },
            Self::Triangles(indices) => Region::Triangles(indices.iter().copied().collect()),
        }
    }
}

impl Wanted {
    fn constraints(&self) -> Constraints {
        let unit = |v: &Vector| Unit::new_normalize(Vector3::from(*v));
        Constraints {
            include: self.include.iter().map(Shape::region).collect(),
            exclude: self.exclude.iter().map(Shape::region).collect(),
            approach: (!self.directions.is_empty()).then(|| Approach {
                directions: self.directions.iter().map(unit).collect(),
                max_angle: self.max_degrees.to_radians(),
            }),
            spacing: Spacing {
                min: self.min,
                max: self.max,
            },
            fixed: self
                .fixed
                .iter()
                .map(|spot| Contact {
                    position: Point3::from(spot.position),
                    normal: unit(&spot.normal),
                })
                .collect(),
        }
    }

    fn comes_well(&self, spot: &Spot, slack: f64) -> bool {
        self.directions.is_empty()
            || self.directions.iter().any(|d| {
                let cosine = dot(*d, spot.normal) / length(*d);
                cosine > self.max_degrees.to_radians().cos() - slack
            })
    }

    fn too_near(&self, a: &Spot, b: &Spot, slack: f64) -> bool {
        let distance = length(minus(a.position, b.position));
        self.min.is_some_and(|min| distance < min - slack)
    }

    fn too_far(&self, a: &Spot, b: &Spot, slack: f64) -> bool {
        let distance = length(minus(a.position, b.position));
        self.max.is_some_and(|max| distance > max + slack)
    }

    /// What is wrong with a grasp.
    fn violation(&self, grasp: &[Candidate]) -> Option<String> {
        let spots: Vec<Spot> = grasp.iter().map(Spot::from).collect();
        for (i, spot) in spots.iter().enumerate() {
            let holds = |shape: &Shape| shape.holds(spot, SLACK);
            if !self.include.is_empty() && !self.include.iter().any(holds) {
                return Some(format!("contact {i} is in no included region"));
            }
            if self.exclude.iter().any(|shape| shape.holds(spot, -SLACK)) {
                return Some(format!("contact {i} is excluded"));
            }
            if !self.comes_well(spot, SLACK) {
                return Some(format!("contact {i} cannot be approached"));
            }
            for other in spots[..i].iter().chain(&self.fixed) {
                if spot.position == other.position {
                    return Some(format!("contact {i} stands on another"));
                }
                if self.too_near(spot, other, SLACK) || self.too_far(spot, other, SLACK) {
                    return Some(format!("contact {i} keeps no distance"));
                }
            }
        }
        None
    }

    /// The rule that forbids a place first, by its name.
    fn forbids(&self, spot: &Spot) -> Option<String> {
        let holds = |shape: &Shape| shape.holds(spot, 0.0);
        if !self.include.is_empty() && !self.include.iter().any(holds) {
            return Some("include".to_owned());
        }
        if let Some(index) = self.exclude.iter().position(holds) {
            return Some(format!("exclude[{index}]"));
        }
        if !self.comes_well(spot, 0.0) {
            return Some("max_normal_angle".to_owned());
        }
        let by_any = |fails: &dyn Fn(&Spot) -> bool| self.fixed.iter().any(fails);
        let failed = [
            ("fixed_contacts", by_any(&|f| f.position == spot.position)),
            (
                "min_contact_distance",
                by_any(&|f| self.too_near(f, spot, 0.0)),
            ),
            (
                "max_contact_distance",
                by_any(&|f| self.too_far(f, spot, 0.0)),
            ),
        ];
        let first = failed.iter().find(|(_, failed)| *failed);
        first.map(|(name, _)| (*name).to_owned())
    }
}

/// Random numbers of the test itself.
struct Dice(Pcg64);

impl Dice {
    fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }

    fn vector(&mut self, reach: f64) -> Vector {
        [(); 3].map(|()| self.between(-reach, reach))
    }

    fn shapes(&mut self, most: usize, size: f64, spots: &[Spot]) -> Vec<Shape> {
        let count = self.below(most + 1);
        (0..count).map(|_| self.shape(size, spots)).collect()
    }

    fn shape(&mut self, size: f64, spots: &[Spot]) -> Shape {
        let center = spots[self.below(spots.len())].position;
        match self.below(4) {
            0 => {
                let half = [(); 3].map(|()| self.between(0.2, 1.2) * size);
                let high = [0, 1, 2].map(|axis| center[axis] + half[axis]);
                Shape::Box(minus(center, half), high)
            }
            1 => Shape::HalfSpace(self.vector(0.5 * size), self.vector(3.0)),
            2 => Shape::Sphere(center, self.between(0.3, 1.3) * size),
            _ => {
                let count = 1 + self.below(spots.len());
                let some = (0..count).map(|_| spots[self.below(spots.len())].triangle);
                Shape::Triangles(some.flatten().collect())
            }
        }
    }

    fn wanted(&mut self, size: f64, spots: &[Spot], contacts: usize) -> Wanted {
        let directed = self.unit() < 0.3;
        let count = if directed { 1 + self.below(3) } else { 0 };
        let min = (self.unit() < 0.5).then(|| self.between(0.0, 0.9) * size);
        let max = (self.unit() < 0.5).then(|| min.unwrap_or(0.0) + self.between(0.3, 2.0) * size);
        let given = self.below(contacts.min(3));
        let fixed = (0..given).map(|_| {
            let spot = spots[self.below(spots.len())];
            if self.unit() < 0.5 {
                return spot;
            }
            Spot {
                position: minus(spot.position, self.vector(0.1 * size)),
                triangle: None,
                ..spot
            }
        });
        let fixed = fixed.collect();
        Wanted {
            include: self.shapes(2, size, spots),
            exclude: self.shapes(2, 0.5 * size, spots),
            directions: (0..count).map(|_| self.vector(2.0)).collect(),
            max_degrees: self.between(20.0, 150.0),
            min,
            max,
            fixed,
        }
    }
}

fn bodies() -> Vec<Mesh> {
    let prepare = |raw: RawMesh| Mesh::prepare(raw).unwrap();
    vec![
        prepare(solids::cuboid([-1.0, -0.6, -0.4], [1.0, 0.6, 0.4])),
        prepare(solids::sphere(1.0, 8, 12)),
        prepare(solids::torus(1.0, 0.4, 14, 8)),
        prepare(solids::l_shape()),
    ]
}

fn settings(contacts: usize, constraints: Constraints, seed: u64) -> Settings {
    let contact = ContactModel::Hard {
        friction: Friction::new(0.6).unwrap(),
        cone: Cone::Pyramid(ConeEdges::new(5).unwrap()),
    };
    Settings {
        contacts,
        wrench: WrenchSettings {
            contact: ContactSettings::Known(contact),
            edge_norm: EdgeNorm::UnitEdge,
            space: WrenchSpace::L1,
            torque_scale: TorqueScale::MaxRadius,
            center_of_mass: None,
        },
        constraints,
        candidates: CandidateSource::Triangles,
        method: [
            Method::Memetic,
            Method::ModifiedGa,
            Method::Local,
            Method::Random,
        ][seed as usize % 4],
        polish: seed % 8 < 4,
        top: 1 + seed as usize % 3,
        analysis: AnalysisSettings::default(),
        initial: InitialMode::Weak,
        search: SearchSettings {
            population: 6,
            generations: 3,
            crossover_probability: 0.9,
            mutation_probability: 0.5,
            elitism: 1,
            target_quality: None,
        },
        evaluation_limit: Some(60),
        seed,
    }
}

fn planned(mesh: &Mesh, settings: &Settings) -> Plan {
    plan(mesh, settings, Interrupt::never(), &mut |_| {}).unwrap()
}

#[test]
fn no_constraint_is_ever_violated() {
    let bodies = bodies();
    let outcomes: Vec<[usize; 5]> = (0..REQUESTS)
        .into_par_iter()
        .map(|request| {
            let mut dice = Dice(Pcg64::new(u128::from(request), 1));
            let mesh = &bodies[dice.below(bodies.len())];
            let spots: Vec<Spot> = mesh.candidates().iter().map(Spot::from).collect();
            let contacts = 3 + dice.below(3);
            let wanted = dice.wanted(mesh.report().bounding_radius, &spots, contacts);
            let plan = planned(mesh, &settings(contacts, wanted.constraints(), request));
            for grasp in [&plan.initial, &plan.best]
                .into_iter()
                .flatten()
                .chain(&plan.top)
            {
                assert_eq!(grasp.contacts.len() + wanted.fixed.len(), contacts);
                let violation = wanted.violation(&grasp.contacts);
                assert_eq!(violation, None, "request {request}");
            }
            let forbidden: Vec<String> = spots
                .iter()
                .filter_map(|spot| wanted.forbids(spot))
                .collect();
            assert_eq!(plan.candidates + forbidden.len(), spots.len());
            for removal in &plan.removals {
                let name = removal.rule.to_string();
                let count = forbidden.iter().filter(|rule| **rule == name).count();
                assert_eq!(removal.removed, count, "request {request}: {name}");
            }
            let left = plan.candidates + wanted.fixed.len();
            let too_few = matches!(plan.infeasible, Some(Infeasible::TooFewLeft { .. }));
            assert_eq!(left < contacts, too_few, "request {request}");
            let none_fits = matches!(plan.infeasible, Some(Infeasible::NoneFits { .. }));
            assert!(!none_fits || wanted.min.is_some() || wanted.max.is_some());
            assert_eq!(
                plan.infeasible.is_some(),
                plan.stop == StopReason::Infeasible
            );
            let closed = plan.best.as_ref().is_some_and(|best| best.force_closure);
            let spaced = wanted.min.is_some() || wanted.max.is_some();
            let fixed = !wanted.fixed.is_empty();
            [
                closed,
                closed && spaced,
                closed && fixed,
                too_few,
                none_fits,
            ]
            .map(usize::from)
        })
        .collect();
    let total = outcomes.iter().fold([0; 5], |mut sum, outcome| {
        sum.iter_mut()
            .zip(outcome)
            .for_each(|(sum, one)| *sum += one);
        sum
    });
    // Force closure, with distances, with fixed contacts; too few left, none that fits.
    let least = [1000, 500, 500, 500, 100];
    assert!(
        total.iter().zip(least).all(|(n, least)| *n >= least),
        "{total:?}"
    );
}

#[test]
fn tight_distances_are_met_where_random_grasps_hardly_ever_meet_them() {
    let raw = solids::torus(1.0, 0.3, 60, 24);
    let mesh = Mesh::prepare(raw).unwrap();
    let wanted = Wanted {
        include: Vec::new(),
        exclude: Vec::new(),
        directions: Vec::new(),
        max_degrees: 180.0,
        min: Some(0.35),
        max: Some(0.72),
        fixed: Vec::new(),
    };
    let mut settings = settings(4, wanted.constraints(), 5);
    settings.evaluation_limit = None;
    settings.search = SearchSettings {
        population: 60,
        generations: 20,
        ..settings.search
    };
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| planned(&mesh, &settings))
    };
    let plan = on(1);
    let best = plan.best.as_ref().unwrap();
    assert!(best.force_closure);
    assert_eq!(wanted.violation(&best.contacts), None);
    assert!(best.margin.unwrap().value > plan.initial.as_ref().unwrap().margin.unwrap().value);
    let last = plan.history.last().unwrap();
    assert!(last.force_closures > 30, "{last:?}");
    assert_eq!(plan, on(3));
}

#[test]
fn what_does_not_fit_is_not_evaluated() {
    let mesh = &bodies()[2];
    let apart = |min: f64| Constraints {
        spacing: Spacing {
            min: Some(min),
            max: None,
        },
        ..Constraints::default()
    };
    let plan = planned(mesh, &settings(4, apart(2.6), 1));
    assert_eq!(plan.infeasible, Some(Infeasible::NoneFits { planned: 4 }));
    assert_eq!((plan.stop, plan.evaluations), (StopReason::Infeasible, 0));
    assert!(plan.best.is_none() && plan.evaluation.is_none() && plan.history.is_empty());
    // A distance that all grasps keep changes nothing but the random numbers.
    let plan = planned(mesh, &settings(4, apart(0.0), 1));
    assert!(plan.best.is_some_and(|best| best.force_closure));
}

#[test]
fn a_proof_counts_the_fixed_contacts() {
    let mesh = &bodies()[1];
    let candidates = mesh.candidates();
    let lowest = candidates
        .iter()
        .max_by(|a, b| a.normal.z.total_cmp(&b.normal.z));
    let top = Constraints {
        include: vec![Region::HalfSpace {
            point: Point3::new(0.0, 0.0, 0.6),
            normal: Vector3::z_axis(),
        }],
        ..Constraints::default()
    };
    let one_sided = planned(mesh, &settings(4, top.clone(), 1));
    assert!(matches!(
        one_sided.impossible,
        Some(Impossible::OneSided { .. })
    ));
    let held = Constraints {
        fixed: lowest.map(Contact::from).into_iter().collect(),
        ..top
    };
    let plan = planned(mesh, &settings(4, held, 1));
    assert_eq!(
        (plan.impossible, plan.candidates),
        (None, one_sided.candidates)
    );
    let best = plan.best.unwrap();
    assert_eq!((best.contacts.len(), best.force_closure), (3, true));
    // Enough contacts, though each kind alone is too few.
    let fixed = candidates[..2].iter().map(Contact::from).collect();
    let two = Constraints {
        fixed,
        ..Constraints::default()
    };
    assert_eq!(planned(mesh, &settings(3, two.clone(), 1)).impossible, None);
    let mut frictionless = settings(6, two, 1);
    frictionless.wrench.contact = ContactSettings::Known(ContactModel::Frictionless);
    let least = Some(Impossible::TooFewContacts { least: 7 });
    assert_eq!(planned(mesh, &frictionless).impossible, least);
}
