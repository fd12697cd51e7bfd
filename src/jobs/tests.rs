use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use serde_json::value::to_raw_value;
use tempfile::TempDir;

use super::*;
use crate::core::mesh::{Format, Limits};
use crate::wire::{Phase, PlanRequest, Progress};

const TETRAHEDRON: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n\
                           f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

fn options(data: &TempDir) -> Options {
    Options {
        data_dir: data.path().to_owned(),
        workers: 1,
        threads_per_job: 1,
        queue_capacity: 100,
        mesh_limits: Limits {
            triangles: 1000,
            vertices: 1000,
        },
        max_attempts: 3,
    }
}

/// A planner that does what the label of the job says.
fn scripted() -> Arc<Runner> {
    Arc::new(|mesh, request, observe| {
        let mut progress = Progress {
            phase: Phase::Search,
            generation: 0,
            generations: 100,
            evaluations: 0,
            best_quality: None,
            elapsed_s: 0.0,
        };
        match request.label.as_deref() {
            Some("panic") => panic!("as the script says"),
            Some("endless") => loop {
                progress.generation += 1;
                if observe(&progress) == ControlFlow::Break(()) {
                    let partial = serde_json::json!({"partial": true});
                    return Ok(to_raw_value(&partial).unwrap());
                }
                std::thread::sleep(Duration::from_millis(1));
            },
            _ => {
                progress.generation = 100;
                let _ = observe(&progress);
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

async fn submit(service: &Service, label: &str) -> JobRecord {
    let upload = upload(service, TETRAHEDRON).await;
    let submitted = service.submit_with_upload(upload, None, None, request(label));
    submitted.await.unwrap()
}

async fn until(service: &Service, job: JobId, state: JobState) -> JobRecord {
    let clock = Instant::now();
    loop {
        let record = service.job(&job.to_string()).await.unwrap();
        if record.state == state {
            return record;
        }
        let waiting = clock.elapsed() < Duration::from_secs(20) && !record.state.is_final();
        assert!(waiting, "wanted {state:?}: {record:?}");
        tokio::time::sleep(Duration::from_millis(2)).await;
    }
}

fn files_in(data: &TempDir) -> usize {
    let count = |folder: &str| fs::read_dir(data.path().join(folder)).unwrap().count();
    count("uploads") + count("meshes")
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_runs_from_upload_to_result() {
    let data = data();
    let service = start(options(&data)).await;
    let job = submit(&service, "quick").await;
    assert_eq!(
        (job.state, job.label.as_deref()),
        (JobState::Queued, Some("quick"))
    );
    let done = until(&service, job.id, JobState::Succeeded).await;
    assert_eq!(done.result.unwrap().get(), r#"{"triangles":4}"#);
    assert_eq!(done.progress.unwrap().generation, 100);
    assert_eq!(done.attempt, 1);
    assert!(done.revision > job.revision);
    assert!(done.created_at <= done.started_at.unwrap());
    assert!(done.started_at <= done.finished_at);
    let page = service
        .jobs(None, Some(&job.mesh_id), 10, None)
        .await
        .unwrap();
    assert!(page.jobs[0].result.is_none(), "lists leave results out");
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_planner_itself_is_behind_the_pool() {
    let data = data();
    let service = Service::start(options(&data)).await.unwrap();
    let fields = [
        ("population", "10"),
        ("generations", "2"),
        ("label", "real"),
    ];
    let fields = fields.map(|(name, value)| (name.to_owned(), value.to_owned()));
    let request = PlanRequest::from_form(fields, 7).unwrap();
    let upload = upload(&service, TETRAHEDRON).await;
    let job = service
        .submit_with_upload(upload, None, None, request)
        .await
        .unwrap();
    let done = until(&service, job.id, JobState::Succeeded).await;
    let result: crate::wire::PlanResult = serde_json::from_str(done.result.unwrap().get()).unwrap();
    assert_eq!((result.seed, result.candidates), (7, 4));
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn progress_of_a_running_job_is_seen() {
    let data = data();
    let service = start(options(&data)).await;
    let job = submit(&service, "endless").await;
    let mut seen = until(&service, job.id, JobState::Running).await;
    let clock = Instant::now();
    while seen
        .progress
        .as_ref()
        .is_none_or(|progress| progress.generation < 3)
    {
        assert!(clock.elapsed() < Duration::from_secs(10), "{seen:?}");
        tokio::time::sleep(Duration::from_millis(5)).await;
        let later = service.job(&job.id.to_string()).await.unwrap();
        assert!(later.revision >= seen.revision);
        seen = later;
    }
    let (_, changed) = service.cancel(&job.id.to_string()).await.unwrap();
    assert!(changed);
    let ended = until(&service, job.id, JobState::Cancelled).await;
    assert!(ended.revision > seen.revision);
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn cancelling_stops_a_run_soon_and_keeps_what_was_found() {
    let data = data();
    let service = start(options(&data)).await;
    let running = submit(&service, "endless").await.id;
    let waiting = submit(&service, "quick").await.id;
    until(&service, running, JobState::Running).await;

    let (record, changed) = service.cancel(&waiting.to_string()).await.unwrap();
    assert_eq!((record.state, changed), (JobState::Cancelled, true));

    let clock = Instant::now();
    service.cancel(&running.to_string()).await.unwrap();
    let ended = until(&service, running, JobState::Cancelled).await;
    assert!(
        clock.elapsed() < Duration::from_millis(200),
        "{:?}",
        clock.elapsed()
    );
    assert_eq!(ended.result.unwrap().get(), r#"{"partial":true}"#);

    let (again, changed) = service.cancel(&running.to_string()).await.unwrap();
    assert_eq!((again.revision, changed), (ended.revision, false));
    let unknown = service.cancel(&JobId::new().to_string()).await;
    assert!(matches!(unknown, Err(Error::NotFound)));
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_forgotten_run_ends_and_leaves_nothing() {
    let data = data();
    let service = start(options(&data)).await;
    let job = submit(&service, "endless").await;
    until(&service, job.id, JobState::Running).await;
    let in_use = service.delete_mesh(&job.mesh_id).await;
    assert!(matches!(in_use, Err(Error::MeshInUse)), "{in_use:?}");
    service.delete_job(&job.id.to_string()).await.unwrap();
    // The only worker is free again.
    let next = submit(&service, "quick").await;
    until(&service, next.id, JobState::Succeeded).await;
    let gone = service.job(&job.id.to_string()).await;
    assert!(matches!(gone, Err(Error::NotFound)), "{gone:?}");
    assert!(matches!(
        service.delete_job(&job.id.to_string()).await,
        Err(Error::NotFound)
    ));
    service.delete_mesh(&job.mesh_id).await.unwrap();
    assert_eq!(files_in(&data), 0);
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_panic_fails_its_job_alone() {
    let data = data();
    let service = start(options(&data)).await;
    let broken = submit(&service, "panic").await;
    let next = submit(&service, "quick").await;
    let failed = until(&service, broken.id, JobState::Failed).await;
    let problem = failed.problem.unwrap();
    assert_eq!(problem.status, 500);
    assert!(
        !problem.detail.contains("script"),
        "what the panic said is for the log"
    );
    until(&service, next.id, JobState::Succeeded).await;
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn all_workers_wake_for_jobs_that_come_together() {
    let data = data();
    let service = start(Options {
        workers: 3,
        ..options(&data)
    })
    .await;
    let mut jobs = Vec::new();
    for _ in 0..3 {
        jobs.push(submit(&service, "endless").await.id);
    }
    for job in jobs {
        until(&service, job, JobState::Running).await;
    }
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn shutdown_puts_running_jobs_back_and_burns_no_attempt() {
    let data = data();
    let service = start(options(&data)).await;
    let running = submit(&service, "endless").await.id;
    let waiting = submit(&service, "quick").await.id;
    until(&service, running, JobState::Running).await;
    service.begin_drain();
    assert!(matches!(service.ready().await, Err(Error::Draining)));
    assert!(matches!(service.begin_upload().await, Err(Error::Draining)));
    assert_eq!(
        service.job(&running.to_string()).await.unwrap().state,
        JobState::Running
    );
    service.shutdown().await;
    drop(service);

    let service = start(Options {
        workers: 2,
        ..options(&data)
    })
    .await;
    until(&service, waiting, JobState::Succeeded).await;
    let record = until(&service, running, JobState::Running).await;
    assert_eq!(record.attempt, 1);
    service.shutdown().await;
}

/// A planner that neither reports nor listens until it is freed.
fn deaf() -> (Arc<Runner>, Arc<AtomicBool>) {
    let stuck = Arc::new(AtomicBool::new(true));
    let until_freed = Arc::clone(&stuck);
    let runner: Arc<Runner> = Arc::new(move |_, _, _| {
        while until_freed.load(Ordering::Relaxed) {
            std::thread::sleep(Duration::from_millis(1));
        }
        Ok(to_raw_value("late").unwrap())
    });
    (runner, stuck)
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_that_is_still_being_prepared_is_cancelled_at_once() {
    let data = data();
    let (runner, stuck) = deaf();
    let service = Service::start_with(options(&data), runner).await.unwrap();
    let job = submit(&service, "").await.id;
    until(&service, job, JobState::Running).await;
    let (record, changed) = service.cancel(&job.to_string()).await.unwrap();
    assert_eq!((record.state, changed), (JobState::Cancelled, true));
    stuck.store(false, Ordering::Relaxed);
    service.shutdown().await;
    let record = service.job(&job.to_string()).await.unwrap();
    assert_eq!(record.state, JobState::Cancelled);
    assert!(record.result.is_none());
}

#[tokio::test(flavor = "multi_thread")]
async fn a_run_that_does_not_stop_cannot_hold_its_job() {
    let data = data();
    let (runner, stuck) = deaf();
    let service = Service::start_with(options(&data), runner).await.unwrap();
    let job = submit(&service, "").await.id;
    until(&service, job, JobState::Running).await;
    service.stop_workers(Duration::from_millis(50)).await;
    let record = service.job(&job.to_string()).await.unwrap();
    assert_eq!((record.state, record.attempt), (JobState::Queued, 1));
    stuck.store(false, Ordering::Relaxed);
    service.stop_workers(Duration::from_secs(10)).await;
    let record = service.job(&job.to_string()).await.unwrap();
    assert_eq!(
        record.state,
        JobState::Queued,
        "a late result changes nothing"
    );
    assert!(record.result.is_none());
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn bad_meshes_are_named_and_leave_nothing() {
    let data = data();
    let service = start(options(&data)).await;
    let flat = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    for (text, format, status) in [
        ("", None, 415),
        ("hello, this is no mesh", None, 415),
        (flat, None, 422),
        ("v 0 0 0\nv 1 0 0\nf 1 2 9\n", Some(Format::Obj), 422),
    ] {
        let refused = service
            .add_mesh(upload(&service, text).await, format, None)
            .await;
        let Err(Error::Refused(problem)) = refused else {
            panic!("{text:?}: {refused:?}");
        };
        assert_eq!(problem.status, status, "{text:?}: {problem:?}");
    }
    let too_big: String = "f 1 3 2\n".repeat(2000);
    let upload = upload(&service, &format!("{TETRAHEDRON}{too_big}")).await;
    let refused = service.add_mesh(upload, None, None).await;
    assert!(matches!(refused, Err(Error::Refused(problem)) if problem.status == 422));
    assert_eq!(files_in(&data), 0);
    assert!(service.meshes(10, None).await.unwrap().meshes.is_empty());
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_same_mesh_is_kept_once() {
    let data = data();
    let service = start(options(&data)).await;
    let first = upload(&service, TETRAHEDRON).await;
    let (mesh, created) = service
        .add_mesh(first, None, Some("tetra.obj".to_owned()))
        .await
        .unwrap();
    assert!(created);
    assert!(
        mesh.report.get().contains(r#""candidates":4"#),
        "{}",
        mesh.report
    );
    for format in [None, Some(Format::Obj)] {
        let (again, created) = service
            .add_mesh(upload(&service, TETRAHEDRON).await, format, None)
            .await
            .unwrap();
        assert_eq!((&again.id, created), (&mesh.id, false));
        assert_eq!(again.file_name.as_deref(), Some("tetra.obj"));
    }
    assert_eq!(files_in(&data), 1);
    assert_eq!(service.mesh(mesh.id.as_str()).await.unwrap().id, mesh.id);
    for id in ["", "../../graspd.db", &"0".repeat(64)] {
        assert!(
            matches!(service.mesh(id).await, Err(Error::NotFound)),
            "{id}"
        );
        assert!(
            matches!(service.delete_mesh(id).await, Err(Error::NotFound)),
            "{id}"
        );
    }
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_refused_job_leaves_no_mesh() {
    let data = data();
    let service = start(Options {
        queue_capacity: 1,
        ..options(&data)
    })
    .await;
    let fields = [("contacts".to_owned(), "9".to_owned())];
    let nine = PlanRequest::from_form(fields, 7).unwrap();
    let refused = service
        .submit_with_upload(
            upload(&service, TETRAHEDRON).await,
            None,
            None,
            nine.clone(),
        )
        .await;
    let Err(Error::Refused(problem)) = refused else {
        panic!("{refused:?}");
    };
    assert_eq!(
        (problem.status, problem.errors[0].pointer.as_str()),
        (422, "/contacts")
    );
    assert!(
        problem.detail.contains('9') && problem.detail.contains('4'),
        "{}",
        problem.detail
    );
    assert_eq!(files_in(&data), 0);

    let job = submit(&service, "endless").await;
    until(&service, job.id, JobState::Running).await;
    submit(&service, "quick").await;
    let other = format!("{TETRAHEDRON}# another\n");
    let refused = service
        .submit_with_upload(upload(&service, &other).await, None, None, request(""))
        .await;
    assert!(
        matches!(
            refused,
            Err(Error::QueueFull {
                retry_after_s: 1..=60
            })
        ),
        "{refused:?}"
    );
    let refused = service.submit(&job.mesh_id, request("")).await;
    assert!(
        matches!(refused, Err(Error::QueueFull { .. })),
        "{refused:?}"
    );
    let refused = service.submit(&job.mesh_id, nine).await;
    assert!(matches!(refused, Err(Error::Refused(_))), "{refused:?}");
    let refused = service.submit(&"0".repeat(64), request("")).await;
    assert!(matches!(refused, Err(Error::UnknownMesh)), "{refused:?}");
    assert_eq!(files_in(&data), 1);
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_mesh_is_read_again_after_a_restart() {
    let data = data();
    let service = start(options(&data)).await;
    let (mesh, _) = service
        .add_mesh(upload(&service, TETRAHEDRON).await, None, None)
        .await
        .unwrap();
    service.shutdown().await;
    drop(service);
    let service = start(options(&data)).await;
    let job = service.submit(mesh.id.as_str(), request("")).await.unwrap();
    until(&service, job.id, JobState::Succeeded).await;
    // A file that is gone fails the jobs on it, and nothing else.
    fs::remove_file(data.path().join("meshes").join(mesh.id.as_str())).unwrap();
    service.shutdown().await;
    drop(service);
    let service = start(options(&data)).await;
    let refused = service.submit(mesh.id.as_str(), request("")).await;
    assert!(matches!(refused, Err(Error::UnknownMesh)), "{refused:?}");
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn two_services_cannot_share_a_directory() {
    let data = data();
    let service = start(options(&data)).await;
    let second = Service::start_with(options(&data), scripted()).await.err();
    let second = second.expect("the second is refused").to_string();
    assert!(second.contains("in use by another graspd"), "{second}");
    assert!(Path::new(&data.path().join("graspd.db")).exists());
    service.shutdown().await;
}
