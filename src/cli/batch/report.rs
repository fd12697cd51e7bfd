//! What is told while the work goes on, and of all of it at the end.

use std::fmt::Write;
use std::io::{IsTerminal, stderr};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::journal::{End, Outcome};
use crate::cli::complain;
use crate::cli::exit::{EXIT_INPUT, EXIT_NO_GRASP};

/// The table in the folder of the results.
pub const SUMMARY: &str = "summary.csv";
/// Time between two lines that tell what is waited for.
const WAITS_EVERY: Duration = Duration::from_secs(5);

/// A mesh, and what became of it.
pub struct Row {
    /// As it was given.
    pub file: String,
    /// The name of its result.
    pub output: String,
    pub outcome: Outcome,
}

/// Tells on standard error how far the work is: a bar on a terminal, else a line for each mesh. Clones are the
/// same one.
#[derive(Clone)]
pub struct Board {
    bar: ProgressBar,
    is_terminal: bool,
    /// When it was last told what is waited for.
    waits: Arc<Mutex<Option<Instant>>>,
}

impl Board {
    /// For so many meshes.
    pub fn new(meshes: usize) -> Self {
        let style =
            ProgressStyle::with_template("{bar:30} {pos}/{len} meshes {elapsed} {wide_msg}")
                .unwrap_or_else(|_| ProgressStyle::default_bar());
        Self {
            bar: ProgressBar::new(meshes as u64).with_style(style),
            is_terminal: stderr().is_terminal(),
            waits: Arc::default(),
        }
    }

    /// A mesh is done with; unless that is new, it was before.
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
            self.say(&format!("[{done}/{all}] {file}: {words}"));
        }
    }

    /// The server does not do what is asked, for now.
    pub fn waits(&self, why: &str) {
        self.bar.set_message(format!("waiting: {why}"));
        let mut last = self.waits.lock().unwrap_or_else(PoisonError::into_inner);
        if !self.is_terminal && last.is_none_or(|last| last.elapsed() >= WAITS_EVERY) {
            *last = Some(Instant::now());
            complain(format_args!("waiting: {why}"));
        }
    }

    /// How much is done, in words.
    pub fn standing(&self) -> String {
        let all = self.bar.length().unwrap_or_default();
        format!("{} of {all} meshes done", self.bar.position())
    }

    /// Takes the bar away.
    pub fn close(&self) {
        self.bar.finish_and_clear();
    }

    fn say(&self, line: &str) {
        match self.is_terminal {
            true => self.bar.println(line),
            false => complain(line),
        }
    }
}

/// The code to end with.
pub fn worst(rows: &[Row]) -> u8 {
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

/// The rows as a table (RFC 4180).
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

/// The rows as a table for people, and how many there are of each kind.
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
    let of =
        |text: fn(&super::journal::Found) -> String| found.as_ref().map_or(String::new(), text);
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
    use super::super::journal::Found;
    use super::*;

    fn row(file: &str, state: End, found: Option<bool>, problem: Option<&str>) -> Row {
        let found = found.map(|force_closure| Found {
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
    fn the_code_tells_the_worst() {
        let good = || row("a", End::Succeeded, Some(true), None);
        let none = || row("b", End::Succeeded, Some(false), None);
        let bad = || row("c", End::Refused, None, Some("flat"));
        assert_eq!(worst(&[good()]), 0);
        assert_eq!(worst(&[good(), none()]), 3);
        assert_eq!(worst(&[none(), bad(), good()]), 1);
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
