mod files;
mod keys;
mod leases;
mod lists;
mod retention;
mod submissions;
mod turns;
mod webhooks;

use std::collections::HashSet;
use std::fs;
use std::path::Path;

use serde_json::value::to_raw_value;
use tempfile::TempDir;

use super::*;
use crate::wire::{
    JobId, JobRecord, JobState, MeshFormat, MeshId, MeshReport, Phase, Priority, Problem, Progress,
};

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

async fn open(data: &TempDir) -> Store {
    Store::open(data.path()).await.unwrap()
}

fn new_mesh() -> NewMesh {
    let report: MeshReport = serde_json::from_value(serde_json::json!({
        "vertices_read": 8, "triangles_read": 12, "vertices": 8, "triangles": 12,
        "degenerate_triangles": 0, "components": 1, "flipped_triangles": 0, "border_edges": 0,
        "non_manifold_edges": 0, "watertight": true, "mass_from": "solid", "volume": 1.0,
        "area": 6.0, "center_of_mass": [0.0, 0.0, 0.0],
        "bounds": [[-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]], "bounding_radius": 0.87,
        "candidates": 12, "area_ratio": 1.0
    }))
    .unwrap();
    NewMesh {
        owner: Owner::ANONYMOUS,
        room: None,
        format: MeshFormat::Stl,
        units: None,
        scale: 1.0,
        file_name: Some("box.stl".to_owned()),
        report,
    }
}

fn new_job(capacity: u32) -> NewJob {
    NewJob {
        owner: Owner::ANONYMOUS,
        request: "{}".to_owned(),
        label: None,
        priority: Priority::Interactive,
        capacity,
        share: None,
        submission: None,
    }
}

async fn receive(store: &Store, bytes: &[u8]) -> Received {
    let mut upload = store.begin_upload().await.unwrap();
    for piece in bytes.chunks(3) {
        upload.write(piece).await.unwrap();
    }
    upload.finish().await.unwrap()
}

async fn add_mesh(store: &Store, bytes: &[u8]) -> MeshId {
    let received = receive(store, bytes).await;
    let added = store.add_mesh(received, &new_mesh()).await.unwrap();
    added.unwrap().0.id
}

async fn submit(store: &Store, mesh: &MeshId) -> JobRecord {
    store.submit(mesh, &new_job(1000)).await.unwrap().unwrap()
}

/// Takes the next job off the queue.
async fn claim(store: &Store) -> Claim {
    let claim = store.claim(Priority::Interactive).await.unwrap();
    claim.expect("a job that waits")
}

async fn job(store: &Store, id: JobId) -> JobRecord {
    store.job(&Owner::ANONYMOUS, id).await.unwrap().unwrap()
}

fn progress() -> Progress {
    Progress {
        phase: Phase::Search,
        generation: 3,
        generations: 30,
        evaluations: 1200,
        best_quality: Some(0.1),
        best_contacts: None,
        elapsed_s: 0.5,
    }
}

fn found() -> Ending {
    Ending::Result(to_raw_value(&serde_json::json!({"quality": 0.1})).unwrap())
}

fn exhausted() -> Problem {
    Problem::new(500, "interrupted", "Interrupted too often", "three times")
}

fn files_in(folder: &Path) -> usize {
    fs::read_dir(folder).unwrap().count()
}
