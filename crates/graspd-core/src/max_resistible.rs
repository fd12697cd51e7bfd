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
//! # What is checked
//!
//! The interior-point method (clarabel) is trusted for nothing: balance, cones and the gap to what duality proves to be
//! the limit are verified on the numbers it returns, each against a named tolerance. A solution that fails one of them is
//! not returned. Some 100 µs for four contacts, at most [`MAX_STEPS`] steps.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, SolverStatus,
    SupportedConeT::{self, NonnegativeConeT, SecondOrderConeT, ZeroConeT},
};
use nalgebra::Vector3;

use super::contact::{Contact, ContactModel};
use super::wrench::{Wrench, WrenchModel, WrenchSpace};

/// Greatest imbalance of forces and scaled torques, over the sum of normal forces times the length of
/// a wrench of unit normal force. The interior-point method reaches 10⁻¹¹ where the columns are
/// independent; ten times the accuracy that the forces of a simulation could use is left to those
/// that nearly are not.
pub const BALANCE_TOLERANCE: f64 = 1e-8;

/// How far a force may be outside its cone, over the greatest normal force allowed.
pub const CONE_TOLERANCE: f64 = 1e-8;

/// Gap between the multiple found and what duality proves to be its limit, relative where that is above
/// one.
const GAP_TOLERANCE: f64 = 1e-9;

/// A multiple below this counts as zero: the gap is no longer small against it.
pub const LEAST_REACH: f64 = 1e-7;

/// Steps of the interior-point method; ten to twenty are usual.
const MAX_STEPS: u32 = 100;

/// The greatest multiple of a wrench that is balanced, with the variables that balance it.
pub(super) struct Resistible {
    pub reach: f64,
    /// The variables, one per column.
    pub shares: Vec<f64>,
}

/// The wrenches that the contacts of a grasp can exert, one column per variable of the program.
pub(super) struct Columns {
    columns: Vec<Column>,
    cone: Cone,
    contacts: usize,
}

/// The effect of a unit of one variable.
pub(super) struct Column {
    pub contact: usize,
    pub wrench: Wrench,
    pub force: Vector3<f64>,
    pub torsion: f64,
    /// Normal force, zero or one.
    normal: f64,
}

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

impl Columns {
    /// Uses the friction cones of `model`: round ones as they are, pyramids through their edges. Neither the edge norm nor
    /// the wrench space matters.
    pub fn new(model: &WrenchModel, contacts: &[Contact]) -> Self {
        let numbered = contacts.iter().enumerate();
        Self {
            columns: numbered
                .flat_map(|(contact, at)| columns_of(model, contact, at))
                .collect(),
            cone: Cone::of(model),
            contacts: contacts.len(),
        }
    }

    pub fn iter(&self) -> impl Iterator<Item = &Column> {
        self.columns.iter()
    }

    /// Maximises t over the variables x in the cones with Σ wrench·x + t·w = 0 and normal forces that obey the
    /// limit of `space`, for a unit w.
    ///
    /// `None` when t is not above [`LEAST_REACH`], and when the numbers fail the tolerances named here. Some
    /// 100 µs for 4 contacts; at most 100 steps of O(columns).
    pub fn max_resistible(&self, space: WrenchSpace, wrench: &Wrench) -> Option<Resistible> {
        let (columns, cone) = (&self.columns, self.cone);
        let n = columns.len();
        let sums = match space {
            WrenchSpace::L1 => 1,
            WrenchSpace::Linf => self.contacts,
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
            ..DefaultSettings::default()
        };
        let none = CscMatrix::zeros((n + 1, n + 1));
        let mut solver =
            DefaultSolver::new(&none, &cost, &matrix, &right, &cones, settings).ok()?;
        solver.solve();
        let found = &solver.solution;
        // What a status short of solved is worth, the checks below decide.
        if matches!(
            found.status,
            SolverStatus::PrimalInfeasible | SolverStatus::DualInfeasible
        ) {
            return None;
        }
        let (&reach, shares) = found.x.split_first()?;
        let gap = (found.obj_val - found.obj_val_dual).abs();
        let sound = reach > LEAST_REACH
            && gap <= GAP_TOLERANCE * reach.max(1.0)
            && self.is_balanced(shares, &(wrench * reach))
            && self.is_within(space, shares)
            && in_cones(shares, cone);
        sound.then(|| Resistible {
            reach,
            shares: shares.to_vec(),
        })
    }

    fn is_balanced(&self, shares: &[f64], wrench: &Wrench) -> bool {
        let pairs = self.columns.iter().zip(shares);
        let exerted: Wrench = pairs.map(|(column, share)| column.wrench * *share).sum();
        let longest = self.columns.iter().map(|c| c.wrench.norm());
        (exerted + wrench).norm() <= BALANCE_TOLERANCE * longest.fold(0.0, f64::max)
    }

    fn is_within(&self, space: WrenchSpace, shares: &[f64]) -> bool {
        let mut sums = vec![0.0; self.contacts];
        for (column, share) in self.columns.iter().zip(shares) {
            sums[column.sum(space)] += column.normal * share;
        }
        match space {
            WrenchSpace::L1 => (sums[0] - 1.0).abs() <= BALANCE_TOLERANCE,
            WrenchSpace::Linf => sums.iter().all(|sum| *sum <= 1.0 + BALANCE_TOLERANCE),
        }
    }
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
