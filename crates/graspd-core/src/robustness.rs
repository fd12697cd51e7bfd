//! Robustness: the quality to expect when the fingers miss their places.
//!
//! Every contact is displaced by a normal distribution in its tangent plane and put back on the surface. The
//! quality of many grasps scattered in this way shows what to expect from a hand that is not exact. The mean
//! of ε, counting zero without force closure, and the share of the grasps that are force closure are the
//! probabilistic quality and the probability of force closure of Weisz & Allen, "Pose error robust grasping
//! from contact wrench space metrics" (ICRA 2012), here with errors at the contacts instead of an error of the
//! body's pose.
//!
//! ```text
//! for each sample:                              (in parallel)
//!     random ← the stream of this sample, from the seed
//!     for each contact: move it in its tangent plane, project it on the surface
//!     ε of the sample ← quality of the moved contacts, 0 without force closure
//! mean, 5th percentile and share of the positive ε
//! ```
//!
//! Every sample draws from a stream of its own and its ε has a place of its own, so the numbers depend neither
//! on the number of threads nor on the size of the blocks in which the interrupt is checked. The mean of n
//! samples has a standard error of σ/√n. A sample costs one quality evaluation and one projection a contact.

use rayon::prelude::*;

use super::blocks::{FACET_LIMIT, grasps_per_block};
use super::contact::{Contact, Site};
use super::interrupt::{Interrupt, Interrupted};
use super::mesh::Projector;
use super::quality::{ACCURACY, Evaluator, Margin};
use super::random::{Purpose, Stream};
use super::wrench::WrenchModel;

/// How the contacts of a grasp are scattered.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Scatter {
    /// Standard deviation of either component of a displacement in the tangent plane, in the mesh's unit.
    pub sigma: f64,
    /// Number of scattered grasps; at least one.
    pub samples: u32,
    pub seed: u64,
}

/// The quality of a grasp to expect when its fingers miss their places (Weisz & Allen 2012).
///
/// Each contact is displaced by a normal distribution in its tangent plane and put back on the surface, with
/// the normal there, on an edge that of the face which leans least from the contact's own; a free contact stays in the plane and keeps its normal. The same seed gives the same
/// numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct Robustness {
    /// Standard deviation of either component of a displacement, in the mesh's unit.
    pub sigma: f64,
    /// Number of scattered grasps.
    pub samples: u32,
    /// The seed of the displacements.
    pub seed: u64,
    /// Mean quality ε of the scattered grasps, zero for those that are not force closure.
    pub expected: f64,
    /// The ε that 5 of 100 scattered grasps fall short of, interpolated between the two nearest.
    pub percentile_5: f64,
    /// Share of the scattered grasps that are force closure.
    pub force_closure_probability: f64,
}

/// Share of the scattered grasps that fall short of [`Robustness::percentile_5`].
const TAIL: f64 = 0.05;

/// Scatters the contacts of a grasp, on the current rayon pool. A margin above `closure_floor` counts as force
/// closure.
///
/// The same seed gives the same bits on any number of threads. `interrupt` is checked every few milliseconds.
pub fn robustness(
    model: &WrenchModel,
    projector: &Projector,
    sites: &[Site],
    closure_floor: f64,
    scatter: &Scatter,
    interrupt: Interrupt<'_>,
) -> Result<Robustness, Interrupted> {
    let &Scatter {
        sigma,
        samples,
        seed,
    } = scatter;
    let block = grasps_per_block(model, sites.len());
    let count = samples as usize;
    let mut epsilons = Vec::with_capacity(count);
    for first in (0..count).step_by(block) {
        interrupt.check()?;
        let last = count.min(first + block);
        epsilons.par_extend((first..last).into_par_iter().map_init(
            || (Evaluator::with_facet_limit(FACET_LIMIT), Vec::new()),
            |(evaluator, contacts), sample| {
                let mut stream = Stream::new(seed, Purpose::Scatter, sample as u64);
                let moved = sites
                    .iter()
                    .map(|site| displaced(model, projector, site, sigma, &mut stream));
                contacts.clear();
                contacts.extend(moved);
                let margin = evaluator.grasp_quality(model, contacts, ACCURACY).ok();
                let closes = |m: &Margin| m.value > closure_floor && m.is_force_closure();
                margin.filter(closes).map_or(0.0, |margin| margin.value)
            },
        ));
    }
    let count = epsilons.len() as f64;
    let expected = epsilons.iter().sum::<f64>() / count;
    let closed = epsilons.iter().filter(|epsilon| **epsilon > 0.0).count();
    epsilons.sort_unstable_by(f64::total_cmp);
    let rank = TAIL * (count - 1.0);
    let at = |rank: f64| epsilons.get(rank as usize).copied().unwrap_or(0.0);
    let (below, above) = (at(rank.floor()), at(rank.ceil()));
    Ok(Robustness {
        sigma,
        samples,
        seed,
        expected,
        percentile_5: below + (above - below) * rank.fract(),
        force_closure_probability: closed as f64 / count,
    })
}

