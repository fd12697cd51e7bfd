//! The greatest multiple of a wrench that a grasp resists, by one small convex program.
//!
//! # Idea
//!
//! Of all contact forces inside their friction cones whose normal components obey the limit of the wrench space (L1: they
//! sum to one; L∞: each is at most one), find those that balance the greatest multiple t of a unit wrench w:
//!
//! ```text
//! maximise t  subject to  Σ gᵢ·xᵢ + t·w = 0,  x in the friction cones,  normal forces within the limit
//! ```
//!
//! gᵢ are the wrenches of unit variables. For pyramids and frictionless contacts this is a linear program; for round
//! cones it is a second-order cone program (Han, Trinkle & Li 2000, "Grasp analysis as linear matrix inequality
//! problems"). Geometrically it is the ray from the origin against w, cut by the border of the wrench space; no hull is
//! built.
//!
//! # Scale
//!
//! The equations of torques are multiplied by a number that makes the longest torque of a column one, as long as a normal
//! force is. So the program does not depend on the torque scale λ, whose powers of ten would cost as many digits.
//!
//! # What is checked
//!
//! The interior-point method (clarabel) is trusted for nothing. Balance, cones and the gap to what duality proves to be
//! the limit are verified on the numbers it returns, each against a named tolerance; a solution that fails one of them is
//! not returned. Nor is a "no" believed: it takes a direction u along which the wrench space reaches no farther than h(u),
//! so that t·(−w·u) ≤ h(u) proves t to be too small. Where neither a solution nor a proof comes out, the program is solved
//! again under other settings of the method, and then with a pyramid inside each round cone.
//!
//! ```text
//! for each attempt:
//!     solve
//!     forces that pass the checks:             return them
//!     multipliers u that prove t to be small:  return "not resisted"
//! return "undecided"
//! ```
//!
//! Some 100 µs for four contacts, at most [`MAX_STEPS`] steps an attempt; the second attempt is rare.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver,
    SupportedConeT::{self, NonnegativeConeT, SecondOrderConeT, ZeroConeT},
};
use nalgebra::Vector3;

use super::contact::{Cone as Shape, ConeEdges, Contact, ContactModel};
use super::wrench::{Wrench, WrenchModel, WrenchSpace};

/// Greatest imbalance of forces and stretched torques, over the sum of normal forces times the length of
/// a wrench of unit normal force. The interior-point method reaches 10⁻¹¹ where the columns are
/// independent; ten times the accuracy that the forces of a simulation could use is left to those
/// that nearly are not.
pub const BALANCE_TOLERANCE: f64 = 1e-8;

/// How far a force may be outside its cone, over the greatest normal force allowed.
pub const CONE_TOLERANCE: f64 = 1e-8;

/// Gap between the multiple found and what duality proves to be its limit, relative where that is above
/// one.
const GAP_TOLERANCE: f64 = 1e-9;

/// That gap for the last attempts, relative.
const COARSE_GAP: f64 = 1e-6;

/// A multiple below this, with torques measured over the longest of a column, counts as zero: the gap is no longer small
/// against it.
pub const LEAST_REACH: f64 = 1e-7;

/// Edges of the pyramids inside the round cones in the last attempt.
const STAND_IN: u32 = 32;

/// Steps of the interior-point method; ten to twenty are usual.
const MAX_STEPS: u32 = 100;

/// What was found out about a wrench.
pub(super) enum Resistible {
    /// The greatest multiple that is balanced, and what balances it.
    UpTo(Balance),
    /// Proven: no multiple above [`LEAST_REACH`].
    Not,
    /// Neither was found.
    Undecided,
}

/// Contact forces that balance a multiple of a wrench.
pub(super) struct Balance {
    pub reach: f64,
    /// Force and torsion of each contact.
    pub forces: Vec<(Vector3<f64>, f64)>,
}

/// The wrenches that the contacts of a grasp can exert, one column per variable of the program.
pub(super) struct Columns<'a> {
    model: &'a WrenchModel,
    contacts: &'a [Contact],
    columns: Vec<Column>,
    cone: Cone,
    /// What torques are multiplied by, so that the longest of a column is one.
    stretch: f64,
    /// Length of the longest column, torques stretched.
    longest: f64,
}

/// The effect of a unit of one variable.
struct Column {
    contact: usize,
    /// With its torque stretched.
    wrench: Wrench,
    force: Vector3<f64>,
    torsion: f64,
    /// Normal force, zero or one.
    normal: f64,
}

