//! Candidates spread evenly over the surface, whatever its triangles are.
//!
//! More points than needed are drawn at random, in proportion to area, and the most crowded ones are taken away until
//! the right number is left: weighted sample elimination (Yuksel, "Sample elimination for generating Poisson disk sample
//! sets", Computer Graphics Forum 34, 2015).
//!
//! ```text
//! draw 5 points for each that is to stay, one in each of as many equal shares of the area
//! diameter = of the disks that would fill the area in the densest packing
//! weight of a point = sum over its neighbours within the diameter of (1 − distance / diameter)⁸
//! heap = all points by weight
//! while there are too many points:
//!     take the point with the greatest weight away
//!     lower the weights of its neighbours
//! ```
//!
//! The eighth power makes close neighbours count for almost everything. Below a certain distance all count alike, or the
//! first points to go would be those that happen to lie next to each other, wherever the crowd is. Only points whose
//! normals are less than a right angle apart are neighbours, so that the two faces of a thin plate do not thin out each
//! other.
//!
//! **Why an old heap entry does no harm:** weights only fall. An entry may stand too high, never too low; when it comes
//! to the top it is put back with the weight of now.
//!
//! **Why it ends:** an entry is put back only after its weight fell, and that happens at most once for each neighbour that
//! goes. **Cost:** O(n + k log k) for n triangles and k points: neighbours come from a grid whose cells are one diameter
//! wide, and at most [`NEIGHBOURS`] of at most [`LOOKED_AT`] points count, so that a crumpled surface cannot make it
//! quadratic. Order and ties depend on the seed alone, so the result is the same on any number of threads.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::Range;

use nalgebra::{Point3, UnitVector3};
use rayon::prelude::*;

use super::{Candidate, Mesh, triangle, weld};
use crate::interrupt::{Interrupt, Interrupted};
use crate::random::{Purpose, Stream};

/// Most candidates that are spread evenly; finer than a finger tip on any body, and a second of work.
pub const MAX_UNIFORM: usize = 200_000;

/// Points drawn for each that is kept. Yuksel has 5; more bring little.
const DRAWN: usize = 5;

/// Share of the greatest possible distance below which closer neighbours count no more, when almost all points
/// go (Yuksel 2015, section 4).
const CLOSEST: f64 = 0.65;

/// Most neighbours of a point that count: three times as many as a flat surface has. A crumpled one would
/// have any number.
const NEIGHBOURS: usize = 64;

/// Most points looked at for the neighbours of one.
const LOOKED_AT: usize = 1024;

/// Cells along one axis, at most; three of their numbers fit one key.
const CELLS: f64 = (1_u32 << 20) as f64;
const CELL_BITS: u32 = 21;

/// Points looked at or taken away between two checks of the interrupt.
const BLOCK: usize = 1 << 13;

