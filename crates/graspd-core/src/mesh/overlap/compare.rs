//! Compares the closed parts of a surface, and finds the boundary of their union.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use super::meeting::{self, Meeting};
use super::nesting::Said;
use super::regions::{self, Extent, NONE, Region, Regions};
use super::shells::Shells;
use super::{neighbours, nesting, reach};
use crate::mesh::cover::{Cover, Piece, State};
use crate::mesh::parts::Part;
use crate::mesh::tree::{Bounds, Tree};
use crate::mesh::triangle;

/// Most pairs of triangles that meet; some seconds of work, and more than two meshes of a million triangles have.
const MAX_MEETINGS: usize = 1 << 22;

/// What comparing the parts came to.
pub(in crate::mesh) enum Outcome {
    /// No two parts come near each other, and none crosses itself.
    Apart,
    /// There are too many to compare.
    TooMany,
    Found(Overlap),
}

/// Parts that were compared.
pub(in crate::mesh) struct Overlap {
    found: Regions,
    /// Of each region.
    states: Vec<State>,
    /// For each part whether it bounds a void.
    pub(in crate::mesh) voids: Vec<bool>,
    /// For each part whether it has matter in common with another.
    pub(in crate::mesh) overlapping: Vec<bool>,
    /// Pairs of parts that touch, cross or nest.
    pub(in crate::mesh) joined: Vec<[u32; 2]>,
    part_of: Vec<u32>,
}

/// The volume within the boundary and its moments, about a reference point in units of a length.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::mesh) struct Moments {
    pub(in crate::mesh) volume: f64,
    pub(in crate::mesh) moment: Vector3<f64>,
    /// The volume as the flux of x, y and z through the boundary.
    pub(in crate::mesh) flux: Vector3<f64>,
    /// How much of the volume may be wrong.
    pub(in crate::mesh) uncertain: f64,
}

/// Compares the closed parts of a surface, each wound outward; `crosses_itself` and `said` have an entry for each part.
pub(in crate::mesh) fn compare(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    parts: &[Part],
    crosses_itself: Vec<bool>,
    said: &[Said],
    reference: &Point3<f64>,
    tolerance: f64,
) -> Outcome {
    let closed = |n: &usize| parts[*n].closed;
    if (0..parts.len()).filter(closed).count() < 2 && !crosses_itself.contains(&true) {
        return Outcome::Apart;
    }
    let bounds = |part: &Part| {
        let corners = part
            .triangles
            .iter()
            .map(|&n| Bounds::of(&triangle::corners(vertices, triangles[n as usize])));
        let bounds = corners.fold(Bounds::empty(), |all, corners| all.joined(&corners));
        bounds.inflated(tolerance)
    };
    let numbers: Vec<usize> = (0..parts.len()).filter(closed).collect();
    let boxes: Vec<Bounds> = numbers.par_iter().map(|&n| bounds(&parts[n])).collect();
    let Some(pairs) = neighbours::pairs(&boxes) else {
        return Outcome::TooMany;
    };
    if pairs.is_empty() && !crosses_itself.contains(&true) {
        return Outcome::Apart;
    }
    let mut neighbours = vec![Vec::new(); parts.len()];
    for [a, b] in pairs.iter().map(|pair| pair.map(|n| numbers[n as usize])) {
        neighbours[a].push(b as u32);
        neighbours[b].push(a as u32);
    }
    neighbours.iter_mut().for_each(|list| list.sort_unstable());
    let mut part_of = vec![NONE; triangles.len()];
    for (n, part) in (0..).zip(parts) {
        part.triangles
            .iter()
            .for_each(|&number| part_of[number as usize] = n);
    }
    let trees = (0..parts.len()).into_par_iter().map(|n| {
        let involved = crosses_itself[n] || !neighbours[n].is_empty();
        involved.then(|| Tree::new(vertices, triangles, &parts[n].triangles))
    });
    let shells = Shells {
        vertices,
        triangles,
        parts,
        part_of,
        trees: trees.collect(),
        neighbours,
        crosses_itself,
        tolerance,
    };
    let Some(meetings) = meetings(&shells) else {
        return Outcome::TooMany;
    };
    Outcome::Found(examine(shells, &meetings, said, reference))
}

/// Where two triangles of different parts, or of one that crosses itself, meet.
type Met = ([u32; 2], Meeting);