/// Moves the contact in its tangent plane, then to the nearest place on the surface, with the normal there. Beyond an edge
/// that place is on the edge, and the normal is that of the face which leans least from the contact's own: a finger that
/// slides over the rim still presses the way it did. A contact that is not on the surface stays in the plane.
fn displaced(
    model: &WrenchModel,
    projector: &Projector,
    site: &Site,
    sigma: f64,
    stream: &mut Stream,
) -> Contact {
    let (t1, t2) = model.tangents(&site.contact);
    let (along, across) = (stream.normal(), stream.normal());
    let moved = site.contact.position + (t1 * along + t2 * across) * sigma;
    // A free contact was never on the surface, so it is not put back on it.
    let back = site
        .triangle
        .and_then(|_| projector.project_facing(&moved, &site.contact.normal));
    back.map_or(
        Contact {
            position: moved,
            ..site.contact
        },
        |place| Contact {
            position: place.position,
            normal: place.normal,
        },
    )
}

#[cfg(test)]
mod tests {

    use nalgebra::{Point3, Unit, Vector3};

    use super::*;
    use crate::contact::{Cone, ConeEdges, ContactModel, Friction};
    use crate::mesh::{Mesh, solids};
    use crate::wrench::{EdgeNorm, WrenchSpace};

    const FLOOR: f64 = 1e-6;

    fn model(cone: Cone) -> WrenchModel {
        WrenchModel {
            contact_model: ContactModel::Hard {
                friction: Friction::new(0.4).unwrap(),
                cone,
            },
            edge_norm: EdgeNorm::UnitEdge,
            space: WrenchSpace::L1,
            center: Point3::origin(),
            torque_scale: 1.0,
        }
    }

    fn pyramid() -> Cone {
        Cone::Pyramid(ConeEdges::new(8).unwrap())
    }

    /// Fingers near the corners of a tetrahedron on a ball.
    fn sites(mesh: &Mesh) -> Vec<Site> {
        let projector = Projector::new(mesh);
        [
            [1.0, 1.0, 1.1],
            [-1.0, -1.0, 1.0],
            [-1.0, 1.2, -1.0],
            [1.0, -1.0, -1.0],
        ]
        .map(|p| projector.project(&Point3::from(p)).unwrap())
        .map(|place| Site::from(&mesh.candidate_of(place.triangle).unwrap()))
        .into()
    }

    fn scattered(
        mesh: &Mesh,
        model: &WrenchModel,
        sites: &[Site],
        scatter: &Scatter,
    ) -> Robustness {
        let projector = Projector::new(mesh);
        robustness(model, &projector, sites, FLOOR, scatter, Interrupt::never()).unwrap()
    }

    fn scatter(sigma: f64) -> Scatter {
        Scatter {
            sigma,
            samples: 300,
            seed: 5,
        }
    }

    #[test]
    fn without_scatter_to_speak_of_it_is_the_quality() {
        let mesh = Mesh::prepare(solids::sphere(1.0, 48, 96)).unwrap();
        for cone in [pyramid(), Cone::Round] {
            let (model, sites) = (model(cone), sites(&mesh));
            let contacts: Vec<Contact> = sites.iter().map(|site| site.contact).collect();
            let quality = Evaluator::new().grasp_quality(&model, &contacts, ACCURACY);
            let quality = quality.unwrap().value;
            assert!(quality > 0.05, "{quality}");
            let found = scattered(&mesh, &model, &sites, &scatter(1e-9));
            assert!((found.expected - quality).abs() < 1e-6);
            assert!((found.percentile_5 - quality).abs() < 1e-6);
            assert_eq!(found.force_closure_probability, 1.0);
        }
    }