/// How a program is solved.
#[derive(Clone, Copy)]
struct Attempt {
    equilibrate: bool,
    /// Relative to the greatest number of the matrix.
    regularization: f64,
    /// Accepted gap.
    gap: f64,
}

/// What an attempt found.
enum Found {
    Balance(Balance),
    /// A direction along which the space reaches too little for the wrench.
    Proof,
    Nothing,
}

/// In the order in which they are tried; the first is the method's default.
const ATTEMPTS: [Attempt; 4] = [
    Attempt {
        equilibrate: true,
        regularization: 1e-8,
        gap: GAP_TOLERANCE,
    },
    Attempt {
        equilibrate: false,
        regularization: 1e-8,
        gap: GAP_TOLERANCE,
    },
    Attempt {
        equilibrate: true,
        regularization: 1e-11,
        gap: GAP_TOLERANCE,
    },
    Attempt {
        equilibrate: false,
        regularization: 1e-7,
        gap: COARSE_GAP,
    },
];

/// The cone of the variables of one contact.
#[derive(Clone, Copy)]
enum Cone {
    /// Each at least zero.
    Nonnegative,
    /// Of this many variables, the first is at least the length of the others.
    SecondOrder(usize),
}

impl Cone {
    fn of(model: &WrenchModel) -> Self {
        match model.contact_model {
            ContactModel::Hard { .. } if model.contact_model.is_round() => Self::SecondOrder(3),
            ContactModel::Soft { .. } if model.contact_model.is_round() => Self::SecondOrder(4),
            _ => Self::Nonnegative,
        }
    }
}

fn columns_of(model: &WrenchModel, contact: usize, at: &Contact) -> Vec<Column> {
    let normal = at.normal.into_inner();
    let column = |force: Vector3<f64>, torsion: f64, normal: f64| Column {
        contact,
        wrench: model.wrench(&at.position, &force) + model.twist(at) * torsion,
        force,
        torsion,
        normal,
    };
    let (friction, torsion) = match model.contact_model {
        ContactModel::Frictionless => return vec![column(normal, 0.0, 1.0)],
        ContactModel::Hard { friction, .. } => (friction, None),
        ContactModel::Soft {
            friction, torsion, ..
        } => (friction, Some(torsion.get())),
    };
    let round = model.contact_model.is_round();
    if round {
        let (t1, t2) = model.tangents(at);
        let mut columns = vec![
            column(normal, 0.0, 1.0),
            column(t1 * friction.get(), 0.0, 0.0),
            column(t2 * friction.get(), 0.0, 0.0),
        ];
        columns.extend(torsion.map(|length| column(Vector3::zeros(), length, 0.0)));
        return columns;
    }
    let mut edges = Vec::new();
    model.push_wrenches(at, &mut edges);
    let length = model.edge_length(friction);
    let plain = edges.len() - if torsion.is_some() { 2 } else { 0 };
    let mut columns: Vec<Column> = edges[..plain]
        .iter()
        .map(|edge| column(edge.fixed_rows::<3>(0) / length, 0.0, 1.0))
        .collect();
    if let Some(torsion) = torsion {
        columns.extend([torsion, -torsion].map(|torsion| column(normal, torsion, 1.0)));
    }
    columns
}

impl<'a> Columns<'a> {
    /// Uses the friction cones of `model`: round ones as they are, pyramids through their edges. Neither the edge norm nor
    /// the wrench space matters.
    pub fn new(model: &'a WrenchModel, contacts: &'a [Contact]) -> Self {
        let numbered = contacts.iter().enumerate();
        let mut columns: Vec<Column> = numbered
            .flat_map(|(contact, at)| columns_of(model, contact, at))
            .collect();
        let torques = columns.iter().map(|c| c.wrench.fixed_rows::<3>(3).norm());
        let greatest = torques.fold(0.0, f64::max);
        let stretch = match greatest > 0.0 {
            true => greatest.recip(),
            false => 1.0,
        };
        for column in &mut columns {
            column.wrench = stretched(&column.wrench, stretch);
        }
        let lengths = columns.iter().map(|c| c.wrench.norm());
        Self {
            model,
            contacts,
            cone: Cone::of(model),
            stretch,
            longest: lengths.fold(0.0, f64::max),
            columns,
        }
    }

