//! The quality engine beside Qhull: `cargo bench --bench quality --features qhull -- [--quick] [--write]`.

mod cases;
mod grasps;
mod measure;
#[allow(unsafe_code, reason = "Qhull is a C library")]
mod qhull;

use std::time::Duration;

use cases::{Case, Source, bodies};
use measure::{Effort, compare};

fn main() {
    let quick = std::env::args().any(|a| a == "--quick");
    let effort = if quick {
        Effort {
            rounds: 3,
            qhull: Duration::from_millis(60),
            engine: Duration::from_millis(5),
        }
    } else {
        Effort {
            rounds: 5,
            qhull: Duration::from_millis(200),
            engine: Duration::from_millis(20),
        }
    };
    for body in bodies() {
        for case in [
            Case::hard(4, 8, 0.2),
            Case::hard(4, 8, 0.5),
            Case::frictionless(7),
            Case::hard(5, 16, 0.5),
        ] {
            for source in Source::ALL {
                let sets = body.sets(&case, source, 200);
                let Some(c) = compare(&sets, qhull::PLAIN, effort) else {
                    println!("{} {} {}: none", body.name, case.name(), source.name());
                    continue;
                };
                println!(
                    "{:14} {:16} {:16} {:3}/{:3}  engine {:9.3} us ±{:3.0}%  qhull {:9.1} us ±{:3.0}%  ratio {:6.0}  {}",
                    body.name,
                    case.name(),
                    source.name(),
                    c.closures,
                    c.sets,
                    c.engine.median * 1e6,
                    c.engine.spread * 50.0,
                    c.qhull.median * 1e6,
                    c.qhull.spread * 50.0,
                    c.qhull.median / c.engine.median,
                    c.batch
                        .map(|b| format!(
                            "batch {:.3} us ratio {:.0}",
                            b.median * 1e6,
                            c.qhull.median / b.median
                        ))
                        .unwrap_or_default()
                );
            }
        }
    }
}
