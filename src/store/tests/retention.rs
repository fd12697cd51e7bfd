//! What is kept no longer.

use std::time::Duration;

use super::*;

const DAY: Duration = Duration::from_secs(86_400);

/// Moves everything into the past.
pub async fn age(store: &Bench, days: i64) {
    let shift = days * 86_400_000_000;
    for (table, time) in [
        ("jobs", "finished_at"),
        ("jobs", "created_at"),
        ("batches", "created_at"),
        ("meshes", "used_at"),
        ("submissions", "created_at"),
        ("expired", "expired_at"),
    ] {
        let statement = format!("UPDATE {table} SET {time} = {time} - {shift}");
        store.execute(&statement).await;
    }
}

pub async fn ended_jobs_and_unused_meshes_go_and_the_rest_stays(store: Bench) {
    let mesh = add_mesh(&*store, b"used").await;
    let unused = add_mesh(&*store, b"unused").await;
    let submission = Submission {
        key: "k".to_owned(),
        fingerprint: [1; 32],
    };
    let ended = NewJob {
        submission: Some(submission),
        ..new_job(10)
    };
    let ended = store.submit(&mesh, &ended).await.unwrap().unwrap().id;
    let lease = claim(&*store).await.lease;
    store
        .finish(&lease, &found(), &progress(), 2)
        .await
        .unwrap();
    let waiting = submit(&*store, &mesh).await.id;

    assert_eq!(store.expire(DAY).await.unwrap(), Expired::default());
    age(&store, 2).await;
    assert_eq!(
        store.expire(DAY).await.unwrap(),
        Expired { jobs: 1, meshes: 1 }
    );
    assert!(store.job(&Owner::ANONYMOUS, ended).await.unwrap().is_none());
    assert!(store.has_expired(&Owner::ANONYMOUS, ended).await.unwrap());
    assert!(!store.has_expired(&Owner::of_key("b"), ended).await.unwrap());
    assert!(!store.has_expired(&Owner::ANONYMOUS, waiting).await.unwrap());
    assert!(
        store
            .mesh(&Owner::ANONYMOUS, &unused)
            .await
            .unwrap()
            .is_none()
    );
    assert_eq!(store.files().await, 1);
    assert_eq!(job(&*store, waiting).await.state, JobState::Queued);
    store.forget_submissions().await.unwrap();
    assert_eq!(store.rows("submissions").await, 0);

    // Once its last job has gone too, so does the mesh, and in the end the memory of it all.
    store
        .cancel(&Owner::ANONYMOUS, waiting)
        .await
        .unwrap()
        .unwrap();
    age(&store, 2).await;
    assert_eq!(
        store.expire(DAY).await.unwrap(),
        Expired { jobs: 1, meshes: 1 }
    );
    assert_eq!(store.files().await, 0);
    age(&store, 2).await;
    store.expire(DAY).await.unwrap();
    for table in ["jobs", "meshes", "submissions", "expired"] {
        assert_eq!(store.rows(table).await, 0, "{table}");
    }
}

pub async fn a_mesh_that_is_used_does_not_expire(store: Bench) {
    let owner = Owner::ANONYMOUS;
    let meshes = [
        add_mesh(&*store, b"evaluated").await,
        add_mesh(&*store, b"planned").await,
        add_mesh(&*store, b"sent again").await,
    ];
    age(&store, 2).await;
    let kept = store
        .mesh_summary(&owner, &meshes[0])
        .await
        .unwrap()
        .unwrap();
    store
        .mark_used(&owner, &meshes[0], &kept, DAY)
        .await
        .unwrap();
    submit(&*store, &meshes[1]).await;
    add_mesh(&*store, b"sent again").await;
    assert_eq!(store.expire(DAY).await.unwrap(), Expired::default());
    for mesh in &meshes {
        assert!(store.mesh_file(&owner, mesh).await.unwrap().is_some());
    }
}

pub async fn thousands_expire_in_one_sweep(store: Bench) {
    let mesh = add_mesh(&*store, b"m").await;
    for number in 0..1001 {
        let job = submit(&*store, &mesh).await.id;
        // Some were withdrawn, the rest is still there.
        if number < 1000 {
            store.cancel(&Owner::ANONYMOUS, job).await.unwrap();
        }
    }
    age(&store, 2).await;
    assert_eq!(store.expire(DAY).await.unwrap().jobs, 1000);
    assert_eq!(
        (store.rows("jobs").await, store.rows("expired").await),
        (1, 1000)
    );
}
