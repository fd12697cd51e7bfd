//! Reports on a batch: its progress on standard error, and the table at its end.

use std::fmt::Write;
use std::io::{IsTerminal, stderr};
use std::sync::Arc;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use parking_lot::Mutex;

use super::journal::{End, Outcome};
use crate::cli::exit::{EXIT_INPUT, EXIT_NO_GRASP};
use crate::cli::print_error;

/// The table in the folder of the results.
pub const SUMMARY: &str = "summary.csv";
/// Least time between two lines that say why the batch waits.
const WAITING_INTERVAL: Duration = Duration::from_secs(5);

/// A mesh and its outcome.
pub struct Row {
    /// The path as given.
    pub file: String,
    /// The name of its result.
    pub output: String,
    pub outcome: Outcome,
}

/// Shows the progress on standard error: as a bar on a terminal, otherwise as a line for each mesh. Clones share their
/// state.
#[derive(Clone)]
pub struct Board {
    bar: ProgressBar,
    is_terminal: bool,
    /// When the last line about waiting was printed.
    last_waiting: Arc<Mutex<Option<Instant>>>,
}

impl Board {
    /// Creates the board for a number of meshes.
    pub fn new(meshes: usize) -> Self {
        let style =
            ProgressStyle::with_template("{bar:30} {pos}/{len} meshes {elapsed} {wide_msg}")
                .unwrap_or_else(|_| ProgressStyle::default_bar());
        Self {
            bar: ProgressBar::new(meshes as u64).with_style(style),
            is_terminal: stderr().is_terminal(),
            last_waiting: Arc::default(),
        }
    }

    /// Counts a finished mesh, and reports it unless an earlier run has done so.
    pub fn ended(&self, row: &Row, is_new: bool) {
        self.bar.inc(1);
        self.bar.set_message("");
        let Row { file, outcome, .. } = row;
        let is_problem = outcome.problem.is_some();
        if is_new && (is_problem || !self.is_terminal) {
            let words = match (&outcome.problem, outcome.found) {
                (Some(problem), _) => format!("{}: {problem}", outcome.state.name()),
                (None, Some(found)) if found.force_closure => {
                    format!("quality {}", number(found.quality))
                }
                (None, _) => "no force closure".to_owned(),
            };
            let (done, all) = (self.bar.position(), self.bar.length().unwrap_or_default());
            self.print(&format!("[{done}/{all}] {file}: {words}"));
        }
    }

    /// Reports why the batch waits for the server.
    pub fn waiting(&self, why: &str) {
        self.bar.set_message(format!("waiting: {why}"));
        let mut last = self.last_waiting.lock();
        if !self.is_terminal && last.is_none_or(|last| last.elapsed() >= WAITING_INTERVAL) {
            *last = Some(Instant::now());
            print_error(format_args!("waiting: {why}"));
        }
    }

    /// Says how many meshes are done.
    pub fn summary(&self) -> String {
        let all = self.bar.length().unwrap_or_default();
        format!("{} of {all} meshes done", self.bar.position())
    }

    /// Removes the bar.
    pub fn close(&self) {
        self.bar.finish_and_clear();
    }

    fn print(&self, line: &str) {
        match self.is_terminal {
            true => self.bar.println(line),
            false => print_error(line),
        }
    }
}

/// Returns the exit code for the worst outcome.
pub fn exit_code(rows: &[Row]) -> u8 {
    let is_failure = |row: &Row| row.outcome.state != End::Succeeded;
    let has_grasp = |row: &Row| row.outcome.found.is_some_and(|found| found.force_closure);
    match (rows.iter().any(is_failure), rows.iter().all(has_grasp)) {
        (true, _) => EXIT_INPUT,
        (false, false) => EXIT_NO_GRASP,
        (false, true) => 0,
    }
}

const COLUMNS: [&str; 8] = [
    "file",
    "output",
    "state",
    "force_closure",
    "quality",
    "evaluations",
    "seconds",
    "problem",
];

/// Formats the rows as CSV (RFC 4180).
pub fn csv(rows: &[Row]) -> String {
    let mut out = COLUMNS.join(",") + "\r\n";
    for row in rows {
        let quoted = cells(row).map(|cell| match cell.contains([',', '"', '\n', '\r']) {
            true => format!("\"{}\"", cell.replace('"', "\"\"")),
            false => cell,
        });
        out += &(quoted.join(",") + "\r\n");
    }
    out
}

