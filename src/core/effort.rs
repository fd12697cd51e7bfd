//! The least contact forces that resist an external wrench.
//!
//! Sought are contact forces in their friction cones that balance the wrench with the least sum of
//! normal forces (Roa & Suárez 2015, section 2.3; Han, Trinkle & Li 2000 for the conic form). In the
//! other direction it is a ray: of all forces whose normal components sum to one, those that balance
//! the greatest multiple t of the wrench. Both have the same solution but for the factor t, and the
//! second stays well scaled however weak the grasp is.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, SolverStatus,
    SupportedConeT::{self, NonnegativeConeT, SecondOrderConeT, ZeroConeT},
};
use nalgebra::Vector3;

use super::contact::{Contact, ContactModel};
use super::wrench::{Wrench, WrenchModel};

/// Greatest imbalance of forces and scaled torques, over the sum of normal forces times the length of
/// a wrench of unit normal force. The interior-point method reaches 10⁻¹¹ where the columns are
/// independent; ten times the accuracy that the forces of a simulation could use is left to those
/// that nearly are not.
pub const BALANCE_TOLERANCE: f64 = 1e-8;

/// How far a force may be outside its cone, over the sum of normal forces.
pub const CONE_TOLERANCE: f64 = 1e-8;

/// Gap between the sum of normal forces found and what duality proves to be needed, in the terms of
/// the ray.
const GAP_TOLERANCE: f64 = 1e-9;

/// A wrench is not resisted when forces of this many times its size do not suffice; beyond, the gap
/// is no longer small against what is sought.
pub const GREATEST_EFFORT: f64 = 1e7;

/// Steps of the interior-point method; ten to twenty are usual.
const MAX_STEPS: u32 = 100;

/// A wrench that acts on the body from outside, in the mesh's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct External {
    /// In any unit of force; the contact forces come in the same.
    pub force: Vector3<f64>,
    /// About the centre of mass, in that unit times the mesh's unit of length; not scaled by λ.
    pub torque: Vector3<f64>,
}

impl External {
    /// A wrench of the scaled space, in its own units.
    pub fn of_wrench(model: &WrenchModel, wrench: &Wrench) -> Self {
        Self {
            force: wrench.fixed_rows::<3>(0).into_owned(),
            torque: wrench.fixed_rows::<3>(3) / model.torque_scale,
        }
    }

    /// Its place in the scaled space.
    pub fn wrench(&self, model: &WrenchModel) -> Wrench {
        let (f, t) = (self.force, self.torque * model.torque_scale);
        Wrench::new(f.x, f.y, f.z, t.x, t.y, t.z)
    }
}

/// What one finger exerts on the body, in the mesh's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactForce {
    /// In the unit of the external force.
    pub force: Vector3<f64>,
    /// Torque about the inward normal, in that unit times the mesh's unit of length; zero but for
    /// soft fingers.
    pub torsion: f64,
}

/// Contact forces that balance an external wrench with the least sum of normal forces.
#[derive(Debug, Clone, PartialEq)]
pub struct Effort {
    /// One per contact, in their order.
    pub forces: Vec<ContactForce>,
    /// Sum of the normal forces, in the unit of the external force.
    pub total: f64,
}

/// The least contact forces that balance `external`, in the friction cones of `model`: round ones
/// themselves, pyramids through their edges. Neither the edge norm nor the wrench space matters.
///
/// `None` when the grasp cannot resist it, or only with more than [`GREATEST_EFFORT`] times its size,
/// and when the numbers fail the tolerances named here. Some 100 µs for 4 contacts; at most
/// 100 steps of O(columns).
pub fn least_effort(
    model: &WrenchModel,
    contacts: &[Contact],
    external: &External,
) -> Option<Effort> {
    let wrench = external.wrench(model);
    let size = wrench.norm();
    if size == 0.0 {
        let idle = ContactForce {
            force: Vector3::zeros(),
            torsion: 0.0,
        };
        return Some(Effort {
            forces: vec![idle; contacts.len()],
            total: 0.0,
        });
    }
    if !size.is_finite() || contacts.is_empty() {
        return None;
    }
    let columns: Vec<Column> = contacts
        .iter()
        .enumerate()
        .flat_map(|(contact, at)| columns_of(model, contact, at))
        .collect();
    let cone = Cone::of(model);
    let solution = ray(&columns, cone, &(wrench / size))?;
    let factor = size / solution.reach;

    let mut forces = vec![
        ContactForce {
            force: Vector3::zeros(),
            torsion: 0.0,
        };
        contacts.len()
    ];
    for (column, share) in columns.iter().zip(&solution.shares) {
        let amount = share * factor;
        let at = &mut forces[column.contact];
        at.force += column.force * amount;
        at.torsion += column.torsion * amount;
    }
    Some(Effort {
        forces,
        total: factor,
    })
}

/// What a unit of one variable exerts.
struct Column {
    contact: usize,
    wrench: Wrench,
    force: Vector3<f64>,
    torsion: f64,
    /// Normal force, zero or one.
    normal: f64,
}

/// The cone that the variables of one contact are in.
#[derive(Clone, Copy)]
enum Cone {
    /// Each at least zero.
    Nonnegative,
    /// The first, of so many, is at least the length of the others.
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

struct Ray {
    /// The greatest multiple of the wrench that is balanced.
    reach: f64,
    /// The variables, their normal forces summing to one.
    shares: Vec<f64>,
}

/// Maximises t over shares x in the cones with Σ wrench·x + t·w = 0 and Σ normal·x = 1, for a
/// unit w.
fn ray(columns: &[Column], cone: Cone, wrench: &Wrench) -> Option<Ray> {
    let n = columns.len();
    // Variables: t, then the shares. Rows: six of balance, one of sum, then the cones.
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
        put(6, j + 1, column.normal);
        put(7 + j, j + 1, -1.0);
    }
    let matrix = CscMatrix::new_from_triplets(7 + n, n + 1, entries.0, entries.1, entries.2);
    let mut right = vec![0.0; 7 + n];
    right[6] = 1.0;
    let mut cost = vec![0.0; n + 1];
    cost[0] = -1.0;
    let mut cones: Vec<SupportedConeT<f64>> = vec![ZeroConeT(7)];
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
    let mut solver = DefaultSolver::new(&none, &cost, &matrix, &right, &cones, settings).ok()?;
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
    let sound = reach > GREATEST_EFFORT.recip()
        && gap <= GAP_TOLERANCE
        && is_balanced(columns, shares, &(wrench * reach))
        && in_cones(shares, cone);
    sound.then(|| Ray {
        reach,
        shares: shares.to_vec(),
    })
}

fn is_balanced(columns: &[Column], shares: &[f64], wrench: &Wrench) -> bool {
    let pairs = || columns.iter().zip(shares);
    let exerted: Wrench = pairs().map(|(column, share)| column.wrench * *share).sum();
    let normal: f64 = pairs().map(|(column, share)| column.normal * share).sum();
    let longest = columns.iter().map(|c| c.wrench.norm()).fold(0.0, f64::max);
    (exerted + wrench).norm() <= BALANCE_TOLERANCE * longest
        && (normal - 1.0).abs() <= BALANCE_TOLERANCE
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
