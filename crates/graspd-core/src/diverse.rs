//! Diverse grasps: whether two grasps of a body differ.
//!
//! A search often ends with many grasps that are nearly the same. Of grasps sorted by quality, one is kept when it is
//! at least a given distance from all that were kept before, so each that is dropped is near a better one. Choosing k
//! of n grasps costs at most k·n distances.

use nalgebra::Point3;

use super::mesh::Candidate;

/// Least distance of two grasps that differ, over the radius of the body.
pub const DISTINCT: f64 = 0.05;

/// Returns the Hausdorff distance of two grasps with the same `fixed` contacts, in the mesh's unit: the greatest distance of
/// a contact of either from the nearest contact of the other. It does not depend on the order of the contacts. O(m²).
pub fn distance(a: &[Candidate], b: &[Candidate], fixed: &[Point3<f64>]) -> f64 {
    // A fixed contact is in both grasps, at no distance from itself.
    farthest(a, b, fixed).max(farthest(b, a, fixed))
}

fn farthest(from: &[Candidate], to: &[Candidate], fixed: &[Point3<f64>]) -> f64 {
    let nearest = |p: &Point3<f64>| {
        let places = to.iter().map(|c| &c.position).chain(fixed);
        let distances = places.map(|place| (place - p).norm());
        distances.fold(f64::INFINITY, f64::min)
    };
    from.iter()
        .map(|c| nearest(&c.position))
        .fold(0.0, f64::max)
}

/// Whether a grasp is at least `least` from each of some others with the same `fixed` contacts.
pub fn differs<'a>(
    grasp: &[Candidate],
    mut others: impl Iterator<Item = &'a [Candidate]>,
    fixed: &[Point3<f64>],
    least: f64,
) -> bool {
    others.all(|other| distance(grasp, other, fixed) >= least)
}

#[cfg(test)]
mod tests {
    use nalgebra::{UnitVector3, Vector3};

    use super::*;

    fn grasp(xs: &[f64]) -> Vec<Candidate> {
        let candidate = |&x: &f64| Candidate {
            position: Point3::new(x, 0.0, 0.0),
            normal: UnitVector3::new_normalize(Vector3::x()),
            triangle: 0,
            barycentric: [1.0 / 3.0; 3],
        };
        xs.iter().map(candidate).collect()
    }

    #[test]
    fn the_distance_is_symmetric_and_knows_no_order() {
        let (a, b) = (grasp(&[0.0, 1.0, 5.0]), grasp(&[5.5, 0.25, 1.0]));
        assert_eq!(distance(&a, &b, &[]), 0.5);
        assert_eq!(distance(&b, &a, &[]), 0.5);
        assert_eq!(distance(&a, &grasp(&[5.0, 0.0, 1.0]), &[]), 0.0);
        // A contact that no other is near counts in both directions.
        assert_eq!(
            distance(&grasp(&[0.0, 1.0, 9.0]), &grasp(&[0.0, 1.0, 1.0]), &[]),
            8.0
        );
    }

    /// Against the distance of the two sets of all contacts.
    #[test]
    fn fixed_contacts_are_contacts_of_both() {
        let (a, b, fixed) = (grasp(&[0.0, 4.0]), grasp(&[0.5, 9.0]), grasp(&[3.0, 8.0]));
        let positions: Vec<Point3<f64>> = fixed.iter().map(|c| c.position).collect();
        let all = |planned: &[Candidate]| [planned, &fixed[..]].concat();
        let expected = distance(&all(&a), &all(&b), &[]);
        assert_eq!(distance(&a, &b, &positions), expected);
        assert_eq!(expected, 1.0);
        assert_eq!(distance(&a, &b, &[]), 5.0);
    }

    #[test]
    fn the_first_of_grasps_that_are_alike_differs() {
        let grasps = [
            [0.0, 4.0],
            [0.1, 4.0],
            [1.0, 4.0],
            [1.05, 4.0],
            [2.0, 4.0],
            [3.0, 3.5],
        ];
        let mut kept: Vec<Vec<Candidate>> = Vec::new();
        for grasp in grasps.map(|xs| grasp(&xs)) {
            if differs(&grasp, kept.iter().map(Vec::as_slice), &[], 0.5) {
                kept.push(grasp);
            }
        }
        let firsts: Vec<f64> = kept.iter().map(|grasp| grasp[0].position.x).collect();
        assert_eq!(firsts, [0.0, 1.0, 2.0, 3.0]);
    }
}
