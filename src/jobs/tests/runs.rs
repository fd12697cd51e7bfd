//! Jobs from submission to their end.

use super::*;

/// A filter for the jobs on a mesh.
fn on(mesh_id: &str) -> JobFilter {
    JobFilter {
        mesh_id: Some(mesh_id.to_owned()),
        ..JobFilter::default()
    }
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
    let page = service.jobs(&on(&job.mesh_id), 10, None).await.unwrap();
    assert!(page.jobs[0].result.is_none(), "lists leave results out");
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_planner_itself_is_behind_the_pool() {
    let data = data();
    let service = Service::start(options(&data)).await.unwrap();
    let fields = [
        ("population", "10"),
        ("candidates", "uniform"),
        ("generations", "2"),
        ("label", "real"),
    ];
    let fields = fields.map(|(name, value)| (name.to_owned(), value.to_owned()));
    let request = PlanRequest::from_form(fields, 7).unwrap();
    let upload = upload(&service, TETRAHEDRON).await;
    let job = service
        .submit_with_upload(
            &Owner::ANONYMOUS,
            incoming(upload, MeshOptions::default(), None),
            request,
            None,
        )
        .await
        .unwrap();
    let done = until(&service, job.id, JobState::Succeeded).await;
    let result: crate::wire::PlanResult = serde_json::from_str(done.result.unwrap().get()).unwrap();
    assert_eq!((result.seed, result.candidates), (7, 10_000));
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
        let later = service
            .job(&Owner::ANONYMOUS, &job.id.to_string())
            .await
            .unwrap();
        assert!(later.revision >= seen.revision);
        seen = later;
    }
    let (_, changed) = service
        .cancel(&Owner::ANONYMOUS, &job.id.to_string())
        .await
        .unwrap();
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
    until_progress(&service, running).await;

    let (record, changed) = service
        .cancel(&Owner::ANONYMOUS, &waiting.to_string())
        .await
        .unwrap();
    assert_eq!((record.state, changed), (JobState::Cancelled, true));

    let clock = Instant::now();
    service
        .cancel(&Owner::ANONYMOUS, &running.to_string())
        .await
        .unwrap();
    let ended = until(&service, running, JobState::Cancelled).await;
    assert!(
        clock.elapsed() < Duration::from_millis(200),
        "{:?}",
        clock.elapsed()
    );
    assert_eq!(ended.result.unwrap().get(), r#"{"partial":true}"#);

    let (again, changed) = service
        .cancel(&Owner::ANONYMOUS, &running.to_string())
        .await
        .unwrap();
    assert_eq!((again.revision, changed), (ended.revision, false));
    let unknown = service
        .cancel(&Owner::ANONYMOUS, &JobId::new().to_string())
        .await;
    assert!(matches!(unknown, Err(Error::NotFound)));
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_forgotten_run_ends_and_leaves_nothing() {
    let data = data();
    let service = start(options(&data)).await;
    let job = submit(&service, "endless").await;
    until(&service, job.id, JobState::Running).await;
    let in_use = service.delete_mesh(&Owner::ANONYMOUS, &job.mesh_id).await;
    assert!(matches!(in_use, Err(Error::MeshInUse)), "{in_use:?}");
    service
        .delete_job(&Owner::ANONYMOUS, &job.id.to_string())
        .await
        .unwrap();
    // The only worker is free again.
    let next = submit(&service, "quick").await;
    until(&service, next.id, JobState::Succeeded).await;
    let gone = service.job(&Owner::ANONYMOUS, &job.id.to_string()).await;
    assert!(matches!(gone, Err(Error::NotFound)), "{gone:?}");
    assert!(matches!(
        service
            .delete_job(&Owner::ANONYMOUS, &job.id.to_string())
            .await,
        Err(Error::NotFound)
    ));
    service
        .delete_mesh(&Owner::ANONYMOUS, &job.mesh_id)
        .await
        .unwrap();
    assert_eq!(files_in(&data), 0);
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_panic_fails_its_job_alone() {
    let data = data();
    let service = start(options(&data)).await;
    let before = submit(&service, "quick").await;
    let broken = submit(&service, "panic").await;
    let next = submit(&service, "quick").await;
    until(&service, before.id, JobState::Succeeded).await;
    let failed = until(&service, broken.id, JobState::Failed).await;
    let problem = failed.problem.unwrap();
    assert_eq!(problem.status, 500);
    assert!(
        !problem.detail.contains("script"),
        "the message of the panic is for the log"
    );
    until(&service, next.id, JobState::Succeeded).await;
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn all_workers_wake_for_jobs_that_come_together() {
    let data = data();
    let service = start(options_with_workers(&data, 3)).await;
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
async fn a_worker_survives_panics_in_odd_places() {
    /// A payload of a panic that panics again when it is dropped.
    struct Bomb;
    impl Drop for Bomb {
        fn drop(&mut self) {
            panic!("dropped");
        }
    }
    let runner: Arc<Runner> = Arc::new(|_, request, _, _| match request.label.as_deref() {
        Some("bomb") => std::panic::panic_any(Bomb),
        Some("number") => std::panic::panic_any(7),
        _ => Ok(to_raw_value("done").unwrap()),
    });
    let data = data();
    let service = Service::start_with(options(&data), runner).await.unwrap();
    for label in ["bomb", "number"] {
        let job = submit(&service, label).await;
        let failed = until(&service, job.id, JobState::Failed).await;
        assert!(failed.problem.unwrap().kind.ends_with("internal-error"));
    }
    let next = submit(&service, "quick").await;
    until(&service, next.id, JobState::Succeeded).await;
    service.ready().await.unwrap();
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_being_prepared_shows_its_generations_and_the_time() {
    let data = data();
    let (runner, stuck) = deaf();
    let service = Service::start_with(options(&data), runner).await.unwrap();
    let job = submit(&service, "").await.id;
    until(&service, job, JobState::Running).await;
    tokio::time::sleep(Duration::from_millis(20)).await;
    let progress = service
        .job(&Owner::ANONYMOUS, &job.to_string())
        .await
        .unwrap()
        .progress;
    let progress = progress.unwrap();
    assert_eq!(
        (progress.phase, progress.generations),
        (Phase::Preparing, 25)
    );
    assert!(progress.elapsed_s > 0.0);
    stuck.store(false, Ordering::Relaxed);
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_forged_cursor_is_refused_with_any_other_parameters() {
    let data = data();
    let service = start(options(&data)).await;
    let forged = service.jobs(&on("zzz"), 10, Some("forged")).await;
    assert!(matches!(forged, Err(Error::InvalidCursor)), "{forged:?}");
    let none = service.jobs(&on("zzz"), 10, None).await.unwrap();
    assert!(none.jobs.is_empty());
    service.shutdown().await;
}
