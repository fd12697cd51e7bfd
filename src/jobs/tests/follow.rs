//! Following jobs.

use super::*;

/// Waits for a revision of the job greater than `seen`.
async fn next_change(follower: &mut Follower, seen: u64) -> JobRecord {
    let change = tokio::time::timeout(Duration::from_secs(20), follower.next_after(seen));
    let job = change
        .await
        .expect("a change")
        .unwrap()
        .expect("no shutdown");
    assert!(job.revision > seen);
    job
}

#[tokio::test(flavor = "multi_thread")]
async fn every_change_is_seen_in_order() {
    let data = data();
    let service = start(options(&data)).await;
    let first = submit(&service, "endless").await.id;
    let job = submit(&service, "endless").await.id;
    let mut follower = service
        .follow(&Owner::ANONYMOUS, &job.to_string())
        .await
        .unwrap();
    let mut seen = follower.current();
    assert_eq!(seen.state, JobState::Queued);
    service
        .cancel(&Owner::ANONYMOUS, &first.to_string())
        .await
        .unwrap();
    while seen
        .progress
        .is_none_or(|progress| progress.generation == 0)
    {
        seen = next_change(&mut follower, seen.revision).await;
    }
    assert_eq!(seen.state, JobState::Running);

    // Who does not wait for a while sees the newest state once.
    tokio::time::sleep(Duration::from_millis(400)).await;
    let newest = next_change(&mut follower, seen.revision).await;
    assert!(newest.revision >= seen.revision + 2);

    service
        .cancel(&Owner::ANONYMOUS, &job.to_string())
        .await
        .unwrap();
    let mut seen = newest;
    while !seen.state.is_final() {
        seen = next_change(&mut follower, seen.revision).await;
    }
    assert_eq!(seen.state, JobState::Cancelled);
    assert!(seen.result.is_none());
    let stored = service
        .job(&Owner::ANONYMOUS, &job.to_string())
        .await
        .unwrap();
    assert_eq!(stored.revision, seen.revision);
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_is_awaited_no_longer_than_requested() {
    let data = data();
    let service = start(options(&data)).await;
    let job = submit(&service, "endless").await.id.to_string();
    let ended = |job: &JobRecord| job.state.is_final();
    let clock = Instant::now();
    let time = Duration::from_millis(300);
    let running = service
        .wait_for_job(&Owner::ANONYMOUS, &job, time, ended)
        .await
        .unwrap();
    assert!(clock.elapsed() >= time);
    assert_eq!(running.state, JobState::Running);
    let owner = Owner::ANONYMOUS;
    let (cancelled, ended) = tokio::join!(
        service.cancel(&owner, &job),
        service.wait_for_job(&owner, &job, Duration::from_secs(60), ended)
    );
    assert!(cancelled.unwrap().1);
    assert_eq!(ended.unwrap().state, JobState::Cancelled);
    assert!(clock.elapsed() < Duration::from_secs(20));
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_deleted_job_is_not_waited_for() {
    let data = data();
    let service = start(options(&data)).await;
    let job = submit(&service, "endless").await.id;
    until_progress(&service, job).await;
    let mut follower = service
        .follow(&Owner::ANONYMOUS, &job.to_string())
        .await
        .unwrap();
    service
        .delete_job(&Owner::ANONYMOUS, &job.to_string())
        .await
        .unwrap();
    let mut seen = follower.current().revision;
    let gone = loop {
        match follower.next_after(seen).await {
            Ok(job) => seen = job.expect("no shutdown").revision,
            Err(error) => break error,
        }
    };
    assert!(matches!(gone, Error::NotFound), "{gone:?}");
    let unknown = service
        .follow(&Owner::ANONYMOUS, &JobId::new().to_string())
        .await
        .err();
    assert!(matches!(unknown, Some(Error::NotFound)));
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn what_others_change_in_the_store_is_noticed() {
    let data = data();
    let service = start(options(&data)).await;
    submit(&service, "endless").await;
    let job = submit(&service, "endless").await;
    let mut follower = service
        .follow(&Owner::ANONYMOUS, &job.id.to_string())
        .await
        .unwrap();
    let database = data.path().join("graspd.db");
    let database = sqlx::SqlitePool::connect(database.to_str().unwrap())
        .await
        .unwrap();
    let change = "UPDATE jobs SET label = 'renamed', revision = revision + 1 WHERE id = ?1";
    let changed = sqlx::query(change).bind(job.id.to_string());
    assert_eq!(changed.execute(&database).await.unwrap().rows_affected(), 1);
    let renamed = next_change(&mut follower, job.revision).await;
    assert_eq!(renamed.label.as_deref(), Some("renamed"));
    database.close().await;
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn revisions_grow_over_a_restart_and_followers_end_with_the_server() {
    let data = data();
    let service = start(options(&data)).await;
    let job = submit(&service, "endless").await.id;
    let mut follower = service
        .follow(&Owner::ANONYMOUS, &job.to_string())
        .await
        .unwrap();
    let mut seen = follower.current().revision;
    for _ in 0..8 {
        seen = next_change(&mut follower, seen).await.revision;
    }
    service.shutdown().await;
    while let Some(newer) = follower.next_after(seen).await.unwrap() {
        assert!(newer.revision > seen);
        seen = newer.revision;
    }
    let mut put_back = service
        .job(&Owner::ANONYMOUS, &job.to_string())
        .await
        .unwrap();
    assert_eq!(put_back.state, JobState::Queued);
    assert!(put_back.revision >= seen);
    drop((follower, service));

    let service = start(options(&data)).await;
    let mut follower = service
        .follow(&Owner::ANONYMOUS, &job.to_string())
        .await
        .unwrap();
    for _ in 0..3 {
        put_back = next_change(&mut follower, put_back.revision).await;
    }
    assert_eq!(put_back.state, JobState::Running);
    service.shutdown().await;
}
