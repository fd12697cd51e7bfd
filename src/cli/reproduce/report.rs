//! The table, the grids and the plots.

use std::fmt::Write as _;
use std::io;
use std::path::Path;

use super::cases::{GENERATIONS, POPULATIONS};
use super::plot::{Curve, plot};
use super::{Measured, Row};
use crate::wire::Statistics;

/// Writes all files into a folder, which is created if necessary.
pub fn write(folder: &Path, measured: &[Measured], runs: u16, seed: u64) -> io::Result<()> {
    std::fs::create_dir_all(folder)?;
    let put = |name: &str, text: String| std::fs::write(folder.join(name), text);
    for one in measured {
        let name = one.case.name;
        put(&format!("{name}-history.svg"), history(one))?;
        if !one.grid.is_empty() {
            put(&format!("{name}-grid.svg"), grid(one))?;
        }
    }
    put("table.csv", table_csv(measured))?;
    put("grids.csv", grids_csv(measured))?;
    put("reproduction.md", markdown(measured, runs, seed))
}

fn markdown(measured: &[Measured], runs: u16, seed: u64) -> String {
    let mut out = format!(
        "# The paper's experiments, repeated\n\nRakesh et al. (2016), §4; averages over {runs} runs, seeds {seed} to \
         {}. λ = max_radius; friction 0.2 with 8 cone edges; contacts at centroids. `modified_ga` has the paper's \
         population and generations; `local` starts from the same first grasp; `random` and `memetic` have as \
         many evaluations as the genetic algorithm. The paper's qualities refer to its own meshes and an \
         unknown scale of torques, so only ratios and orders can be compared. Seconds depend on the machine; all \
         other figures are reproducible.\n",
        seed.wrapping_add(u64::from(runs) - 1)
    );
    for one in measured {
        let case = one.case;
        let [first, last] = case.paper;
        let _ = write!(
            out,
            "\n## {}: {} ({} candidates), {} contacts{}, {} × {}\n\n\
             Paper: {first} → {last}, ratio {:.1}.\n\n\
             | method | first ε | last ε | sd | least | greatest | last / first | evaluations | s |\n\
             |---|--:|--:|--:|--:|--:|--:|--:|--:|\n",
            case.name,
            one.file,
            one.candidates,
            case.contacts,
            if case.friction {
                ", μ 0.2"
            } else {
                ", frictionless"
            },
            case.population,
            case.generations,
            last / first
        );
        for row in &one.rows {
            let Some(last) = row.last() else {
                let _ = writeln!(out, "| {} | – | none | | | | | | |", row.method);
                continue;
            };
            let (first, ratio) = row
                .first()
                .map_or(("–".to_owned(), "–".to_owned()), |first| {
                    let ratio = last.mean / first.mean;
                    (format!("{:.4}", first.mean), format!("{ratio:.1}"))
                });
            let _ = writeln!(
                out,
                "| {} | {first} | {:.4} | {:.4} | {:.4} | {:.4} | {ratio} | {:.0} | {:.3} |",
                row.method,
                last.mean,
                last.sd,
                last.min,
                last.max,
                row.mean(|result| result.evaluations as f64),
                row.mean(|result| result.elapsed_s)
            );
        }
        let _ = writeln!(
            out,
            "\n![best quality over evaluations]({}-history.svg)",
            case.name
        );
        if one.grid.is_empty() {
            continue;
        }
        out += "\nAverage quality of `modified_ga`:\n\n| population |";
        for generations in GENERATIONS {
            let _ = write!(out, " {generations} generations |");
        }
        out += "\n|--:|--:|--:|--:|\n";
        for (population, cells) in POPULATIONS.iter().zip(&one.grid) {
            let _ = write!(out, "| {population} |");
            for cell in cells {
                let _ = write!(out, " {:.4} |", mean(cell));
            }
            out += "\n";
        }
        let _ = writeln!(
            out,
            "\n![average quality over population]({}-grid.svg)",
            case.name
        );
    }
    out
}

