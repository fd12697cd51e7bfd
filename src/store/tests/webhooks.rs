//! The outbox: filled whoever ends a job, emptied by one sender at a time.

use std::time::Duration;

use super::*;
use crate::wire::{CallbackRecord, CallbackState};

const LEASE: Duration = Duration::from_secs(600);

async fn submit_with_callback(store: &dyn Store, mesh: &MeshId, url: &str) -> JobRecord {
    let job = NewJob {
        request: serde_json::json!({ "callback_url": url }).to_string(),
        ..new_job(1000)
    };
    store.submit(mesh, &job).await.unwrap().unwrap()
}

async fn callback(store: &dyn Store, job: JobId) -> CallbackRecord {
    store.callback(job).await.unwrap().unwrap()
}

async fn claim(store: &dyn Store) -> Option<Delivery> {
    store.claim_webhook(&[], LEASE).await.unwrap()
}

/// A job that was cancelled while it waited.
async fn ended(store: &dyn Store, mesh: &MeshId, url: &str) -> JobId {
    let job = submit_with_callback(store, mesh, url).await.id;
    store.cancel(&Owner::ANONYMOUS, job).await.unwrap().unwrap();
    job
}

pub async fn every_end_of_a_job_is_to_be_delivered_and_nothing_else(store: Bench) {
    let mesh = add_mesh(&*store, b"solid").await;
    let run = async |store: &dyn Store| {
        let job = submit_with_callback(store, &mesh, "https://a.example/x").await;
        let lease = super::claim(store).await.lease;
        assert_eq!(lease.job, job.id);
        lease
    };
    let delivered = async |job: JobId, has_result: bool| {
        let delivery = claim(&*store).await.expect("a delivery");
        assert_eq!((delivery.job, delivery.attempts), (job, 0));
        assert_eq!(delivery.has_result, has_result);
        assert_eq!(delivery.host, "a.example");
        assert!(claim(&*store).await.is_none());
    };

    let lease = run(&*store).await;
    let early = callback(&*store, lease.job).await;
    assert_eq!((early.state, early.attempts), (CallbackState::Pending, 0));
    assert_eq!(early.next_attempt_at, None);
    assert!(claim(&*store).await.is_none(), "it has not ended");
    store.release(&lease, 0).await.unwrap();
    assert!(claim(&*store).await.is_none(), "it was put back");
    let lease = super::claim(&*store).await.lease;
    store
        .finish(&lease, &found(), &progress(), 0)
        .await
        .unwrap();
    delivered(lease.job, true).await;

    let lease = run(&*store).await;
    let problem = RunOutcome::Problem(exhausted());
    store
        .finish(&lease, &problem, &progress(), 0)
        .await
        .unwrap();
    delivered(lease.job, false).await;

    let lease = run(&*store).await;
    store.cancel(&Owner::ANONYMOUS, lease.job).await.unwrap();
    assert!(claim(&*store).await.is_none(), "it is still running");
    store
        .finish(&lease, &found(), &progress(), 0)
        .await
        .unwrap();
    delivered(lease.job, true).await;

    let lease = run(&*store).await;
    store.cancel(&Owner::ANONYMOUS, lease.job).await.unwrap();
    store.release(&lease, 0).await.unwrap();
    delivered(lease.job, false).await;

    let job = ended(&*store, &mesh, "https://a.example").await;
    delivered(job, false).await;

    let lease = run(&*store).await;
    store.take_over(1).await;
    delivered(lease.job, false).await;

    let lease = run(&*store).await;
    store.cancel(&Owner::ANONYMOUS, lease.job).await.unwrap();
    store.take_over(3).await;
    delivered(lease.job, false).await;

    let silent = submit(&*store, &mesh).await;
    store.cancel(&Owner::ANONYMOUS, silent.id).await.unwrap();
    assert!(claim(&*store).await.is_none());
    assert_eq!(store.callback(silent.id).await.unwrap(), None);
}

