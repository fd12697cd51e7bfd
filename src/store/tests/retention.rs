//! What is kept no longer.

use std::time::Duration;

use super::*;

const DAY: Duration = Duration::from_secs(86_400);

/// Moves everything into the past.
async fn age(store: &Store, days: i64) {
    let shift = days * 86_400_000_000;
    for statement in [
        "UPDATE jobs SET finished_at = finished_at - ?1, created_at = created_at - ?1",
        "UPDATE meshes SET used_at = used_at - ?1",
        "UPDATE submissions SET created_at = created_at - ?1",
        "UPDATE expired SET expired_at = expired_at - ?1",
    ] {
        let shifted = sqlx::query(statement).bind(shift);
        shifted.execute(&store.writer).await.unwrap();
    }
}

async fn rows(store: &Store, table: &str) -> i64 {
    let count = format!("SELECT count(*) FROM {table}");
    let count = sqlx::query_scalar(sqlx::AssertSqlSafe(count));
    count.fetch_one(&store.readers).await.unwrap()
}

#[tokio::test]
async fn ended_jobs_and_unused_meshes_go_and_the_rest_stays() {
    let data = folder();
    let store = open(&data).await;
    let mesh = add_mesh(&store, b"used").await;
    let unused = add_mesh(&store, b"unused").await;
    let submission = Submission {
        key: "k".to_owned(),
        fingerprint: [1; 32],
    };
    let ended = NewJob {
        submission: Some(submission),
        ..new_job(10)
    };
    let ended = store.submit(&mesh, &ended).await.unwrap().unwrap().id;
    let lease = claim(&store).await.lease;
    store
        .finish(&lease, &found(), &progress(), 2)
        .await
        .unwrap();
    let waiting = submit(&store, &mesh).await.id;

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
    assert_eq!(files_in(&data.path().join("meshes")), 1);
    assert_eq!(job(&store, waiting).await.state, JobState::Queued);
    store.forget_submissions().await.unwrap();
    assert_eq!(rows(&store, "submissions").await, 0);

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
    assert_eq!(files_in(&data.path().join("meshes")), 0);
    age(&store, 2).await;
    store.expire(DAY).await.unwrap();
    for table in ["jobs", "meshes", "submissions", "expired"] {
        assert_eq!(rows(&store, table).await, 0, "{table}");
    }
}

#[tokio::test]
async fn a_mesh_asked_for_lives_on() {
    let data = folder();
    let store = open(&data).await;
    let owner = Owner::ANONYMOUS;
    let meshes = [
        add_mesh(&store, b"evaluated").await,
        add_mesh(&store, b"planned").await,
        add_mesh(&store, b"sent again").await,
    ];
    age(&store, 2).await;
    let kept = store.kept(&owner, &meshes[0]).await.unwrap().unwrap();
    store.touch(&owner, &meshes[0], &kept, DAY).await.unwrap();
    submit(&store, &meshes[1]).await;
    add_mesh(&store, b"sent again").await;
    assert_eq!(store.expire(DAY).await.unwrap(), Expired::default());
    for mesh in &meshes {
        assert!(store.mesh_file(&owner, mesh).await.unwrap().is_some());
    }
}

#[tokio::test]
async fn thousands_expire_in_one_sweep() {
    let data = folder();
    let store = open(&data).await;
    let mesh = add_mesh(&store, b"m").await;
    sqlx::query(
        "WITH RECURSIVE n (i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 1001) \
         INSERT INTO jobs (id, mesh_id, state, created_at, finished_at, request) \
         SELECT printf('id-%d', i), ?1, 'succeeded', 0, 1, '{}' FROM n",
    )
    .bind(mesh.as_str())
    .execute(&store.writer)
    .await
    .unwrap();
    assert_eq!(store.expire(DAY).await.unwrap().jobs, 1001);
    assert_eq!(
        (rows(&store, "jobs").await, rows(&store, "expired").await),
        (0, 1001)
    );
}
