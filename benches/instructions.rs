//! Evaluations to count the instructions of: `benches/instructions.sh`, or `make instructions`.
//!
//! Two arguments: a case, and how many times its sixteen grasps are evaluated.

use std::hint::black_box;

use graspd_core::quality::Evaluator;
use graspd_core::wrench::Wrench;
use testkit::cases::{Case, Source, bodies};

/// Grasps of a case, all on the last body: the duck.
const GRASPS: usize = 16;

fn main() {
    let mut arguments = std::env::args().skip(1).filter(|a| a != "--bench");
    let (case, passes) = (arguments.next(), arguments.next());
    let passes: usize = passes.map_or(0, |n| n.parse().expect("a number of passes"));
    let (case, source) = match case.as_deref() {
        Some("4x8") => (Case::hard(4, 8, 0.2), Source::Closures),
        Some("4x8-mid-search") => (Case::hard(4, 8, 0.2), Source::MidSearch),
        Some("5x16") => (Case::hard(5, 16, 0.5), Source::Closures),
        Some("7" | "7-batched") => (Case::frictionless(7), Source::Closures),
        _ => {
            // `cargo bench` and `cargo test --all-targets` run every benchmark without arguments.
            println!("nothing to evaluate; see benches/instructions.sh");
            return;
        }
    };
    let bodies = bodies();
    let body = bodies.last().expect("a body");
    let sets = body.sets(&case, source, GRASPS);
    assert_eq!(sets.len(), GRASPS);
    let mut evaluator = Evaluator::new();
    if std::env::args().any(|a| a == "7-batched") {
        let sevens = sets.iter().map(|set| set.as_slice().try_into());
        let sevens: Vec<[Wrench; 7]> = sevens.collect::<Result<_, _>>().expect("sets of seven");
        let mut margins = Vec::with_capacity(GRASPS);
        for _ in 0..passes {
            margins.clear();
            evaluator.qualities_of_sevens(black_box(&sevens), &mut margins);
            black_box(&margins);
        }
        return;
    }
    for _ in 0..passes {
        for set in &sets {
            black_box(evaluator.quality(black_box(set)).is_ok());
        }
    }
}
