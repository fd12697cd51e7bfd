//! Wrench sets from arbitrary bytes, and what the engine promises of any of them.

use graspd_core::quality::{CLOSURE_TOLERANCE, Degenerate, Evaluator, Margin};
use graspd_core::wrench::Wrench;

/// Most wrenches in a set: 64 contacts × 32 edges.
const MOST: usize = 2048;

/// Facets after which the evaluator has to give up, in sets small enough to try that.
const FACET_LIMIT: usize = 3000;

/// Sets above this size are evaluated, but their whole hulls are not built.
const WHOLE_HULL: usize = 40;

/// How far a support value in double precision may be off, over the longest wrench: the tolerance of
/// the engine and the rounding of a sum of six products.
const ROUNDING: f64 = 1e-11;

/// The bytes of an input, from front to back; zeros when they are used up.
struct Bytes<'a>(std::slice::Iter<'a, u8>);

impl Bytes<'_> {
    fn byte(&mut self) -> u8 {
        self.0.next().copied().unwrap_or(0)
    }

    fn float(&mut self) -> f64 {
        f64::from_bits(u64::from_le_bytes(std::array::from_fn(|_| self.byte())))
    }

    fn index(&mut self, n: usize) -> usize {
        usize::from(u16::from_le_bytes([self.byte(), self.byte()])) % n
    }
}

/// The set that some bytes stand for: a byte for the scale, then wrench after wrench, each a byte for its
/// kind and what that needs.
pub fn decode(data: &[u8]) -> Vec<Wrench> {
    let mut bytes = Bytes(data.iter());
    let scale = match bytes.byte() % 8 {
        0..=3 => 1.0,
        4 => 1e150,
        5 => 1e-150,
        6 => 1e-320,
        _ => bytes.float(),
    };
    let torques = [1.0, 1e-3, 1e3, 1e-8][usize::from(bytes.byte() % 4)];
    let mut set: Vec<Wrench> = Vec::new();
    while bytes.0.len() > 0 && set.len() < MOST {
        let kind = bytes.byte();
        if kind % 8 == 7 && !set.is_empty() {
            many(kind, &mut bytes, &mut set);
            continue;
        }
        let wrench = one(kind, &mut bytes, &set);
        let image = Wrench::from_fn(|c, _| wrench[c] * if c < 3 { 1.0 } else { torques });
        set.push(if kind & 128 == 0 {
            image * scale
        } else {
            image
        });
    }
    set.truncate(MOST);
    set
}

fn one(kind: u8, bytes: &mut Bytes, set: &[Wrench]) -> Wrench {
    match kind % 8 {
        // Small integers: ties, coplanar points, duplicates.
        0 | 1 => Wrench::from_fn(|_, _| f64::from(bytes.byte().cast_signed() % 3)),
        2 => Wrench::from_fn(|_, _| f64::from(bytes.byte().cast_signed()) / 64.0),
        // Anything, not finite numbers included.
        3 => Wrench::from_fn(|_, _| bytes.float()),
        // A unit vector, or one of the cross-polytope.
        4 => Wrench::ith(
            usize::from(bytes.byte() % 6),
            f64::from(bytes.byte().cast_signed()).signum(),
        ),
        5 if set.len() > 1 => {
            // Between two others, or a hair off.
            let (a, b) = (set[bytes.index(set.len())], set[bytes.index(set.len())]);
            let middle = a * 0.5 + b * 0.5;
            let hair = f64::from(bytes.byte().cast_signed()) * f64::EPSILON;
            middle.map(|x| x * (1.0 + hair))
        }
        6 if !set.is_empty() => {
            let twin = set[bytes.index(set.len())];
            if bytes.byte() & 1 == 0 { twin } else { -twin }
        }
        _ => Wrench::from_fn(|_, _| f64::from(bytes.byte().cast_signed()) * 1e-9),
    }
}

/// The edges of a friction cone, or many copies of wrenches with one component changed.
fn many(kind: u8, bytes: &mut Bytes, set: &mut Vec<Wrench>) {
    let base = set[bytes.index(set.len())];
    let count = usize::from(bytes.byte()) * if kind & 64 == 0 { 1 } else { 8 };
    let (a, b) = (usize::from(bytes.byte() % 6), usize::from(bytes.byte() % 6));
    let length = f64::from(bytes.byte()) / 128.0 * base.amax();
    for i in 0..count.min(MOST) {
        let (sin, cos) = (std::f64::consts::TAU * i as f64 / count as f64).sin_cos();
        let mut wrench = base;
        wrench[a] += length * cos;
        wrench[b] += length * sin;
        set.push(wrench);
    }
}