fn table_csv(measured: &[Measured]) -> String {
    let mut out = "case,mesh,method,seed,first,last,evaluations,elapsed_s\n".to_owned();
    for one in measured {
        for row in &one.rows {
            for result in &row.results {
                let number = |value: Option<f64>| value.map_or(String::new(), |x| x.to_string());
                let _ = writeln!(
                    out,
                    "{},{},{},{},{},{},{},{}",
                    one.case.name,
                    one.file,
                    row.method,
                    result.seed,
                    number(result.initial.as_ref().map(|grasp| grasp.quality)),
                    number(result.quality),
                    result.evaluations,
                    result.elapsed_s
                );
            }
        }
    }
    out
}

fn grids_csv(measured: &[Measured]) -> String {
    let mut out = "case,population,generations,mean,sd,min,max\n".to_owned();
    for one in measured {
        for (population, cells) in POPULATIONS.iter().zip(&one.grid) {
            for (generations, cell) in GENERATIONS.iter().zip(cells) {
                if let Some(Statistics { mean, sd, min, max }) =
                    Statistics::of(cell.iter().copied())
                {
                    let name = one.case.name;
                    let _ = writeln!(
                        out,
                        "{name},{population},{generations},{mean},{sd},{min},{max}"
                    );
                }
            }
        }
    }
    out
}

/// Plots the best quality so far over the evaluations, in generations of the genetic algorithm.
fn history(one: &Measured) -> String {
    let population = f64::from(one.case.population);
    let curve = |row: &Row| Curve {
        name: row.method.to_owned(),
        points: (0..=one.case.generations)
            .map(|generation| {
                let spent = (f64::from(generation) + 1.0) * population;
                [
                    f64::from(generation),
                    row.mean(|result| best_within(result, spent)),
                ]
            })
            .collect(),
    };
    plot(
        &format!(
            "{}: best quality, mean of {} runs",
            one.case.name,
            one.runs()
        ),
        "evaluations, in generations of the genetic algorithm",
        "quality",
        &one.rows.iter().map(curve).collect::<Vec<_>>(),
    )
}

/// Returns the best quality of a run after so many evaluations.
fn best_within(result: &crate::wire::PlanResult, evaluations: f64) -> f64 {
    let first = result.initial.as_ref().map_or(0.0, |grasp| grasp.quality);
    let entries = result.history.iter();
    let known = entries.take_while(|entry| entry.evaluations as f64 <= evaluations);
    known.filter_map(|entry| entry.best).fold(first, f64::max)
}

fn grid(one: &Measured) -> String {
    let curve = |(i, generations): (usize, &u32)| Curve {
        name: format!("{generations} gen."),
        points: POPULATIONS
            .iter()
            .zip(&one.grid)
            .map(|(population, cells)| [f64::from(*population), mean(&cells[i])])
            .collect(),
    };
    plot(
        &format!(
            "{}: modified_ga, mean of {} runs",
            one.case.name,
            one.runs()
        ),
        "population",
        "quality",
        &GENERATIONS
            .iter()
            .enumerate()
            .map(curve)
            .collect::<Vec<_>>(),
    )
}

impl Measured {
    fn runs(&self) -> usize {
        self.rows.first().map_or(0, |row| row.results.len())
    }
}

impl Row {
    fn first(&self) -> Option<Statistics> {
        let first = self
            .results
            .iter()
            .filter_map(|result| result.initial.as_ref());
        Statistics::of(first.map(|grasp| grasp.quality))
    }

    /// Statistics of the runs that found a grasp.
    fn last(&self) -> Option<Statistics> {
        Statistics::of(self.results.iter().filter_map(|result| result.quality))
    }

    fn mean(&self, of: impl Fn(&crate::wire::PlanResult) -> f64) -> f64 {
        mean(&self.results.iter().map(of).collect::<Vec<_>>())
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}
