//! Where each finger of a grasp may be while the others stay.
//!
//! The independent region of a contact holds the candidates to which that finger alone can move so that the
//! grasp keeps force closure and a given fraction of its ε, after Nguyen, "Constructing force-closure
//! grasps" (Int. J. Robotics Research 7, 1988), and Roa & Suárez, "Computation of independent contact regions
//! for grasping 3-D objects" (IEEE Trans. Robotics 25, 2009). Theirs let all fingers move at once and are
//! found from sufficient conditions; here one moves at a time, and the region is exact.
//!
//! Along a unit direction u, in which the fingers that stay reach no farther than what is wanted, the one that
//! moves has to: a candidate that cannot is out, for a few multiplications. Such cuts come from the
//! evaluations of candidates that failed; what no cut excludes is evaluated.

use rayon::prelude::*;

use super::analysis::{FACET_LIMIT, Poll, block};
use super::contact::{Contact, Site};
use super::mesh::{Adjacency, Candidate, Mesh};
use super::quality::{ACCURACY, COPLANAR_TOLERANCE, Degenerate, Evaluator, Margin};
use super::wrench::{Wrench, WrenchModel, WrenchSpace};

/// Share of ε that is to be kept: above 0, at most 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fraction(f64);

impl Fraction {
    /// `None` unless `0 < share <= 1`.
    pub fn new(share: f64) -> Option<Self> {
        (share > 0.0 && share <= 1.0).then_some(Self(share))
    }
}

/// Where one finger may be.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// Candidates by their triangles, ascending, as indices in the file.
    pub triangles: Vec<u32>,
    /// Of these triangles, in the mesh's unit squared.
    pub area: f64,
    /// The part that hangs together with the triangle that the finger touches; `None` when it touches none.
    pub connected: Option<Patch>,
}

/// A part of a region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch {
    pub triangles: usize,
    /// In the mesh's unit squared.
    pub area: f64,
}

/// The places that fingers may move to. Of size O(n), so build it once per mesh.
#[derive(Debug)]
pub struct Places<'a> {
    mesh: &'a Mesh,
    candidates: Vec<Candidate>,
    adjacency: Adjacency<'a>,
}

impl<'a> Places<'a> {
    /// O(n log n).
    pub fn new(mesh: &'a Mesh) -> Self {
        Self {
            mesh,
            candidates: mesh.candidates(),
            adjacency: Adjacency::new(mesh),
        }
    }

    fn area(&self, triangles: &[u32]) -> f64 {
        triangles.iter().map(|&t| self.mesh.area_of(t)).sum()
    }
}

/// Most cuts of a finger: applying each to a million candidates takes some 10 ms.
const MAX_CUTS: usize = 128;

/// Most cuts that one block of evaluations gives, so that applying them takes no longer than making them.
const NEW_CUTS: usize = 8;

/// The region of every contact, in their order, on the current rayon pool.
///
/// `margin` is that of the grasp, which must be force closure; a margin above `closure_floor` is called so.
/// Where ε is known as an interval, its lower end counts. The regions do not depend on the number of threads.
/// `None` when `poll`, which is called between blocks of some milliseconds, breaks. At worst as many quality
/// evaluations as there are candidates for each finger.
pub fn independent_regions(
    places: &Places,
    model: &WrenchModel,
    sites: &[Site],
    margin: &Margin,
    closure_floor: f64,
    fraction: Fraction,
    poll: Poll,
) -> Option<Vec<Region>> {
    // A place that is worth the same but for rounding keeps all of ε.
    let wanted = fraction.0 * margin.value - COPLANAR_TOLERANCE * margin.scale;
    let contacts: Vec<Contact> = sites.iter().map(|site| site.contact).collect();
    let mut regions = Vec::with_capacity(sites.len());
    for (finger, site) in sites.iter().enumerate() {
        let exchange = Exchange {
            model,
            candidates: &places.candidates,
            contacts: &contacts,
            finger,
            threshold: wanted.max(closure_floor),
        };
        let triangles = exchange.kept(&margin.direction, poll)?;
        let connected = site.triangle.map(|own| {
            let reached = places.adjacency.reachable(own, &triangles);
            Patch {
                triangles: reached.len(),
                area: places.area(&reached),
            }
        });
        regions.push(Region {
            area: places.area(&triangles),
            triangles,
            connected,
        });
    }
    Some(regions)
}

/// The move of one finger.
struct Exchange<'a> {
    model: &'a WrenchModel,
    candidates: &'a [Candidate],
    contacts: &'a [Contact],
    finger: usize,
    /// What the margin has to exceed.
    threshold: f64,
}

/// A direction along which the finger that moves has to reach farther than so much.
struct Cut {
    direction: Wrench,
    height: f64,
}

