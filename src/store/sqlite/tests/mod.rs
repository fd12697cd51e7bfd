//! What is true of a data directory alone: lock, settings, files, room on the disk.

use sqlx::sqlite::SqlitePool;

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use super::*;
use crate::store::tests::{add_mesh, new_job, receive, submit};
use crate::store::*;
use crate::wire::JobId;

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

async fn open(data: &TempDir) -> Sqlite {
    Sqlite::open(data.path()).await.unwrap()
}

fn files_in(folder: &Path) -> usize {
    fs::read_dir(folder).unwrap().count()
}

#[tokio::test]
async fn one_process_at_a_time_has_a_data_directory() {
    let data = folder();
    let store = open(&data).await;
    let second = Sqlite::open(data.path()).await;
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
        let answer = store.writer.run(sqlx::query(statement)).await.unwrap();
        answer.one::<(i64,)>().unwrap().0
    };
    assert_eq!(pragma("PRAGMA synchronous").await, 2);
    assert_eq!(pragma("PRAGMA foreign_keys").await, 1);
    let journal = store.writer.run(sqlx::query("PRAGMA journal_mode")).await;
    let (journal,): (String,) = journal.unwrap().one().unwrap();
    assert_eq!(journal, "wal");
    let write = store.readers.run(sqlx::query("DELETE FROM jobs")).await;
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
    assert!(
        store
            .mesh(&Owner::ANONYMOUS, &kept)
            .await
            .unwrap()
            .is_some()
    );
    assert!(
        store
            .mesh(&Owner::ANONYMOUS, &lost)
            .await
            .unwrap()
            .is_none()
    );
}

#[tokio::test]
async fn a_closed_store_leaves_no_log_behind() {
    let data = folder();
    let store = open(&data).await;
    add_mesh(&store, b"m").await;
    store.close().await;
    assert!(data.path().join("graspd.db").exists());
    for leftover in ["graspd.db-wal", "graspd.db-shm"] {
        assert!(!data.path().join(leftover).exists(), "{leftover}");
    }
}

#[tokio::test]
async fn a_folder_among_the_uploads_is_left_alone() {
    let data = folder();
    drop(open(&data).await);
    let uploads = data.path().join("uploads");
    fs::create_dir(uploads.join("of-someone")).unwrap();
    fs::write(uploads.join("leftover"), b"half").unwrap();
    drop(open(&data).await);
    assert!(uploads.join("of-someone").is_dir() && !uploads.join("leftover").exists());
}

#[tokio::test]
async fn a_write_that_finds_no_room_gets_what_is_kept() {
    let data = folder();
    let store = open(&data).await;
    let kept = data.path().join("graspd.db-reserve");
    let tries = std::cell::Cell::new(0);
    // The first try finds the disk full.
    let write = || {
        tries.set(tries.get() + 1);
        let tried = tries.get();
        async move {
            match tried {
                1 => Err(StoreError::Full),
                _ => Ok(tried),
            }
        }
    };
    store.keep_reserve(1).await;
    assert!(!kept.exists(), "there was too little room to keep any");
    store.keep_reserve(u64::MAX).await;
    assert_eq!(fs::metadata(&kept).unwrap().len(), 4 << 20);
    assert_eq!(store.with_reserve(write).await.unwrap(), 2);
    assert!(!kept.exists());
    store.keep_reserve(u64::MAX).await;
    assert!(kept.exists());
    let full = || async { Err::<(), _>(StoreError::Full) };
    assert!(matches!(
        store.with_reserve(full).await,
        Err(StoreError::Full)
    ));
    let other = || async { Err::<(), _>(StoreError::Damaged("so".to_owned())) };
    store.keep_reserve(u64::MAX).await;
    assert!(store.with_reserve(other).await.is_err());
    assert!(kept.exists(), "room does not help there");
}

#[tokio::test]
async fn what_can_be_written_is_found_out_by_writing() {
    let data = folder();
    let store = open(&data).await;
    assert!(store.writer.written().is_none());
    store.check_writable().await.unwrap();
    let first = store.writer.written().unwrap();
    // A proof is good for a while.
    store.check_writable().await.unwrap();
    assert_eq!(store.writer.written(), Some(first));
    // Finding nothing to change proves nothing.
    store.cancel(&Owner::ANONYMOUS, JobId::new()).await.unwrap();
    assert_eq!(store.writer.written(), Some(first));
    add_mesh(&store, b"mesh").await;
    assert!(store.writer.written().unwrap() > first);
    let wrong = sqlx::query("INSERT INTO meshes (id) VALUES ('x')");
    let wrong = store.writer.run(wrong).await;
    assert!(wrong.is_err() && store.writer.written().is_none());
    store.close().await;
    assert!(store.check_writable().await.is_err());
}

#[tokio::test]
async fn a_transaction_that_fails_half_way_leaves_the_store_in_order() {
    let data = folder();
    let store = open(&data).await;
    let mesh = add_mesh(&store, b"m").await;
    let set = async |statement: &'static str| {
        store.writer.run(sqlx::query(statement)).await.unwrap();
    };
    // SQLite itself rolls back here, as it does when the disk is full.
    set("CREATE TRIGGER broken BEFORE INSERT ON jobs BEGIN SELECT RAISE(ROLLBACK, 'no'); END")
        .await;
    for _ in 0..3 {
        assert!(store.submit(&mesh, &new_job(10)).await.is_err());
    }
    set("DROP TRIGGER broken").await;
    submit(&store, &mesh).await;
    assert_eq!(store.queued().await.unwrap(), 1);
}

#[tokio::test]
async fn a_turn_is_found_in_the_indices() {
    let data = folder();
    let store = open(&data).await;
    let plan = sqlx::query(
        "EXPLAIN QUERY PLAN SELECT min(id) FROM jobs WHERE state = 'queued' AND priority = 'batch' \
         AND owner = (SELECT min(owner) FROM jobs WHERE state = 'queued' AND priority = 'batch' \
         AND owner > 'x')",
    );
    let plan = store.readers.read(plan).await.unwrap();
    let steps: Vec<(i64, i64, i64, String)> = plan.all().unwrap();
    for (.., step) in steps.iter().filter(|(.., step)| step.contains("jobs")) {
        assert!(step.contains("jobs_queued"), "{step}");
    }
}

#[tokio::test]
async fn no_secret_is_kept() {
    let data = folder();
    let keys = SqliteKeys::open(data.path()).await.unwrap();
    let key = keys.create("robot", None).await.unwrap();
    drop(keys);
    let secret = key.text.rsplit('_').next().unwrap().as_bytes();
    for entry in fs::read_dir(data.path()).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            let bytes = fs::read(&path).unwrap();
            assert!(
                !bytes.windows(secret.len()).any(|piece| piece == secret),
                "{path:?}"
            );
        }
    }
}
