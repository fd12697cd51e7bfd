//! Runs that do not end when they have to.

use sqlx::ConnectOptions;
use sqlx::sqlite::SqliteConnectOptions;

use super::*;
use crate::host::resident_bytes;

/// A planner that is unresponsive where the label is `deaf`, until it is freed, and scripted otherwise.
fn deaf_or_scripted() -> (Arc<Runner>, Arc<AtomicBool>) {
    let (deaf, stuck) = deaf();
    let scripted = scripted();
    let runner: Arc<Runner> =
        Arc::new(
            move |mesh, request, interrupt, observe| match request.label.as_deref() {
                Some("deaf") => deaf(mesh, request, interrupt, observe),
                _ => scripted(mesh, request, interrupt, observe),
            },
        );
    (runner, stuck)
}

/// Submits a job that may run for a twentieth of a second.
async fn submit_short(service: &Service, label: &str) -> JobId {
    let mesh = submit(service, "quick").await.mesh_id;
    let request = PlanRequest {
        time_limit_s: Some(0.05),
        ..request(label)
    };
    service
        .submit(&Owner::ANONYMOUS, &mesh, request, None)
        .await
        .unwrap()
        .id
}

#[tokio::test(flavor = "multi_thread")]
async fn a_run_that_does_not_listen_is_cancelled_over_its_head() {
    let data = data();
    let (runner, stuck) = deaf();
    let service = Service::start_with(options(&data), runner).await.unwrap();
    let job = submit(&service, "").await.id;
    until(&service, job, JobState::Running).await;
    let clock = Instant::now();
    let (record, changed) = service
        .cancel(&Owner::ANONYMOUS, &job.to_string())
        .await
        .unwrap();
    assert!(changed);
    let cancelled = until(&service, job, JobState::Cancelled).await;
    // 0.15 s and the time to write it down; the rest is for a machine with other things to do.
    let took = clock.elapsed();
    assert!(took < Duration::from_secs(1), "{took:?}");
    assert!(cancelled.revision > record.revision);
    stuck.store(false, Ordering::Relaxed);
    service.shutdown().await;
    let record = service
        .job(&Owner::ANONYMOUS, &job.to_string())
        .await
        .unwrap();
    assert_eq!(record.state, JobState::Cancelled);
    assert!(record.result.is_none(), "a late result changes nothing");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_runaway_fails_alone_and_another_worker_takes_its_place() {
    let data = data();
    let (runner, stuck) = deaf_or_scripted();
    let service = Service::start_with(options(&data), runner).await.unwrap();
    let runaway = submit_short(&service, "deaf").await;
    let next = submit(&service, "quick").await.id;
    let failed = until(&service, runaway, JobState::Failed).await;
    assert_eq!(failed.problem.as_ref().unwrap().kind, "/problems/runaway");
    until(&service, next, JobState::Succeeded).await;
    service.ready().await.unwrap();

    // The thread comes back and finds that it is not needed any more: one worker, not two.
    stuck.store(false, Ordering::Relaxed);
    tokio::time::sleep(Duration::from_millis(100)).await;
    let one = submit(&service, "endless").await.id;
    let other = submit(&service, "endless").await.id;
    until(&service, one, JobState::Running).await;
    tokio::time::sleep(Duration::from_millis(100)).await;
    let waiting = service
        .job(&Owner::ANONYMOUS, &other.to_string())
        .await
        .unwrap();
    assert_eq!(waiting.state, JobState::Queued);
    let still = service
        .job(&Owner::ANONYMOUS, &runaway.to_string())
        .await
        .unwrap();
    assert_eq!(
        (still.state, still.revision),
        (JobState::Failed, failed.revision)
    );
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn workers_are_replaced_a_bounded_number_of_times() {
    let data = data();
    let (runner, stuck) = deaf_or_scripted();
    let options = options_with_workers(&data, 5);
    let service = Service::start_with(options, runner).await.unwrap();
    let mut jobs = Vec::new();
    for _ in 0..5 {
        jobs.push(submit_short(&service, "deaf").await);
    }
    for job in jobs {
        until(&service, job, JobState::Failed).await;
    }
    let clock = Instant::now();
    while !matches!(service.ready().await, Err(Error::WorkerLost)) {
        assert!(clock.elapsed() < Duration::from_secs(20));
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    // Once they come back all places are filled again.
    stuck.store(false, Ordering::Relaxed);
    while service.ready().await.is_err() {
        assert!(clock.elapsed() < Duration::from_secs(20));
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    let mut jobs = Vec::new();
    for _ in 0..5 {
        jobs.push(submit(&service, "endless").await.id);
    }
    for job in jobs {
        until(&service, job, JobState::Running).await;
    }
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_result_that_waits_for_the_store_is_neither_late_nor_lost() {
    let data = data();
    let (runner, stuck) = deaf_or_scripted();
    let service = Service::start_with(options(&data), runner).await.unwrap();
    let job = submit_short(&service, "deaf").await;
    until(&service, job, JobState::Running).await;
    // Another process keeps the database to itself for longer than a run that does not end is waited for.
    let database = SqliteConnectOptions::new().filename(data.path().join("graspd.db"));
    let mut other = database.connect().await.unwrap();
    sqlx::query("BEGIN IMMEDIATE")
        .execute(&mut other)
        .await
        .unwrap();
    stuck.store(false, Ordering::Relaxed);
    tokio::time::sleep(Duration::from_secs(8)).await;
    sqlx::query("ROLLBACK").execute(&mut other).await.unwrap();
    let ended = until(&service, job, JobState::Succeeded).await;
    assert_eq!(ended.result.unwrap().get(), "\"late\"");
    service.ready().await.unwrap();
    service.shutdown().await;
}

#[cfg(target_os = "linux")]
#[tokio::test(flavor = "multi_thread")]
async fn a_run_that_takes_too_much_memory_is_stopped_and_nothing_new_begun() {
    /// Far more than the other tests of this process take and let go of meanwhile.
    const ROOM: u64 = 512 << 20;
    let scripted = scripted();
    let (grows, freed) = (
        Arc::new(AtomicBool::new(false)),
        Arc::new(AtomicBool::new(false)),
    );
    let (until_grows, until_freed) = (Arc::clone(&grows), Arc::clone(&freed));
    // Once it grows, takes memory for as long as it may, and keeps it for a while after.
    let runner: Arc<Runner> = Arc::new(move |mesh, request, interrupt, observe| {
        if request.label.as_deref() != Some("hog") {
            return scripted(mesh, request, interrupt, observe);
        }
        let mut taken = Vec::new();
        let mut progress = Progress {
            phase: Phase::Search,
            generation: 0,
            generations: 1,
            evaluations: 0,
            best_quality: None,
            best_contacts: None,
            elapsed_s: 0.0,
        };
        while interrupt.check().is_ok() {
            observe(&progress);
            progress.generation += 1;
            if until_grows.load(Ordering::Relaxed) && taken.len() < 64 {
                taken.push(vec![1_u8; 32 << 20]);
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        while !until_freed.load(Ordering::Relaxed) {
            std::thread::sleep(Duration::from_millis(1));
        }
        Ok(to_raw_value(&std::hint::black_box(taken).len()).unwrap())
    });
    let data = data();
    let mut options = options_with_workers(&data, 2);
    options.planning.max_memory = Some(resident_bytes().unwrap() + ROOM);
    let service = Service::start_with(options, runner).await.unwrap();
    let mesh = submit(&service, "quick").await.mesh_id;
    let hog = service
        .submit(&Owner::ANONYMOUS, &mesh, request("hog"), None)
        .await
        .unwrap()
        .id;
    until(&service, hog, JobState::Running).await;
    let young = submit(&service, "endless").await.id;
    until_progress(&service, young).await;
    grows.store(true, Ordering::Relaxed);
    let failed = until(&service, hog, JobState::Failed).await;
    // What ran beside it has only to wait.
    let innocent = until(&service, young, JobState::Queued).await;
    assert_eq!(innocent.attempt, 1);
    let problem = failed.problem.unwrap();
    assert_eq!(problem.kind, "/problems/out-of-memory");
    assert!(
        problem.detail.contains("--max-memory"),
        "{}",
        problem.detail
    );
    assert!(matches!(service.ready().await, Err(Error::OutOfMemory)));
    assert!(matches!(
        service.begin_upload().await,
        Err(Error::OutOfMemory)
    ));
    // A worker is free, and yet the job waits rather than being the next to fail.
    let next = service
        .submit(&Owner::ANONYMOUS, &mesh, request("quick"), None)
        .await
        .unwrap()
        .id;
    tokio::time::sleep(Duration::from_millis(300)).await;
    let waiting = service
        .job(&Owner::ANONYMOUS, &next.to_string())
        .await
        .unwrap();
    assert_eq!(waiting.state, JobState::Queued);

    freed.store(true, Ordering::Relaxed);
    until(&service, next, JobState::Succeeded).await;
    until(&service, young, JobState::Running).await;
    service.begin_upload().await.unwrap();
    service.ready().await.unwrap();
    service.shutdown().await;
}
