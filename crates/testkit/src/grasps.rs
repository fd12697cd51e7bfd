//! Grasps to measure and to check with: random ones, and the populations of a genetic search.

use std::path::Path;

use graspd_core::contact::ContactModel;
use graspd_core::mesh::Mesh;
use graspd_core::quality::Evaluator;
use graspd_core::search::{Grasp, SearchProblem};
use graspd_core::wrench::{EdgeNorm, TorqueScale, WrenchModel, WrenchSpace};
use graspd_mesh_io::Limits;
use rand::Rng;
use rand_pcg::Pcg64;

/// A repeatable source of random numbers.
pub struct Sampler(Pcg64);

impl Sampler {
    pub fn new(seed: u64) -> Self {
        Self(Pcg64::new(u128::from(seed), 0x6a09_e667))
    }

    /// A whole number in `0..n`.
    pub fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.0.next_u64()) * n as u128) >> 64) as usize
    }

    /// `contacts` distinct candidates out of `n`.
    pub fn grasp(&mut self, n: usize, contacts: usize) -> Grasp {
        let mut grasp = Grasp::new();
        while grasp.len() < contacts {
            let pick = self.below(n) as u32;
            if !grasp.contains(&pick) {
                grasp.push(pick);
            }
        }
        grasp
    }
}

/// The body in a mesh file.
pub fn body(path: &Path) -> Mesh {
    let limits = Limits {
        triangles: usize::MAX,
        vertices: usize::MAX,
        ..Limits::NONE
    };
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let (_, raw) = graspd_mesh_io::read(&bytes, None, &limits).expect("a mesh file");
    Mesh::prepare(raw).expect("a body")
}

/// Grasps of `contacts` fingers on a body, torques about its centre of mass.
pub fn problem(
    mesh: &Mesh,
    contacts: usize,
    contact_model: ContactModel,
    edge_norm: EdgeNorm,
    torque_scale: TorqueScale,
) -> SearchProblem {
    let center = mesh.report().center_of_mass;
    let model = WrenchModel {
        contact_model,
        edge_norm,
        space: WrenchSpace::L1,
        center,
        torque_scale: torque_scale.value(mesh, &center),
    };
    SearchProblem::new(mesh.candidates(), model, contacts).expect("more candidates than contacts")
}

/// Up to `count` force closures among `tries` random grasps.
pub fn closures(
    problem: &SearchProblem,
    count: usize,
    tries: usize,
    sampler: &mut Sampler,
) -> Vec<Grasp> {
    let mut evaluator = Evaluator::new();
    let random = (0..tries).map(|_| sampler.grasp(problem.len(), problem.contacts()));
    random
        .filter(|grasp| epsilon(&mut evaluator, problem, grasp) > 0.0)
        .take(count)
        .collect()
}

/// The children of one generation of a genetic search with the paper's population of 200, tournaments
/// of two, one mutation in five children and elitism of two, before selection.
pub fn population(problem: &SearchProblem, generation: usize, sampler: &mut Sampler) -> Vec<Grasp> {
    const SIZE: usize = 200;
    let (n, m) = (problem.len(), problem.contacts());
    let mut evaluator = Evaluator::new();
    let mut scored = |grasp: Grasp| {
        let epsilon = epsilon(&mut evaluator, problem, &grasp);
        (grasp, epsilon)
    };
    let first = closures(problem, 1, 100_000, sampler);
    let founders = first
        .into_iter()
        .chain((1..SIZE).map(|_| sampler.grasp(n, m)));
    let mut people: Vec<(Grasp, f64)> = founders.map(&mut scored).collect();
    for _ in 0..generation {
        people.sort_by(|a, b| b.1.total_cmp(&a.1));
        let mut next = people[..2].to_vec();
        while next.len() < SIZE {
            let mut child = crossed(
                tournament(&people, sampler),
                tournament(&people, sampler),
                m,
                sampler,
            );
            if sampler.below(5) == 0 {
                mutate(&mut child, n, sampler);
            }
            next.push(scored(child));
        }
        people = next;
    }
    // The children before the elite, for whoever takes only some.
    people.rotate_left(2);
    people.into_iter().map(|(grasp, _)| grasp).collect()
}

/// ε, zero for no force closure.
fn epsilon(evaluator: &mut Evaluator, problem: &SearchProblem, grasp: &[u32]) -> f64 {
    match evaluator.quality(&problem.wrenches(grasp)) {
        Ok(margin) if problem.passes_closure_floor(&margin) => margin.value,
        _ => 0.0,
    }
}

fn tournament<'p>(people: &'p [(Grasp, f64)], sampler: &mut Sampler) -> &'p Grasp {
    let (a, b) = (
        &people[sampler.below(people.len())],
        &people[sampler.below(people.len())],
    );
    if b.1 > a.1 { &b.0 } else { &a.0 }
}

/// What both parents hold, and of the rest as many at random as are wanting.
fn crossed(a: &Grasp, b: &Grasp, contacts: usize, sampler: &mut Sampler) -> Grasp {
    let (mut child, mut rest): (Grasp, Grasp) = a.iter().partition(|c| b.contains(c));
    rest.extend(b.iter().filter(|c| !a.contains(c)));
    while child.len() < contacts {
        child.push(rest.swap_remove(sampler.below(rest.len())));
    }
    child
}

fn mutate(grasp: &mut Grasp, n: usize, sampler: &mut Sampler) {
    let (slot, pick) = (sampler.below(grasp.len()), sampler.below(n) as u32);
    if !grasp.contains(&pick) {
        grasp[slot] = pick;
    }
}