impl Mesh {
    /// `count` candidates, spread evenly over what is exposed of the triangles that are not degenerate, with the normals of
    /// these triangles and in their order; at most [`MAX_UNIFORM`].
    ///
    /// The same mesh, count and seed give the same candidates on any number of threads. Runs on the current rayon pool;
    /// `interrupt` is checked every few milliseconds. O(n + k log k) for n triangles and k candidates: about 0.1 s for
    /// 20,000.
    ///
    /// ```
    /// use graspd_core::Interrupt;
    /// use graspd_core::mesh::{Mesh, solids};
    ///
    /// // Twelve triangles, and far more places for fingers.
    /// let mesh = Mesh::prepare(solids::cube(1.0))?;
    /// let candidates = mesh.uniform_candidates(600, 1, Interrupt::never())?;
    /// assert_eq!(candidates.len(), 600);
    /// let on_top = candidates.iter().filter(|c| c.position.z == 1.0).count();
    /// assert!(on_top.abs_diff(100) < 10);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn uniform_candidates(
        &self,
        count: usize,
        seed: u64,
        interrupt: Interrupt<'_>,
    ) -> Result<Vec<Candidate>, Interrupted> {
        let count = count.min(MAX_UNIFORM);
        interrupt.check()?;
        let (points, area) = self.random_points(count * DRAWN, seed);
        if count == 0 || points.is_empty() {
            return Ok(Vec::new());
        }
        // Twice the radius of disks that fill the plane in the densest packing.
        let diameter = 2.0 * (area / (2.0 * 3_f64.sqrt() * count as f64)).sqrt();
        let kept = eliminate(&points, count, diameter, interrupt)?;
        let kept = points.into_iter().zip(kept).filter(|(_, kept)| *kept);
        Ok(kept.map(|(point, _)| point).collect())
    }

    /// Draws `count` points, one in each of as many equal shares of the area; returns them and the area.
    fn random_points(&self, count: usize, seed: u64) -> (Vec<Candidate>, f64) {
        let usable: Vec<(usize, Option<u32>, f64)> = (0..self.triangles.len())
            .filter(|&index| {
                let corners = triangle::corners(&self.vertices, self.triangles[index]);
                !triangle::is_degenerate(&corners, self.tolerance)
            })
            .flat_map(|index| {
                let parts = self.cover.exposed_parts(index);
                parts.map(move |part| (index, part, triangle::area(&self.part(index, part))))
            })
            .collect();
        let area: f64 = usable.iter().map(|(_, _, area)| area).sum();
        let mut stream = Stream::new(seed, Purpose::Candidates, 0);
        let mut points = Vec::with_capacity(count);
        let (mut at, mut passed) = (0, 0.0);
        for share in 0..count {
            let wanted = (share as f64 + stream.unit()) / count as f64 * area;
            while at + 1 < usable.len() && passed + usable[at].2 <= wanted {
                passed += usable[at].2;
                at += 1;
            }
            // The square root makes the points of a triangle uniform: its part up to a share s of the height, seen
            // from a corner, has s² of the area.
            let (root, along) = (stream.unit().sqrt(), stream.unit());
            if let Some(&(index, part, _)) = usable.get(at) {
                let weights = [1.0 - root, root * (1.0 - along), root * along];
                let weights = self.cover.of_whole(part, weights);
                points.push(self.candidate_at(index, weights));
            }
        }
        (points, area)
    }

    /// The corners of a part of a triangle.
    pub(super) fn part(&self, index: usize, part: Option<u32>) -> [Point3<f64>; 3] {
        let [a, b, c] = triangle::corners(&self.vertices, self.triangles[index]);
        match part {
            None => [a, b, c],
            Some(_) => {
                let corners = self.cover.corners(part);
                corners.map(|weights| a + (b - a) * weights[1] + (c - a) * weights[2])
            }
        }
    }

    fn candidate_at(&self, index: usize, barycentric: [f64; 3]) -> Candidate {
        let corners = triangle::corners(&self.vertices, self.triangles[index]);
        let [a, b, c] = corners;
        Candidate {
            position: a + (b - a) * barycentric[1] + (c - a) * barycentric[2],
            normal: UnitVector3::new_normalize(-triangle::normal(&corners)),
            triangle: self.source[index],
            barycentric,
        }
    }
}

/// For each point whether it is among the `count` that stay.
fn eliminate(
    points: &[Candidate],
    count: usize,
    diameter: f64,
    interrupt: Interrupt<'_>,
) -> Result<Vec<bool>, Interrupted> {
    let share = count as f64 / points.len() as f64;
    let closest = diameter * (1.0 - share * share.sqrt()) * CLOSEST;
    let weight = |i: usize, j: u32| {
        let distance = (points[i].position - points[j as usize].position).norm();
        let nearness = 1.0 - distance.max(closest) / diameter;
        let fourth = (nearness * nearness) * (nearness * nearness);
        fourth * fourth
    };
    let grid = Grid::new(points, diameter);
    interrupt.check()?;
    let mut neighbours: Vec<Vec<u32>> = Vec::with_capacity(points.len());
    for begin in (0..points.len()).step_by(BLOCK) {
        let block = begin..points.len().min(begin + BLOCK);
        let found = block.into_par_iter().map(|i| grid.neighbours(points, i));
        neighbours.par_extend(found);
        interrupt.check()?;
    }
    let sum = |i: usize| neighbours[i].iter().map(|&j| weight(i, j)).sum();
    let mut weights: Vec<f64> = (0..points.len()).into_par_iter().map(sum).collect();
    let entries = weights.iter().enumerate();
    let mut heap: BinaryHeap<Crowded> = entries
        .map(|(point, &weight)| Crowded { weight, point })
        .collect();
    let mut kept = vec![true; points.len()];
    let mut surplus = points.len() - count;
    let mut steps = 0_usize;
    while surplus > 0
        && let Some(most) = heap.pop()
    {
        steps += 1;
        if steps.is_multiple_of(BLOCK) {
            interrupt.check()?;
        }
        let point = most.point;
        if most.weight > weights[point] {
            // Out of date: neighbours of it went in the meantime.
            heap.push(Crowded {
                weight: weights[point],
                point,
            });
            continue;
        }
        kept[point] = false;
        surplus -= 1;
        for &other in &neighbours[point] {
            weights[other as usize] -= weight(point, other);
        }
    }
    Ok(kept)
}

