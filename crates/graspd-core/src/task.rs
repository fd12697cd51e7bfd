//! Quality of a grasp for given tasks.
//!
//! The quality for a disturbance t = (force; λ·torque) is the largest s with −s·t/‖t‖ in the grasp wrench
//! space: the size of the disturbance along t that contact forces of unit size resist. ε is the same for the
//! worst disturbance, so the task quality is never below ε and equals it opposite to the weakest wrench. Li &
//! Sastry, "Task-oriented optimal grasping by multifingered robot hands" (IEEE J. Robotics and Automation 4,
//! 1988), here for single task wrenches instead of an ellipsoid of them; Roa & Suárez, "Grasp quality
//! measures" (Autonomous Robots 38, 2015).
//!
//! Each task is one ray through the wrench space: a linear program for pyramids, a second-order cone program
//! for round cones and L∞. Tasks are independent of each other and solved in parallel.

use std::ops::RangeInclusive;

use rayon::prelude::*;

use super::contact::{Contact, ContactModel};
use super::effort::ExternalWrench;
use super::interrupt::{Interrupt, Interrupted};
use super::max_resistible::{Columns, Resistible};
use super::wrench::{Wrench, WrenchModel};

/// Least and greatest number of tasks between two checks of the interrupt, and the contacts of all of them
/// together: some milliseconds, some tens for the largest grasps.
const BLOCK: RangeInclusive<usize> = 2..=16;
const BLOCK_CONTACTS: usize = 256;

/// Quality for a task (Li & Sastry 1988; Roa & Suárez 2015): how much of each disturbance the grasp resists.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct TaskQuality {
    /// For each task wrench t, torque scaled, the largest s with −s·t/‖t‖ in the grasp wrench space: in the
    /// unit of ε, never below it; zero when t is not resisted at all.
    pub per_wrench: Vec<f64>,
    /// The least of them.
    pub least: f64,
    /// Which task wrench that is, counted from 0; the first of equals.
    pub weakest: u32,
}

impl TaskQuality {
    /// Finds the least quality; `None` without task wrenches.
    pub fn new(per_wrench: Vec<f64>) -> Option<Self> {
        let numbered = per_wrench.iter().copied().enumerate();
        let (weakest, least) = numbered.min_by(|(_, a), (_, b)| a.total_cmp(b))?;
        Some(Self {
            per_wrench,
            least,
            weakest: weakest as u32,
        })
    }
}

/// Returns the largest s for each of `tasks`, in the unit of ε; zero for a task that is not resisted at all or
/// has no direction. Exact to 1e-8 of the longest wrench. `epsilon`, zero without force closure, is a lower bound on the ε
/// of the grasp: every wrench of that size is resisted, whatever comes of its program. `interrupt` is checked between
/// blocks.
///
/// Solves one program a task, on the current rayon pool: some 100 µs for 4 contacts.
pub fn task_quality(
    model: &WrenchModel,
    contacts: &[Contact],
    tasks: &[ExternalWrench],
    epsilon: f64,
    interrupt: Interrupt<'_>,
) -> Result<Vec<f64>, Interrupted> {
    let columns = Columns::new(model, contacts);
    // The columns have unit normal force; the wrenches of the space may be shorter.
    let length = match model.contact_model {
        ContactModel::Frictionless => 1.0,
        ContactModel::Hard { friction, .. } | ContactModel::Soft { friction, .. } => {
            model.edge_length(friction)
        }
    };
    let resisted = |task: &ExternalWrench| {
        let wrench = direction(model, task)?;
        Some(match columns.max_resistible(model.space, &wrench) {
            Resistible::UpTo(balance) => epsilon.max(balance.reach * length),
            Resistible::Not | Resistible::Undecided => epsilon,
        })
    };
    let mut found = Vec::with_capacity(tasks.len());
    let block = (BLOCK_CONTACTS / contacts.len().max(1)).clamp(*BLOCK.start(), *BLOCK.end());
    for block in tasks.chunks(block) {
        interrupt.check()?;
        found.par_extend(block.par_iter().map(|task| resisted(task).unwrap_or(0.0)));
    }
    Ok(found)
}