/// Evaluates the set in every way there is.
///
/// # Panics
/// When a promise of the engine is broken.
pub fn check(set: &[Wrench]) {
    let mut evaluator = Evaluator::new();
    let finite = set.iter().all(|w| w.iter().all(|x| x.is_finite()));
    let quality = evaluator.quality(set);
    sound(set, &quality);
    if !finite {
        assert!(quality.is_err(), "not finite, yet {quality:?}");
    }
    let half = match &quality {
        Ok(margin) => margin.value / 2.0,
        Err(_) => 0.0,
    };
    sound(set, &evaluator.quality_above(set, half));

    let mut limited = Evaluator::with_facet_limit(FACET_LIMIT);
    let capped = limited.quality(set);
    sound(set, &capped);
    facets_within(&capped);
    if set.len() > WHOLE_HULL {
        return;
    }
    let margin = limited.margin(set);
    sound(set, &margin);
    facets_within(&margin);
    if let (Ok(quality), Ok(margin)) = (&quality, &margin)
        && quality.exact
        && margin.exact
    {
        assert_eq!(
            quality.is_force_closure(),
            margin.is_force_closure(),
            "{quality:?} {margin:?}"
        );
    }
    if let Some(volume) = limited.volume(set) {
        assert!(volume >= 0.0, "volume {volume}");
    }
    if let Ok(Some(normals)) = limited.supporting_normals(set) {
        let scaled = Scaled::new(set);
        for normal in normals {
            assert!(is_unit(&normal), "{normal}");
            let beyond = scaled.height(&normal);
            assert!(
                beyond <= 10.0 * CLOSURE_TOLERANCE * scaled.longest,
                "{beyond} beyond {normal}"
            );
        }
    }
    if let Ok(seven) = <[Wrench; 7]>::try_from(set) {
        let mut margins = Vec::new();
        evaluator.qualities_of_sevens(&[seven], &mut margins);
        assert_eq!(margins, [evaluator.quality(set)], "batch and single differ");
    }
}

fn facets_within(margin: &Result<Margin, Degenerate>) {
    if let Ok(margin) = margin {
        assert!(margin.facets <= FACET_LIMIT, "{margin:?}");
    }
}

/// What holds of every answer: no NaN, a unit direction, value at most upper, and no certificate against it.
fn sound(set: &[Wrench], answer: &Result<Margin, Degenerate>) {
    let margin = match answer {
        Ok(margin) => margin,
        Err(Degenerate { rank, direction }) => {
            assert!(*rank < 6, "rank {rank}");
            assert!(direction.iter().all(|x| x.is_finite()), "{answer:?}");
            return;
        }
    };
    assert!(
        !margin.value.is_nan() && !margin.upper.is_nan() && !margin.scale.is_nan(),
        "{margin:?}"
    );
    assert!(is_unit(&margin.direction), "{margin:?}");
    let scaled = Scaled::new(set);
    let (value, upper) = (margin.value / scaled.unit, margin.upper / scaled.unit);
    let rounding = ROUNDING * scaled.longest;
    assert!(value <= upper + rounding, "{margin:?}");
    if margin.is_force_closure() {
        // Any support value bounds ε from above.
        let mut state = 1_u64;
        let sampled = (0..64)
            .map(|_| direction(&mut state))
            .chain(scaled.set.iter().map(|w| -w));
        for u in sampled.take(128) {
            if let Some(u) = u.try_normalize(1e-3) {
                let height = scaled.height(&u);
                assert!(
                    height >= value - rounding,
                    "{height} along {u} under {margin:?}"
                );
            }
        }
    } else if upper <= CLOSURE_TOLERANCE * scaled.longest {
        // The plane that proves the origin outside has no wrench beyond it.
        let beyond = scaled.height(&margin.direction);
        assert!(
            beyond <= 2.0 * CLOSURE_TOLERANCE * scaled.longest,
            "{beyond} beyond {margin:?}"
        );
    }
}

fn is_unit(direction: &Wrench) -> bool {
    (direction.norm() - 1.0).abs() < 1e-9
}

/// A set with its greatest component divided out, so that no product overflows.
struct Scaled {
    set: Vec<Wrench>,
    unit: f64,
    longest: f64,
}

impl Scaled {
    fn new(set: &[Wrench]) -> Self {
        let unit = set
            .iter()
            .map(|w| w.amax())
            .fold(f64::MIN_POSITIVE, f64::max);
        let set: Vec<Wrench> = set.iter().map(|w| w / unit).collect();
        let longest = set.iter().map(|w| w.norm()).fold(0.0, f64::max);
        Self { set, unit, longest }
    }

    /// How far the set reaches along `u`, in its unit.
    fn height(&self, u: &Wrench) -> f64 {
        let heights = self.set.iter().map(|w| w.dot(u));
        heights.fold(f64::NEG_INFINITY, f64::max)
    }
}

/// A direction from a short linear congruence: a certificate needs no better chance.
fn direction(state: &mut u64) -> Wrench {
    Wrench::from_fn(|_, _| {
        *state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (*state >> 40) as f64 / f64::from(1_u32 << 23) - 1.0
    })
}
