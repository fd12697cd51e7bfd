//! A growing polytope for sets that rounding folds in `polytope.rs`.
//!
//! # Idea
//!
//! Regular grasps have many wrenches in one flat but for rounding. Facets of such wrenches are slivers: their six vertices
//! lie within 10⁻¹² of a flat of four dimensions, and doubles do not determine their planes. Two things together remove
//! the case:
//!
//! ```text
//! every vertex is moved by a random 2⁻⁴⁵ of the scale        so no seven lie in one plane, and no six in one ridge
//! every plane is solved from its vertices with 106 bits       so every sign below is that of the moved vertices
//! ```
//!
//! A set moved by t has an ε within t of the set's own, because every support value has. The move is a twentieth of
//! [`COPLANAR_TOLERANCE`](super::COPLANAR_TOLERANCE), so the answer is as good as that of `polytope.rs`.
//!
//! # Invariant
//!
//! The surface is the boundary of the convex hull of the moved vertices; the centre of the first simplex is strictly
//! inside. A moved vertex is at least some 10⁻¹⁷ from any plane that it is not on, the planes are exact to some 10⁻¹⁸ for
//! slivers as thin as 10⁻¹⁴, and the signs of distances of more than [`CLEAR`] are taken from doubles.
//!
//! # Cost
//!
//! Some 3 µs a facet, ten to twenty times the cost of `polytope.rs`. The facet limit bounds the work.

use std::collections::HashMap;

use foldhash::fast::FixedState;
use nalgebra::Matrix6;

use super::growth::{Growing, Nearest, Unfinished};
use super::lanes::Lanes;
use super::pairing::name;
use super::twofold::Twofold;
use crate::wrench::Wrench;

/// How far each component of a vertex is moved at most, over the scale.
const MOVE: f64 = 1.0 / (1_u64 << 45) as f64;

/// Signed distances of more than this, over the scale, have the right sign in doubles: the plane is rounded to
/// doubles once, the product of seven terms carries a few units of 2⁻⁵² more, and the vertex is looked at before its
/// move, of √6 times [`MOVE`] at most.
const CLEAR: f64 = 2e-13;

/// Neighbour of a facet that is not known yet.
const NONE: u32 = u32::MAX;

type Point = [Twofold; 6];

#[derive(Debug, Clone, Copy)]
struct Facet {
    vertices: [u32; 6],
    /// Across from the vertex in the same slot.
    neighbors: [u32; 6],
    /// n·x = offset, n not a unit vector.
    normal: Point,
    offset: Twofold,
    /// The plane in doubles: the outward unit normal and minus the offset.
    plane: Lanes,
    /// Replaced by others, and no part of the surface any more.
    replaced: bool,
    /// Returned to the caller.
    taken: bool,
}

/// The polytope; see the module. The memory is kept from one set to the next.
#[derive(Debug, Default)]
pub(super) struct PrecisePolytope {
    facets: Vec<Facet>,
    vertices: Vec<Point>,
    /// The centre of the first simplex.
    center: Point,
    scale: f64,
    facet_limit: usize,
    sides: HashMap<[u32; 5], (u32, usize), FixedState>,
    beyond: Vec<bool>,
}

impl PrecisePolytope {
    /// Adds a vertex, moved a little, and returns its number.
    fn push(&mut self, point: &Lanes) -> u32 {
        let number = self.vertices.len() as u32;
        self.vertices.push(std::array::from_fn(|axis| {
            let random = name(number * 8 + axis as u32) >> 11;
            let share = random as f64 / (1_u64 << 52) as f64 - 1.0;
            Twofold::sum(point.0[axis], share * MOVE * self.scale)
        }));
        number
    }