/// How crowded a point is; the most crowded one, and of equals the last, is the greatest.
struct Crowded {
    weight: f64,
    point: usize,
}

impl Ord for Crowded {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_weight = self.weight.total_cmp(&other.weight);
        by_weight.then(self.point.cmp(&other.point))
    }
}

impl PartialOrd for Crowded {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Crowded {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Crowded {}

/// Points sorted by the cell that they are in.
struct Grid {
    low: Point3<f64>,
    side: f64,
    radius: f64,
    cells: Vec<(u64, u32)>,
}

impl Grid {
    /// For neighbours within `radius`.
    fn new(points: &[Candidate], radius: f64) -> Self {
        let (low, high) = weld::bounds(points.iter().map(|point| point.position));
        let mut grid = Self {
            low,
            side: radius.max((high - low).amax() / CELLS),
            radius,
            cells: Vec::new(),
        };
        let key = |(i, point): (u32, &Candidate)| (grid.key(grid.cell(&point.position)), i);
        let mut cells: Vec<(u64, u32)> = (0..).zip(points).map(key).collect();
        cells.par_sort_unstable();
        grid.cells = cells;
        grid
    }

    /// Counted from 1, so that the first cell along an axis has one before it.
    fn cell(&self, position: &Point3<f64>) -> [u64; 3] {
        (position - self.low)
            .map(|x| (x / self.side) as u64 + 1)
            .into()
    }

    fn key(&self, [x, y, z]: [u64; 3]) -> u64 {
        z << (2 * CELL_BITS) | y << CELL_BITS | x
    }

    /// The points whose keys are in a range.
    fn within(&self, keys: Range<u64>) -> impl Iterator<Item = u32> {
        let begin = self.cells.partition_point(|(key, _)| *key < keys.start);
        let cells = self.cells[begin..].iter();
        cells
            .take_while(move |(key, _)| *key < keys.end)
            .map(|&(_, point)| point)
    }

    fn neighbours(&self, points: &[Candidate], of: usize) -> Vec<u32> {
        let Candidate {
            position, normal, ..
        } = &points[of];
        let [x, y, z] = self.cell(position);
        // Cells in a row along x have consecutive keys.
        let rows = (z - 1..=z + 1).flat_map(|z| (y - 1..=y + 1).map(move |y| (y, z)));
        let near =
            rows.flat_map(|(y, z)| self.within(self.key([x - 1, y, z])..self.key([x + 2, y, z])));
        let is_neighbour = |&other: &u32| {
            let there = &points[other as usize];
            other as usize != of
                && (there.position - position).norm() < self.radius
                && there.normal.dot(normal) > 0.0
        };
        near.take(LOOKED_AT)
            .filter(is_neighbour)
            .take(NEIGHBOURS)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{self, AtomicUsize};

    use super::*;
    use crate::interrupt::at_check;
    use crate::mesh::{RawMesh, solids};

    fn uniform(mesh: &Mesh, count: usize, seed: u64) -> Vec<Candidate> {
        mesh.uniform_candidates(count, seed, Interrupt::never())
            .unwrap()
    }

    fn bodies() -> [RawMesh; 4] {
        [
            solids::cube(1.0),
            solids::sphere(1.0, 9, 70),
            solids::torus(2.0, 0.7, 5, 60),
            solids::cuboid([0.0; 3], [1.0, 1.0, 1e-3]),
        ]
    }

    #[test]
    fn every_candidate_is_where_its_weights_say_and_points_into_the_body() {
        for raw in bodies() {
            let mesh = Mesh::prepare(raw).unwrap();
            let found = uniform(&mesh, 500, 3);
            assert_eq!(found.len(), 500);
            assert!(found.is_sorted_by_key(|candidate| candidate.triangle));
            for candidate in found {
                let place = mesh.source().binary_search(&candidate.triangle).unwrap();
                let corners = triangle::corners(mesh.vertices(), mesh.triangles()[place]);
                let weights = candidate.barycentric;
                assert!(weights.iter().all(|w| (0.0..=1.0).contains(w)));
                assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-15);
                let sum = corners
                    .iter()
                    .zip(weights)
                    .map(|(corner, w)| corner.coords * w);
                let at: nalgebra::Vector3<f64> = sum.sum();
                assert!((candidate.position.coords - at).norm() < 1e-14);
                let centroid = mesh.candidate_of(candidate.triangle).unwrap();
                assert_eq!(candidate.normal, centroid.normal);
            }
        }
    }