    /// Maximises t over the variables x in the cones with Σ wrench·x + t·w = 0 and normal forces that obey the
    /// limit of `space`, for a unit w. Some 100 µs for 4 contacts; at most 100 steps of O(columns) for each of a few
    /// attempts.
    pub fn max_resistible(&self, space: WrenchSpace, wrench: &Wrench) -> Resistible {
        let in_program = stretched(wrench, self.stretch);
        // The program is for a unit wrench.
        let length = in_program.norm();
        if !(length > 0.0 && length.is_finite()) {
            return Resistible::Undecided;
        }
        let unit = in_program / length;
        for attempt in &ATTEMPTS {
            match self.solve(space, &unit, attempt) {
                Found::Balance(balance) => {
                    return Resistible::UpTo(Balance {
                        reach: balance.reach / length,
                        ..balance
                    });
                }
                Found::Proof => return Resistible::Not,
                Found::Nothing => {}
            }
        }
        self.within_pyramids(space, wrench)
    }

    /// What pyramids inside the round cones balance.
    fn within_pyramids(&self, space: WrenchSpace, wrench: &Wrench) -> Resistible {
        let edges = ConeEdges::new(STAND_IN).map(Shape::Pyramid);
        let (Cone::SecondOrder(_), Some(pyramid)) = (self.cone, edges) else {
            return Resistible::Undecided;
        };
        let model = WrenchModel {
            contact_model: self.model.contact_model.with_cone(pyramid),
            ..*self.model
        };
        match Columns::new(&model, self.contacts).max_resistible(space, wrench) {
            // That the pyramids do not resist it proves nothing about the cones.
            Resistible::Not => Resistible::Undecided,
            other => other,
        }
    }

    /// Solves the program for a unit wrench, torques stretched.
    fn solve(&self, space: WrenchSpace, wrench: &Wrench, attempt: &Attempt) -> Found {
        let (columns, cone) = (&self.columns, self.cone);
        let n = columns.len();
        let sums = match space {
            WrenchSpace::L1 => 1,
            WrenchSpace::Linf => self.contacts.len(),
        };
        // Variables: t, then the shares. Rows: six of balance, those of sums, then the cones.
        let rows = 6 + sums + n;
        let mut entries: (Vec<usize>, Vec<usize>, Vec<f64>) = Default::default();
        let mut put = |row: usize, column: usize, value: f64| {
            if value != 0.0 {
                entries.0.push(row);
                entries.1.push(column);
                entries.2.push(value);
            }
        };
        for row in 0..6 {
            put(row, 0, wrench[row]);
        }
        for (j, column) in columns.iter().enumerate() {
            for row in 0..6 {
                put(row, j + 1, column.wrench[row]);
            }
            put(6 + column.sum(space), j + 1, column.normal);
            put(6 + sums + j, j + 1, -1.0);
        }
        let matrix = CscMatrix::new_from_triplets(rows, n + 1, entries.0, entries.1, entries.2);
        let mut right = vec![0.0; rows];
        right[6..6 + sums].fill(1.0);
        let mut cost = vec![0.0; n + 1];
        cost[0] = -1.0;
        let mut cones: Vec<SupportedConeT<f64>> = match space {
            WrenchSpace::L1 => vec![ZeroConeT(7)],
            WrenchSpace::Linf => vec![ZeroConeT(6), NonnegativeConeT(sums)],
        };
        match cone {
            Cone::Nonnegative => cones.push(NonnegativeConeT(n)),
            Cone::SecondOrder(size) => cones.extend((0..n / size).map(|_| SecondOrderConeT(size))),
        }
        let settings = DefaultSettings {
            verbose: false,
            max_iter: MAX_STEPS,
            max_threads: 1,
            tol_gap_abs: 1e-12,
            tol_gap_rel: 1e-12,
            tol_feas: 1e-12,
            equilibrate_enable: attempt.equilibrate,
            static_regularization_constant: attempt.regularization,
            ..DefaultSettings::default()
        };
        let none = CscMatrix::zeros((n + 1, n + 1));
        let Ok(mut solver) = DefaultSolver::new(&none, &cost, &matrix, &right, &cones, settings)
        else {
            return Found::Nothing;
        };
        solver.solve();
        // What a status is worth, the checks below decide.
        let found = &solver.solution;
        let Some((&reach, shares)) = found.x.split_first() else {
            return Found::Nothing;
        };
        let gap = (found.obj_val - found.obj_val_dual).abs();
        if reach > LEAST_REACH
            && gap <= attempt.gap * reach.max(1.0)
            && self.is_balanced(shares, &(wrench * reach))
            && self.is_within(space, shares)
            && in_cones(shares, cone)
        {
            return Found::Balance(self.balance(reach, shares));
        }
        let multipliers = Wrench::from_fn(|row, _| found.z.get(row).copied().unwrap_or(f64::NAN));
        match self.is_out_of_reach(space, wrench, &-multipliers) {
            true => Found::Proof,
            false => Found::Nothing,
        }
    }

