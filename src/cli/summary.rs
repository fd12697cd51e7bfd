//! The result of a run for people to read.

use std::io::{self, Write};

use crate::wire::{ContactPoint, PlanResult};

/// Writes whether and where the body can be held, and how the search went.
pub fn write(out: &mut impl Write, result: &PlanResult) -> io::Result<()> {
    match &result.explanation {
        None => writeln!(out, "force closure, quality {}", number(result.quality))?,
        Some(explanation) => {
            writeln!(out, "no force-closure grasp: {}", explanation.detail)?;
            if result.margin.is_some() {
                writeln!(out, "best margin {}", number(result.margin))?;
            }
        }
    }
    if let Some(weakest) = &result.weakest_wrench {
        writeln!(out, "{}", weakest.description)?;
    }
    write_contacts(out, &result.contacts)?;
    let stopped = serde_json::to_value(result.stopped_because)?;
    writeln!(out)?;
    if let Some(first) = &result.initial {
        let (first, best) = (Some(first.quality), result.quality);
        write!(
            out,
            "first grasp {} → best {}; ",
            number(first),
            number(best)
        )?;
    }
    writeln!(
        out,
        "{} evaluations in {:.3} s; {}; seed {}",
        result.evaluations,
        result.elapsed_s,
        stopped.as_str().unwrap_or_default(),
        result.seed,
    )
}

fn write_contacts(out: &mut impl Write, contacts: &[ContactPoint]) -> io::Result<()> {
    if contacts.is_empty() {
        return Ok(());
    }
    let (triangle, position, normal) = ("triangle", "position", "normal (into the body)");
    writeln!(out, "\n{triangle:>9}  {position:^38}  {normal:^32}")?;
    for contact in contacts {
        let [x, y, z] = contact.position;
        let [a, b, c] = contact.normal;
        writeln!(
            out,
            "{:>9}  {x:12.5} {y:12.5} {z:12.5}  {a:10.5} {b:10.5} {c:10.5}",
            contact.triangle
        )?;
    }
    Ok(())
}

fn number(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.6}"))
}
