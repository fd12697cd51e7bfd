//! A plot of the quality over the generations.
//!
//! The SVG is written here and not by a plotting crate: it follows the light or dark theme of the viewer, which needs style
//! rules that such crates do not write.

use std::fmt::Write as _;

use super::text::{self, TITLE_SIZE, figure};
use super::{Background, MAX_WIDTH, MIN_WIDTH, PictureError, raster};
use crate::wire::{HistoryEntry, PlanResult};

const WIDTH: f64 = 1024.0;
const HEIGHT: f64 = 560.0;
/// Margins around the curves: left, top, right, bottom.
const MARGIN: [f64; 4] = [92.0, 84.0, 150.0, 104.0];
/// Approximate number of labels of an axis.
const TICKS: f64 = 6.0;

/// Plots the best and mean quality ε over the generations of a search, the first grasp, and the gain of the final polish.
///
/// `title` may be any text. O(history).
pub fn convergence_svg(result: &PlanResult, title: &str, background: Background) -> String {
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" \
         height=\"{HEIGHT}\" role=\"img\" font-family=\"DejaVu Sans,system-ui,sans-serif\" font-size=\"14\">\n\
         <style>{}</style>\n<title>{title}</title>\n\
         <rect class=\"paper\" width=\"100%\" height=\"100%\"/>\n\
         <text class=\"text\" x=\"{}\" y=\"38\" font-size=\"{TITLE_SIZE}\" font-weight=\"bold\">{heading}</text>\n\
         <text class=\"muted\" x=\"{}\" y=\"62\">quality ε over generations</text>\n",
        background.style(),
        MARGIN[0],
        MARGIN[0],
        title = text::escape(title),
        heading = text::title(title),
    );
    let best = known(&result.history, |entry| entry.best);
    match best.is_empty() {
        true => {
            let (x, y) = (WIDTH / 2.0, HEIGHT / 2.0);
            // Writing to a string cannot fail.
            let _ = writeln!(
                out,
                "<text class=\"muted\" x=\"{x}\" y=\"{y}\" text-anchor=\"middle\">no force-closure grasp was \
                 found in any generation</text>"
            );
        }
        false => curves(&mut out, result, &best),
    }
    out.push_str("</svg>\n");
    out
}

/// The same plot as a PNG of a width in pixels, light unless the background is dark.
///
/// # Errors
/// Only faults that the caller cannot remedy.
pub fn convergence_png(
    result: &PlanResult,
    title: &str,
    background: Background,
    width: u32,
) -> Result<Vec<u8>, PictureError> {
    let svg = convergence_svg(result, title, background.opaque());
    let width = width.clamp(MIN_WIDTH, MAX_WIDTH);
    raster::png(&svg, width, background.paper(), None)
}

/// Size of such a PNG in pixels.
pub fn convergence_pixels(width: u32) -> u64 {
    let width = f64::from(width.clamp(MIN_WIDTH, MAX_WIDTH));
    (width * width * HEIGHT / WIDTH) as u64
}

fn known(history: &[HistoryEntry], value: impl Fn(&HistoryEntry) -> Option<f64>) -> Vec<[f64; 2]> {
    let points = history.iter().map(|entry| (entry.generation, value(entry)));
    points
        .filter_map(|(generation, value)| Some([generation as f64, value?]))
        .filter(|[_, value]| value.is_finite())
        .collect()
}