    /// Whether the direction u proves that no t above [`LEAST_REACH`] is balanced. Balance takes a wrench of the space with
    /// the height t·(−w·u) along u, at most the support value h(u); and t is at most the length of the longest wrench of the
    /// space, because w has length one. The difference is linear in t, so that its ends decide.
    fn is_out_of_reach(&self, space: WrenchSpace, wrench: &Wrench, direction: &Wrench) -> bool {
        let along = -wrench.dot(direction);
        let height = self.support(space, direction);
        // Twice for a round cone: its centre and its radius.
        let longest = 2.0 * self.longest * self.contacts.len() as f64;
        height < LEAST_REACH * along && height < longest * along
    }

    /// How far the wrench space of unit normal forces reaches along a direction, torques stretched.
    fn support(&self, space: WrenchSpace, direction: &Wrench) -> f64 {
        let mut reaches = vec![f64::NEG_INFINITY; self.contacts.len()];
        let heights = self.columns.iter().map(|c| c.wrench.dot(direction));
        match self.cone {
            Cone::Nonnegative => {
                for (column, height) in self.columns.iter().zip(heights) {
                    let reach = &mut reaches[column.contact];
                    *reach = reach.max(height);
                }
            }
            Cone::SecondOrder(size) => {
                let heights: Vec<f64> = heights.collect();
                for (reach, heights) in reaches.iter_mut().zip(heights.chunks(size)) {
                    let tangential: f64 = heights[1..].iter().map(|x| x * x).sum();
                    *reach = heights[0] + tangential.sqrt();
                }
            }
        }
        match space {
            WrenchSpace::L1 => reaches.into_iter().fold(f64::NEG_INFINITY, f64::max),
            WrenchSpace::Linf => reaches.into_iter().map(|reach| reach.max(0.0)).sum(),
        }
    }

    fn balance(&self, reach: f64, shares: &[f64]) -> Balance {
        let mut forces = vec![(Vector3::zeros(), 0.0); self.contacts.len()];
        for (column, share) in self.columns.iter().zip(shares) {
            let (force, torsion) = &mut forces[column.contact];
            *force += column.force * *share;
            *torsion += column.torsion * share;
        }
        Balance { reach, forces }
    }

    fn is_balanced(&self, shares: &[f64], wrench: &Wrench) -> bool {
        let pairs = self.columns.iter().zip(shares);
        let exerted: Wrench = pairs.map(|(column, share)| column.wrench * *share).sum();
        (exerted + wrench).norm() <= BALANCE_TOLERANCE * self.longest
    }

    fn is_within(&self, space: WrenchSpace, shares: &[f64]) -> bool {
        let mut sums = vec![0.0; self.contacts.len()];
        for (column, share) in self.columns.iter().zip(shares) {
            sums[column.sum(space)] += column.normal * share;
        }
        match space {
            WrenchSpace::L1 => (sums[0] - 1.0).abs() <= BALANCE_TOLERANCE,
            WrenchSpace::Linf => sums.iter().all(|sum| *sum <= 1.0 + BALANCE_TOLERANCE),
        }
    }
}

/// A wrench with its torque multiplied.
fn stretched(wrench: &Wrench, stretch: f64) -> Wrench {
    let mut wrench = *wrench;
    wrench.fixed_rows_mut::<3>(3).scale_mut(stretch);
    wrench
}

impl Column {
    /// Which limit its normal force counts against.
    fn sum(&self, space: WrenchSpace) -> usize {
        match space {
            WrenchSpace::L1 => 0,
            WrenchSpace::Linf => self.contact,
        }
    }
}

fn in_cones(shares: &[f64], cone: Cone) -> bool {
    match cone {
        Cone::Nonnegative => shares.iter().all(|&share| share >= -CONE_TOLERANCE),
        Cone::SecondOrder(size) => shares.chunks(size).all(|shares| {
            let tangential: f64 = shares[1..].iter().map(|x| x * x).sum();
            tangential.sqrt() <= shares[0] + CONE_TOLERANCE
        }),
    }
}
