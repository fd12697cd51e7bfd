//! The closed parts of a surface, ready to be compared.

use nalgebra::Point3;

use super::meeting::{self, Meeting};
use crate::mesh::parts::Part;
use crate::mesh::tree::Tree;
use crate::mesh::triangle;

/// Length, in welding tolerances, up to which two triangles that have a vertex in common meet nowhere else.
const COMMON: f64 = 4.0;

/// The closed parts of a surface, each wound outward, and what it takes to compare them.
pub(super) struct Shells<'a> {
    pub(super) vertices: &'a [Point3<f64>],
    pub(super) triangles: &'a [[u32; 3]],
    pub(super) parts: &'a [Part],
    /// For each triangle its part.
    pub(super) part_of: Vec<u32>,
    /// Of the parts that are compared.
    pub(super) trees: Vec<Option<Tree>>,
    /// For each part those whose boxes meet its own, in ascending order.
    pub(super) neighbours: Vec<Vec<u32>>,
    /// For each part whether it encloses some space twice.
    pub(super) crosses_itself: Vec<bool>,
    pub(super) tolerance: f64,
}

impl Shells<'_> {
    pub(super) fn corners(&self, number: u32) -> [Point3<f64>; 3] {
        triangle::corners(self.vertices, self.triangles[number as usize])
    }

    pub(super) fn is_usable(&self, number: u32) -> bool {
        !triangle::is_degenerate(&self.corners(number), self.tolerance)
    }

    /// How often a part winds about a point.
    pub(super) fn winding(&self, part: u32, point: &Point3<f64>) -> i32 {
        let tree = self.trees[part as usize].as_ref();
        let tree = tree.filter(|tree| tree.bounds().contains(point));
        tree.map_or(0, |tree| tree.winding(point).round() as i32)
    }
}

impl Shells<'_> {
    /// Where two triangles of one part meet, beyond the vertices that they have in common.
    pub(super) fn own_meeting(&self, [one, other]: [u32; 2]) -> Option<Meeting> {
        let vertices = self.triangles[other as usize];
        let common = self.triangles[one as usize].iter();
        let common = common.filter(|vertex| vertices.contains(vertex)).count();
        let [a, b] = [one, other].map(|number| self.corners(number));
        let met = meeting::meeting(&a, &b, self.tolerance, -self.tolerance)?;
        let is_own = match met {
            Meeting::Plane => true,
            Meeting::Stretch([from, to]) => {
                common == 0 || common == 1 && (to - from).norm() > COMMON * self.tolerance
            }
        };
        is_own.then_some(met)
    }
}
