//! How far a grasp reaches along a direction, and how that changes when its contacts move.
//!
//! The support h(u) of a wrench space is its greatest reach along a unit direction u, and ε is the least support over
//! all u. A cut is a local minimum of the support, such as a facet of a polytope: near it ε is bounded by its height.
//!
//! At a local minimum the point h(u)·u is a convex combination of support points pᵢ. By the envelope theorem the minimum
//! changes with the contacts' positions as the same combination of the u·pᵢ does, with u and the weights held. So one
//! small quadratic program gives the gradient in all positions at once.
//!
//! ```text
//! cut(u)
//!     three times
//!         points ← support points around u, weights ← the combination that lies best on u
//!         turn u against the imbalance of the combination
//!     height ← h(u), gradient ← Σ weight · change of u·p with the position
//! ```
//!
//! It ends after [`PASSES`] passes with at most [`MAX_POINTS`] points each. The height is the support along the final u
//! whatever the passes found, so a cut that has not converged is still a bound on ε, only a weaker one.

use nalgebra::{DMatrix, Vector3};

use super::program::minimize;
use crate::contact::Contact;
use crate::wrench::{Wrench, WrenchModel, WrenchSpace};

/// Support points that a combination is made of; six suffice.
const MAX_POINTS: usize = 24;

/// Passes that move a direction to the next local minimum.
const PASSES: usize = 3;

/// Support points that reach no farther than this beyond the others, over the longest, add nothing.
const NOVELTY: f64 = 1e-9;

/// Ratio of the tangential part of a lever arm to its length below which the edges of a cone do not
/// turn with it.
const LEVER_TOLERANCE: f64 = 1e-9;

/// The support function of the wrench space of a grasp.
pub(super) struct GraspSupport<'a> {
    model: &'a WrenchModel,
    contacts: &'a [Contact],
    /// Columns of each contact: its wrenches, or the slice of a round cone.
    columns: Vec<Wrench>,
    width: usize,
}

/// A support point: the wrenches of the contacts that it is the sum of.
struct Support {
    point: Wrench,
    parts: Vec<(usize, Wrench)>,
}

/// A direction along which little can be exerted, at a local minimum of the support.
#[derive(Debug, Clone)]
pub(super) struct Cut {
    pub direction: Wrench,
    /// The support along it, at least ε.
    pub height: f64,
    /// Change of the height with the position of each contact, per length.
    pub gradient: Vec<Vector3<f64>>,
}

impl<'a> GraspSupport<'a> {
    pub fn new(model: &'a WrenchModel, contacts: &'a [Contact]) -> Self {
        let mut columns = Vec::new();
        for contact in contacts {
            push_columns(model, contact, &mut columns);
        }
        let width = columns.len() / contacts.len().max(1);
        Self {
            model,
            contacts,
            columns,
            width,
        }
    }

    /// Returns the support along a direction.
    pub fn height(&self, direction: &Wrench) -> f64 {
        self.support(direction).point.dot(direction)
    }

    /// Returns for each contact the support of the others along a direction.
    pub fn without_each(&self, direction: &Wrench) -> Vec<f64> {
        let n = self.contacts.len();
        let heights: Vec<f64> = (0..n)
            .map(|contact| farthest(self.model, self.of(contact), direction).0)
            .collect();
        let others = |contact: usize| (0..n).filter(move |&other| other != contact);
        (0..n)
            .map(|contact| match self.model.space {
                WrenchSpace::L1 => others(contact)
                    .map(|other| heights[other])
                    .fold(f64::NEG_INFINITY, f64::max),
                WrenchSpace::Linf => others(contact).map(|other| heights[other].max(0.0)).sum(),
            })
            .collect()
    }

    /// Returns the support along a direction of a space whose support is `height` and one more contact.
    pub fn with_another(&self, height: f64, columns: &[Wrench], direction: &Wrench) -> f64 {
        let (own, _) = farthest(self.model, columns, direction);
        match self.model.space {
            WrenchSpace::L1 => height.max(own),
            WrenchSpace::Linf => height + own.max(0.0),
        }
    }