pub async fn a_delivery_is_in_one_hand_until_its_lease_is_over(store: Bench) {
    let mesh = add_mesh(&*store, b"solid").await;
    let job = ended(&*store, &mesh, "https://a.example/x").await;
    let lost = store.claim_webhook(&[], Duration::ZERO).await.unwrap();
    let held = claim(&*store).await.expect("the lease of zero is over");
    assert!(claim(&*store).await.is_none());
    let lost = lost.unwrap();
    let late = store.record_attempt(&lost, &Attempt::Delivered).await;
    assert!(!late.unwrap());
    assert_eq!(callback(&*store, job).await.attempts, 0);

    let store = store.reopen().await;
    store.take_over_webhooks().await;
    let again = claim(&*store).await.expect("its holder is gone");
    let late = store.record_attempt(&held, &Attempt::Delivered).await;
    assert!(!late.unwrap());
    let settled = store.record_attempt(&again, &Attempt::Delivered).await;
    assert!(settled.unwrap());
    let record = callback(&*store, job).await;
    assert_eq!(
        (record.state, record.attempts),
        (CallbackState::Delivered, 1)
    );
    assert_eq!((record.last_error, record.next_attempt_at), (None, None));
    assert!(claim(&*store).await.is_none());
}

pub async fn what_failed_waits_for_its_time_or_is_given_up(store: Bench) {
    let mesh = add_mesh(&*store, b"solid").await;
    let job = ended(&*store, &mesh, "https://a.example/x").await;
    let delivery = claim(&*store).await.unwrap();
    let why = "no answer".to_owned();
    let hour = Duration::from_secs(3600);
    let later = Attempt::Failed(why.clone(), Some(hour));
    let before = jiff::Timestamp::now().as_microsecond();
    store.record_attempt(&delivery, &later).await.unwrap();
    let record = callback(&*store, job).await;
    assert_eq!((record.state, record.attempts), (CallbackState::Pending, 1));
    assert_eq!(record.last_error.as_ref(), Some(&why));
    let wait = record.next_attempt_at.unwrap().as_microsecond() - before;
    assert!((3_599_000_000..3_660_000_000).contains(&wait), "{wait}");
    assert!(claim(&*store).await.is_none());

    let other = ended(&*store, &mesh, "https://a.example/x").await;
    let delivery = claim(&*store).await.unwrap();
    let at_once = Attempt::Failed(why.clone(), Some(Duration::ZERO));
    store.record_attempt(&delivery, &at_once).await.unwrap();
    let delivery = claim(&*store).await.unwrap();
    assert_eq!((delivery.job, delivery.attempts), (other, 1));
    let never = Attempt::Failed(why, None);
    store.record_attempt(&delivery, &never).await.unwrap();
    let record = callback(&*store, other).await;
    assert_eq!((record.state, record.attempts), (CallbackState::Failed, 2));
    assert_eq!(record.next_attempt_at, None);
    assert!(claim(&*store).await.is_none());
}

pub async fn hosts_that_are_busy_are_passed_over_and_forgotten_jobs_are_not_delivered(
    store: Bench,
) {
    let mesh = add_mesh(&*store, b"solid").await;
    let first = ended(&*store, &mesh, "https://a.example/x//y?z=//").await;
    let second = ended(&*store, &mesh, "https://b.example:8443/").await;
    let third = ended(&*store, &mesh, "http://[::1]:80/a/b").await;
    let busy = ["a.example", "b.example:8443"];
    let free = store.claim_webhook(&busy, LEASE).await.unwrap().unwrap();
    assert_eq!((free.job, free.host.as_str()), (third, "[::1]:80"));
    assert!(store.claim_webhook(&busy, LEASE).await.unwrap().is_none());
    assert!(store.delete_job(&Owner::ANONYMOUS, first).await.unwrap());
    assert_eq!(store.callback(first).await.unwrap(), None);
    let next = claim(&*store).await.unwrap();
    assert_eq!(next.job, second);
    assert!(store.delete_job(&Owner::ANONYMOUS, second).await.unwrap());
    assert!(claim(&*store).await.is_none());
    let late = store.record_attempt(&next, &Attempt::Delivered).await;
    assert!(!late.unwrap());
    assert_eq!(store.rows("webhooks").await, 1);
}
