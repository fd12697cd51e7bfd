//! API keys, and that what is one owner's does not exist for another.

use jiff::{SignedDuration, Timestamp};

use super::*;

pub async fn a_key_is_good_until_it_expires_or_is_revoked(store: Bench) {
    assert!(!store.has_keys().await.unwrap());
    // Beside the server that holds the folder, as the command line does it.
    let keys = store.keys().await;
    let key = keys.create("robot", None).await.unwrap();
    assert!(store.has_keys().await.unwrap());
    let owner = store.owner_of(&key.text).await.unwrap().unwrap();
    assert_eq!(owner.as_str(), key.record.id);
    let other = keys.create("robot", None).await.unwrap();
    assert_ne!(store.owner_of(&other.text).await.unwrap(), Some(owner));

    let past = Timestamp::now() - SignedDuration::from_secs(1);
    let expired = keys.create("old", Some(past)).await.unwrap();
    assert_eq!(store.owner_of(&expired.text).await.unwrap(), None);
    assert!(keys.revoke(&key.record.id).await.unwrap());
    assert!(!keys.revoke("nobody").await.unwrap());
    assert_eq!(store.owner_of(&key.text).await.unwrap(), None);
    let listed = keys.list().await.unwrap();
    assert_eq!(listed.len(), 3);
    assert!(listed[0].revoked_at.is_some() && listed[1].revoked_at.is_none());
}

pub async fn what_is_no_key_lets_nobody_in(store: Bench) {
    let key = store.keys().await.create("", None).await.unwrap();
    let text = key.text.as_str();
    let last = if text.ends_with('0') { "1" } else { "0" };
    let close = format!("{}{last}", &text[..text.len() - 1]);
    let id = key.record.id.as_str();
    let shapes = [
        String::new(),
        "graspd".to_owned(),
        format!("graspd_{id}_"),
        format!("graspd_{id}"),
        format!("graspd__{}", text.rsplit('_').next().unwrap()),
        format!("{text}_"),
        text.to_uppercase(),
        close,
        "é".repeat(100),
        "' OR 1=1 --".to_owned(),
    ];
    for wrong in shapes {
        assert_eq!(store.owner_of(&wrong).await.unwrap(), None, "{wrong:?}");
    }
    assert!(store.owner_of(text).await.unwrap().is_some());
}

pub async fn owners_share_a_file_and_nothing_else(store: Bench) {
    let (a, b) = (Owner::of_key("a"), Owner::of_key("b"));
    let mut id = None;
    for owner in [&a, &b] {
        let received = receive(&*store, b"same").await;
        let mesh = NewMesh {
            owner: owner.clone(),
            ..new_mesh()
        };
        let (record, created) = store.add_mesh(received, &mesh).await.unwrap().unwrap();
        assert!(created);
        id = Some(record.id);
    }
    let id = id.unwrap();
    assert_eq!(store.files().await, 1);
    let job = NewJob {
        owner: a.clone(),
        ..new_job(10)
    };
    let job = store.submit(&id, &job).await.unwrap().unwrap();
    assert!(store.job(&b, job.id).await.unwrap().is_none());
    assert!(store.cancel(&b, job.id).await.unwrap().is_none());
    assert!(!store.delete_job(&b, job.id).await.unwrap());
    assert!(
        store
            .job(&Owner::ANONYMOUS, job.id)
            .await
            .unwrap()
            .is_none()
    );
    assert!(store.job(&a, job.id).await.unwrap().is_some());

    assert_eq!(store.delete_mesh(&a, &id).await.unwrap(), Deletion::InUse);
    assert_eq!(store.delete_mesh(&b, &id).await.unwrap(), Deletion::Done);
    assert!(store.mesh_file(&a, &id).await.unwrap().is_some());
    assert!(store.mesh_file(&b, &id).await.unwrap().is_none());
    assert!(store.delete_job(&a, job.id).await.unwrap());
    assert_eq!(store.delete_mesh(&a, &id).await.unwrap(), Deletion::Done);
    assert_eq!(store.files().await, 0);
}

pub async fn quotas_bound_each_owner_alone(store: Bench) {
    let (a, b) = (Owner::of_key("a"), Owner::of_key("b"));
    let mesh = |owner: &Owner| NewMesh {
        owner: owner.clone(),
        max_owner_bytes: Some(10),
        ..new_mesh()
    };
    let added = |bytes: &'static [u8], owner: Owner| {
        let store = store.share();
        let mesh = mesh(&owner);
        async move {
            let received = receive(&*store, bytes).await;
            store.add_mesh(received, &mesh).await.unwrap()
        }
    };
    let id = added(b"123456", a.clone()).await.unwrap().0.id;
    assert_eq!(
        added(b"12345", a.clone()).await.unwrap_err(),
        Refusal::OwnerStorageFull
    );
    // It is there: that takes no more room.
    assert!(!added(b"123456", a.clone()).await.unwrap().1);
    added(b"1234", a.clone()).await.unwrap();
    added(b"12345", b.clone()).await.unwrap();
    assert_eq!(store.files().await, 3);

    let job = |owner: &Owner| NewJob {
        owner: owner.clone(),
        owner_capacity: Some(2),
        ..new_job(3)
    };
    for expected in [None, None, Some(Refusal::OwnerQueueFull)] {
        let outcome = store.submit(&id, &job(&a)).await.unwrap();
        assert_eq!(outcome.err(), expected);
    }
    assert_eq!(
        store.submit(&id, &job(&b)).await.unwrap().unwrap_err(),
        Refusal::UnknownMesh
    );
    let id = added(b"12345", b.clone()).await.unwrap().0.id;
    store.submit(&id, &job(&b)).await.unwrap().unwrap();
    assert_eq!(
        store.submit(&id, &job(&b)).await.unwrap().unwrap_err(),
        Refusal::QueueFull
    );
}