    /// Returns a local minimum of the support near a unit direction.
    ///
    /// `reach` is the weight ρ of the imbalance of support points against their depth below the plane: the
    /// direction turns by about so much, over the length of a wrench, in one pass. It should be what
    /// contacts have moved since the direction was weakest: less misses a facet that has turned with
    /// them, more runs down a round space to where another cut already is.
    pub fn cut(&self, from: &Wrench, reach: f64) -> Cut {
        let mut direction = *from;
        let mut points = vec![self.support(&direction)];
        let mut weights = vec![1.0];
        for _ in 0..PASSES {
            let turn = self.balance(&direction, reach, &mut points, &mut weights);
            if turn.norm() <= NOVELTY {
                break;
            }
            direction = (direction + turn).normalize();
        }
        let mut gradient = vec![Vector3::zeros(); self.contacts.len()];
        for (support, weight) in points.iter().zip(&weights) {
            for (contact, wrench) in &support.parts {
                gradient[*contact] += self.slope(*contact, wrench, &direction) * *weight;
            }
        }
        Cut {
            direction,
            height: self.height(&direction),
            gradient,
        }
    }

    /// Collects support points until a combination of them lies on the direction as well as can be. Returns
    /// the turn of the direction that lowers the support, less its square over 2ρ, most.
    fn balance(
        &self,
        direction: &Wrench,
        reach: f64,
        points: &mut Vec<Support>,
        weights: &mut Vec<f64>,
    ) -> Wrench {
        let mut turn = Wrench::zeros();
        while points.len() <= MAX_POINTS {
            let heights: Vec<f64> = points.iter().map(|p| p.point.dot(direction)).collect();
            let highest = heights.iter().fold(f64::NEG_INFINITY, |m, h| m.max(*h));
            let costs: Vec<f64> = heights.iter().map(|height| highest - height).collect();
            let aside: Vec<Wrench> = points
                .iter()
                .zip(&heights)
                .map(|(p, height)| p.point - direction * *height)
                .collect();
            let n = points.len();
            let products = DMatrix::from_fn(n, n, |i, j| reach * aside[i].dot(&aside[j]));
            minimize(&products, &costs, n, weights);
            let imbalance: Wrench = aside.iter().zip(&*weights).map(|(a, w)| a * *w).sum();
            turn = imbalance * -reach;
            let turned = direction + turn;
            let known = points
                .iter()
                .map(|p| p.point.dot(&turned))
                .fold(f64::NEG_INFINITY, f64::max);
            let next = self.support(&turned);
            let height = next.point.dot(&turned);
            // A point that reaches no farther along the turned direction than the known ones adds nothing.
            let novel = height > known + NOVELTY * next.point.norm();
            if !novel || n == MAX_POINTS {
                break;
            }
            points.push(next);
        }
        turn
    }

    fn of(&self, contact: usize) -> &[Wrench] {
        &self.columns[contact * self.width..(contact + 1) * self.width]
    }

    fn support(&self, direction: &Wrench) -> Support {
        let heights = (0..self.contacts.len())
            .map(|contact| (contact, farthest(self.model, self.of(contact), direction)));
        match self.model.space {
            WrenchSpace::L1 => {
                let best = heights.reduce(|a, b| if b.1.0 > a.1.0 { b } else { a });
                let parts: Vec<_> = best.into_iter().map(|(i, (_, w))| (i, w)).collect();
                Support {
                    point: parts.iter().map(|(_, w)| w).sum(),
                    parts,
                }
            }
            WrenchSpace::Linf => {
                let parts: Vec<_> = heights
                    .filter(|(_, (height, _))| *height > 0.0)
                    .map(|(i, (_, w))| (i, w))
                    .collect();
                Support {
                    point: parts.iter().map(|(_, w)| w).sum(),
                    parts,
                }
            }
        }
    }

    /// Returns the change of the component of a contact's wrench along a direction with the contact's position.
    fn slope(&self, contact: usize, wrench: &Wrench, direction: &Wrench) -> Vector3<f64> {
        let at = &self.contacts[contact];
        let force = wrench.fixed_rows::<3>(0).into_owned();
        let push = direction.fixed_rows::<3>(0).into_owned();
        let twist = direction.fixed_rows::<3>(3) * self.model.torque_scale;
        let lever = at.position - self.model.center;
        let mut slope = force.cross(&twist);
        // The first edge points along the tangential part of the lever arm, so all turn with it.
        let (t1, t2) = self.model.tangents(at);
        let arm = lever.dot(&t1);
        if arm > LEVER_TOLERANCE * lever.norm() {
            let turned = at.normal.cross(&force);
            slope += t2 * (turned.dot(&(push + twist.cross(&lever))) / arm);
        }
        slope - at.normal.into_inner() * slope.dot(&at.normal)
    }
}

/// Appends the generators of the wrenches of a contact: all wrenches, or the slice of a round cone.
pub(super) fn push_columns(model: &WrenchModel, contact: &Contact, columns: &mut Vec<Wrench>) {
    if model.contact_model.is_round() {
        model.push_slice(contact, columns);
    } else {
        model.push_wrenches(contact, columns);
    }
}

