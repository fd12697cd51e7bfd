//! How the time of a search grows with the candidates.

use std::fmt::Write as _;
use std::time::Instant;

use graspd_core::Interrupt;
use graspd_core::search::Budget;

use super::{bodies, compare_genetic, memetic_settings, problem, quality, search};

/// Cells of the body: 2,028, 20,172, 199,692 and 1,002,252 triangles.
const CELLS: [u32; 4] = [13, 41, 129, 289];

const SEEDS: u64 = 5;

/// One size of the body.
pub struct Size {
    candidates: usize,
    /// Seconds that the triangles took to become candidates.
    prepared: f64,
    /// Mean evaluations and seconds of the memetic search, and the mean ε it found.
    evaluations: f64,
    memetic: f64,
    found: f64,
    /// Mean seconds and ε of the genetic algorithm.
    genetic: f64,
    paper: f64,
}

pub fn measure() -> Vec<Size> {
    CELLS.iter().map(|&cells| size(cells)).collect()
}

fn size(cells: u32) -> Size {
    let begun = Instant::now();
    let mesh = bodies::pebble(cells);
    let problem = problem(&mesh, 4, true);
    let mut size = Size {
        candidates: problem.len(),
        prepared: begun.elapsed().as_secs_f64(),
        evaluations: 0.0,
        memetic: 0.0,
        found: 0.0,
        genetic: 0.0,
        paper: 0.0,
    };
    let share = 1.0 / SEEDS as f64;
    for seed in 0..SEEDS {
        let begun = Instant::now();
        let mut budget = Budget::new(None);
        let outcome = search(
            &problem,
            seed,
            &memetic_settings(8, 1),
            &mut budget,
            Interrupt::never(),
            &mut |_| {},
        );
        size.memetic += begun.elapsed().as_secs_f64() * share;
        size.evaluations += budget.spent() as f64 * share;
        size.found += quality(&outcome) * share;
    }
    (size.paper, size.genetic) = compare_genetic(&problem, 200, 20, SEEDS);
    size
}

/// The section of the page.
pub fn text(sizes: &[Size]) -> String {
    let mut out = format!(
        "\n## Growth with the candidates\n\n![Seconds over candidates](planner-growth.svg)\n\n\
         A body with bumps and without symmetry, cut into more and more even triangles; four contacts, μ 0.2, 8 \
         edges; means over seeds 0 to {}. Memetic: until eight climbers have arrived at optima that are proven \
         over all candidates. GA: the paper's, population 200, 20 generations. Prepared: from triangles to \
         candidates.\n\n\
         | candidates | prepared, s | memetic: evaluations | s | ε | GA, s | ε |\n\
         |--:|--:|--:|--:|--:|--:|--:|\n",
        SEEDS - 1
    );
    for size in sizes {
        let _ = writeln!(
            out,
            "| {} | {:.3} | {:.0} | {:.3} | {:.4} | {:.3} | {:.4} |",
            size.candidates,
            size.prepared,
            size.evaluations,
            size.memetic,
            size.found,
            size.genetic,
            size.paper
        );
    }
    out
}

/// Powers of ten of the axes: candidates, seconds.
const ACROSS: [f64; 2] = [3.0, 6.5];
const UP: [f64; 2] = [-3.0, 1.0];
/// The panel.
const LEFT: f64 = 70.0;
const TOP: f64 = 40.0;
const WIDTH: f64 = 440.0;
const HEIGHT: f64 = 280.0;

/// Seconds over candidates, both axes logarithmic.
pub fn picture(sizes: &[Size]) -> String {
    let x = |value: f64| LEFT + (value.log10() - ACROSS[0]) / (ACROSS[1] - ACROSS[0]) * WIDTH;
    let y = |value: f64| TOP + (UP[1] - value.log10()) / (UP[1] - UP[0]) * HEIGHT;
    let mut out = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 640 380\" width=\"640\" height=\"380\" \
         font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"640\" height=\"380\" fill=\"white\"/>\n",
    );
    for (seconds, label) in [
        (1e-3, "1 ms"),
        (1e-2, "10 ms"),
        (1e-1, "0.1 s"),
        (1.0, "1 s"),
        (10.0, "10 s"),
    ] {
        let _ = writeln!(
            out,
            "<line x1=\"{LEFT}\" x2=\"{}\" y1=\"{at:.1}\" y2=\"{at:.1}\" stroke=\"#ddd\"/>\
             <text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
            LEFT + WIDTH,
            LEFT - 6.0,
            y(seconds) + 4.0,
            at = y(seconds)
        );
    }
    for (candidates, label) in [(1e3, "1 k"), (1e4, "10 k"), (1e5, "100 k"), (1e6, "1 M")] {
        let _ = writeln!(
            out,
            "<text x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">{label}</text>",
            x(candidates),
            TOP + HEIGHT + 18.0
        );
    }
    let _ = writeln!(
        out,
        "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">candidates</text>",
        LEFT + WIDTH / 2.0,
        TOP + HEIGHT + 40.0
    );
    let curves = [
        ("memetic, 8 optima", "#0072b2"),
        ("modified_ga", "#d55e00"),
        ("preparation", "#777777"),
    ];
    for (i, (name, color)) in curves.into_iter().enumerate() {
        let seconds = |size: &Size| [size.memetic, size.genetic, size.prepared][i].max(1e-3);
        let place = |size: &Size| [x(size.candidates as f64), y(seconds(size))];
        let places: Vec<[f64; 2]> = sizes.iter().map(place).collect();
        let points: Vec<String> = places
            .iter()
            .map(|[x, y]| format!("{x:.1},{y:.1}"))
            .collect();
        let _ = writeln!(
            out,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\"/>",
            points.join(" ")
        );
        if let Some([x, y]) = places.last() {
            // Their ends are close to one another.
            let lower = [0.0, 2.0, 14.0][i];
            let _ = writeln!(
                out,
                "<text x=\"{:.1}\" y=\"{:.1}\" fill=\"{color}\">{name}</text>",
                x + 6.0,
                y + lower
            );
        }
    }
    out + "</svg>\n"
}
