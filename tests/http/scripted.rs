//! A server whose planner does what the label of a job says, and what becomes of jobs that misbehave.

use std::sync::Arc;
use std::time::Duration;

use graspd::jobs::Runner;
use graspd::wire::Progress;
use graspd_core::search::Phase;
use serde_json::value::{RawValue, to_raw_value};
use serde_json::{Value, json};

use crate::common::{Server, small_box, start};

/// Ends at once; `endless` reports a thousand times a second until it is stopped, `paced` ten states at
/// their pace, `deaf` nothing for as long as the process lives, and `panic` panics.
pub fn runner() -> Arc<Runner> {
    Arc::new(|_, request, interrupt, observe| {
        let pause = |milliseconds| std::thread::sleep(Duration::from_millis(milliseconds));
        let mut progress = Progress {
            phase: Phase::Search,
            generation: 0,
            generations: 10,
            evaluations: 0,
            best_quality: None,
            best_contacts: None,
            elapsed_s: 0.0,
        };
        match request.label.as_deref() {
            Some("endless") => loop {
                progress.generation += 1;
                observe(&progress);
                if interrupt.check().is_err() {
                    return Ok(found(&progress));
                }
                pause(1);
            },
            Some("paced") => {
                while progress.generation < 10 {
                    progress.generation += 1;
                    observe(&progress);
                    pause(60);
                }
                Ok(found(&progress))
            }
            Some("deaf") => loop {
                pause(1000);
            },
            Some("panic") => panic!("as the label says"),
            _ => Ok(found(&progress)),
        }
    })
}

fn found(progress: &Progress) -> Box<RawValue> {
    to_raw_value(&json!({"generation": progress.generation})).expect("JSON")
}

/// A server with that planner, with a mesh.
pub async fn server(flags: &[&str]) -> (Server, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let server = start(folder, flags, |_| {}, Some(runner())).await;
    let mesh = server.mesh(small_box()).await;
    (server, mesh)
}

#[tokio::test(flavor = "multi_thread")]
async fn a_panic_and_a_run_without_end_fail_alone() {
    let (server, mesh) = server(&[]).await;
    let before = server.job(&mesh, json!({})).await;
    let panics = server.job(&mesh, json!({"label": "panic"})).await;
    let between = server.job(&mesh, json!({})).await;
    let deaf = json!({"label": "deaf", "time_limit_s": 0.1});
    let deaf = server.job(&mesh, deaf).await;
    let after = server.job(&mesh, json!({})).await;
    for job in [&before, &between, &after] {
        server.wait_for(job, &["succeeded"]).await;
    }
    for (job, kind) in [
        (&panics, "/problems/internal-error"),
        (&deaf, "/problems/runaway"),
    ] {
        let failed: Value = server.json(&format!("/jobs/{job}")).await;
        assert_eq!(failed["state"], "failed", "{failed}");
        assert_eq!(failed["problem"]["type"], kind, "{failed}");
    }
    server.json("/readyz").await;
    server.stop().await;
}