/// Returns how far the wrenches of a contact reach along a direction, and the wrench that reaches farthest.
fn farthest(model: &WrenchModel, columns: &[Wrench], direction: &Wrench) -> (f64, Wrench) {
    if !model.contact_model.is_round() {
        let mut best = (f64::NEG_INFINITY, Wrench::zeros());
        for wrench in columns {
            let height = wrench.dot(direction);
            if height > best.0 {
                best = (height, *wrench);
            }
        }
        return best;
    }
    let Some((center, axes)) = columns.split_first() else {
        return (f64::NEG_INFINITY, Wrench::zeros());
    };
    let mut across = Wrench::zeros();
    let mut square = 0.0;
    for axis in axes {
        let slope = axis.dot(direction);
        across += axis * slope;
        square += slope * slope;
    }
    let length = f64::sqrt(square);
    let wrench = if length > 0.0 {
        center + across / length
    } else {
        *center
    };
    (center.dot(direction) + length, wrench)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Unit};
    use rand::{Rng, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::contact::{Cone, ConeEdges, ContactModel, Friction, Torsion};
    use crate::quality::Evaluator;
    use crate::wrench::EdgeNorm;

    fn vector(rng: &mut Pcg64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| (rng.next_u64() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0)
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

    /// By differences of ε itself, wherever it has a derivative.
    #[test]
    fn the_gradient_is_that_of_epsilon_in_every_model() {
        let friction = Friction::new(0.5).unwrap();
        let pyramid = Cone::Pyramid(ConeEdges::new(8).unwrap());
        let hard = |cone| ContactModel::Hard { friction, cone };
        let soft = |cone| ContactModel::Soft {
            friction,
            torsion: Torsion::new(0.2).unwrap(),
            cone,
        };
        let (l1, linf) = (WrenchSpace::L1, WrenchSpace::Linf);
        let mut evaluator = Evaluator::new();
        for (contact_model, space, m) in [
            (ContactModel::Frictionless, l1, 9),
            (hard(pyramid), l1, 4),
            (soft(pyramid), l1, 4),
            (hard(Cone::Round), l1, 4),
            (hard(pyramid), linf, 3),
            (hard(Cone::Round), linf, 4),
        ] {
            let model = WrenchModel {
                contact_model,
                edge_norm: EdgeNorm::UnitEdge,
                space,
                center: Point3::new(0.05, 0.0, -0.05),
                torque_scale: 0.8,
            };
            let mut rng = Pcg64::seed_from_u64(1);
            let (mut smooth, mut kinks) = (0, 0);
            for _ in 0..400 {
                let contacts = grasp(&mut rng, m);
                let mut epsilon = |contacts: &[Contact]| {
                    let margin = evaluator.grasp_quality(&model, contacts, 1e-8);
                    margin
                        .ok()
                        .filter(|margin| margin.value > 1e-3 && margin.exact)
                };
                let Some(margin) = epsilon(&contacts) else {
                    continue;
                };
                let cut = GraspSupport::new(&model, &contacts).cut(&margin.direction, 1e-3);
                assert!(
                    (cut.height - margin.value).abs() < 1e-7,
                    "{contact_model:?} {space:?}: {}, but {margin:?}",
                    cut.height
                );
                let steps: Vec<Vector3<f64>> = contacts
                    .iter()
                    .map(|contact| contact.normal.cross(&vector(&mut rng)))
                    .collect();
                let mut moved = |length: f64| {
                    let pairs = contacts.iter().zip(&steps);
                    let there: Vec<Contact> = pairs
                        .map(|(contact, step)| Contact {
                            position: contact.position + step * length,
                            normal: contact.normal,
                        })
                        .collect();
                    epsilon(&there).map(|margin| (margin.value - cut.height) / length)
                };
                let (Some(ahead), Some(behind)) = (moved(1e-4), moved(-1e-4)) else {
                    continue;
                };
                if (ahead - behind).abs() > 1e-2 * ahead.abs().max(behind.abs()) {
                    kinks += 1;
                    continue;
                }
                smooth += 1;
                let slope: f64 = cut.gradient.iter().zip(&steps).map(|(g, s)| g.dot(s)).sum();
                let middle = 0.5 * (ahead + behind);
                assert!(
                    (slope - middle).abs() < 1e-2 * middle.abs() + 1e-3,
                    "{contact_model:?} {space:?}: {slope}, but {behind} and {ahead}"
                );
                if smooth == 12 {
                    break;
                }
            }
            assert!(
                smooth >= 6 && kinks <= smooth,
                "{contact_model:?}: {smooth} {kinks}"
            );
        }
    }
}
