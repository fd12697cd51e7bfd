use std::collections::HashSet;
use std::fs;
use std::path::Path;

use serde_json::value::to_raw_value;
use tempfile::TempDir;

use super::*;
use crate::wire::{
    JobId, JobRecord, JobState, MeshFormat, MeshId, MeshReport, Phase, Problem, Progress,
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
        format: MeshFormat::Stl,
        file_name: Some("box.stl".to_owned()),
        report,
    }
}

fn new_job(capacity: u32) -> NewJob {
    NewJob {
        request: "{}".to_owned(),
        label: None,
        capacity,
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
    store.add_mesh(received, &new_mesh()).await.unwrap().0.id
}

async fn submit(store: &Store, mesh: &MeshId) -> JobRecord {
    store.submit(mesh, &new_job(1000)).await.unwrap().unwrap()
}

async fn job(store: &Store, id: JobId) -> JobRecord {
    store.job(id).await.unwrap().unwrap()
}

fn progress() -> Progress {
    Progress {
        phase: Phase::Search,
        generation: 3,
        generations: 30,
        evaluations: 1200,
        best_quality: Some(0.1),
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

#[tokio::test]
async fn one_process_at_a_time_has_a_data_directory() {
    let data = folder();
    let store = open(&data).await;
    let second = Store::open(data.path()).await;
    assert!(
        matches!(&second, Err(OpenError::InUse(path)) if path == data.path()),
        "{second:?}"
    );
    store.close().await;
    drop(store);
    open(&data).await;
}

#[tokio::test]
async fn every_connection_that_writes_syncs() {
    let data = folder();
    let store = open(&data).await;
    let pragma = async |statement: &'static str| -> i64 {
        sqlx::query_scalar(statement)
            .fetch_one(&store.writer)
            .await
            .unwrap()
    };
    assert_eq!(pragma("PRAGMA synchronous").await, 2);
    assert_eq!(pragma("PRAGMA foreign_keys").await, 1);
    let journal: String = sqlx::query_scalar("PRAGMA journal_mode")
        .fetch_one(&store.writer)
        .await
        .unwrap();
    assert_eq!(journal, "wal");
    let write = sqlx::query("DELETE FROM jobs")
        .execute(&store.readers)
        .await;
    assert!(write.is_err(), "readers cannot write");
}

#[tokio::test]
async fn a_store_that_would_not_sync_is_refused() {
    let data = folder();
    let options = sqlx::sqlite::SqliteConnectOptions::new()
        .filename(data.path().join("other.db"))
        .create_if_missing(true)
        .synchronous(sqlx::sqlite::SqliteSynchronous::Normal)
        .journal_mode(sqlx::sqlite::SqliteJournalMode::Wal);
    let pool = SqlitePool::connect_with(options).await.unwrap();
    let refused = super::open::check_settings(&pool).await;
    assert!(
        matches!(&refused, Err(OpenError::Pragma { pragma: "synchronous", found, .. }) if found == "1"),
        "{refused:?}"
    );
}

#[tokio::test]
async fn an_upload_leaves_nothing_unless_it_becomes_a_mesh() {
    let data = folder();
    let store = open(&data).await;
    let (uploads, meshes) = (data.path().join("uploads"), data.path().join("meshes"));

    let mut upload = store.begin_upload().await.unwrap();
    upload.write(b"half a me").await.unwrap();
    assert_eq!(files_in(&uploads), 1);
    drop(upload);
    drop(receive(&store, b"whole").await);
    assert_eq!((files_in(&uploads), files_in(&meshes)), (0, 0));

    let received = receive(&store, b"solid").await;
    let id = received.mesh_id(MeshFormat::Stl);
    assert_ne!(id, received.mesh_id(MeshFormat::Ply));
    let (record, created) = store.add_mesh(received, &new_mesh()).await.unwrap();
    assert!(created);
    assert_eq!((&record.id, record.bytes), (&id, 5));
    assert_eq!(fs::read(meshes.join(id.as_str())).unwrap(), b"solid");
    let again = receive(&store, b"solid").await;
    let (again, created) = store.add_mesh(again, &new_mesh()).await.unwrap();
    assert!(!created);
    assert_eq!(again.id, id);
    assert_eq!((files_in(&uploads), files_in(&meshes)), (0, 1));
    assert_eq!(
        store.mesh_file(&id).await.unwrap(),
        Some((MeshFormat::Stl, b"solid".to_vec()))
    );
}

#[tokio::test]
async fn leftovers_of_a_crash_are_swept_at_start() {
    let data = folder();
    let store = open(&data).await;
    let kept = add_mesh(&store, b"kept").await;
    let lost = add_mesh(&store, b"lost").await;
    drop(store);
    let meshes = data.path().join("meshes");
    fs::write(data.path().join("uploads/half"), b"ha").unwrap();
    fs::write(meshes.join("0".repeat(64)), b"no row").unwrap();
    fs::write(meshes.join("README"), b"not ours").unwrap();
    fs::remove_file(meshes.join(lost.as_str())).unwrap();

    let store = open(&data).await;
    assert_eq!(files_in(&data.path().join("uploads")), 0);
    assert_eq!(files_in(&meshes), 2);
    assert!(meshes.join("README").exists());
    assert!(store.mesh(&kept).await.unwrap().is_some());
    assert!(store.mesh(&lost).await.unwrap().is_none());
}

#[tokio::test]
async fn illegal_transitions_are_refused_whoever_asks() {
    let data = folder();
    let store = open(&data).await;
    for from in JobState::ALL {
        for to in JobState::ALL {
            let id = JobId::new().to_string();
            sqlx::query(
                "INSERT INTO jobs (id, mesh_id, state, created_at, request, lease, finished_at) \
                 VALUES (?1, 'm', ?2, 0, '{}', CASE ?2 WHEN 'running' THEN 'x' END, \
                 CASE WHEN ?2 NOT IN ('queued', 'running') THEN 0 END)",
            )
            .bind(&id)
            .bind(from.name())
            .execute(&store.writer)
            .await
            .unwrap();
            let changed = sqlx::query(
                "UPDATE jobs SET state = ?2, lease = CASE ?2 WHEN 'running' THEN 'x' END, \
                 finished_at = CASE WHEN ?2 NOT IN ('queued', 'running') THEN 0 END WHERE id = ?1",
            )
            .bind(&id)
            .bind(to.name())
            .execute(&store.writer)
            .await;
            let legal = from == to
                || match from {
                    JobState::Queued => matches!(to, JobState::Running | JobState::Cancelled),
                    JobState::Running => true,
                    JobState::Succeeded | JobState::Failed | JobState::Cancelled => false,
                };
            assert_eq!(changed.is_ok(), legal, "{from:?} to {to:?}: {changed:?}");
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn the_queue_never_holds_more_than_its_capacity() {
    let data = folder();
    let store = open(&data).await;
    let mesh = add_mesh(&store, b"m").await;
    let attempts: Vec<_> = (0..40)
        .map(|_| {
            let (store, mesh) = (store.clone(), mesh.clone());
            tokio::spawn(async move { store.submit(&mesh, &new_job(7)).await.unwrap() })
        })
        .collect();
    let mut queued = 0;
    for attempt in attempts {
        match attempt.await.unwrap() {
            Ok(job) => {
                assert_eq!((job.state, job.attempt), (JobState::Queued, 1));
                queued += 1;
            }
            Err(refusal) => assert_eq!(refusal, Refusal::QueueFull),
        }
    }
    assert_eq!((queued, store.queued().await.unwrap()), (7, 7));
    // A claimed job waits no more.
    store.claim().await.unwrap().unwrap();
    assert!(store.submit(&mesh, &new_job(7)).await.unwrap().is_ok());
    let nowhere = MeshId::parse(&"0".repeat(64)).unwrap();
    let refused = store.submit(&nowhere, &new_job(100)).await.unwrap();
    assert_eq!(refused.unwrap_err(), Refusal::UnknownMesh);
}

#[tokio::test(flavor = "multi_thread")]
async fn every_job_is_claimed_once_and_in_order() {
    let data = folder();
    let store = open(&data).await;
    let mesh = add_mesh(&store, b"m").await;
    let mut submitted = Vec::new();
    for _ in 0..12 {
        submitted.push(submit(&store, &mesh).await.id);
    }
    let first = store.claim().await.unwrap().unwrap();
    assert_eq!(first.lease.job, submitted[0]);
    let claims: Vec<_> = (0..30)
        .map(|_| {
            let store = store.clone();
            tokio::spawn(async move { store.claim().await.unwrap() })
        })
        .collect();
    let mut claimed = vec![first.lease.job];
    for claim in claims {
        claimed.extend(claim.await.unwrap().map(|claim| claim.lease.job));
    }
    claimed.sort();
    assert_eq!(claimed, submitted);
}

#[tokio::test]
async fn a_job_survives_two_crashes_and_fails_at_the_third() {
    let data = folder();
    let store = open(&data).await;
    let mesh = add_mesh(&store, b"m").await;
    let id = submit(&store, &mesh).await.id;
    let bystander = submit(&store, &mesh).await.id;
    drop(store);
    for attempt in 1..=3 {
        let store = open(&data).await;
        assert_eq!(
            store.recover(3, &exhausted()).await.unwrap(),
            u64::from(attempt > 1)
        );
        let record = job(&store, id).await;
        assert_eq!((record.state, record.attempt), (JobState::Queued, attempt));
        assert_eq!(record.started_at, None);
        let claim = store.claim().await.unwrap().unwrap();
        assert_eq!(claim.lease.job, id);
        assert_eq!(job(&store, id).await.state, JobState::Running);
    }
    let store = open(&data).await;
    store.recover(3, &exhausted()).await.unwrap();
    let record = job(&store, id).await;
    assert_eq!((record.state, record.attempt), (JobState::Failed, 3));
    assert_eq!(record.problem, Some(exhausted()));
    assert!(record.finished_at.is_some());
    let record = job(&store, bystander).await;
    assert_eq!((record.state, record.attempt), (JobState::Queued, 1));
}

#[tokio::test]
async fn a_cancellation_outlives_a_crash() {
    let data = folder();
    let store = open(&data).await;
    let mesh = add_mesh(&store, b"m").await;
    let id = submit(&store, &mesh).await.id;
    let claim = store.claim().await.unwrap().unwrap();
    let record = store.cancel(id).await.unwrap().unwrap();
    assert_eq!(record.state, JobState::Running);
    assert_eq!(store.hold(&claim.lease).await.unwrap(), Hold::Cancelled);
    drop(store);
    let store = open(&data).await;
    store.recover(3, &exhausted()).await.unwrap();
    assert_eq!(job(&store, id).await.state, JobState::Cancelled);
}

#[tokio::test]
async fn a_stale_lease_changes_nothing() {
    let data = folder();
    let store = open(&data).await;
    let mesh = add_mesh(&store, b"m").await;
    let id = submit(&store, &mesh).await.id;
    let stale = store.claim().await.unwrap().unwrap().lease;
    store.recover(3, &exhausted()).await.unwrap();
    let unchanged = async |store: &Store| {
        let before = serde_json::to_string(&job(store, id).await).unwrap();
        assert_eq!(store.hold(&stale).await.unwrap(), Hold::Lost);
        assert!(
            !store
                .finish(&stale, &found(), &progress(), 9)
                .await
                .unwrap()
        );
        assert!(!store.release(&stale, 9).await.unwrap());
        assert_eq!(
            serde_json::to_string(&job(store, id).await).unwrap(),
            before
        );
    };
    unchanged(&store).await;
    let fresh = store.claim().await.unwrap().unwrap().lease;
    unchanged(&store).await;
    assert_eq!(store.hold(&fresh).await.unwrap(), Hold::Held);
    assert!(
        store
            .finish(&fresh, &found(), &progress(), 9)
            .await
            .unwrap()
    );
    unchanged(&store).await;
    let record = job(&store, id).await;
    assert_eq!((record.state, record.revision), (JobState::Succeeded, 10));
    assert_eq!(record.result.unwrap().get(), r#"{"quality":0.1}"#);
    assert_eq!(record.progress, Some(progress()));
    assert!(store.delete_job(id).await.unwrap());
    assert!(
        !store
            .finish(&fresh, &found(), &progress(), 9)
            .await
            .unwrap()
    );
    assert!(store.job(id).await.unwrap().is_none());
}

#[tokio::test]
async fn a_cancelled_run_keeps_what_it_found_and_an_ended_one_stays() {
    let data = folder();
    let store = open(&data).await;
    let mesh = add_mesh(&store, b"m").await;
    let running = submit(&store, &mesh).await.id;
    let waiting = submit(&store, &mesh).await.id;
    let lease = store.claim().await.unwrap().unwrap().lease;
    store.cancel(running).await.unwrap().unwrap();
    store
        .finish(&lease, &found(), &progress(), 2)
        .await
        .unwrap();
    let record = job(&store, running).await;
    assert_eq!(record.state, JobState::Cancelled);
    assert!(record.result.is_some());
    assert!(store.cancel(running).await.unwrap().is_none());
    let record = store.cancel(waiting).await.unwrap().unwrap();
    assert_eq!(record.state, JobState::Cancelled);
    assert!(store.claim().await.unwrap().is_none());
}

#[tokio::test]
async fn a_job_put_back_loses_neither_attempt_nor_place() {
    let data = folder();
    let store = open(&data).await;
    let mesh = add_mesh(&store, b"m").await;
    let first = submit(&store, &mesh).await.id;
    submit(&store, &mesh).await;
    let lease = store.claim().await.unwrap().unwrap().lease;
    assert!(store.release(&lease, 17).await.unwrap());
    let record = job(&store, first).await;
    assert_eq!(
        (record.state, record.attempt, record.revision),
        (JobState::Queued, 1, 18)
    );
    assert_eq!(store.claim().await.unwrap().unwrap().lease.job, first);
}

#[tokio::test]
async fn a_mesh_in_use_stays_and_a_refused_job_takes_its_mesh_along() {
    let data = folder();
    let store = open(&data).await;
    let meshes = data.path().join("meshes");
    let mesh = add_mesh(&store, b"m").await;
    let id = submit(&store, &mesh).await.id;
    assert_eq!(store.delete_mesh(&mesh).await.unwrap(), Deletion::InUse);

    let full = new_job(1);
    let received = receive(&store, b"other").await;
    let refused = store
        .add_mesh_and_job(received, &new_mesh(), &full)
        .await
        .unwrap();
    assert_eq!(refused.unwrap_err(), Refusal::QueueFull);
    assert_eq!(files_in(&meshes), 1);
    let received = receive(&store, b"m").await;
    let refused = store
        .add_mesh_and_job(received, &new_mesh(), &full)
        .await
        .unwrap();
    assert!(refused.is_err());
    assert_eq!(files_in(&meshes), 1, "a mesh that was there stays");
    assert_eq!(
        store.meshes(None, 10).await.unwrap().unwrap().meshes.len(),
        1
    );

    store.cancel(id).await.unwrap();
    assert_eq!(store.delete_mesh(&mesh).await.unwrap(), Deletion::Done);
    assert_eq!(store.delete_mesh(&mesh).await.unwrap(), Deletion::NotFound);
    assert_eq!(files_in(&meshes), 0);
    assert_eq!(job(&store, id).await.mesh_id, mesh.as_str());
}

#[tokio::test]
async fn pages_are_complete_and_without_duplicates() {
    let data = folder();
    let store = open(&data).await;
    let (mut meshes, mut jobs) = (Vec::new(), Vec::new());
    for number in 0..23_u8 {
        let mesh = add_mesh(&store, &[number]).await;
        jobs.push(submit(&store, &mesh).await.id);
        meshes.push(mesh);
    }
    let (mut cursor, mut seen) = (None, Vec::new());
    loop {
        let page = store.meshes(cursor.as_deref(), 5).await.unwrap().unwrap();
        assert!(page.meshes.len() == 5 || page.next_cursor.is_none());
        seen.extend(page.meshes.into_iter().map(|mesh| mesh.id));
        // What comes meanwhile is newer than any page to come.
        add_mesh(&store, format!("late {}", seen.len()).as_bytes()).await;
        cursor = page.next_cursor;
        if cursor.is_none() {
            break;
        }
    }
    meshes.reverse();
    assert_eq!(seen, meshes);

    let (mut cursor, mut seen) = (None, Vec::new());
    let filter = JobFilter {
        state: Some(JobState::Queued),
        mesh_id: None,
    };
    loop {
        let page = store
            .jobs(&filter, cursor.as_deref(), 6)
            .await
            .unwrap()
            .unwrap();
        seen.extend(page.jobs.into_iter().map(|job| job.id));
        cursor = page.next_cursor;
        if cursor.is_none() {
            break;
        }
    }
    jobs.reverse();
    assert_eq!(seen, jobs);
    assert_eq!(seen.iter().collect::<HashSet<_>>().len(), 23);

    let one = JobFilter {
        state: None,
        mesh_id: Some(meshes[3].clone()),
    };
    let page = store.jobs(&one, None, 6).await.unwrap().unwrap();
    assert_eq!((page.jobs.len(), page.next_cursor), (1, None));
    let none = JobFilter {
        state: Some(JobState::Failed),
        ..one
    };
    assert!(
        store
            .jobs(&none, None, 6)
            .await
            .unwrap()
            .unwrap()
            .jobs
            .is_empty()
    );

    let of_meshes = store.meshes(None, 5).await.unwrap().unwrap().next_cursor;
    for forged in ["", "x", &jobs[0].to_string(), &of_meshes.unwrap()] {
        assert!(
            store
                .jobs(&filter, Some(forged), 5)
                .await
                .unwrap()
                .is_none(),
            "{forged}"
        );
    }
}