fn curves(out: &mut String, result: &PlanResult, best: &[[f64; 2]]) {
    let mean = known(&result.history, |entry| entry.mean);
    let initial = result.initial.as_ref().map(|initial| initial.quality);
    let polished = result.quality.filter(|_| result.polish.is_some());
    let last = result
        .history
        .last()
        .map_or(0.0, |entry| entry.generation as f64);
    let values = best.iter().chain(&mean).map(|[_, value]| *value);
    let values = values.chain(initial).chain(polished);
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    // The relative and absolute terms leave room around a single value.
    let room = (0.06 * (high - low)).max(0.02 * high.abs()).max(1e-12);
    let (low, high) = ((low - room).max(0.0), high + room);
    let across = last.max(1.0);
    let [left, top, right, bottom] = MARGIN;
    let x = |generation: f64| left + generation / across * (WIDTH - left - right);
    let y = |value: f64| HEIGHT - bottom - (value - low) / (high - low) * (HEIGHT - top - bottom);

    for value in ticks(low, high) {
        let _ = writeln!(
            out,
            "<line class=\"rule\" x1=\"{left}\" x2=\"{}\" y1=\"{at:.1}\" y2=\"{at:.1}\"/>\
             <text class=\"muted\" x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            WIDTH - right,
            left - 10.0,
            y(value) + 5.0,
            figure(value),
            at = y(value)
        );
    }
    let base = HEIGHT - bottom;
    for generation in ticks(0.0, across).filter(|generation| generation.fract() == 0.0) {
        let entry = result
            .history
            .iter()
            .find(|entry| entry.generation as f64 >= generation);
        let work = entry.map_or(String::new(), |entry| {
            format!("{}, {:.2} s", grouped(entry.evaluations), entry.elapsed_s)
        });
        let _ = writeln!(
            out,
            "<line class=\"rule\" x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{base}\" y2=\"{}\"/>\
             <text class=\"muted\" x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{generation}</text>\
             <text class=\"muted\" x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\" font-size=\"11\">{work}</text>",
            base + 6.0,
            base + 24.0,
            base + 44.0,
            at = x(generation)
        );
    }
    let _ = writeln!(
        out,
        "<text class=\"muted\" x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">generation; below it the grasps evaluated and the seconds so far</text>",
        (left + WIDTH - right) / 2.0,
        base + 74.0
    );
    if let Some(initial) = initial {
        let _ = writeln!(
            out,
            "<line class=\"mean\" x1=\"{left}\" x2=\"{end}\" y1=\"{at:.1}\" y2=\"{at:.1}\" stroke-width=\"1.2\" \
             stroke-dasharray=\"2 5\"/><text class=\"muted\" x=\"{}\" y=\"{:.1}\">first {}</text>",
            WIDTH - right + 10.0,
            y(initial) + 5.0,
            figure(initial),
            end = WIDTH - right,
            at = y(initial),
        );
    }
    let path = |points: &[[f64; 2]], steps: bool| {
        let mut path = String::new();
        for (index, [generation, value]) in points.iter().enumerate() {
            let (x, y) = (x(*generation), y(*value));
            let _ = match (index, steps) {
                (0, _) => write!(path, "M{x:.1} {y:.1}"),
                (_, true) => write!(path, "H{x:.1}V{y:.1}"),
                (_, false) => write!(path, "L{x:.1} {y:.1}"),
            };
        }
        path
    };
    let _ = writeln!(
        out,
        "<path class=\"mean\" d=\"{}\" fill=\"none\" stroke-width=\"1.5\" stroke-dasharray=\"6 4\"/>\n\
         <path class=\"curve\" d=\"{}\" fill=\"none\" stroke-width=\"2.5\"/>",
        path(&mean, false),
        path(best, true)
    );
    let mut labels: Vec<(f64, String, &'static str)> = Vec::new();
    let [_, found] = best[best.len() - 1];
    labels.push((y(found), format!("best {}", figure(found)), "text"));
    if let Some([_, value]) = mean.last() {
        labels.push((y(*value), format!("mean {}", figure(*value)), "muted"));
    }
    if let Some(polished) = polished {
        let at = x(last);
        let _ = writeln!(
            out,
            "<line class=\"curve\" x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{:.1}\" y2=\"{:.1}\" stroke-width=\"2.5\" \
             stroke-dasharray=\"2 3\"/><circle class=\"point\" cx=\"{at:.1}\" cy=\"{:.1}\" r=\"4.5\"/>",
            y(found),
            y(polished),
            y(polished)
        );
        labels.push((
            y(polished),
            format!("polished {}", figure(polished)),
            "text",
        ));
    }
    for (at, label, class) in apart(labels, initial.map(y)) {
        let _ = writeln!(
            out,
            "<text class=\"{class}\" x=\"{}\" y=\"{:.1}\">{label}</text>",
            WIDTH - right + 10.0,
            at + 5.0
        );
    }
}

/// Moves labels apart so that they can be read; a label at `taken` stays in place.
fn apart(
    mut labels: Vec<(f64, String, &'static str)>,
    taken: Option<f64>,
) -> Vec<(f64, String, &'static str)> {
    const GAP: f64 = 19.0;
    labels.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut lowest = taken.map_or(f64::INFINITY, |taken| taken - GAP);
    for label in &mut labels {
        // From the lowest label upwards.
        if label.0 > lowest && taken.is_none_or(|taken| label.0 < taken + GAP) {
            label.0 = lowest;
        }
        lowest = lowest.min(label.0 - GAP);
    }
    labels
}

/// Returns round numbers between two values.
fn ticks(low: f64, high: f64) -> impl Iterator<Item = f64> {
    let rough = (high - low) / TICKS;
    let power = 10_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|factor| factor * power)
        .find(|step| *step >= rough)
        .unwrap_or(rough);
    let first = (low / step).ceil() as i64;
    (first..)
        .map(move |index| index as f64 * step)
        .take_while(move |value| *value <= high * (1.0 + 1e-12))
        .take(100)
}

/// Formats a count with separated thousands.
fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut out = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

#[cfg(test)]
mod tests {
    use resvg::usvg::roxmltree::Document;

    use super::*;
    use crate::picture::tests::decoded;

    fn with(history: &[(u64, Option<f64>)]) -> PlanResult {
        let text = include_str!("../../openapi/examples/result.json");
        let mut result: PlanResult = serde_json::from_str(text).unwrap();
        let entry = |&(generation, best): &(u64, Option<f64>)| HistoryEntry {
            generation,
            best,
            mean: best.map(|best| best / 2.0),
            force_closures: 1,
            evaluations: 10 * generation,
            elapsed_s: generation as f64,
        };
        result.history = history.iter().map(entry).collect();
        result.initial = None;
        result
    }

    #[test]
    fn the_paper_reaches_to_the_edges() {
        let result = with(&[(0, Some(0.1)), (1, Some(0.2))]);
        for (background, paper) in [(Background::Light, 255), (Background::Dark, 0x16)] {
            let png = convergence_png(&result, "", background, 900).unwrap();
            let (.., pixels) = decoded(png);
            assert!(pixels.iter().all(|pixel| pixel[3] == 255));
            assert_eq!(pixels.last().unwrap()[0], paper);
        }
    }

    /// The points of the curve of the best quality.
    fn curve(svg: &str) -> Vec<[f64; 2]> {
        let document = Document::parse(svg).unwrap();
        let path = document
            .descendants()
            .find(|node| node.has_tag_name("path") && node.attribute("class") == Some("curve"));
        let path = path.and_then(|path| path.attribute("d")).unwrap();
        let mut at = [0.0; 2];
        let mut places = Vec::new();
        for step in path
            .split_inclusive(|c: char| c.is_ascii_digit())
            .collect::<String>()
            .replace('M', " M")
            .replace('H', " H")
            .replace('V', " V")
            .split_whitespace()
        {
            match (step.as_bytes()[0], step[1..].parse::<f64>()) {
                (b'M', Ok(x)) => at[0] = x,
                (b'H', Ok(x)) => at[0] = x,
                (b'V', Ok(y)) => at[1] = y,
                _ => at[1] = step.parse().unwrap(),
            }
            places.push(at);
        }
        places
    }

    #[test]
    fn the_curve_rises_from_generation_to_generation() {
        let history: Vec<_> = (0..=20).map(|n| (n, Some(0.01 * (n + 1) as f64))).collect();
        let svg = convergence_svg(&with(&history), "a search", Background::Light);
        let places = curve(&svg);
        assert!(places.len() > 20);
        let rises = |pair: &[[f64; 2]]| pair[1][0] >= pair[0][0];
        assert!(places.windows(2).skip(1).all(rises));
        // Down is positive.
        assert!(places.last().unwrap()[1] < places[2][1] - 100.0);
    }

    #[test]
    fn unusual_histories_are_drawn_too() {
        let long: Vec<_> = (0..1000)
            .map(|n| (1000 * n, Some(1e-9 * n as f64)))
            .collect();
        let histories: [&[(u64, Option<f64>)]; 6] = [
            &[],
            &[(0, None), (1, None)],
            &[(0, Some(0.2))],
            &[(0, Some(0.2)), (1, Some(0.2))],
            &[(0, None), (7, Some(1e300)), (9, Some(f64::INFINITY))],
            &long,
        ];
        for history in histories {
            for background in [Background::Light, Background::Dark, Background::Transparent] {
                let result = with(history);
                let svg = convergence_svg(&result, "<&>\u{0}", background);
                assert!(
                    Document::parse(&svg).is_ok() && !svg.contains("NaN"),
                    "{svg}"
                );
                let png = convergence_png(&result, "x", background, 320).unwrap();
                assert!(png.len() > 500);
            }
        }
    }
}
