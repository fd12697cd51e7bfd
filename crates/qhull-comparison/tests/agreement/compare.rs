//! One wrench set, engine against Qhull.

use graspd_core::quality::{CLOSURE_TOLERANCE, Evaluator, Margin};
use graspd_core::wrench::Wrench;

use crate::arbiter::{Side, side, support};
use qhull_comparison::{Qhull, Silence, VOLUME, points};

/// The two must agree to this, absolutely.
const AGREEMENT: f64 = 1e-9;

/// Volumes of balanced sets differ by this for rounding alone: a few units of 2⁻⁵² on each of the hundreds
/// of facets.
const FLAT_VOLUME: f64 = 1e-13;

/// Most by which volumes of thin sets differ, as a share: the engine's coplanar tolerance over the least
/// width that it does not call flat is a hundred times as much.
const THIN_SHARE: f64 = 1e-4;

/// Singular values of the centred set below this share of the longest wrench count as none. Between it
/// and [`CLEARLY_FULL`] rank is a matter of taste.
const CLEARLY_FLAT: f64 = 1e-12;
const CLEARLY_FULL: f64 = 1e-8;

/// What came of one comparison.
#[derive(Debug, Clone, PartialEq)]
pub enum Verdict {
    Agree {
        closure: bool,
    },
    /// They agree to [`AGREEMENT`] only when it is taken as a share of the longest wrench, which is
    /// longer than one.
    AgreeForTheirLength {
        by: f64,
    },
    /// The volumes agree to [`AGREEMENT`] absolutely, but not as a share of so small a volume: the engine's
    /// planes are those of the set to its tolerance, and the set is hardly wider in some direction.
    AgreeButThin {
        by: f64,
    },
    /// Both say that the set is flat, of this rank.
    Flat,
    /// The singular values do not decide either whether the set is flat.
    NearlyFlat,
    /// The margins differ, and Qhull's is refuted by a support value or a facet found by the engine.
    QhullWrong {
        by: f64,
    },
    /// The volumes differ, and Qhull itself gives the engine's for a rounding-free affine image.
    QhullVolumeWrong {
        by: f64,
    },
    /// Qhull gave up on a set of full rank.
    QhullFailed,
    /// From outside, the margins are those of different hyperplanes through faces that are flat but
    /// for rounding; both support the set, and both are negative.
    IllConditioned {
        by: f64,
    },
    /// The engine is wrong, or nobody is refuted.
    Wrong(String),
}

/// Compares margin, sign, quality and volume of one set.
pub struct Judge {
    evaluator: Evaluator,
    silence: Silence,
}

impl Judge {
    pub fn new() -> Self {
        Self {
            evaluator: Evaluator::new(),
            silence: Silence::new(),
        }
    }

    pub fn compare(&mut self, wrenches: &[Wrench]) -> Verdict {
        let longest = wrenches.iter().map(|w| w.norm()).fold(0.0, f64::max);
        let mut input = points(wrenches);
        let hull = self.silence.hull(&mut input, VOLUME);
        let rank = Rank::of(wrenches, longest);
        let margin = match self.evaluator.margin(wrenches) {
            Ok(margin) => margin,
            Err(flat) if (rank.surely..=rank.perhaps).contains(&flat.rank) => {
                return match hull {
                    Ok(_) if rank.perhaps == 6 => Verdict::NearlyFlat,
                    _ => Verdict::Flat,
                };
            }
            Err(flat) => return Verdict::Wrong(format!("rank {} but {rank:?}", flat.rank)),
        };
        if rank.surely < 6 {
            return match rank.perhaps {
                6 => Verdict::NearlyFlat,
                _ => Verdict::Wrong(format!("margin {} of {rank:?}", margin.value)),
            };
        }
        if !margin.exact {
            return Verdict::Wrong(format!("unfinished: {margin:?}"));
        }
        if let Err(problem) = self.quality_agrees(wrenches, &margin) {
            return Verdict::Wrong(problem);
        }
        let Ok(hull) = hull else {
            return Verdict::QhullFailed;
        };
        let verdict = margins(wrenches, &margin, &hull, longest);
        let theirs = hull.volume();
        if let Verdict::Agree { .. } | Verdict::AgreeForTheirLength { .. } = verdict
            && let Err(problem) = self.volume_agrees(wrenches, theirs)
        {
            return problem;
        }
        verdict
    }

    /// Inside, `quality` is `margin`; outside, its hyperplane proves as much.
    fn quality_agrees(&mut self, wrenches: &[Wrench], margin: &Margin) -> Result<(), String> {
        match self.evaluator.quality(wrenches) {
            Ok(quality) if margin.is_force_closure() && quality.value == margin.value => Ok(()),
            Ok(quality)
                if !margin.is_force_closure()
                    && support(wrenches, &quality.direction)
                        <= 2.0 * CLOSURE_TOLERANCE * margin.scale =>
            {
                Ok(())
            }
            other => Err(format!("quality {other:?} but margin {margin:?}")),
        }
    }