    /// The facet of six vertices, with the centre on its inner side.
    fn facet(&self, vertices: [u32; 6]) -> Result<Facet, Unfinished> {
        let points = vertices.map(|vertex| self.vertices[vertex as usize]);
        let mut normal = kernel(&points).ok_or(Unfinished::Folded)?;
        let mut offset = dot(&normal, &points[0]);
        if (dot(&normal, &self.center) - offset).value() > 0.0 {
            normal = normal.map(|x| -x);
            offset = -offset;
        }
        let length = normal.iter().map(|x| x.value().powi(2)).sum::<f64>().sqrt();
        let unit = Wrench::from_fn(|axis, _| normal[axis].value() / length);
        let plane = Lanes::of(&unit, -offset.value() / length);
        if !plane.0.iter().all(|x| x.is_finite()) {
            return Err(Unfinished::Folded);
        }
        Ok(Facet {
            vertices,
            neighbors: [NONE; 6],
            normal,
            offset,
            plane,
            replaced: false,
            taken: false,
        })
    }

    fn is_beyond(&self, facet: &Facet, rounded: &Lanes, vertex: u32) -> bool {
        let distance = facet.plane.dot(rounded);
        if distance.abs() > CLEAR * self.scale {
            return distance > 0.0;
        }
        let point = &self.vertices[vertex as usize];
        (dot(&facet.normal, point) - facet.offset).value() > 0.0
    }

    /// Makes the facets from number `first` on neighbours of each other, where they share a ridge that has no neighbour yet.
    fn join(&mut self, first: usize) {
        self.sides.clear();
        for number in first..self.facets.len() {
            for slot in 0..6 {
                if self.facets[number].neighbors[slot] != NONE {
                    continue;
                }
                let vertices = self.facets[number].vertices;
                let mut ridge = std::array::from_fn(|i| vertices[i + usize::from(i >= slot)]);
                ridge.sort_unstable();
                match self.sides.remove(&ridge) {
                    Some((other, across)) => {
                        self.facets[number].neighbors[slot] = other;
                        self.facets[other as usize].neighbors[across] = number as u32;
                    }
                    None => {
                        self.sides.insert(ridge, (number as u32, slot));
                    }
                }
            }
        }
    }

    fn take(&mut self, number: usize) -> Nearest {
        let facet = &mut self.facets[number];
        facet.taken = true;
        let mut normal = facet.plane;
        normal.0[6] = 0.0;
        Nearest {
            normal,
            offset: -facet.plane.0[6],
        }
    }
}

impl Growing for PrecisePolytope {
    fn start(
        &mut self,
        corners: &[Lanes; 7],
        _planes: &[Lanes; 7],
        tolerance: f64,
        facet_limit: usize,
    ) {
        self.facets.clear();
        self.vertices.clear();
        self.facet_limit = facet_limit;
        self.scale = tolerance / super::COPLANAR_TOLERANCE;
        for corner in corners {
            self.push(corner);
        }
        let seventh = Twofold::from(1.0).over(Twofold::from(7.0));
        self.center = std::array::from_fn(|axis| {
            let sum = self.vertices.iter().map(|v| v[axis]);
            sum.fold(Twofold::ZERO, |sum, x| sum + x) * seventh
        });
        for opposite in 0..7_u32 {
            let vertices = std::array::from_fn(|i| i as u32 + u32::from(i as u32 >= opposite));
            // A simplex without a plane has no facets, and whoever asks for the nearest finds none.
            if let Ok(facet) = self.facet(vertices) {
                self.facets.push(facet);
            }
        }
        self.join(0);
    }

    fn nearest(&mut self) -> Option<Nearest> {
        let mut found = None;
        let mut least = f64::INFINITY;
        for (number, facet) in self.facets.iter().enumerate() {
            let offset = -facet.plane.0[6];
            if !facet.replaced && !facet.taken && offset < least {
                (found, least) = (Some(number), offset);
            }
        }
        found.map(|number| self.take(number))
    }

    fn any(&mut self, from: &mut usize) -> Option<Nearest> {
        let rest = self.facets.get(*from..)?;
        *from += rest.iter().position(|f| !f.replaced && !f.taken)?;
        Some(self.take(*from))
    }