    #[test]
    fn candidates_keep_their_distance_and_leave_no_gap() {
        for raw in bodies() {
            let mesh = Mesh::prepare(raw).unwrap();
            let count = 600;
            let found = uniform(&mesh, count, 1);
            let disk = (mesh.report().area / (2.0 * 3_f64.sqrt() * count as f64)).sqrt();
            let alike = |a: &Candidate, b: &Candidate| a.normal.dot(&b.normal) > 0.0;
            let least = found.iter().enumerate().map(|(i, a)| {
                let others = found
                    .iter()
                    .enumerate()
                    .filter(|(j, b)| *j != i && alike(a, b));
                let distances = others.map(|(_, b)| (a.position - b.position).norm());
                distances.fold(f64::INFINITY, f64::min)
            });
            let least: Vec<f64> = least.collect();
            let closest = least.iter().copied().fold(f64::INFINITY, f64::min);
            // Random points come as close as a hundredth; Yuksel reports 0.7 and more of the packing's 2.
            assert!(closest > 1.0 * disk, "{} of a disk", closest / disk);
            // Every place of the surface has a candidate near: no hole wider than a few disks. The rim of the
            // plate is too narrow for any.
            let area = |place: &Candidate| {
                let index = mesh.source().binary_search(&place.triangle).unwrap();
                let corners = mesh.triangles()[index];
                triangle::area(&triangle::corners(mesh.vertices(), corners))
            };
            let wide = |place: &Candidate| area(place) > disk * disk;
            for place in uniform(&mesh, 4000, 9).into_iter().filter(wide) {
                let near = found.iter().filter(|c| alike(c, &place));
                let near = near.map(|c| (c.position - place.position).norm());
                let near = near.fold(f64::INFINITY, f64::min);
                assert!(near < 3.0 * disk, "{} disks", near / disk);
            }
        }
    }

    #[test]
    fn area_decides_how_many_a_part_of_the_surface_gets() {
        // Twelve thousand of 12,012 triangles are in a corner of a thousandth of the area.
        let dense = solids::moved(&solids::sphere(0.03, 60, 100), [5.0, 0.0, 0.0]);
        let mesh = Mesh::prepare(solids::join(&[solids::cube(1.0), dense])).unwrap();
        let found = uniform(&mesh, 2000, 5);
        let on_the_cube = found.iter().filter(|c| c.triangle < 12).count();
        let share = 6.0 / mesh.report().area;
        assert!((on_the_cube as f64 / 2000.0 - share).abs() < 0.002);
        let sides = (0..6).map(|side| found.iter().filter(|c| c.triangle / 2 == side).count());
        assert!(
            sides
                .into_iter()
                .all(|count| count.abs_diff(on_the_cube / 6) < 12)
        );
    }

    #[test]
    fn a_seed_gives_the_same_bytes_on_any_number_of_threads() {
        let mesh = Mesh::prepare(solids::torus(2.0, 0.7, 30, 20)).unwrap();
        let on = |threads: usize, seed| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap().install(|| uniform(&mesh, 3000, seed))
        };
        assert_eq!(on(1, 4), on(3, 4));
        assert_ne!(on(1, 4), on(1, 5));
    }

    #[test]
    fn it_can_be_broken_off() {
        let mesh = Mesh::prepare(solids::cube(1.0)).unwrap();
        let checks = AtomicUsize::new(0);
        let count = || {
            checks.fetch_add(1, atomic::Ordering::Relaxed);
            None
        };
        let whole = mesh.uniform_candidates(20_000, 1, Interrupt::new(&count));
        assert!(whole.is_ok());
        let whole = checks.into_inner();
        assert!(whole > 20, "{whole}");
        for stop in [1, 2, whole / 2, whole] {
            let ask = at_check(stop);
            let found = mesh.uniform_candidates(20_000, 1, Interrupt::new(&ask));
            assert_eq!(found, Err(Interrupted::Cancelled));
        }
    }
}