    #[test]
    fn on_a_ball_more_scatter_is_worse() {
        let mesh = Mesh::prepare(solids::sphere(1.0, 48, 96)).unwrap();
        let (model, sites) = (model(pyramid()), sites(&mesh));
        let found = [0.01, 0.05, 0.15, 0.4, 1.0]
            .map(|sigma| scattered(&mesh, &model, &sites, &scatter(sigma)));
        for pair in found.windows(2) {
            assert!(pair[0].percentile_5 >= pair[1].percentile_5, "{pair:?}");
            assert!(pair[0].expected > pair[1].expected, "{pair:?}");
            assert!(pair[0].force_closure_probability >= pair[1].force_closure_probability);
        }
        let last = found[4];
        assert!(last.percentile_5 == 0.0 && last.force_closure_probability < 1.0);
        assert!(last.expected > 0.0 && last.force_closure_probability > 0.0);
    }

    #[test]
    fn the_same_seed_gives_the_same_bits_on_any_number_of_threads() {
        let mesh = Mesh::prepare(solids::torus(2.0, 0.7, 24, 12)).unwrap();
        let (model, sites) = (model(pyramid()), sites(&mesh));
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let run = || scattered(&mesh, &model, &sites, &scatter(0.1));
            pool.unwrap().install(run)
        };
        assert_eq!(on(1), on(3));
        let other = Scatter {
            seed: 6,
            ..scatter(0.1)
        };
        assert_ne!(on(1), scattered(&mesh, &model, &sites, &other));
    }

    #[test]
    fn contacts_are_put_back_on_the_surface_but_free_ones_stay_in_their_plane() {
        let mesh = Mesh::prepare(solids::cube(1.0)).unwrap();
        let projector = Projector::new(&mesh);
        let contact = Contact {
            position: Point3::new(0.9, 0.5, 1.0),
            normal: Unit::new_normalize(Vector3::new(0.0, 0.0, -1.0)),
        };
        let (mut over_the_edge, mut squares) = (0, 0.0);
        for sample in 0..400 {
            let moved = |triangle| {
                let mut stream = Stream::new(1, Purpose::Scatter, sample);
                let site = Site { contact, triangle };
                displaced(&model(pyramid()), &projector, &site, 0.1, &mut stream)
            };
            let (on_surface, free) = (moved(Some(0)), moved(None));
            assert_eq!((free.position.z, free.normal), (1.0, contact.normal));
            squares += (free.position - contact.position).norm_squared();
            let clamped = free.position.map(|x| x.clamp(0.0, 1.0));
            assert!((on_surface.position - clamped).norm() < 1e-12);
            over_the_edge += usize::from(free.position.x > 1.0);
        }
        assert!((400.0 * 0.02 / squares - 1.0).abs() < 0.2, "{squares}");
        assert!((30..100).contains(&over_the_edge), "{over_the_edge}");
    }

    #[test]
    fn the_order_of_the_triangles_plays_no_part() {
        let forwards = solids::cube(1.0);
        let mut backwards = forwards.clone();
        backwards.triangles.reverse();
        let contacts = [
            ([1.0, 0.4, 0.97], [-1.0, 0.0, 0.0]),
            ([0.0, 0.35, 0.97], [1.0, 0.0, 0.0]),
            ([0.0, 0.2, 0.03], [1.0, 0.0, 0.0]),
            ([1.0, 0.25, 0.03], [-1.0, 0.0, 0.0]),
        ];
        let mut model = model(pyramid());
        model.center = Point3::new(0.5, 0.5, 0.5);
        let found = [forwards, backwards].map(|raw| {
            let mesh = Mesh::prepare(raw).unwrap();
            let sites = contacts.map(|(position, normal)| Site {
                contact: Contact {
                    position: Point3::from(position),
                    normal: Unit::new_normalize(Vector3::from(normal)),
                },
                triangle: Some(0),
            });
            scattered(&mesh, &model, &sites, &scatter(0.05))
        });
        assert_eq!(found[0], found[1]);
        assert!(found[0].force_closure_probability > 0.0);
    }

    #[test]
    fn it_can_be_interrupted() {
        let mesh = Mesh::prepare(solids::cube(1.0)).unwrap();
        let cancelled = || Some(Interrupted::Cancelled);
        let found = robustness(
            &model(pyramid()),
            &Projector::new(&mesh),
            &sites(&mesh),
            FLOOR,
            &scatter(0.1),
            Interrupt::new(&cancelled),
        );
        assert_eq!(found, Err(Interrupted::Cancelled));
    }
}
