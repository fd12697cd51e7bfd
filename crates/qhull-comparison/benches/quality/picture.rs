//! The growth of the time, as a picture.

use std::fmt::Write as _;

use crate::report::Growth;

/// Left edges and size of the two panels.
const LEFT: [f64; 2] = [80.0, 480.0];
const TOP: f64 = 50.0;
const WIDTH: f64 = 340.0;
const HEIGHT: f64 = 300.0;

/// Powers of ten of a microsecond at the lower and the upper edge.
const DECADES: [i32; 2] = [0, 6];

const ENGINE: &str = "#0072b2";
const QHULL: &str = "#d55e00";

/// Two panels, time on a logarithmic axis, engine below and Qhull above.
pub fn svg(growth: &[Growth; 2]) -> String {
    let mut picture = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 860 420\" width=\"860\" height=\"420\" \
         font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"860\" height=\"420\" fill=\"white\"/>\n",
    );
    for (panel, left) in growth.iter().zip(LEFT) {
        axes(&mut picture, panel, left);
        for (color, name, micros) in [
            (ENGINE, "graspd", times(panel, |c| c.engine.median)),
            (QHULL, "Qhull", times(panel, |c| c.qhull.median)),
        ] {
            line(&mut picture, panel, left, color, name, &micros);
        }
    }
    picture += "</svg>\n";
    picture
}

fn times(panel: &Growth, of: impl Fn(&crate::measure::Comparison) -> f64) -> Vec<(u32, f64)> {
    panel
        .rows
        .iter()
        .map(|(number, c)| (*number, of(c) * 1e6))
        .collect()
}

/// Horizontal place of a number on the axis of a panel.
fn x(panel: &Growth, left: f64, number: u32) -> f64 {
    let first = panel.rows.first().map_or(0, |row| row.0);
    let last = panel.rows.last().map_or(1, |row| row.0);
    let share = f64::from(number - first) / f64::from((last - first).max(1));
    left + 15.0 + share * (WIDTH - 30.0)
}

/// Vertical place of a time.
fn y(micros: f64) -> f64 {
    let [low, high] = DECADES.map(f64::from);
    let share = (micros.log10() - low) / (high - low);
    TOP + HEIGHT * (1.0 - share.clamp(0.0, 1.0))
}

fn axes(picture: &mut String, panel: &Growth, left: f64) {
    let (right, bottom) = (left + WIDTH, TOP + HEIGHT);
    for decade in DECADES[0]..=DECADES[1] {
        let height = y(10_f64.powi(decade));
        let label = ["1 µs", "10 µs", "100 µs", "1 ms", "10 ms", "100 ms", "1 s"][decade as usize];
        let _ = writeln!(
            picture,
            "<line x1=\"{left}\" x2=\"{right}\" y1=\"{height:.1}\" y2=\"{height:.1}\" stroke=\"#ddd\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
            left - 6.0,
            height + 4.0,
        );
    }
    for (number, _) in &panel.rows {
        let _ = writeln!(
            picture,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{number}</text>",
            x(panel, left, *number),
            bottom + 18.0,
        );
    }
    let middle = left + WIDTH / 2.0;
    let _ = writeln!(
        picture,
        "<rect x=\"{left}\" y=\"{TOP}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"none\" stroke=\"#888\"/>\
         <text x=\"{middle}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\
         <text x=\"{middle}\" y=\"{:.1}\" text-anchor=\"middle\">time for one ε</text>",
        bottom + 40.0,
        panel.what,
        TOP - 14.0,
    );
}

fn line(
    picture: &mut String,
    panel: &Growth,
    left: f64,
    color: &str,
    name: &str,
    micros: &[(u32, f64)],
) {
    let places: Vec<(f64, f64)> = micros
        .iter()
        .map(|&(number, time)| (x(panel, left, number), y(time)))
        .collect();
    let points: Vec<String> = places
        .iter()
        .map(|(x, y)| format!("{x:.1},{y:.1}"))
        .collect();
    let _ = writeln!(
        picture,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\"/>",
        points.join(" "),
    );
    for (x, y) in &places {
        let _ = writeln!(
            picture,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"{color}\"/>"
        );
    }
    if let Some((x, y)) = places.get(places.len() / 2) {
        let _ = writeln!(
            picture,
            "<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"{color}\">{name}</text>",
            y - 12.0,
        );
    }
}