impl Cut {
    fn excludes(&self, model: &WrenchModel, contact: &Contact) -> bool {
        model.reach_bound(contact, &self.direction) <= self.height
    }
}

impl Exchange<'_> {
    /// The triangles of the candidates to which the finger can move.
    fn kept(&self, weakest: &Wrench, poll: Poll) -> Option<Vec<u32>> {
        if poll().is_break() {
            return None;
        }
        let others = self.others();
        let alone = match others.is_empty() {
            true => None,
            false => Some(self.evaluate(&mut evaluator(), &others)),
        };
        let direction = match alone {
            // A finger more takes nothing from what the others reach.
            Some(Ok(())) => return Some(self.candidates.iter().map(|c| c.triangle).collect()),
            Some(Err(direction)) => Some(direction),
            None => None,
        };
        let known = direction.iter().chain([weakest]);
        let first: Vec<Cut> = known.filter_map(|u| self.cut(&others, u)).collect();
        let mut cuts = first.len();
        let mut open = self.uncut(&spread(self.candidates.len()), &first);
        let mut at = 0;
        let mut kept = Vec::new();
        let block = block(self.model, self.contacts.len());
        while at < open.len() {
            if poll().is_break() {
                return None;
            }
            let now = &open[at..open.len().min(at + block)];
            let verdicts: Vec<Result<(), Wrench>> = now
                .par_iter()
                .map_init(evaluator, |evaluator, &candidate| {
                    let mut contacts = self.contacts.to_vec();
                    contacts[self.finger] = self.contact(candidate);
                    self.evaluate(evaluator, &contacts)
                })
                .collect();
            let mut fresh: Vec<Cut> = Vec::new();
            for (&candidate, verdict) in now.iter().zip(verdicts) {
                let Err(direction) = verdict else {
                    kept.push(self.candidates[candidate as usize].triangle);
                    continue;
                };
                let there = self.contact(candidate);
                let wanted = fresh.len() < NEW_CUTS.min(MAX_CUTS - cuts);
                if wanted && !fresh.iter().any(|cut| cut.excludes(self.model, &there)) {
                    fresh.extend(self.cut(&others, &direction));
                }
            }
            at += now.len();
            if !fresh.is_empty() {
                cuts += fresh.len();
                open = self.uncut(&open[at..], &fresh);
                at = 0;
            }
        }
        kept.sort_unstable();
        Some(kept)
    }

    fn others(&self) -> Vec<Contact> {
        let mut others = self.contacts.to_vec();
        others.remove(self.finger);
        others
    }

    fn contact(&self, candidate: u32) -> Contact {
        Contact::from(&self.candidates[candidate as usize])
    }

    /// Whether contacts exceed the threshold, or a unit direction along which they hardly reach.
    fn evaluate(&self, evaluator: &mut Evaluator, contacts: &[Contact]) -> Result<(), Wrench> {
        match evaluator.grasp_quality_above(self.model, contacts, ACCURACY, self.threshold) {
            Ok(margin) if margin.value > self.threshold && margin.is_force_closure() => Ok(()),
            Ok(Margin { direction, .. }) | Err(Degenerate { direction, .. }) => Err(direction),
        }
    }

    /// What the finger has to reach along a direction; `None` when the others do already, and for no
    /// direction.
    fn cut(&self, others: &[Contact], direction: &Wrench) -> Option<Cut> {
        let reaches = others.iter().map(|at| self.model.reach(at, direction));
        let height = match self.model.space {
            WrenchSpace::L1 => {
                let farthest = reaches.fold(f64::NEG_INFINITY, f64::max);
                (farthest <= self.threshold).then_some(self.threshold)?
            }
            WrenchSpace::Linf => {
                let sum: f64 = reaches.map(|reach| reach.max(0.0)).sum();
                (sum < self.threshold).then_some(self.threshold - sum)?
            }
        };
        // Rounding of the bound is not to exclude what an evaluation would keep.
        let height = height * (1.0 - COPLANAR_TOLERANCE) - COPLANAR_TOLERANCE * direction.norm();
        let usable = direction.norm_squared() > 0.5 && height > 0.0;
        usable.then_some(Cut {
            direction: *direction,
            height,
        })
    }

    fn uncut(&self, candidates: &[u32], cuts: &[Cut]) -> Vec<u32> {
        let open = |candidate: &u32| {
            let contact = self.contact(*candidate);
            !cuts.iter().any(|cut| cut.excludes(self.model, &contact))
        };
        candidates.par_iter().copied().filter(open).collect()
    }
}

fn evaluator() -> Evaluator {
    Evaluator::with_facet_limit(FACET_LIMIT)
}

