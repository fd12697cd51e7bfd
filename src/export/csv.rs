//! Contacts and histories as tables (RFC 4180). The cells are numbers and booleans, so nothing is ever
//! quoted, and a crate would have nothing to do.

use std::fmt::Write as _;

use crate::wire::{ChosenGrasp, ContactPoint, PlanResult};

const CONTACT_COLUMNS: &str = "contact,x,y,z,normal_x,normal_y,normal_z,triangle,barycentric_0,barycentric_1,\
    barycentric_2,force_x,force_y,force_z,torsion,fixed";
const HISTORY_COLUMNS: &str = "generation,best,mean,force_closures,evaluations,elapsed_s";

/// Writes the contacts of a grasp, a line each, counted from 1.
///
/// Positions are in the mesh's frame and unit, normals point inward. Forces and torsion answer the weakest wrench of
/// unit size. A cell is empty where the contact does not have the value.
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

/// Writes the history of a search, a line for each generation.
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

#[cfg(test)]
mod tests {
    use super::super::samples::{best, contact, result};
    use super::*;
    use crate::wire::HistoryEntry;

    /// A table without quotes: its columns and the cells of each line.
    fn table(text: &str) -> (Vec<&str>, Vec<Vec<&str>>) {
        let mut lines = text.strip_suffix("\r\n").expect("an end").split("\r\n");
        let columns: Vec<&str> = lines.next().expect("a header").split(',').collect();
        let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
        assert!(rows.iter().all(|row| row.len() == columns.len()), "{text}");
        (columns, rows)
    }

    #[test]
    fn a_contact_is_written_to_the_last_bit_and_what_it_lacks_is_empty() {
        let mut free = contact([0.1 + 0.2, -1e-300, 1.0 / 3.0], [1.0, 2.0, 3.0]);
        free.forces = Some([1e22, -0.0, 7.0]);
        free.torsion = Some(-0.25);
        let mut fixed = contact([1.0, 2.0, 3.0], [0.0, 0.0, -1.0]);
        (fixed.triangle, fixed.barycentric, fixed.fixed) = (None, None, true);
        let result = result(vec![free.clone(), fixed]);
        let text = contacts_csv(&best(&result));
        let (columns, rows) = table(&text);
        let at = |row: usize, column: &str| {
            let place = columns.iter().position(|name| *name == column);
            rows[row][place.unwrap_or_else(|| panic!("no {column}"))]
        };
        let numbers = |row, names: [&str; 3]| names.map(|name| at(row, name).parse::<f64>().ok());
        assert_eq!(rows.len(), 2);
        assert_eq!([at(0, "contact"), at(1, "contact")], ["1", "2"]);
        assert_eq!(numbers(0, ["x", "y", "z"]), free.position.map(Some));
        let normal = ["normal_x", "normal_y", "normal_z"];
        assert_eq!(numbers(0, normal), free.normal.map(Some));
        assert_eq!(numbers(1, normal), [0.0, 0.0, -1.0].map(Some));
        let barycentric = ["barycentric_0", "barycentric_1", "barycentric_2"];
        assert_eq!(numbers(0, barycentric), [0.5, 0.25, 0.25].map(Some));
        assert_eq!(numbers(1, barycentric), [None; 3]);
        let force = ["force_x", "force_y", "force_z"];
        assert_eq!(numbers(0, force), [1e22, 0.0, 7.0].map(Some));
        assert_eq!([at(1, "force_x"), at(1, "torsion")], ["", ""]);
        assert_eq!(at(0, "torsion"), "-0.25");
        assert_eq!([at(0, "triangle"), at(1, "triangle")], ["3", ""]);
        assert_eq!([at(0, "fixed"), at(1, "fixed")], ["false", "true"]);
    }

    #[test]
    fn a_history_has_a_line_for_each_generation() {
        let mut result = result(Vec::new());
        assert_eq!(table(&history_csv(&result)).1.len(), 0);
        let entry = |generation, best| HistoryEntry {
            generation,
            best,
            mean: best.map(|best| best / 2.0),
            force_closures: generation,
            evaluations: 100 * generation,
            elapsed_s: 1e-9,
        };
        result.history = vec![entry(0, None), entry(1, Some(0.125))];
        let text = history_csv(&result);
        let (columns, rows) = table(&text);
        assert_eq!(columns.join(","), HISTORY_COLUMNS);
        assert_eq!(rows[0], ["0", "", "", "0", "0", "0.000000001"]);
        assert_eq!(rows[1], ["1", "0.125", "0.0625", "1", "100", "0.000000001"]);
    }
}