/// Returns the unit wrench along a disturbance, however small or large that is.
fn direction(model: &WrenchModel, task: &ExternalWrench) -> Option<Wrench> {
    let wrench = task.wrench(model);
    // Divided by its greatest component first: the norm of a very small or large wrench would vanish or
    // overflow.
    let greatest = wrench.amax();
    let usable = greatest > 0.0 && greatest.is_finite();
    usable.then(|| (wrench / greatest).normalize())
}

#[cfg(test)]
mod tests {

    use nalgebra::{Point3, Unit, Vector3};
    use rand::{Rng, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::contact::{Cone, ConeEdges, Friction, Torsion};
    use crate::quality::{ACCURACY, Evaluator};
    use crate::wrench::{EdgeNorm, WrenchSpace};

    fn uniform(rng: &mut Pcg64) -> f64 {
        (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn vector(rng: &mut Pcg64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| 2.0 * uniform(rng) - 1.0)
    }

    fn grasp(rng: &mut Pcg64, m: usize) -> Vec<Contact> {
        (0..m)
            .map(|_| {
                let out = vector(rng).normalize();
                Contact {
                    position: Point3::from(out),
                    normal: Unit::new_normalize(vector(rng) * 0.3 - out),
                }
            })
            .collect()
    }

    fn model(contact_model: ContactModel, space: WrenchSpace) -> WrenchModel {
        WrenchModel {
            contact_model,
            edge_norm: EdgeNorm::UnitEdge,
            space,
            center: Point3::new(0.1, 0.0, -0.1),
            torque_scale: 0.8,
        }
    }

    fn hard(cone: Cone) -> ContactModel {
        ContactModel::Hard {
            friction: Friction::new(0.6).unwrap(),
            cone,
        }
    }

    fn soft(cone: Cone) -> ContactModel {
        ContactModel::Soft {
            friction: Friction::new(0.6).unwrap(),
            torsion: Torsion::new(0.15).unwrap(),
            cone,
        }
    }

    fn pyramid(edges: u32) -> Cone {
        Cone::Pyramid(ConeEdges::new(edges).unwrap())
    }

    fn quality(model: &WrenchModel, contacts: &[Contact], tasks: &[ExternalWrench]) -> Vec<f64> {
        task_quality(model, contacts, tasks, 0.0, Interrupt::never()).unwrap()
    }

    /// All points of which the wrench space is the hull.
    fn points(model: &WrenchModel, contacts: &[Contact]) -> Vec<Wrench> {
        let mut sums = vec![Wrench::zeros()];
        let mut all = Vec::new();
        for contact in contacts {
            let mut own = Vec::new();
            model.push_wrenches(contact, &mut own);
            all.extend_from_slice(&own);
            own.push(Wrench::zeros());
            sums = sums
                .iter()
                .flat_map(|sum| own.iter().map(move |wrench| sum + wrench))
                .collect();
        }
        match model.space {
            WrenchSpace::L1 => all,
            WrenchSpace::Linf => sums,
        }
    }

    /// The largest s by halving: is −s·t in the hull, that is the origin in the hull moved by s·t?
    fn slow(points: &[Wrench], task: &Wrench) -> f64 {
        let (mut inside, mut outside) = (0.0, 10.0);
        let mut evaluator = Evaluator::new();
        for _ in 0..40 {
            let middle = 0.5 * (inside + outside);
            let moved: Vec<Wrench> = points.iter().map(|w| w + task * middle).collect();
            match evaluator.quality(&moved) {
                Ok(margin) if margin.value > 0.0 => inside = middle,
                _ => outside = middle,
            }
        }
        inside
    }

    #[test]
    fn it_is_where_halving_finds_the_border() {
        let mut rng = Pcg64::seed_from_u64(19);
        let mut closed = [0; 4];
        for _ in 0..40 {
            for (kind, (contact_model, space, m)) in [
                (ContactModel::Frictionless, WrenchSpace::L1, 9),
                (hard(pyramid(5)), WrenchSpace::L1, 4),
                (soft(pyramid(4)), WrenchSpace::L1, 3),
                (hard(pyramid(3)), WrenchSpace::Linf, 3),
            ]
            .into_iter()
            .enumerate()
            {
                let model = model(contact_model, space);
                let contacts = grasp(&mut rng, m);
                let points = points(&model, &contacts);
                let epsilon = Evaluator::new().grasp_quality(&model, &contacts, ACCURACY);
                let Some(epsilon) = epsilon.ok().map(|m| m.value).filter(|&e| e > 1e-3) else {
                    continue;
                };
                closed[kind] += 1;
                let task = ExternalWrench {
                    force: vector(&mut rng) * 1e-3,
                    torque: vector(&mut rng) * 1e-3,
                };
                let found = quality(&model, &contacts, &[task])[0];
                let slow = slow(&points, &direction(&model, &task).unwrap());
                assert!((found - slow).abs() < 1e-7, "{kind}: {found} {slow}");
                assert!(found > epsilon - 1e-7);
            }
        }
        assert!(closed.iter().all(|&count| count >= 4), "{closed:?}");
    }

    #[test]
    fn it_is_never_below_epsilon_and_equals_it_against_the_weakest_wrench() {
        let mut rng = Pcg64::seed_from_u64(23);
        for (contact_model, m) in [
            (ContactModel::Frictionless, 10),
            (hard(pyramid(8)), 5),
            (hard(Cone::Round), 5),
            (soft(Cone::Round), 4),
        ] {
            for space in [WrenchSpace::L1, WrenchSpace::Linf] {
                let model = model(contact_model, space);
                let mut closed = 0;
                for _ in 0..200 {
                    let contacts = grasp(&mut rng, m);
                    let margin = Evaluator::new().grasp_quality(&model, &contacts, ACCURACY);
                    let Some(margin) = margin.ok().filter(|m| m.value > 1e-3) else {
                        continue;
                    };
                    closed += 1;
                    let mut tasks = vec![ExternalWrench::of_wrench(&model, &-margin.direction)];
                    tasks.extend((0..10).map(|_| ExternalWrench {
                        force: vector(&mut rng),
                        torque: vector(&mut rng),
                    }));
                    let found = quality(&model, &contacts, &tasks);
                    assert!((found[0] / margin.upper - 1.0).abs() < 1e-5, "{found:?}");
                    assert!(found.iter().all(|s| *s > margin.value * (1.0 - 1e-6)));
                    if closed == 5 {
                        break;
                    }
                }
                assert_eq!(closed, 5, "{contact_model:?}");
            }
        }
    }

    #[test]
    fn size_does_not_matter_and_what_is_not_resisted_is_zero() {
        let below = [[1.0, 0.0], [-1.0, 0.7], [-1.0, -0.7]].map(|[x, y]| Contact {
            position: Point3::new(x, y, -1.0),
            normal: Unit::new_normalize(Vector3::z()),
        });
        let model = model(hard(Cone::Round), WrenchSpace::Linf);
        let along = |z: f64| ExternalWrench {
            force: Vector3::new(0.0, 0.0, z),
            torque: (Point3::new(-0.2, 0.0, 0.0) - model.center).cross(&Vector3::new(0.0, 0.0, z)),
        };
        let found = quality(&model, &below, &[-1e-150, -1.0, -1e12, 1.0, 0.0].map(along));
        assert!(found[0] > 1.0);
        for same in &found[1..3] {
            assert!((same / found[0] - 1.0).abs() < 1e-7);
        }
        assert_eq!(found[3..], [0.0, 0.0]);
    }

    #[test]
    fn it_can_be_interrupted() {
        let contacts = grasp(&mut Pcg64::seed_from_u64(1), 4);
        let model = model(hard(Cone::Round), WrenchSpace::L1);
        let task = ExternalWrench {
            force: Vector3::z(),
            torque: Vector3::zeros(),
        };
        let cancelled = || Some(Interrupted::Cancelled);
        let found = task_quality(&model, &contacts, &[task], 0.0, Interrupt::new(&cancelled));
        assert_eq!(found, Err(Interrupted::Cancelled));
    }
}
