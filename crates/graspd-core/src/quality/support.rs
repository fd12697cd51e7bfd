//! Support points of wrench spaces that are not the hull of finitely many wrenches.
//!
//! The generator of a contact is the set of wrenches it exerts with a unit of normal force: a finite set for a pyramid,
//! an ellipse or ellipsoid c + A·z, ‖z‖ ≤ 1, for a round cone, with two columns in A for a hard contact and three for a
//! soft one. Support values along u (Ferrari & Canny 1992):
//!
//! ```text
//! generator, finite     max over its wrenches w of w·u
//! generator, ellipsoid  c·u + ‖Aᵀu‖, reached at c + A·Aᵀu/‖Aᵀu‖
//! L1 space              the hull of all generators:   max over the contacts
//! L∞ space              the Minkowski sum of hull(0, generator):   Σ max(0, support value) over the contacts
//! ```
//!
//! So the Minkowski sum, with its exponentially many vertices, is never built. A support point costs one pass over the
//! contacts, eight side by side.

// Lanes of several rows are taken by one number.
#![allow(clippy::needless_range_loop)]

use super::lanes::{LANES, Lanes, heights, power_of_two_below};
use crate::contact::Contact;
use crate::wrench::{Wrench, WrenchModel, WrenchSpace};

/// A convex set known by its support points.
pub(super) trait Body {
    /// At least the length of its longest vector, and no more than some times that.
    fn scale(&self) -> f64;
    /// The support point along a direction, which need not be a unit vector; its last two lanes are ignored.
    fn reach(&self, direction: &Lanes) -> Reach;
}

/// A support point (six components, one, and zero) and how far it reaches.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach {
    pub point: Lanes,
    pub height: f64,
}

/// How the columns of a contact are to be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Generator {
    /// Wrenches, as many as there are columns.
    Finite,
    /// c, then the columns of A.
    Ellipsoid,
}

/// The wrench space of one grasp, divided by a power of two (the unit) so that its greatest component is from one to two.
/// Contacts lie side by side in blocks of eight. The last block is filled up with contacts that change nothing: zero in
/// L∞, copies of the first contact in L1.
#[derive(Debug)]
pub(super) struct Space {
    generator: Generator,
    sum: bool,
    /// Columns of a contact.
    width: usize,
    /// `width` columns a block, each with one row an axis.
    columns: Vec<[Lanes; 6]>,
    /// Points of the space that span it.
    pub samples: Vec<Lanes>,
    /// The power of two that all numbers were divided by.
    pub unit: f64,
    scale: f64,
    scratch: Vec<Wrench>,
}

impl Default for Space {
    fn default() -> Self {
        Self {
            generator: Generator::Finite,
            sum: false,
            width: 0,
            columns: Vec::new(),
            samples: Vec::new(),
            unit: 1.0,
            scale: 0.0,
            scratch: Vec::new(),
        }
    }
}

impl Space {
    /// Loads a grasp. Returns `false` when a component is not finite, or when there are no contacts.
    pub fn load(&mut self, model: &WrenchModel, contacts: &[Contact]) -> bool {
        self.sum = model.space == WrenchSpace::Linf;
        self.generator = if model.contact_model.is_round() {
            Generator::Ellipsoid
        } else {
            Generator::Finite
        };
        self.scratch.clear();
        for contact in contacts {
            match self.generator {
                Generator::Finite => model.push_wrenches(contact, &mut self.scratch),
                Generator::Ellipsoid => model.push_slice(contact, &mut self.scratch),
            }
        }
        if self
            .scratch
            .iter()
            .any(|w| !w.iter().all(|x| x.is_finite()))
            || contacts.is_empty()
        {
            return false;
        }
        self.width = self.scratch.len() / contacts.len();
        let greatest = self.scratch.iter().map(|w| w.amax()).fold(0.0, f64::max);
        self.unit = power_of_two_below(greatest);
        let factor = self.unit.recip();
        self.scratch.iter_mut().for_each(|w| *w *= factor);
        self.arrange(contacts.len());
        self.measure();
        true
    }

    fn arrange(&mut self, contacts: usize) {
        self.columns.clear();
        for first in (0..contacts).step_by(LANES) {
            for column in 0..self.width {
                let of = |contact: usize| match contact < contacts {
                    true => self.scratch[contact * self.width + column],
                    false if self.sum => Wrench::zeros(),
                    false => self.scratch[column],
                };
                let eight: [Wrench; LANES] = std::array::from_fn(|lane| of(first + lane));
                self.columns.push(std::array::from_fn(|axis| {
                    Lanes(std::array::from_fn(|lane| eight[lane][axis]))
                }));
            }
        }
    }

