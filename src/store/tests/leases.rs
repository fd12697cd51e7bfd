//! Who may write about a job, and what becomes of it.

use super::*;

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
async fn every_job_is_claimed_once_and_in_order() {
    let data = folder();
    let store = open(&data).await;
    let mesh = add_mesh(&store, b"m").await;
    let mut submitted = Vec::new();
    for _ in 0..12 {
        submitted.push(submit(&store, &mesh).await.id);
    }
    let first = claim(&store).await;
    assert_eq!(first.lease.job, submitted[0]);
    let claims: Vec<_> = (0..30)
        .map(|_| {
            let store = store.clone();
            tokio::spawn(async move { store.claim(Priority::Interactive).await.unwrap() })
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
        let claim = claim(&store).await;
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
    let claim = claim(&store).await;
    let record = store.cancel(&Owner::ANONYMOUS, id).await.unwrap().unwrap();
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
    let stale = claim(&store).await.lease;
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
    let Claim {
        lease: fresh,
        revision,
        ..
    } = claim(&store).await;
    // Past all that the holder who died can have shown, 20 a second for two hours and more.
    assert!(revision > 200_000, "{revision}");
    unchanged(&store).await;
    assert_eq!(store.hold(&fresh).await.unwrap(), Hold::Held);
    let shown = revision + 7;
    assert!(
        store
            .finish(&fresh, &found(), &progress(), shown)
            .await
            .unwrap()
    );
    unchanged(&store).await;
    let record = job(&store, id).await;
    assert_eq!(
        (record.state, record.revision),
        (JobState::Succeeded, shown + 1)
    );
    assert_eq!(record.result.unwrap().get(), r#"{"quality":0.1}"#);
    assert_eq!(record.progress, Some(progress()));
    assert!(store.delete_job(&Owner::ANONYMOUS, id).await.unwrap());
    assert!(
        !store
            .finish(&fresh, &found(), &progress(), 9)
            .await
            .unwrap()
    );
    assert!(store.job(&Owner::ANONYMOUS, id).await.unwrap().is_none());
}

#[tokio::test]
async fn a_cancelled_run_keeps_what_it_found_and_an_ended_one_stays() {
    let data = folder();
    let store = open(&data).await;
    let mesh = add_mesh(&store, b"m").await;
    let running = submit(&store, &mesh).await.id;
    let waiting = submit(&store, &mesh).await.id;
    let lease = claim(&store).await.lease;
    store
        .cancel(&Owner::ANONYMOUS, running)
        .await
        .unwrap()
        .unwrap();
    store
        .finish(&lease, &found(), &progress(), 2)
        .await
        .unwrap();
    let record = job(&store, running).await;
    assert_eq!(record.state, JobState::Cancelled);
    assert!(record.result.is_some());
    assert!(
        store
            .cancel(&Owner::ANONYMOUS, running)
            .await
            .unwrap()
            .is_none()
    );
    let record = store
        .cancel(&Owner::ANONYMOUS, waiting)
        .await
        .unwrap()
        .unwrap();
    assert_eq!(record.state, JobState::Cancelled);
    assert!(store.claim(Priority::Interactive).await.unwrap().is_none());
}

#[tokio::test]
async fn a_job_put_back_loses_neither_attempt_nor_place() {
    let data = folder();
    let store = open(&data).await;
    let mesh = add_mesh(&store, b"m").await;
    let first = submit(&store, &mesh).await.id;
    submit(&store, &mesh).await;
    let lease = claim(&store).await.lease;
    assert!(store.release(&lease, 17).await.unwrap());
    let record = job(&store, first).await;
    assert_eq!(
        (record.state, record.attempt, record.revision),
        (JobState::Queued, 1, 18)
    );
    assert_eq!(claim(&store).await.lease.job, first);
}

#[tokio::test]
async fn times_stay_in_order_when_the_clock_is_set_back() {
    let data = folder();
    let store = open(&data).await;
    let mesh = add_mesh(&store, b"mesh").await;
    for ending in ["finish", "release", "cancel", "recover", "withdraw"] {
        let submitted = submit(&store, &mesh).await.id;
        // As if it had been submitted under a clock that was an hour ahead.
        sqlx::query("UPDATE jobs SET created_at = created_at + 3600000000 WHERE id = ?1")
            .bind(submitted.to_string())
            .execute(&store.writer)
            .await
            .unwrap();
        if ending == "withdraw" {
            store
                .cancel(&Owner::ANONYMOUS, submitted)
                .await
                .unwrap()
                .unwrap();
        } else {
            let lease = claim(&store).await.lease;
            assert_eq!(lease.job, submitted);
            if ending != "finish" {
                store
                    .cancel(&Owner::ANONYMOUS, submitted)
                    .await
                    .unwrap()
                    .unwrap();
            }
            match ending {
                "finish" => {
                    let written = store.finish(&lease, &found(), &progress(), 9).await;
                    assert!(written.unwrap());
                }
                "release" => assert!(store.release(&lease, 9).await.unwrap()),
                "cancel" => {
                    let written = store.finish(&lease, &Ending::Nothing, &progress(), 9).await;
                    assert!(written.unwrap());
                }
                _ => assert_eq!(store.recover(3, &exhausted()).await.unwrap(), 1),
            }
        }
        let ended = job(&store, submitted).await;
        assert!(ended.state.is_final(), "{ending}");
        let started = ended.started_at.unwrap_or(ended.created_at);
        assert!(ended.created_at <= started, "{ending}");
        assert!(started <= ended.finished_at.unwrap(), "{ending}");
    }
}

#[tokio::test]
async fn a_transaction_that_fails_half_way_leaves_the_store_in_order() {
    let data = folder();
    let store = open(&data).await;
    let mesh = add_mesh(&store, b"m").await;
    let set = async |statement: &'static str| {
        sqlx::query(statement).execute(&store.writer).await.unwrap();
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