    fn insert(&mut self, point: &Lanes) -> Result<bool, Unfinished> {
        let apex = self.push(point);
        let mut rounded = *point;
        rounded.0[6] = 1.0;
        let mut beyond = std::mem::take(&mut self.beyond);
        beyond.clear();
        let facets = self.facets.iter();
        beyond.extend(facets.map(|f| !f.replaced && self.is_beyond(f, &rounded, apex)));
        let grown = self.raise_cone(apex, &beyond);
        self.beyond = beyond;
        grown
    }

    fn facet_count(&self) -> usize {
        self.facets.len()
    }

    fn volume(&self) -> f64 {
        let center = self.center.map(Twofold::value);
        let standing = self.facets.iter().filter(|facet| !facet.replaced);
        let pieces = standing.map(|facet| {
            let edges = Matrix6::from_fn(|row, slot| {
                self.vertices[facet.vertices[slot] as usize][row].value() - center[row]
            });
            edges.determinant().abs()
        });
        pieces.sum::<f64>() / 720.0
    }
}

impl PrecisePolytope {
    /// Replaces the facets that the apex lies beyond by those over their rim.
    fn raise_cone(&mut self, apex: u32, beyond: &[bool]) -> Result<bool, Unfinished> {
        let first = self.facets.len();
        let visible: Vec<usize> = (0..first).filter(|&f| beyond[f]).collect();
        if visible.is_empty() {
            return Ok(false);
        }
        for &below in &visible {
            for slot in 0..6 {
                let behind = self.facets[below].neighbors[slot];
                if *beyond.get(behind as usize).ok_or(Unfinished::Folded)? {
                    continue;
                }
                if self.facets.len() >= self.facet_limit {
                    return Err(Unfinished::Limit);
                }
                let mut vertices = self.facets[below].vertices;
                vertices[slot] = apex;
                let mut facet = self.facet(vertices)?;
                facet.neighbors[slot] = behind;
                let new = self.facets.len() as u32;
                let neighbors = &mut self.facets[behind as usize].neighbors;
                let back = neighbors.iter().position(|n| *n == below as u32);
                neighbors[back.ok_or(Unfinished::Folded)?] = new;
                self.facets.push(facet);
            }
        }
        if self.facets.len() == first {
            return Err(Unfinished::Folded);
        }
        for below in visible {
            self.facets[below].replaced = true;
        }
        self.join(first);
        Ok(true)
    }
}

fn dot(a: &Point, b: &Point) -> Twofold {
    (0..6).fold(Twofold::ZERO, |sum, axis| sum + a[axis] * b[axis])
}

/// A vector orthogonal to the differences of six points, by Gauss-Jordan elimination with full pivoting.
fn kernel(points: &[Point; 6]) -> Option<Point> {
    let mut m: [Point; 5] = std::array::from_fn(|row| {
        std::array::from_fn(|axis| points[row + 1][axis] - points[0][axis])
    });
    let mut order = [0, 1, 2, 3, 4, 5];
    for step in 0..5 {
        let (mut pivot_row, mut pivot_column) = (step, step);
        for row in step..5 {
            for column in step..6 {
                if m[row][column].magnitude() > m[pivot_row][pivot_column].magnitude() {
                    (pivot_row, pivot_column) = (row, column);
                }
            }
        }
        m.swap(step, pivot_row);
        for row in &mut m {
            row.swap(step, pivot_column);
        }
        order.swap(step, pivot_column);
        let pivot = m[step];
        if pivot[step].value() == 0.0 {
            return None;
        }
        for row in (0..5).filter(|&row| row != step) {
            let factor = m[row][step].over(pivot[step]);
            for column in step..6 {
                m[row][column] = m[row][column] - factor * pivot[column];
            }
        }
    }
    let mut kernel = [Twofold::ZERO; 6];
    kernel[order[5]] = Twofold::from(1.0);
    for row in 0..5 {
        kernel[order[row]] = -m[row][5].over(m[row][row]);
    }
    Some(kernel)
}
