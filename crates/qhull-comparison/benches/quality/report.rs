//! The measurements as a page of Markdown.

use std::ffi::CStr;
use std::fmt::Write as _;

use qhull_comparison::{GRASPIT, PLAIN, TRIANGULATED};
use testkit::cases::{Body, Case, Source};

use crate::measure::{Comparison, Effort, compare};

/// The cases of the main table.
const CASES: [Case; 4] = [
    Case::hard(4, 8, 0.2),
    Case::hard(4, 8, 0.5),
    Case::hard(5, 16, 0.5),
    Case::frictionless(7),
];

/// Friction of the grasps whose number of contacts or edges grows.
const GROWTH_FRICTION: f64 = 0.5;

/// How the time grows with one number.
pub struct Growth {
    /// What grows.
    pub what: &'static str,
    pub rows: Vec<(u32, Comparison)>,
}

/// Contacts from 3 to 12 with 8 edges, and 4 contacts with 4 to 32 edges, random closures on the last body.
pub fn growth(bodies: &[Body], effort: Effort) -> [Growth; 2] {
    let Some(body) = bodies.last() else {
        return [("contacts of 8 edges"), ("edges of 4 contacts")].map(|what| Growth {
            what,
            rows: Vec::new(),
        });
    };
    let row = |number: u32, case: Case| {
        let sets = body.sets(&case, Source::Closures, 200);
        compare(&sets, PLAIN, effort).map(|comparison| (number, comparison))
    };
    let contacts = (3..=12).filter_map(|m| row(m, Case::hard(m as usize, 8, GROWTH_FRICTION)));
    let edges = [4, 6, 8, 12, 16, 24, 32];
    let edges = edges
        .into_iter()
        .filter_map(|r| row(r, Case::hard(4, r, GROWTH_FRICTION)));
    [
        Growth {
            what: "contacts of 8 edges",
            rows: contacts.collect(),
        },
        Growth {
            what: "edges of 4 contacts",
            rows: edges.collect(),
        },
    ]
}

/// The page.
pub fn text(bodies: &[Body], effort: Effort, growth: &[Growth]) -> String {
    let mut page = String::from(HEAD);
    let _ = writeln!(
        page,
        "\nProcessor: {}; {} rounds.\n",
        processor(),
        effort.rounds
    );
    page += "## Grasps of three bodies\n\n";
    page += "| body | contacts × edges | grasps | closures | facets | engine µs | ± | Qhull µs | ± | ratio | batched µs | ratio |\n";
    page += "|---|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";
    for case in CASES {
        for body in bodies {
            for source in Source::ALL {
                let sets = body.sets(&case, source, 200);
                let head = format!("| {} | {} | {} ", body.name, case.name(), source.name());
                page += &head;
                match compare(&sets, PLAIN, effort) {
                    Some(comparison) => page += &cells(&comparison),
                    None => page += "| none found | | | | | | | | |\n",
                }
            }
        }
    }
    page += "\n## Options of Qhull\n\n";
    page += "Random closures of 4 contacts × 8 edges, μ 0.2, on the last body.\n\n";
    page += "| options | who asks for them | Qhull µs | ± |\n|---|---|--:|--:|\n";
    for (options, who) in OPTIONS {
        let sets = bodies
            .last()
            .map(|body| body.sets(&CASES[0], Source::Closures, 200));
        if let Some(found) = sets.and_then(|sets| compare(&sets, options, effort)) {
            let options = options.to_string_lossy();
            let (median, spread) = (found.qhull.median * 1e6, found.qhull.spread * 50.0);
            let _ = writeln!(
                page,
                "| `{options}` | {who} | {median:.0} | {spread:.0} % |"
            );
        }
    }
    page += "\n## Growth\n\n![Time over contacts and over edges](quality-growth.svg)\n\n";
    let _ = writeln!(
        page,
        "Random closures on the last body, μ {GROWTH_FRICTION}."
    );
    for part in growth {
        let _ = writeln!(
            page,
            "\n| {} | closures | facets | engine µs | ± | Qhull µs | ± | ratio | | |",
            part.what
        );
        page += "|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";
        for (number, comparison) in &part.rows {
            let _ = write!(page, "| {number} {}", cells(comparison));
        }
    }
    page
}

const HEAD: &str = "\
# Speed of the quality engine

Written by `make bench`; edit nothing here.

Microseconds for one ε, engine and Qhull on the same wrench sets, one after the other in one thread. Each
round goes over all sets of a row with the one, then with the other; shown are the median of the rounds and,
as ±, half of what lies between the fastest and the slowest. Closures are the force closures among the sets,
facets those that the engine builds on average.

The engine: `Evaluator::quality`, exact for a force closure, a separating hyperplane for any other grasp; the
evaluator is reused. Batched: `Evaluator::qualities_of_sevens`, eight sets at a time. Qhull: 2020.2, reentrant,
compiled by the `cc` crate at the optimisation level of the release profile; its time is that of
`qh_new_qhull` with the points in its own layout and of a loop over the facets for the least offset, without
the freeing of its memory. ε is taken from the whole hull, as it has to be with Qhull.

Random closures are random grasps that are force closure. Mid-search is generation 4 of a genetic search
with a population of 200 from one closure and 199 random grasps, converged is generation 60: children before
selection, force closure or not.
";

const OPTIONS: [(&CStr, &str); 3] = [
    (
        PLAIN,
        "scipy in five dimensions and more; Qhull's own choice there",
    ),
    (TRIANGULATED, "those who want simplices"),
    (GRASPIT, "GraspIt!; accurate to 10⁻⁴, with volume"),
];

fn cells(c: &Comparison) -> String {
    let batch = c.batch.map_or_else(
        || "| | |".to_owned(),
        |batch| {
            let ratio = c.qhull.median / batch.median;
            format!("| {:.3} | {ratio:.0} |", batch.median * 1e6)
        },
    );
    format!(
        "| {} of {} | {:.0} | {:.2} | {:.0} % | {:.1} | {:.0} % | {:.0} {batch}\n",
        c.closures,
        c.sets,
        c.facets,
        c.engine.median * 1e6,
        c.engine.spread * 50.0,
        c.qhull.median * 1e6,
        c.qhull.spread * 50.0,
        c.qhull.median / c.engine.median,
    )
}

fn processor() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = info.lines().find(|line| line.starts_with("model name"));
    line.and_then(|line| line.split(':').nth(1))
        .map_or_else(|| "unknown".to_owned(), |name| name.trim().to_owned())
}
