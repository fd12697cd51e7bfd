//! Directory, settings and mesh files.

use sqlx::sqlite::SqlitePool;

use super::*;

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
    let id = received.mesh_id(MeshFormat::Stl, None, 1.0);
    assert_ne!(id, received.mesh_id(MeshFormat::Ply, None, 1.0));
    let (record, created) = store
        .add_mesh(received, &new_mesh())
        .await
        .unwrap()
        .unwrap();
    assert!(created);
    assert_eq!((&record.id, record.bytes), (&id, 5));
    assert_eq!(fs::read(meshes.join(id.as_str())).unwrap(), b"solid");
    let again = receive(&store, b"solid").await;
    let (again, created) = store.add_mesh(again, &new_mesh()).await.unwrap().unwrap();
    assert!(!created);
    assert_eq!(again.id, id);
    assert_eq!((files_in(&uploads), files_in(&meshes)), (0, 1));
    assert_eq!(
        store.mesh_file(&Owner::ANONYMOUS, &id).await.unwrap(),
        Some((record.options(), b"solid".to_vec()))
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
async fn a_mesh_in_use_stays_and_a_refused_job_takes_its_mesh_along() {
    let data = folder();
    let store = open(&data).await;
    let meshes = data.path().join("meshes");
    let mesh = add_mesh(&store, b"m").await;
    let id = submit(&store, &mesh).await.id;
    assert_eq!(
        store.delete_mesh(&Owner::ANONYMOUS, &mesh).await.unwrap(),
        Deletion::InUse
    );

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
        store
            .meshes(&Owner::ANONYMOUS, None, 10)
            .await
            .unwrap()
            .unwrap()
            .meshes
            .len(),
        1
    );

    store.cancel(&Owner::ANONYMOUS, id).await.unwrap();
    assert_eq!(
        store.delete_mesh(&Owner::ANONYMOUS, &mesh).await.unwrap(),
        Deletion::Done
    );
    assert_eq!(
        store.delete_mesh(&Owner::ANONYMOUS, &mesh).await.unwrap(),
        Deletion::NotFound
    );
    assert_eq!(files_in(&meshes), 0);
    assert_eq!(job(&store, id).await.mesh_id, mesh.as_str());
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
    let wrong = sqlx::query("INSERT INTO meshes (id) VALUES ('x')")
        .execute(&store.writer)
        .await;
    assert!(wrong.is_err() && store.writer.written().is_none());
    store.close().await;
    assert!(store.check_writable().await.is_err());
}