/// All numbers below `n`, in an order whose beginning is evenly spread: neighbours in a file are often
/// neighbours on the surface, and cuts from all over it exclude more.
fn spread(n: usize) -> Vec<u32> {
    let step = n.isqrt().max(1);
    (0..step)
        .flat_map(|first| (first..n).step_by(step))
        .map(|index| index as u32)
        .collect()
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;
    use crate::core::contact::{Cone, ConeEdges, ContactModel, Friction, Torsion};
    use crate::core::mesh::{RawMesh, solids};
    use crate::core::random::{Purpose, Stream};
    use crate::core::wrench::EdgeNorm;

    const FLOOR: f64 = 1e-6;

    fn prepared(raw: RawMesh) -> Mesh {
        Mesh::prepare(raw, None).unwrap()
    }

    fn friction() -> Friction {
        Friction::new(0.5).unwrap()
    }

    fn pyramid() -> Cone {
        Cone::Pyramid(ConeEdges::new(6).unwrap())
    }

    fn models() -> [(ContactModel, WrenchSpace, usize); 6] {
        let hard = |cone| ContactModel::Hard {
            friction: friction(),
            cone,
        };
        let soft = ContactModel::Soft {
            friction: friction(),
            torsion: Torsion::new(0.2).unwrap(),
            cone: pyramid(),
        };
        [
            (ContactModel::Frictionless, WrenchSpace::L1, 7),
            (ContactModel::Frictionless, WrenchSpace::Linf, 8),
            (hard(pyramid()), WrenchSpace::L1, 4),
            (hard(pyramid()), WrenchSpace::Linf, 3),
            (hard(Cone::Round), WrenchSpace::L1, 3),
            (soft, WrenchSpace::L1, 3),
        ]
    }

    fn model(mesh: &Mesh, contact_model: ContactModel, space: WrenchSpace) -> WrenchModel {
        let center = mesh.report().center_of_mass;
        WrenchModel {
            contact_model,
            edge_norm: EdgeNorm::UnitEdge,
            space,
            center,
            torque_scale: mesh.radius_about(&center).recip(),
        }
    }

    /// A grasp that is force closure, the best of those drawn, with its margin.
    fn drawn(mesh: &Mesh, model: &WrenchModel, m: usize) -> (Vec<Site>, Margin) {
        let candidates = mesh.candidates();
        let mut stream = Stream::new(3, Purpose::Population, 0);
        let mut best: Option<(Vec<Site>, Margin)> = None;
        for _ in 0..3000 {
            let grasp = stream.subset(candidates.len(), m);
            let sites: Vec<Site> = grasp
                .iter()
                .map(|&i| (&candidates[i as usize]).into())
                .collect();
            let contacts: Vec<Contact> = sites.iter().map(|site| site.contact).collect();
            let found = Evaluator::new().grasp_quality(model, &contacts, 1e-3);
            let Some(margin) = found.ok().filter(|m| m.value > 0.01) else {
                continue;
            };
            if best
                .as_ref()
                .is_none_or(|(_, best)| margin.value > best.value)
            {
                let exact = Evaluator::new().grasp_margin(model, &contacts, ACCURACY);
                best = Some((sites, exact.unwrap()));
            }
        }
        best.unwrap_or_else(|| panic!("no grasp with {model:?}"))
    }

    fn regions(
        mesh: &Mesh,
        model: &WrenchModel,
        sites: &[Site],
        margin: &Margin,
        fraction: f64,
    ) -> Vec<Region> {
        let fraction = Fraction::new(fraction).unwrap();
        let go_on = &mut || ControlFlow::Continue(());
        let places = Places::new(mesh);
        independent_regions(&places, model, sites, margin, FLOOR, fraction, go_on).unwrap()
    }

    #[test]
    fn every_candidate_is_in_or_out_as_its_own_evaluation_says() {
        let (mut inside, mut outside) = (0, 0);
        for raw in [solids::torus(2.0, 0.7, 12, 8), fine_l_shape()] {
            let mesh = prepared(raw);
            for (contact_model, space, m) in models() {
                let model = model(&mesh, contact_model, space);
                let (sites, margin) = drawn(&mesh, &model, m);
                let contacts: Vec<Contact> = sites.iter().map(|site| site.contact).collect();
                for fraction in [0.2, 0.6, 1.0] {
                    let found = regions(&mesh, &model, &sites, &margin, fraction);
                    assert_eq!(found.len(), m);
                    for (finger, region) in found.iter().enumerate() {
                        let own = sites[finger].triangle.unwrap();
                        assert!(region.triangles.contains(&own));
                        assert!(region.triangles.is_sorted());
                        for candidate in mesh.candidates() {
                            let mut moved = contacts.clone();
                            moved[finger] = Contact::from(&candidate);
                            let there = Evaluator::new().grasp_quality(&model, &moved, ACCURACY);
                            let there = there.map_or(0.0, |margin| margin.value);
                            let wanted = (fraction * margin.value).max(FLOOR);
                            if region.triangles.contains(&candidate.triangle) {
                                assert!(there >= wanted - 1e-11, "{there} {wanted}");
                                inside += 1;
                            } else {
                                assert!(there <= wanted + 1e-11, "{there} {wanted}");
                                outside += 1;
                            }
                        }
                    }
                }
            }
        }
        assert!(inside > 1000 && outside > 1000, "{inside} {outside}");
    }

    /// An L shape with more places than its twenty-odd triangles.
    fn fine_l_shape() -> RawMesh {
        let mut raw = solids::l_shape();
        for _ in 0..2 {
            raw.triangles = raw
                .triangles
                .clone()
                .into_iter()
                .flat_map(|[a, b, c]| {
                    let middle = |i: u32, j: u32, raw: &mut RawMesh| {
                        let (p, q) = (raw.vertices[i as usize], raw.vertices[j as usize]);
                        raw.vertices.push(nalgebra::center(&p, &q));
                        raw.vertices.len() as u32 - 1
                    };
                    let ab = middle(a, b, &mut raw);
                    let (bc, ca) = (middle(b, c, &mut raw), middle(c, a, &mut raw));
                    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
                })
                .collect();
        }
        raw
    }

    #[test]
    fn regions_shrink_as_more_is_to_be_kept_and_areas_add_up() {
        let mesh = prepared(solids::sphere(1.0, 10, 20));
        let (contact_model, space, m) = models()[2];
        let model = model(&mesh, contact_model, space);
        let (sites, margin) = drawn(&mesh, &model, m);
        let found = [0.01, 0.3, 0.7, 0.95].map(|f| regions(&mesh, &model, &sites, &margin, f));
        for pair in found.windows(2) {
            for (wide, narrow) in pair[0].iter().zip(&pair[1]) {
                assert!(narrow.triangles.iter().all(|t| wide.triangles.contains(t)));
                assert!(narrow.area <= wide.area && narrow.area > 0.0);
            }
        }
        for region in found.iter().flatten() {
            let patch = region.connected.unwrap();
            assert!((1..=region.triangles.len()).contains(&patch.triangles));
            assert!(patch.area <= region.area * (1.0 + 1e-12));
            let area: f64 = region.triangles.iter().map(|&t| mesh.area_of(t)).sum();
            assert_eq!(region.area, area);
        }
        // On so round a body a finger may be a little aside, and not everywhere.
        assert!(
            found[1]
                .iter()
                .all(|r| (3..390).contains(&r.triangles.len()))
        );
    }

    #[test]
    fn threads_and_free_contacts_change_nothing() {
        let mesh = prepared(solids::torus(2.0, 0.7, 16, 8));
        let (contact_model, space, m) = models()[2];
        let model = model(&mesh, contact_model, space);
        let (mut sites, margin) = drawn(&mesh, &model, m);
        let on = |threads, sites: &[Site]| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap()
                .install(|| regions(&mesh, &model, sites, &margin, 0.5))
        };
        let one = on(1, &sites);
        assert_eq!(one, on(3, &sites));
        sites[0].triangle = None;
        let free = on(2, &sites);
        assert_eq!(free[0].connected, None);
        assert_eq!(free[0].triangles, one[0].triangles);
        assert_eq!(free[1..], one[1..]);
    }

    #[test]
    fn where_the_others_hold_the_body_a_finger_may_be_anywhere() {
        let mesh = prepared(solids::torus(2.0, 0.7, 12, 8));
        let (contact_model, space, _) = models()[2];
        let model = model(&mesh, contact_model, space);
        let (mut sites, margin) = drawn(&mesh, &model, 4);
        sites.push(sites[0]);
        let found = regions(&mesh, &model, &sites, &margin, 1.0);
        assert_eq!(found[4].triangles.len(), mesh.candidates().len());
        assert_eq!(
            found[4].connected.unwrap().triangles,
            mesh.candidates().len()
        );
    }

    #[test]
    fn a_poll_that_breaks_ends_it() {
        let mesh = prepared(solids::torus(2.0, 0.7, 12, 8));
        let (contact_model, space, m) = models()[2];
        let model = model(&mesh, contact_model, space);
        let (sites, margin) = drawn(&mesh, &model, m);
        let stop = &mut || ControlFlow::Break(());
        let fraction = Fraction::new(0.5).unwrap();
        let places = Places::new(&mesh);
        let found = independent_regions(&places, &model, &sites, &margin, FLOOR, fraction, stop);
        assert_eq!(found, None);
    }

    #[test]
    fn every_number_is_visited_once() {
        for n in [0, 1, 2, 7, 100, 1001] {
            let mut visited = spread(n);
            visited.sort_unstable();
            assert!(visited.iter().copied().eq(0..n as u32));
        }
    }
}