    /// Finds the scale and the samples.
    fn measure(&mut self) {
        self.samples.clear();
        self.scale = 0.0;
        if self.sum {
            self.samples.push(Lanes::of(&Wrench::zeros(), 1.0));
        }
        for columns in self.scratch.chunks(self.width) {
            let length = match self.generator {
                Generator::Finite => {
                    self.samples
                        .extend(columns.iter().map(|w| Lanes::of(w, 1.0)));
                    columns.iter().map(Wrench::norm).fold(0.0, f64::max)
                }
                Generator::Ellipsoid => {
                    let center = columns[0];
                    for axis in &columns[1..] {
                        self.samples.push(Lanes::of(&(center + axis), 1.0));
                        self.samples.push(Lanes::of(&(center - axis), 1.0));
                    }
                    let squares: f64 = columns[1..].iter().map(Wrench::norm_squared).sum();
                    center.norm() + squares.sqrt()
                }
            };
            self.scale = if self.sum {
                self.scale + length
            } else {
                self.scale.max(length)
            };
        }
    }

    /// The support values of eight contacts, and where they are reached: by the weights of an ellipsoid's columns, or by
    /// the number of a finite set's column.
    #[inline(always)]
    fn look(&self, block: &[[Lanes; 6]], direction: &Lanes) -> Look {
        let first = heights(direction, &block[0]);
        let mut look = Look {
            heights: first,
            weights: [Lanes::splat(0.0); 3],
            best: [0; LANES],
        };
        match self.generator {
            Generator::Finite => {
                for column in 1..block.len() {
                    let height = heights(direction, &block[column]);
                    for lane in 0..LANES {
                        let farther = height.0[lane] > look.heights.0[lane];
                        look.heights.0[lane] = if farther {
                            height.0[lane]
                        } else {
                            look.heights.0[lane]
                        };
                        look.best[lane] = if farther {
                            column as u64
                        } else {
                            look.best[lane]
                        };
                    }
                }
            }
            Generator::Ellipsoid => {
                let mut squares = Lanes::splat(0.0);
                for axis in 1..block.len() {
                    let slope = heights(direction, &block[axis]);
                    squares = squares.zip(&slope, |s, x| s + x * x);
                    look.weights[axis - 1] = slope;
                }
                let lengths = squares.map(f64::sqrt);
                look.heights = first.zip(&lengths, |h, length| h + length);
                for weight in &mut look.weights {
                    // All of a flat ellipsoid reaches equally far along its normal; its centre stands for it.
                    *weight = weight.zip(&lengths, |w, l| if l > 0.0 { w / l } else { 0.0 });
                }
            }
        }
        look
    }

    /// The support point of one contact.
    #[inline(always)]
    fn point(&self, block: &[[Lanes; 6]], look: &Look, lane: usize) -> Lanes {
        let mut point = Lanes::splat(0.0);
        match self.generator {
            Generator::Finite => {
                let column = &block[look.best[lane] as usize];
                for axis in 0..6 {
                    point.0[axis] = column[axis].0[lane];
                }
            }
            Generator::Ellipsoid => {
                for axis in 0..6 {
                    let mut x = block[0][axis].0[lane];
                    for column in 1..block.len() {
                        x += block[column][axis].0[lane] * look.weights[column - 1].0[lane];
                    }
                    point.0[axis] = x;
                }
            }
        }
        point.0[6] = 1.0;
        point
    }
}

/// See [`Space::look`].
struct Look {
    heights: Lanes,
    weights: [Lanes; 3],
    best: [u64; LANES],
}

impl Body for Space {
    #[inline(always)]
    fn scale(&self) -> f64 {
        self.scale
    }

    #[inline(always)]
    fn reach(&self, direction: &Lanes) -> Reach {
        let mut reach = Reach {
            point: Lanes::splat(0.0),
            height: if self.sum { 0.0 } else { f64::NEG_INFINITY },
        };
        for block in self.columns.chunks_exact(self.width) {
            let look = self.look(block, direction);
            for lane in 0..LANES {
                let height = look.heights.0[lane];
                if self.sum && height > 0.0 {
                    let point = self.point(block, &look, lane);
                    reach.point = reach.point.zip(&point, |a, b| a + b);
                    reach.height += height;
                } else if !self.sum && height > reach.height {
                    reach.point = self.point(block, &look, lane);
                    reach.height = height;
                }
            }
        }
        reach.point.0[6] = 1.0;
        reach
    }
}