/// Every meeting once, the triangle of the lesser part first; `None` when there are too many.
fn meetings(shells: &Shells<'_>) -> Option<Vec<Met>> {
    let mut all: Vec<Met> = Vec::new();
    let parts = 0..shells.parts.len() as u32;
    let pairs = parts.flat_map(|a| {
        let own = shells.crosses_itself[a as usize].then_some(a);
        let others = shells.neighbours[a as usize].iter().copied();
        own.into_iter()
            .chain(others.filter(move |&b| b > a))
            .map(move |b| (a, b))
    });
    for (a, b) in pairs {
        let trees = [a, b].map(|part| shells.trees[part as usize].as_ref());
        let [Some(one), Some(other)] = trees else {
            continue;
        };
        let zone = one.bounds().inflated(shells.tolerance);
        let zone = zone.common(&other.bounds().inflated(shells.tolerance));
        let mut near = Vec::new();
        one.near(&zone, |number, _| near.push(number));
        let found: Vec<Met> = near
            .par_iter()
            .filter(|&&number| shells.is_usable(number))
            .flat_map_iter(|&number| {
                let corners = shells.corners(number);
                let bounds = Bounds::of(&corners).inflated(shells.tolerance);
                let mut found = Vec::new();
                other.near(&bounds, |there, opposite| {
                    if shells.is_usable(there)
                        && let Some(met) = match a == b {
                            false => meeting::meeting(
                                &corners,
                                opposite,
                                shells.tolerance,
                                shells.tolerance,
                            ),
                            true if there <= number => None,
                            true => shells.own_meeting([number, there]),
                        }
                    {
                        found.push(([number, there], met));
                    }
                });
                found
            })
            .collect();
        all.extend(found);
        if all.len() > MAX_MEETINGS {
            return None;
        }
    }
    Some(all)
}

fn examine(
    shells: Shells<'_>,
    meetings: &[Met],
    said: &[Said],
    reference: &Point3<f64>,
) -> Overlap {
    let mut met: Vec<(u32, Option<[Point3<f64>; 2]>)> = Vec::new();
    for (pair, meeting) in meetings {
        let [one, other] = *pair;
        match meeting {
            Meeting::Stretch(stretch) => {
                met.extend([(one, Some(*stretch)), (other, Some(*stretch))]);
            }
            Meeting::Plane => {
                // Each is cut along the sides of the other.
                for (number, there) in [(one, other), (other, one)] {
                    let [a, b, c] = shells.corners(there);
                    met.extend([[a, b], [b, c], [c, a]].map(|side| (number, Some(side))));
                }
            }
        }
    }
    met.sort_by_key(|(number, _)| *number);
    let found = regions::regions(&shells, &met, reference);
    let containers = nesting::containers(&found.regions, said);
    let voids = nesting::voids(&containers, said);
    let flush = Flush::new(&shells, meetings, &voids);
    let mut overlapping = vec![false; shells.parts.len()];
    let sign = |part: u32| if voids[part as usize] { -1 } else { 1 };
    let mut states: Vec<State> = Vec::with_capacity(found.regions.len());
    for region in &found.regions {
        let all = || region.around.iter().chain([&region.own]);
        let above: i32 = all().map(|a| sign(a.part) * a.above).sum();
        let below: i32 = all().map(|a| sign(a.part) * a.below).sum();
        let (outer, inner) = match voids[region.part as usize] {
            true => (below, above),
            false => (above, below),
        };
        if above.max(below) >= 2 {
            overlapping[region.part as usize] = true;
            for around in region.around.iter().filter(|a| a.above.max(a.below) >= 1) {
                overlapping[around.part as usize] |= !voids[around.part as usize];
            }
        }
        let repeated = flush.is_repeated(region, &shells);
        states.push(match outer <= 0 && inner >= 1 && !repeated {
            true => State::Exposed,
            false => State::Buried,
        });
    }
    reach::mark_enclosed(&found, &shells, &voids, !met.is_empty(), &mut states);
    let part = |number: u32| shells.part_of[number as usize];
    let touching = meetings.iter().map(|(pair, _)| pair.map(part));
    let nested = (0..).zip(&containers);
    let nested = nested.flat_map(|(n, all)| all.iter().map(move |&outer| [n, outer]));
    let mut joined: Vec<[u32; 2]> = touching.chain(nested).filter(|[a, b]| a != b).collect();
    joined.sort_unstable();
    joined.dedup();
    Overlap {
        found,
        states,
        voids,
        overlapping,
        joined,
        part_of: shells.part_of,
    }
}

/// Faces that lie on each other and face the same way, such as the tops of two blocks of one height that overlap. They
/// are one piece of the boundary, so only one of them counts.
struct Flush {
    /// Triangles with others that lie in their plane, face the same way and come before them; ascending.
    after: Vec<[u32; 2]>,
}

