//! Whether any two of many places are far apart.

use nalgebra::Point3;

use crate::interrupt::{Interrupt, Interrupted};
use crate::mesh::along_curve;

/// Places of the smallest parts.
const LEAF: usize = 8;

/// Pairs of parts that are looked at between two checks of the interrupt, and at most: some milliseconds, half a second.
const BLOCK: usize = 1 << 14;
const MOST: usize = 1 << 22;

/// A bound is this much too great, over itself: more than rounding takes from it.
const ROUNDING: f64 = 1e-12;

/// The corners of a box; of nothing the first is above the second.
#[derive(Debug, Clone, Copy)]
struct Bounds(Point3<f64>, Point3<f64>);

impl Bounds {
    fn of(places: impl Iterator<Item = Point3<f64>>) -> Self {
        let nothing = Self([f64::INFINITY; 3].into(), [f64::NEG_INFINITY; 3].into());
        places.fold(nothing, |Self(low, high), p| {
            Self(low.inf(&p), high.sup(&p))
        })
    }

    /// No two places, one in each box, are farther apart.
    fn farthest(&self, other: &Self) -> f64 {
        let spread = |i: usize| {
            (self.1[i] - other.0[i])
                .max(other.1[i] - self.0[i])
                .max(0.0)
        };
        spread(0).hypot(spread(1)).hypot(spread(2)) * (1.0 + ROUNDING)
    }
}

/// Whether some two of `places` are at least `distance`, which is positive, apart; `None` where it takes too
/// long to tell, as for a distance within a part in thousands of the diameter of a ball.
///
/// Pairs of parts along a curve are halved, the farthest first, until no two boxes are far enough apart or
/// two places are. On the current rayon pool; `interrupt` is checked every few milliseconds.
pub(crate) fn any_apart(
    places: &[Point3<f64>],
    distance: f64,
    interrupt: Interrupt<'_>,
) -> Result<Option<bool>, Interrupted> {
    let order = along_curve(places.len(), |i| places[i], interrupt)?;
    let leaves = order.len().div_ceil(LEAF).next_power_of_two();
    let at = |i: &u32| places[*i as usize];
    // A heap: the parts 2i and 2i + 1 are the halves of i, and 1 is all.
    let mut parts = vec![Bounds::of(std::iter::empty()); 2 * leaves];
    for (part, leaf) in parts[leaves..].iter_mut().zip(order.chunks(LEAF)) {
        *part = Bounds::of(leaf.iter().map(at));
    }
    for i in (1..leaves).rev() {
        let [a, b] = [parts[2 * i], parts[2 * i + 1]];
        parts[i] = Bounds(a.0.inf(&b.0), a.1.sup(&b.1));
    }
    let members = |part: usize| {
        let first = (part - leaves) * LEAF;
        order.iter().skip(first).take(LEAF).map(at)
    };
    let mut open = vec![(1, 1)];
    for looked_at in 0..MOST {
        if looked_at.is_multiple_of(BLOCK) {
            interrupt.check()?;
        }
        let Some((a, b)) = open.pop() else {
            return Ok(Some(false));
        };
        if a >= leaves {
            let far = |p: Point3<f64>| members(b).any(|q| (p - q).norm() >= distance);
            if members(a).any(far) {
                return Ok(Some(true));
            }
            continue;
        }
        let halves = [
            (2 * a, 2 * b),
            (2 * a, 2 * b + 1),
            (2 * a + 1, 2 * b),
            (2 * a + 1, 2 * b + 1),
        ];
        // Of a part with itself one of the two mixed pairs is enough.
        let mut halves: Vec<(f64, (usize, usize))> = halves
            .into_iter()
            .filter(|&(c, d)| a != b || c <= d)
            .map(|(c, d)| (parts[c].farthest(&parts[d]), (c, d)))
            .filter(|(farthest, _)| *farthest >= distance)
            .collect();
        halves.sort_by(|x, y| x.0.total_cmp(&y.0));
        open.extend(halves.into_iter().map(|(_, pair)| pair));
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;
    use rand::{Rng, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;

    fn any(places: &[Point3<f64>], distance: f64) -> Option<bool> {
        any_apart(places, distance, Interrupt::never()).unwrap()
    }

    #[test]
    fn it_is_so_up_to_the_greatest_distance_of_all_pairs() {
        let mut rng = Pcg64::seed_from_u64(4);
        let mut uniform = || (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
        for count in [2, 3, 8, 9, 100, 700] {
            for flat in [1.0, 0.01, 0.0] {
                let mut place = || Point3::new(3.0 * uniform(), uniform(), flat * uniform());
                let places: Vec<Point3<f64>> = (0..count).map(|_| place()).collect();
                let distances = places
                    .iter()
                    .flat_map(|p| places.iter().map(move |q| (p - q).norm()));
                let greatest = distances.fold(0.0, f64::max);
                assert_eq!(any(&places, greatest), Some(true));
                assert_eq!(any(&places, greatest * 0.9), Some(true));
                assert_eq!(any(&places, greatest * (1.0 + 1e-9)), Some(false));
            }
        }
    }

    #[test]
    fn one_place_is_not_apart_from_itself_and_a_ball_is_decided_near_its_diameter() {
        assert_eq!(any(&[], 1.0), Some(false));
        assert_eq!(any(&[Point3::new(1.0, 2.0, 3.0)], 1e-9), Some(false));
        let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
        let on_ball = |i: u32| {
            let z = 1.0 - (f64::from(i) + 0.5) / 10_000.0;
            let (sin, cos) = (golden * f64::from(i)).sin_cos();
            Point3::from(Vector3::new(cos, sin, 0.0) * (1.0 - z * z).sqrt() + Vector3::z() * z)
        };
        let ball: Vec<Point3<f64>> = (0..20_000).map(on_ball).collect();
        assert_eq!(any(&ball, 2.02), Some(false));
        assert_eq!(any(&ball, 1.99), Some(true));
    }

    #[test]
    fn it_can_be_interrupted() {
        let places = [Point3::origin(); 3];
        assert_eq!(
            any_apart(
                &places,
                1.0,
                Interrupt::new(&|| Some(Interrupted::TimeLimit))
            ),
            Err(Interrupted::TimeLimit)
        );
    }
}
