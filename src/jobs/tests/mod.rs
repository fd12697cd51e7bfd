//! The service with a scripted planner, on a folder and on a shared database.

mod follow;
mod ingest;
mod life;
mod runs;
mod shared;
mod watchdog;

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use serde_json::value::to_raw_value;
use tempfile::TempDir;

use super::*;
use crate::wire::{MeshOptions, PlanRequest, Progress};
use graspd_core::search::Phase;
use graspd_mesh_io::{Limits, MeshFormat};

const TETRAHEDRON: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n\
                           f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

fn options(data: &TempDir) -> Options {
    Options {
        store: Location::Folder(data.path().to_owned()),
        role: Role::Server,
        planning: PlanningOptions {
            workers: 1,
            threads_per_job: 1,
            max_attempts: 3,
            max_memory: None,
            drain: Duration::ZERO,
        },
        queue_capacity: 100,
        quota: Quota::default(),
        retention: None,
        ingest: IngestLimits {
            mesh: Limits {
                triangles: 1000,
                vertices: 1000,
                ..Limits::NONE
            },
            time: Duration::from_secs(60),
        },
        followers: 8,
        webhooks: webhooks::Options::default(),
        min_free_disk: 1,
    }
}

/// The options with so many workers.
fn options_with_workers(data: &TempDir, workers: usize) -> Options {
    let mut options = options(data);
    options.planning.workers = workers;
    options
}

/// A planner that does what the label of the job says.
fn scripted() -> Arc<Runner> {
    Arc::new(|mesh, request, interrupt, observe| {
        let mut progress = Progress {
            phase: Phase::Search,
            generation: 0,
            generations: 100,
            evaluations: 0,
            best_quality: None,
            best_contacts: None,
            elapsed_s: 0.0,
        };
        match request.label.as_deref() {
            Some("panic") => panic!("as the script says"),
            Some("endless") => loop {
                progress.generation += 1;
                observe(&progress);
                if interrupt.check().is_err() {
                    let partial = serde_json::json!({"partial": true});
                    return Ok(to_raw_value(&partial).unwrap());
                }
                std::thread::sleep(Duration::from_millis(1));
            },
            _ => {
                progress.generation = 100;
                observe(&progress);
                let whole = serde_json::json!({"triangles": mesh.triangles().len()});
                Ok(to_raw_value(&whole).unwrap())
            }
        }
    })
}

fn data() -> TempDir {
    tempfile::tempdir().unwrap()
}

async fn start(options: Options) -> Service {
    Service::start_with(options, scripted()).await.unwrap()
}

fn request(label: &str) -> PlanRequest {
    let fields = vec![("label".to_owned(), label.to_owned())];
    PlanRequest::from_form(fields, 7).unwrap()
}

async fn upload(service: &Service, text: &str) -> Upload {
    let mut upload = service.begin_upload().await.unwrap();
    upload.write(text.as_bytes()).await.unwrap();
    upload
}

fn incoming(upload: Upload, options: MeshOptions, file_name: Option<String>) -> MeshUpload {
    MeshUpload {
        upload,
        options,
        file_name,
    }
}

async fn submit(service: &Service, label: &str) -> JobRecord {
    let upload = upload(service, TETRAHEDRON).await;
    let incoming = incoming(upload, MeshOptions::default(), None);
    let owner = Owner::ANONYMOUS;
    let submitted = service.submit_with_upload(&owner, incoming, request(label), None);
    submitted.await.unwrap()
}

/// Waits until the planner has reported progress.
async fn until_progress(service: &Service, job: JobId) -> JobRecord {
    loop {
        let record = until(service, job, JobState::Running).await;
        if record
            .progress
            .as_ref()
            .is_some_and(|progress| progress.generation > 0)
        {
            return record;
        }
        tokio::time::sleep(Duration::from_millis(2)).await;
    }
}

async fn until(service: &Service, job: JobId, state: JobState) -> JobRecord {
    let clock = Instant::now();
    loop {
        let record = service
            .job(&Owner::ANONYMOUS, &job.to_string())
            .await
            .unwrap();
        if record.state == state {
            return record;
        }
        let waiting = clock.elapsed() < Duration::from_secs(20) && !record.state.is_final();
        assert!(waiting, "expected {state:?}: {record:?}");
        tokio::time::sleep(Duration::from_millis(2)).await;
    }
}

fn files_in(data: &TempDir) -> usize {
    let count = |folder: &str| fs::read_dir(data.path().join(folder)).unwrap().count();
    count("uploads") + count("meshes")
}

/// A planner that neither reports nor can be stopped until it is freed.
fn deaf() -> (Arc<Runner>, Arc<AtomicBool>) {
    let stuck = Arc::new(AtomicBool::new(true));
    let until_freed = Arc::clone(&stuck);
    let runner: Arc<Runner> = Arc::new(move |_, _, _, _| {
        while until_freed.load(Ordering::Relaxed) {
            std::thread::sleep(Duration::from_millis(1));
        }
        Ok(to_raw_value("late").unwrap())
    });
    (runner, stuck)
}
