//! Tables of numbers (RFC 4180).

use std::fmt::Write as _;

use crate::wire::{ChosenGrasp, ContactPoint, PlanResult};

const CONTACT_COLUMNS: &str = "contact,x,y,z,normal_x,normal_y,normal_z,triangle,barycentric_0,barycentric_1,\
    barycentric_2,force_x,force_y,force_z,torsion,fixed";
const HISTORY_COLUMNS: &str = "generation,best,mean,force_closures,evaluations,elapsed_s";

/// The contacts of a grasp, a line each, counted from 1.
///
/// Positions in the mesh's frame and unit, normals inward; forces and torsion answer the weakest wrench, of unit
/// size, and are empty where they are not known, as is what a contact does not have.
pub fn contacts_csv(grasp: &ChosenGrasp<'_>) -> String {
    let mut out = format!("{CONTACT_COLUMNS}\r\n");
    for (index, contact) in grasp.contacts.iter().enumerate() {
        let ContactPoint {
            position,
            normal,
            approach: _,
            triangle,
            barycentric,
            fixed,
            forces,
            torsion,
        } = contact;
        // Writing to a string cannot fail.
        let _ = write!(out, "{}", index + 1);
        for number in position.iter().chain(normal) {
            let _ = write!(out, ",{number}");
        }
        cell(&mut out, *triangle);
        for numbers in [barycentric, forces] {
            for part in 0..3 {
                cell(&mut out, numbers.map(|numbers| numbers[part]));
            }
        }
        cell(&mut out, *torsion);
        let _ = write!(out, ",{fixed}\r\n");
    }
    out
}

/// The history of a search, a line for each generation.
pub fn history_csv(result: &PlanResult) -> String {
    let mut out = format!("{HISTORY_COLUMNS}\r\n");
    for entry in &result.history {
        let _ = write!(out, "{}", entry.generation);
        cell(&mut out, entry.best);
        cell(&mut out, entry.mean);
        let (closures, evaluations) = (entry.force_closures, entry.evaluations);
        let _ = write!(out, ",{closures},{evaluations},{}\r\n", entry.elapsed_s);
    }
    out
}

fn cell(out: &mut String, value: Option<impl std::fmt::Display>) {
    out.push(',');
    if let Some(value) = value {
        let _ = write!(out, "{value}");
    }
}
