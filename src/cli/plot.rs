//! The convergence of a search as a plot in braille characters for a terminal.
//!
//! The plot is drawn here and not by a crate: it is one curve on a fixed grid, and the known crates draw axes and frames
//! that would not fit below a table.

use std::env;
use std::io::IsTerminal;

use crate::wire::PlanResult;

/// Greatest and least width of the curve and its height, in characters of 2 × 4 dots.
const MAX_COLUMNS: usize = 56;
const MIN_COLUMNS: usize = 20;
const ROWS: usize = 6;
const USUAL_WIDTH: usize = 80;
/// Width of the scale on the left, including the space after it.
const SCALE: usize = 11;
const BLANK: u32 = 0x2800;
/// The bits of the dots of a braille character, by column and row.
const DOTS: [[u32; 4]; 2] = [[0x01, 0x02, 0x04, 0x40], [0x08, 0x10, 0x20, 0x80]];

/// Whether standard output is a terminal that shows braille characters: not a dumb one, and in UTF-8.
pub fn is_possible() -> bool {
    let is_utf8 = ["LC_ALL", "LC_CTYPE", "LANG"]
        .into_iter()
        .filter_map(|name| env::var(name).ok())
        .find(|value| !value.is_empty())
        .is_some_and(|value| {
            let value = value.to_ascii_lowercase();
            value.contains("utf-8") || value.contains("utf8")
        });
    let is_dumb = env::var("TERM").is_ok_and(|term| term == "dumb");
    std::io::stdout().is_terminal() && is_utf8 && !is_dumb
}

/// Returns the width of the terminal in characters, or the usual width if it is unknown.
pub fn width() -> usize {
    match rustix::termios::tcgetwinsize(std::io::stdout()) {
        Ok(size) if size.ws_col > 0 => size.ws_col.into(),
        _ => USUAL_WIDTH,
    }
}

/// Plots the best quality over the generations, with a scale on the left, in lines of at most `width` characters. Returns
/// `None` if the quality does not rise or there is too little room.
pub fn convergence(result: &PlanResult, width: usize) -> Option<String> {
    let columns = width.checked_sub(SCALE)?.min(MAX_COLUMNS);
    if columns < MIN_COLUMNS {
        return None;
    }
    let known = result.history.iter();
    let points: Vec<(u64, f64)> = known
        .filter_map(|entry| Some((entry.generation, entry.best?)))
        .collect();
    let (&(first, start), &(last, end)) = (points.first()?, points.last()?);
    if last == first || end <= start {
        return None;
    }
    let (width, height) = (2 * columns, 4 * ROWS);
    let mut cells = vec![BLANK; columns * ROWS];
    let mut before: Option<usize> = None;
    for column in 0..width {
        let generation = first + (last - first) * column as u64 / (width as u64 - 1);
        let reached = points.partition_point(|(at, _)| *at <= generation).max(1);
        let share = (points[reached - 1].1 - start) / (end - start);
        let level = ((height - 1) as f64 * share.clamp(0.0, 1.0)).round() as usize;
        // A step upwards is drawn as a vertical line.
        for level in before.unwrap_or(level).min(level)..=level {
            let row = height - 1 - level;
            cells[row / 4 * columns + column / 2] |= DOTS[column % 2][row % 4];
        }
        before = Some(level);
    }
    let mut out = String::new();
    for (row, cells) in cells.chunks(columns).enumerate() {
        let scale = match row {
            0 => format!("{end:.6}"),
            _ if row == ROWS - 1 => format!("{start:.6}"),
            _ => String::new(),
        };
        let line: String = cells
            .iter()
            .filter_map(|cell| char::from_u32(*cell))
            .collect();
        let line = line.trim_end_matches('\u{2800}');
        out.push_str(format!("{scale:>10} {line}").trim_end());
        out.push('\n');
    }
    let axis = format!("generation {first}");
    out.push_str(&format!(
        "{:>10} {axis}{last:>1$}\n",
        "",
        columns - axis.len()
    ));
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::HistoryEntry;

    const RISING: [(u64, Option<f64>); 4] =
        [(0, None), (1, Some(0.1)), (2, Some(0.2)), (4, Some(0.3))];

    fn with(history: &[(u64, Option<f64>)]) -> PlanResult {
        let text = include_str!("../../openapi/examples/result.json");
        let mut result: PlanResult = serde_json::from_str(text).unwrap();
        let entry = |&(generation, best)| HistoryEntry {
            generation,
            best,
            mean: best,
            force_closures: 1,
            evaluations: 1,
            elapsed_s: 0.0,
        };
        result.history = history.iter().map(entry).collect();
        result
    }

    #[test]
    fn a_curve_rises_from_the_lower_left_to_the_upper_right() {
        let plot = convergence(&with(&RISING), 200).unwrap();
        let lines: Vec<&str> = plot.lines().collect();
        assert_eq!(lines.len(), ROWS + 1);
        assert!(lines[0].starts_with("  0.300000 ") && lines[ROWS - 1].starts_with("  0.100000 "));
        let dots = |line: &str| line.chars().position(|c| c as u32 > BLANK).unwrap();
        assert_eq!(dots(lines[ROWS - 1]), SCALE);
        assert!(dots(lines[0]) > SCALE + MAX_COLUMNS / 2);
        assert!(lines[ROWS].contains("generation 1") && lines[ROWS].ends_with('4'));
    }

    #[test]
    fn a_curve_fits_into_the_terminal_or_is_left_out() {
        let longest = |width| {
            let plot = convergence(&with(&RISING), width)?;
            plot.lines().map(|line| line.chars().count()).max()
        };
        let most = SCALE + MAX_COLUMNS;
        for width in [SCALE + MIN_COLUMNS, 40, 60, most] {
            assert_eq!(longest(width), Some(width));
        }
        assert_eq!(longest(200), Some(most));
        assert_eq!(longest(SCALE + MIN_COLUMNS - 1), None);
        assert_eq!(longest(0), None);
    }

    #[test]
    fn a_quality_that_does_not_rise_has_no_plot() {
        for history in [
            &[][..],
            &[(0, None), (1, None)],
            &[(0, Some(0.1))],
            &[(0, Some(0.1)), (5, Some(0.1))],
        ] {
            assert_eq!(convergence(&with(history), 80), None);
        }
    }
}