impl Flush {
    fn new(shells: &Shells<'_>, meetings: &[Met], voids: &[bool]) -> Self {
        // The larger triangle comes first, then what is lower; neither depends on the order of the file.
        let rank = |number: u32| {
            let corners = shells.corners(number);
            let at = triangle::centroid(&corners);
            [-triangle::area(&corners), at.x, at.y, at.z]
        };
        let is_void = |number: u32| voids[shells.part_of[number as usize] as usize];
        let mut after = Vec::new();
        for ([one, other], _) in meetings.iter().filter(|(_, met)| *met == Meeting::Plane) {
            let [a, b] = [*one, *other].map(|number| triangle::normal(&shells.corners(number)));
            if a.dot(&b) > 0.0 && is_void(*one) == is_void(*other) {
                let is_first = rank(*one) < rank(*other);
                after.push(if is_first {
                    [*other, *one]
                } else {
                    [*one, *other]
                });
            }
        }
        after.sort_unstable();
        Self { after }
    }

    /// Whether a region lies on one of a triangle that comes before its own.
    fn is_repeated(&self, region: &Region, shells: &Shells<'_>) -> bool {
        let number = region.triangle();
        let begin = self.after.partition_point(|[n, _]| *n < number);
        let others = self.after[begin..].iter().take_while(|[n, _]| *n == number);
        let (point, _) = region.point(shells);
        others.into_iter().any(|[_, other]| {
            let weights = triangle::raw_barycentric(&shells.corners(*other), &point);
            weights.iter().all(|weight| *weight >= 0.0)
        })
    }
}

impl Overlap {
    /// Adds up what is within the boundary. `triangles` are those that were compared.
    pub(in crate::mesh) fn moments(
        &self,
        vertices: &[Point3<f64>],
        triangles: &[[u32; 3]],
        reference: &Point3<f64>,
        unit: f64,
    ) -> Moments {
        let mut sum = Moments {
            uncertain: self.found.uncertain / (3.0 * unit.powi(3)),
            ..Moments::default()
        };
        let local = |point: Point3<f64>| (point - reference) / unit;
        let is_boundary = |region: usize| self.states[region] != State::Buried;
        let sign = |part: u32| if self.voids[part as usize] { -1.0 } else { 1.0 };
        for (number, &corners) in triangles.iter().enumerate() {
            let region = self.found.first[number];
            let whole = region == NONE
                || matches!(
                    &self.found.regions[region as usize].extent,
                    Extent::Patch(_)
                ) && is_boundary(region as usize);
            if whole {
                let corners = triangle::corners(vertices, corners).map(local);
                sum.add(&corners, sign(self.part_of[number]));
            }
        }
        for (n, region) in self.found.regions.iter().enumerate() {
            if let Extent::Piece { polygon, plane, .. } = &region.extent
                && is_boundary(n)
            {
                let corner = |n: usize| local(plane.point(&polygon[n]));
                for next in 2..polygon.len() {
                    sum.add(
                        &[corner(0), corner(next - 1), corner(next)],
                        sign(region.part),
                    );
                }
            }
        }
        sum
    }

    /// What of the first `count` triangles is exposed, buried and enclosed.
    pub(in crate::mesh) fn cover(
        &self,
        vertices: &[Point3<f64>],
        triangles: &[[u32; 3]],
        count: usize,
    ) -> Cover {
        let mut cover = Cover::exposed(count);
        for number in 0..count {
            let region = self.found.first[number];
            if region != NONE
                && let Extent::Patch(_) = self.found.regions[region as usize].extent
            {
                cover.set(number, self.states[region as usize]);
            }
        }
        let mut pieces = Vec::new();
        for (region, state) in self.found.regions.iter().zip(&self.states) {
            let Extent::Piece {
                triangle: number,
                polygon,
                plane,
            } = &region.extent
            else {
                continue;
            };
            if *number as usize >= count {
                continue;
            }
            let corners = triangle::corners(vertices, triangles[*number as usize]);
            let weights = |n: usize| triangle::barycentric(&corners, &plane.point(&polygon[n]));
            for next in 2..polygon.len() {
                pieces.push(Piece {
                    triangle: *number,
                    corners: [weights(0), weights(next - 1), weights(next)],
                    state: *state,
                });
            }
        }
        cover.cut(pieces);
        cover
    }
}

impl Moments {
    fn add(&mut self, [a, b, c]: &[Vector3<f64>; 3], sign: f64) {
        let normal = (b - a).cross(&(c - a)) * sign;
        let volume = a.dot(&normal) / 6.0;
        let sum = a + b + c;
        self.volume += volume;
        self.moment += sum * (volume / 4.0);
        self.flux += sum.component_mul(&normal) / 6.0;
    }
}