    /// Equal to a share of [`AGREEMENT`], and to the rounding of a set that is nearly flat; otherwise
    /// Qhull again, on the balanced image of the set, says who is right.
    fn volume_agrees(&mut self, wrenches: &[Wrench], theirs: f64) -> Result<(), Verdict> {
        let Some(ours) = self.evaluator.volume(wrenches) else {
            return Err(Verdict::Wrong("volume unfinished".to_owned()));
        };
        let (image, factor) = balanced(wrenches);
        let near = |other: f64| (ours - other).abs() <= AGREEMENT * other + FLAT_VOLUME / factor;
        if near(theirs) {
            return Ok(());
        }
        let mut input = points(&image);
        let Ok(hull) = self.silence.hull(&mut input, VOLUME) else {
            return Err(Verdict::QhullFailed);
        };
        let truth = hull.volume() / factor;
        let by = (ours - truth).abs() / truth;
        Err(if (ours - theirs).abs() <= AGREEMENT && by <= THIN_SHARE {
            Verdict::AgreeButThin { by }
        } else if near(truth) {
            Verdict::QhullVolumeWrong {
                by: (theirs - truth).abs() / truth,
            }
        } else {
            let words = format!("volume {ours}, Qhull {theirs}, of the balanced set {truth}");
            Verdict::Wrong(words)
        })
    }
}

/// The set with every component multiplied by a power of two such that the widest in each is 1 to 2: an
/// affine image free of rounding. And how much smaller its volume is.
fn balanced(wrenches: &[Wrench]) -> (Vec<Wrench>, f64) {
    let widest = wrenches
        .iter()
        .fold(Wrench::zeros(), |m, w| m.sup(&w.abs()));
    let factors = widest.map(|x| (-x.log2().floor()).exp2());
    let image = wrenches.iter().map(|w| w.component_mul(&factors));
    (image.collect(), factors.product())
}

/// Who is right about the margin.
fn margins(wrenches: &[Wrench], margin: &Margin, hull: &Qhull, longest: f64) -> Verdict {
    let Some((normal, theirs)) = hull.facets().min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return Verdict::QhullFailed;
    };
    let normal = Wrench::from_column_slice(&normal);
    let ours = margin.value;
    let by = (ours - theirs).abs();
    let tolerance = AGREEMENT;
    if by <= tolerance {
        return Verdict::Agree {
            closure: margin.is_force_closure(),
        };
    }
    if by <= AGREEMENT * longest && (ours > tolerance) == (theirs > tolerance) {
        return Verdict::AgreeForTheirLength { by };
    }
    let words = || format!("margin {ours}, Qhull {theirs}, longest wrench {longest}");
    // Inside, ε is at most any support value. Outside it is the least offset of a facet, so the hyperplane
    // has to be one.
    let inside = ours > tolerance || theirs > tolerance;
    if inside && ours < theirs && support(wrenches, &margin.direction) < theirs - tolerance / 2.0 {
        return Verdict::QhullWrong { by };
    }
    if inside && theirs < ours && support(wrenches, &normal) > theirs + tolerance / 2.0 {
        // Its own hyperplane does not support the set at the offset it gives.
        return Verdict::QhullWrong { by };
    }
    if inside {
        return Verdict::Wrong(words());
    }
    let slack = 1e-11 * longest;
    match (
        side(wrenches, &margin.direction, ours, slack),
        side(wrenches, &normal, theirs, slack),
    ) {
        (Side::Facet, _) if ours < theirs => Verdict::QhullWrong { by },
        (_, Side::Beyond) if theirs < ours => Verdict::QhullWrong { by },
        (_, Side::Ridge) => Verdict::IllConditioned { by },
        (Side::Ridge, _) => Verdict::IllConditioned { by },
        sides => Verdict::Wrong(format!("{}, {sides:?}", words())),
    }
}

/// Bounds on the dimension of the smallest flat through a set, from its singular values.
#[derive(Debug, Clone, Copy)]
struct Rank {
    surely: usize,
    perhaps: usize,
}

impl Rank {
    fn of(wrenches: &[Wrench], longest: f64) -> Self {
        let mean = wrenches.iter().sum::<Wrench>() / wrenches.len() as f64;
        let centred = nalgebra::Matrix6xX::from_iterator(
            wrenches.len(),
            wrenches
                .iter()
                .flat_map(|w| (w - mean).iter().copied().collect::<Vec<_>>()),
        );
        let values = centred.svd(false, false).singular_values;
        let above = |share: f64| values.iter().filter(|v| **v > share * longest).count();
        Self {
            surely: above(CLEARLY_FULL),
            perhaps: above(CLEARLY_FLAT),
        }
    }
}
