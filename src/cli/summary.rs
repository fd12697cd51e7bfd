//! Results as readable text.

use std::io::{self, Write};

use crate::wire::{ContactPoint, Evaluations, GraspEvaluation, PlanResult};
use graspd_core::independent::IndependentRegion;
use graspd_core::robustness::Robustness;
use graspd_core::task::TaskQuality;

/// Writes the grasp of a plan, the requested analyses, and how the search ended.
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
    let analyses = Analyses {
        robustness: result.robustness.as_ref(),
        regions: result.independent_regions.as_deref(),
        task: result.task_quality.as_ref(),
        gravity: result.gravity_quality,
    };
    if !analyses.is_empty() {
        writeln!(out)?;
        analyses.write(out)?;
    }
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

/// Writes the evaluation of each grasp.
pub fn write_evaluations(out: &mut impl Write, found: &Evaluations) -> io::Result<()> {
    for (i, grasp) in found.evaluations.iter().enumerate() {
        if i > 0 {
            writeln!(out)?;
        }
        write!(out, "grasp {i}: ")?;
        write_evaluation(out, grasp)?;
    }
    Ok(())
}

fn write_evaluation(out: &mut impl Write, grasp: &GraspEvaluation) -> io::Result<()> {
    match (&grasp.explanation, grasp.bounds) {
        (Some(obstacle), _) => writeln!(out, "no force closure: {}", obstacle.detail)?,
        (None, bounds) => {
            write!(out, "force closure, quality {}", number(grasp.quality))?;
            if let Some([lower, upper]) = bounds {
                write!(out, " (round cone {lower:.6} to {upper:.6})")?;
            }
            writeln!(out)?;
        }
    }
    if let Some(weakest) = &grasp.weakest_wrench {
        writeln!(out, "{}", weakest.description)?;
    }
    let measures = &grasp.measures;
    let margin = match grasp.exact {
        Some(false) => "margin (a bound, not exact)",
        _ => "margin",
    };
    for (name, value) in [
        (margin, grasp.margin),
        ("epsilon L1", measures.epsilon_l1),
        ("epsilon Linf", measures.epsilon_linf),
        ("volume L1", measures.volume_l1),
        (
            "smallest singular value",
            Some(measures.smallest_singular_value),
        ),
        ("isotropy", Some(measures.isotropy)),
        ("ellipsoid volume", Some(measures.ellipsoid_volume)),
        ("centroid distance", Some(measures.centroid_distance)),
        ("polygon area", measures.polygon_area),
        ("polygon shape", measures.polygon_shape),
    ] {
        writeln!(out, "  {name:<28} {:>14}", number(value))?;
    }
    let analyses = Analyses {
        robustness: grasp.robustness.as_ref(),
        regions: grasp.independent_regions.as_deref(),
        task: grasp.task_quality.as_ref(),
        gravity: grasp.gravity_quality,
    };
    analyses.write(out)?;
    for (i, resistance) in grasp.resisted.iter().enumerate() {
        match resistance.effort {
            Some(effort) => writeln!(out, "  external wrench {i}: needs {effort:.6}")?,
            None => writeln!(out, "  external wrench {i}: not resisted")?,
        }
    }
    Ok(())
}

/// The analyses of a grasp that were requested.
struct Analyses<'a> {
    robustness: Option<&'a Robustness>,
    regions: Option<&'a [IndependentRegion]>,
    task: Option<&'a TaskQuality>,
    gravity: Option<f64>,
}

impl Analyses<'_> {
    fn is_empty(&self) -> bool {
        let Self {
            robustness,
            regions,
            task,
            gravity,
        } = self;
        robustness.is_none() && regions.is_none() && task.is_none() && gravity.is_none()
    }

    fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let mut line = |name: &str, value: f64| writeln!(out, "  {name:<28} {value:>14.6}");
        if let Some(found) = self.robustness {
            line("expected quality", found.expected)?;
            line("5th percentile", found.percentile_5)?;
            line("force closure probability", found.force_closure_probability)?;
        }
        if let Some(found) = self.task {
            line("task quality", found.least)?;
        }
        if let Some(found) = self.gravity {
            line("gravity quality", found)?;
        }
        for (i, region) in self.regions.unwrap_or_default().iter().enumerate() {
            writeln!(
                out,
                "  region of contact {i}: {} triangles, area {:.6}",
                region.count, region.area
            )?;
        }
        Ok(())
    }
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
            "{:>9}  {x:12.5} {y:12.5} {z:12.5}  {a:10.5} {b:10.5} {c:10.5}{}",
            contact.triangle.map_or("-".to_owned(), |t| t.to_string()),
            if contact.fixed { "  fixed" } else { "" }
        )?;
    }
    Ok(())
}

fn number(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.6}"))
}
