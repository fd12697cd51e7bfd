//! Evaluations of given grasps.

use rayon::prelude::*;

use super::analyses;
use super::explain;
use super::place::{MAX_FAULTS, PlacedContact, Placer, unplaceable};
use super::surface;
use crate::wire::{
    ContactSpec, EvaluatedContact, EvaluationRequest, Evaluations, FieldError, GraspEvaluation,
    Problem, Resistance,
};
use graspd_core::analysis::{Analysis, Analyst};
use graspd_core::contact::{Contact, ContactModel, Site};
use graspd_core::evaluation::{Effort, Evaluation, FACET_LIMIT, evaluate_with};
use graspd_core::mesh::Mesh;
use graspd_core::plan::{ContactFields, Mismatch};
use graspd_core::quality::Evaluator;
use graspd_core::search::closure_floor;
use graspd_core::wrench::WrenchModel;
use graspd_core::{Interrupt, Interrupted};

/// Why there are no evaluations.
#[derive(Debug)]
pub enum EvaluationFault {
    Problem(Problem),
    Interrupted(Interrupted),
}

impl From<Problem> for EvaluationFault {
    fn from(problem: Problem) -> Self {
        Self::Problem(problem)
    }
}

impl From<Mismatch> for EvaluationFault {
    fn from(mismatch: Mismatch) -> Self {
        Self::Problem(mismatch.into())
    }
}

impl From<Interrupted> for EvaluationFault {
    fn from(why: Interrupted) -> Self {
        Self::Interrupted(why)
    }
}

/// Evaluates the grasps of `request` on `mesh`, on the current rayon pool, in their order.
///
/// `interrupt` is checked between grasps and parts of the work for one. Fails with a [`Problem`] when a contact cannot be placed on this mesh, or mesh and settings do not fit together.
/// The same mesh and request give the same evaluations on any number of threads.
pub fn evaluate(
    mesh: &Mesh,
    request: &EvaluationRequest,
    interrupt: Interrupt<'_>,
) -> Result<Evaluations, EvaluationFault> {
    let chosen = surface::chosen(mesh, &request.surface)?;
    let mesh = chosen.as_ref();
    let model = request.quality.wrench.model(mesh)?;
    let floor = closure_floor(&model, mesh.vertices().iter().copied());
    let analyst = Analyst::new(mesh, &model, floor, &request.analyses)?;
    let grasps = places(mesh, &model, &request.grasps)?;
    let found: Vec<Evaluation> = grasps
        .par_iter()
        .map_init(
            || Evaluator::with_facet_limit(FACET_LIMIT),
            |evaluator, places| {
                interrupt.check()?;
                let contacts: Vec<Contact> = places.iter().map(|p| p.site.contact).collect();
                let external = &request.external;
                evaluate_with(evaluator, &model, &contacts, floor, external, interrupt)
            },
        )
        .collect::<Result<_, Interrupted>>()?;
    // One grasp after the other: the work for one is shared out.
    let mut evaluations = Vec::with_capacity(grasps.len());
    for (places, found) in grasps.iter().zip(&found) {
        let sites: Vec<Site> = places.iter().map(|place| place.site).collect();
        let closed = found.margin.as_ref().ok().filter(|_| found.force_closure);
        let mut analysis = analyst.analyse(&sites, closed, interrupt)?;
        analyses::shorten(&mut analysis.independent_regions, grasps.len());
        evaluations.push(entry(&model, places, found, analysis));
    }
    let wrench = &request.quality.wrench;
    let contact = ContactFields::from(wrench.contact);
    Ok(Evaluations {
        evaluations,
        frame: "mesh".to_owned(),
        units: request.quality.units,
        torque_scale: explain::torque_scale(wrench.torque_scale, model.torque_scale),
        center_of_mass: model.center.into(),
        contact_model: contact.contact_model,
        friction: contact.friction,
        cone_edges: contact.cone_edges,
        torsional_friction: explain::torsion(&model),
        edge_norm: wrench.edge_norm,
        wrench_space: wrench.space,
        mesh_warnings: surface::doubts(mesh.report()),
        version: env!("CARGO_PKG_VERSION").to_owned(),
    })
}

fn places(
    mesh: &Mesh,
    model: &WrenchModel,
    grasps: &[Vec<ContactSpec>],
) -> Result<Vec<Vec<PlacedContact>>, Problem> {
    let placer = Placer::new(mesh, model);
    let mut faults = Vec::new();
    let mut all = Vec::with_capacity(grasps.len());
    for (i, grasp) in grasps.iter().enumerate() {
        let mut places = Vec::with_capacity(grasp.len());
        for (j, contact) in grasp.iter().enumerate() {
            match placer.place(contact) {
                Ok(place) => places.push(place),
                Err((member, detail)) => faults.push(FieldError {
                    pointer: format!("/grasps/{i}/{j}/{member}"),
                    detail,
                }),
            }
        }
        all.push(places);
        if faults.len() >= MAX_FAULTS {
            break;
        }
    }
    if faults.is_empty() {
        return Ok(all);
    }
    Err(unplaceable(faults))
}

fn entry(
    model: &WrenchModel,
    places: &[PlacedContact],
    found: &Evaluation,
    analysis: Analysis,
) -> GraspEvaluation {
    let margin = found.margin.ok();
    GraspEvaluation {
        force_closure: found.force_closure,
        quality: margin.filter(|_| found.force_closure).map(|m| m.value),
        margin: margin.map(|m| m.value),
        exact: margin.map(|m| m.exact),
        bounds: found.bounds,
        bounds_exact: found.bounds_exact,
        contacts: places
            .iter()
            .enumerate()
            .map(|(i, place)| contact(model, place, found.weakest.as_ref(), i))
            .collect(),
        weakest_wrench: margin.map(|m| explain::weakest_wrench(&m, found.force_closure)),
        explanation: found.obstacle.as_ref().map(explain::obstacle),
        measures: found.measures,
        robustness: analysis.robustness,
        independent_regions: analysis.independent_regions,
        task_quality: analysis.task_quality,
        gravity_quality: analysis.gravity_quality,
        resisted: found
            .resisted
            .iter()
            .map(|effort| resistance(model, effort.as_ref()))
            .collect(),
    }
}

fn contact(
    model: &WrenchModel,
    place: &PlacedContact,
    effort: Option<&Effort>,
    index: usize,
) -> EvaluatedContact {
    let normal = place.site.contact.normal.into_inner();
    let force = explain::contact_force(model, effort, index);
    EvaluatedContact {
        position: place.site.contact.position.into(),
        normal: normal.into(),
        approach: (-normal).into(),
        triangle: place.site.triangle,
        barycentric: place.barycentric,
        distance: place.distance,
        forces: force.map(|(force, _)| force),
        torsion: force.and_then(|(_, torsion)| torsion),
    }
}

fn resistance(model: &WrenchModel, effort: Option<&Effort>) -> Resistance {
    let soft = matches!(model.contact_model, ContactModel::Soft { .. });
    Resistance {
        resisted: effort.is_some(),
        effort: effort.map(|effort| effort.total),
        forces: effort.map(|e| e.forces.iter().map(|f| f.force.into()).collect()),
        torsions: effort
            .filter(|_| soft)
            .map(|e| e.forces.iter().map(|f| f.torsion).collect()),
    }
}
