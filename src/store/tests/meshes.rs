//! Meshes come and go whole.

use super::*;

pub async fn a_mesh_is_kept_once_and_read_back_to_the_byte(store: Bench) {
    drop(receive(&*store, b"whole").await);
    assert_eq!(store.files().await, 0);
    let received = receive(&*store, b"solid").await;
    let id = received.mesh_id(MeshFormat::Stl, None, 1.0);
    assert_ne!(id, received.mesh_id(MeshFormat::Ply, None, 1.0));
    let added = store.add_mesh(received, &new_mesh()).await.unwrap();
    let (record, created) = added.unwrap();
    assert!(created);
    assert_eq!((&record.id, record.bytes), (&id, 5));
    let again = receive(&*store, b"solid").await;
    let added = store.add_mesh(again, &new_mesh()).await.unwrap();
    let (again, created) = added.unwrap();
    assert!(!created);
    assert_eq!(again.id, id);
    assert_eq!(store.files().await, 1);
    let owner = Owner::ANONYMOUS;
    assert!(store.has_mesh_file(&id).await.unwrap());
    assert_eq!(
        store.mesh_file(&owner, &id).await.unwrap(),
        Some((record.options(), b"solid".to_vec()))
    );

    // Longer than any piece that it may be kept in.
    let long: Vec<u8> = (0..5_000_001_u32).map(|n| (n % 251) as u8).collect();
    let mut upload = store.begin_upload().await.unwrap();
    for piece in long.chunks(300_000) {
        upload.write(piece).await.unwrap();
    }
    let mut received = upload.finish().await.unwrap();
    assert!(received.read().unwrap() == long);
    let added = store.add_mesh(received, &new_mesh()).await.unwrap();
    let id = added.unwrap().0.id;
    let kept = store.mesh_file(&owner, &id).await.unwrap().unwrap();
    assert!(kept.1 == long);
    assert_eq!(store.mesh_bytes(&owner).await.unwrap(), 5 + 5_000_001);
}

pub async fn a_mesh_in_use_stays_and_a_refused_job_takes_its_mesh_along(store: Bench) {
    let owner = Owner::ANONYMOUS;
    let mesh = add_mesh(&*store, b"m").await;
    let id = submit(&*store, &mesh).await.id;
    let deletion = store.delete_mesh(&owner, &mesh).await.unwrap();
    assert_eq!(deletion, Deletion::InUse);

    let full = new_job(1);
    let received = receive(&*store, b"other").await;
    let refused = store.add_mesh_and_job(received, &new_mesh(), &full).await;
    assert_eq!(refused.unwrap().unwrap_err(), Refusal::QueueFull);
    assert_eq!(store.files().await, 1);
    let received = receive(&*store, b"m").await;
    let refused = store.add_mesh_and_job(received, &new_mesh(), &full).await;
    assert!(refused.unwrap().is_err());
    assert_eq!(store.files().await, 1, "a mesh that was there stays");
    let page = store.meshes(&owner, None, 10).await.unwrap().unwrap();
    assert_eq!(page.meshes.len(), 1);

    store.cancel(&owner, id).await.unwrap();
    for expected in [Deletion::Done, Deletion::NotFound] {
        let deletion = store.delete_mesh(&owner, &mesh).await.unwrap();
        assert_eq!(deletion, expected);
    }
    assert_eq!(store.files().await, 0);
    assert_eq!(job(&*store, id).await.mesh_id, mesh.as_str());
}