/// Formats the rows as a readable table, followed by the number of meshes in each state.
pub fn table(rows: &[Row]) -> String {
    let shown = |row: &Row| {
        let [
            file,
            _,
            state,
            closure,
            quality,
            evaluations,
            seconds,
            problem,
        ] = cells(row);
        [file, state, closure, quality, evaluations, seconds, problem]
    };
    let heading = [
        "file",
        "state",
        "force closure",
        "quality",
        "evaluations",
        "seconds",
        "problem",
    ];
    let mut lines = vec![heading.map(str::to_owned)];
    lines.extend(rows.iter().map(shown));
    let widths: [usize; 7] = std::array::from_fn(|column| {
        let widths = lines.iter().map(|line| line[column].chars().count());
        widths.max().unwrap_or_default()
    });
    let mut out = String::new();
    for line in &lines {
        let mut text = String::new();
        for (column, cell) in line.iter().enumerate() {
            let width = widths[column];
            // Writing to a string cannot fail.
            let _ = match column {
                3..=5 => write!(text, "{cell:>width$}  "),
                _ => write!(text, "{cell:<width$}  "),
            };
        }
        out += text.trim_end();
        out.push('\n');
    }
    let count = |end| rows.iter().filter(|row| row.outcome.state == end).count();
    let ends = [
        End::Succeeded,
        End::Failed,
        End::Cancelled,
        End::Refused,
        End::Unreadable,
    ];
    let counted = ends.map(|end| (count(end), end.name()));
    let counted = counted.iter().filter(|(count, _)| *count > 0);
    let counted: Vec<String> = counted
        .map(|(count, name)| format!("{count} {name}"))
        .collect();
    let _ = write!(out, "\n{} meshes: {}\n", rows.len(), counted.join(", "));
    out
}

fn cells(row: &Row) -> [String; 8] {
    let Outcome {
        state,
        found,
        problem,
    } = &row.outcome;
    let of = |text: fn(&super::journal::ResultSummary) -> String| {
        found.as_ref().map_or(String::new(), text)
    };
    [
        row.file.clone(),
        found.map_or(String::new(), |_| row.output.clone()),
        state.name().to_owned(),
        of(|found| found.force_closure.to_string()),
        found.map_or(String::new(), |found| number(found.quality)),
        of(|found| found.evaluations.to_string()),
        of(|found| format!("{:.3}", found.elapsed_s)),
        problem.clone().unwrap_or_default(),
    ]
}

fn number(quality: Option<f64>) -> String {
    quality.map_or_else(String::new, |quality| format!("{quality:.6}"))
}

#[cfg(test)]
mod tests {
    use super::super::journal::ResultSummary;
    use super::*;

    fn row(file: &str, state: End, found: Option<bool>, problem: Option<&str>) -> Row {
        let found = found.map(|force_closure| ResultSummary {
            force_closure,
            quality: force_closure.then_some(0.25),
            evaluations: 10,
            elapsed_s: 0.5,
        });
        Row {
            file: file.to_owned(),
            output: format!("{file}.json"),
            outcome: Outcome {
                state,
                found,
                problem: problem.map(str::to_owned),
            },
        }
    }

    #[test]
    fn the_exit_code_is_that_of_the_worst_outcome() {
        let good = || row("a", End::Succeeded, Some(true), None);
        let none = || row("b", End::Succeeded, Some(false), None);
        let bad = || row("c", End::Refused, None, Some("flat"));
        assert_eq!(exit_code(&[good()]), 0);
        assert_eq!(exit_code(&[good(), none()]), 3);
        assert_eq!(exit_code(&[none(), bad(), good()]), 1);
    }

    #[test]
    fn cells_that_need_it_are_quoted() {
        let rows = [
            row("a,b", End::Succeeded, Some(true), None),
            row("c", End::Refused, None, Some("no \"mesh\"")),
        ];
        let expected = "file,output,state,force_closure,quality,evaluations,seconds,problem\r\n\
            \"a,b\",\"a,b.json\",succeeded,true,0.250000,10,0.500,\r\n\
            c,,refused,,,,,\"no \"\"mesh\"\"\"\r\n";
        assert_eq!(csv(&rows), expected);
        let table = table(&rows);
        assert!(
            table.contains("a,b   succeeded  true           0.250000           10    0.500\n"),
            "{table}"
        );
        assert!(
            table.ends_with("2 meshes: 1 succeeded, 1 refused\n"),
            "{table}"
        );
    }
}
