//! Who may write about a job, and what becomes of it.

use super::*;

pub async fn illegal_transitions_are_refused_whoever_asks(store: Bench) {
    for from in JobState::ALL {
        for to in JobState::ALL {
            let id = JobId::new().to_string();
            let (lease, leased_until) = match store.lease_time() {
                None => ("lease", ""),
                Some(_) => ("lease, leased_until", ", 1"),
            };
            let held = |state: JobState| match state {
                JobState::Running => format!("'x'{leased_until}"),
                _ => format!("NULL{}", leased_until.replace('1', "NULL")),
            };
            let end = |state: JobState| if state.is_final() { "0" } else { "NULL" };
            store
                .execute(&format!(
                    "INSERT INTO jobs (id, owner, mesh_id, state, created_at, request, {lease}, finished_at) \
                     VALUES ('{id}', '', 'm', '{}', 0, '{{}}', {}, {})",
                    from.name(),
                    held(from),
                    end(from)
                ))
                .await;
            let values = held(to);
            let mut values = values.split(", ");
            let mut set = format!("lease = {}", values.next().unwrap());
            if let Some(until) = values.next() {
                set += &format!(", leased_until = {until}");
            }
            let changed = store
                .try_execute(&format!(
                    "UPDATE jobs SET state = '{}', {set}, finished_at = {} WHERE id = '{id}'",
                    to.name(),
                    end(to)
                ))
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

pub async fn every_job_is_claimed_once_and_in_order(store: Bench) {
    let mesh = add_mesh(&*store, b"m").await;
    let mut submitted = Vec::new();
    for _ in 0..12 {
        submitted.push(submit(&*store, &mesh).await.id);
    }
    let first = claim(&*store).await;
    assert_eq!(first.lease.job, submitted[0]);
    let claims: Vec<_> = (0..30)
        .map(|_| {
            let store = store.share();
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

pub async fn a_job_survives_two_crashes_and_fails_at_the_third(store: Bench) {
    let mesh = add_mesh(&*store, b"m").await;
    let id = submit(&*store, &mesh).await.id;
    let bystander = submit(&*store, &mesh).await.id;
    let mut store = store;
    for attempt in 1..=3 {
        store = store.reopen().await;
        assert_eq!(store.take_over(3).await, usize::from(attempt > 1));
        let record = job(&*store, id).await;
        assert_eq!((record.state, record.attempt), (JobState::Queued, attempt));
        assert_eq!(record.started_at, None);
        let claim = claim(&*store).await;
        assert_eq!(claim.lease.job, id);
        assert_eq!(job(&*store, id).await.state, JobState::Running);
    }
    let store = store.reopen().await;
    store.take_over(3).await;
    let record = job(&*store, id).await;
    assert_eq!((record.state, record.attempt), (JobState::Failed, 3));
    assert_eq!(record.problem, Some(exhausted()));
    assert!(record.finished_at.is_some());
    let record = job(&*store, bystander).await;
    assert_eq!((record.state, record.attempt), (JobState::Queued, 1));
}

pub async fn a_cancellation_outlives_a_crash(store: Bench) {
    let mesh = add_mesh(&*store, b"m").await;
    let id = submit(&*store, &mesh).await.id;
    let claim = claim(&*store).await;
    let record = store.cancel(&Owner::ANONYMOUS, id).await.unwrap().unwrap();
    assert_eq!(record.state, JobState::Running);
    assert_eq!(
        store.lease_status(&claim.lease).await.unwrap(),
        LeaseStatus::Cancelled
    );
    let store = store.reopen().await;
    store.take_over(3).await;
    assert_eq!(job(&*store, id).await.state, JobState::Cancelled);
}

pub async fn a_stale_lease_changes_nothing(store: Bench) {
    let mesh = add_mesh(&*store, b"m").await;
    let id = submit(&*store, &mesh).await.id;
    let stale = claim(&*store).await.lease;
    store.take_over(3).await;
    let unchanged = async |store: &dyn Store| {
        let before = serde_json::to_string(&job(store, id).await).unwrap();
        assert_eq!(store.lease_status(&stale).await.unwrap(), LeaseStatus::Lost);
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
    unchanged(&*store).await;
    let Claim {
        lease: fresh,
        revision,
        ..
    } = claim(&*store).await;
    // Past all that the holder who died can have shown, 20 a second for two hours and more.
    assert!(revision > 200_000, "{revision}");
    unchanged(&*store).await;
    assert_eq!(store.lease_status(&fresh).await.unwrap(), LeaseStatus::Held);
    let shown = revision + 7;
    assert!(
        store
            .finish(&fresh, &found(), &progress(), shown)
            .await
            .unwrap()
    );
    unchanged(&*store).await;
    let record = job(&*store, id).await;
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

pub async fn a_cancelled_run_keeps_what_it_found_and_an_ended_one_stays(store: Bench) {
    let mesh = add_mesh(&*store, b"m").await;
    let running = submit(&*store, &mesh).await.id;
    let waiting = submit(&*store, &mesh).await.id;
    let lease = claim(&*store).await.lease;
    store
        .cancel(&Owner::ANONYMOUS, running)
        .await
        .unwrap()
        .unwrap();
    store
        .finish(&lease, &found(), &progress(), 2)
        .await
        .unwrap();
    let record = job(&*store, running).await;
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

pub async fn a_job_put_back_loses_neither_attempt_nor_place(store: Bench) {
    let mesh = add_mesh(&*store, b"m").await;
    let first = submit(&*store, &mesh).await.id;
    submit(&*store, &mesh).await;
    let lease = claim(&*store).await.lease;
    assert!(store.release(&lease, 17).await.unwrap());
    let record = job(&*store, first).await;
    assert_eq!(
        (record.state, record.attempt, record.revision),
        (JobState::Queued, 1, 18)
    );
    assert_eq!(claim(&*store).await.lease.job, first);
}

pub async fn times_stay_in_order_when_the_clock_is_set_back(store: Bench) {
    let mesh = add_mesh(&*store, b"mesh").await;
    for ending in ["finish", "release", "cancel", "recover", "withdraw"] {
        let submitted = submit(&*store, &mesh).await.id;
        // As if it had been submitted under a clock that was an hour ahead.
        let ahead = "UPDATE jobs SET created_at = created_at + 3600000000";
        store
            .execute(&format!("{ahead} WHERE id = '{submitted}'"))
            .await;
        if ending == "withdraw" {
            store
                .cancel(&Owner::ANONYMOUS, submitted)
                .await
                .unwrap()
                .unwrap();
        } else {
            let lease = claim(&*store).await.lease;
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
                    let written = store
                        .finish(&lease, &RunOutcome::Cancelled, &progress(), 9)
                        .await;
                    assert!(written.unwrap());
                }
                _ => assert_eq!(store.take_over(3).await, 1),
            }
        }
        let ended = job(&*store, submitted).await;
        assert!(ended.state.is_final(), "{ending}");
        let started = ended.started_at.unwrap_or(ended.created_at);
        assert!(ended.created_at <= started, "{ending}");
        assert!(started <= ended.finished_at.unwrap(), "{ending}");
    }
}

pub async fn a_lease_that_is_renewed_is_held_until_its_job_is_stopped(store: Bench) {
    let mesh = add_mesh(&*store, b"m").await;
    let mut runs = Vec::new();
    for revision in 5..8 {
        submit(&*store, &mesh).await;
        runs.push(Renewal {
            lease: claim(&*store).await.lease,
            revision,
            progress: progress(),
        });
    }
    assert_eq!(store.renew(&[]).await.unwrap(), []);
    assert_eq!(store.renew(&runs).await.unwrap(), [LeaseStatus::Held; 3]);
    if store.lease_time().is_some() {
        let record = job(&*store, runs[1].lease.job).await;
        assert_eq!(record.progress, Some(progress()));
        assert_eq!(record.revision, 6);
    }
    let owner = Owner::ANONYMOUS;
    store.cancel(&owner, runs[0].lease.job).await.unwrap();
    store.delete_job(&owner, runs[1].lease.job).await.unwrap();
    let holds = [LeaseStatus::Cancelled, LeaseStatus::Lost, LeaseStatus::Held];
    assert_eq!(store.renew(&runs).await.unwrap(), holds);
    // Who is silent loses its job, and does not get it back by speaking up.
    assert_eq!(store.take_over(3).await, 2);
    assert_eq!(store.renew(&runs).await.unwrap(), [LeaseStatus::Lost; 3]);
}

pub async fn revisions_are_those_of_the_records(store: Bench) {
    let mesh = add_mesh(&*store, b"m").await;
    let (first, second) = (submit(&*store, &mesh).await, submit(&*store, &mesh).await);
    claim(&*store).await;
    let asked = [second.id, JobId::new(), first.id];
    let mut revisions = store.revisions(&asked).await.unwrap();
    revisions.sort();
    let claimed = job(&*store, first.id).await.revision;
    assert!(claimed > first.revision);
    assert_eq!(
        revisions,
        [(first.id, claimed), (second.id, second.revision)]
    );
}
