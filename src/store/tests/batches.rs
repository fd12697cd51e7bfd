//! Batches: many jobs as one.

use std::time::Duration;

use super::retention::age;
use super::*;
use crate::wire::{BatchId, BatchRecord, BatchState, JobCounts};

const DAY: Duration = Duration::from_secs(86_400);

/// A batch on these meshes, its jobs labelled with their places.
fn new_batch(meshes: &[&MeshId]) -> NewBatch {
    let job = |(index, mesh): (usize, &&MeshId)| BatchedJob {
        mesh_id: (*mesh).clone(),
        request: format!("{{\"seed\":{index}}}"),
        label: Some(index.to_string()),
        priority: Priority::Interactive,
    };
    NewBatch {
        owner: Owner::ANONYMOUS,
        label: Some("all of it".to_owned()),
        jobs: meshes.iter().enumerate().map(job).collect(),
        capacity: 1000,
        owner_capacity: None,
        submission: None,
    }
}

async fn submit_batch(store: &dyn Store, meshes: &[&MeshId]) -> BatchRecord {
    let submitted = store.submit_batch(&new_batch(meshes)).await.unwrap();
    submitted.unwrap()
}

async fn batch(store: &dyn Store, id: BatchId) -> BatchRecord {
    store.batch(&Owner::ANONYMOUS, id).await.unwrap().unwrap()
}

async fn end(store: &dyn Store, claim: &Claim, ending: &RunOutcome) {
    let ended = store.finish(&claim.lease, ending, &progress(), 2).await;
    assert!(ended.unwrap());
}

pub async fn a_batch_is_queued_as_one_and_counted(store: Bench) {
    let (one, two) = (add_mesh(&*store, b"1").await, add_mesh(&*store, b"2").await);
    let submitted = submit_batch(&*store, &[&one, &two, &one]).await;
    assert_eq!(
        submitted.jobs,
        JobCounts {
            total: 3,
            queued: 3,
            ..JobCounts::default()
        }
    );
    assert_eq!((submitted.started_at, submitted.finished_at), (None, None));
    let store = store.reopen().await;

    // The jobs are jobs like others, in the order of the batch.
    let last = submit(&*store, &one).await;
    let mut claims = Vec::new();
    for (index, mesh) in [&one, &two, &one].into_iter().enumerate() {
        let claim = claim(&*store).await;
        let found = job(&*store, claim.lease.job).await;
        assert_eq!(
            (found.batch_id, found.batch_index),
            (Some(submitted.id), Some(index as u32))
        );
        assert_eq!(
            (&claim.mesh_id, &claim.request),
            (mesh, &format!("{{\"seed\":{index}}}"))
        );
        assert_eq!(found.label, Some(index.to_string()));
        claims.push(claim);
        let still = store.unfinished(submitted.id).await.unwrap();
        assert!(still.is_some());
    }
    assert_eq!(claim(&*store).await.lease.job, last.id);
    assert_eq!((last.batch_id, last.batch_index), (None, None));

    end(&*store, &claims[1], &found()).await;
    let problem = RunOutcome::Problem(exhausted());
    end(&*store, &claims[0], &problem).await;
    let now = batch(&*store, submitted.id).await;
    let counts = JobCounts {
        total: 3,
        running: 1,
        succeeded: 1,
        failed: 1,
        ..JobCounts::default()
    };
    assert_eq!(
        (now.state, now.jobs, now.finished_at),
        (BatchState::Running, counts, None)
    );
    assert_eq!(
        store.unfinished(submitted.id).await.unwrap(),
        Some(claims[2].lease.job)
    );

    end(&*store, &claims[2], &found()).await;
    let ended = batch(&*store, submitted.id).await;
    assert_eq!(ended.state, BatchState::Ended);
    assert_eq!(store.unfinished(submitted.id).await.unwrap(), None);
    let (mut started, mut finished) = (Vec::new(), Vec::new());
    for claim in &claims {
        let job = job(&*store, claim.lease.job).await;
        started.extend(job.started_at);
        finished.extend(job.finished_at);
    }
    assert_eq!(ended.started_at, started.into_iter().min());
    assert_eq!(ended.finished_at, finished.into_iter().max());
    assert_eq!(ended.label.as_deref(), Some("all of it"));

    // What is forgotten alone is reported as forgotten.
    store
        .delete_job(&Owner::ANONYMOUS, claims[1].lease.job)
        .await
        .unwrap();
    let counts = JobCounts {
        total: 3,
        succeeded: 1,
        failed: 1,
        forgotten: 1,
        ..JobCounts::default()
    };
    assert_eq!(batch(&*store, submitted.id).await.jobs, counts);
}

pub async fn a_batch_that_cannot_be_queued_leaves_nothing(store: Bench) {
    let mesh = add_mesh(&*store, b"m").await;
    let unknown = MeshId::parse(&"0".repeat(64)).unwrap();
    let waiting = submit(&*store, &mesh).await;
    let three = [&mesh, &mesh, &mesh];
    let key = Submission {
        key: "k".to_owned(),
        fingerprint: [1; 32],
    };
    let refused = async |batch: NewBatch| {
        let batch = NewBatch {
            submission: Some(key.clone()),
            ..batch
        };
        let refusal = store.submit_batch(&batch).await.unwrap().unwrap_err();
        assert_eq!(
            (store.rows("batches").await, store.rows("jobs").await),
            (0, 1)
        );
        assert_eq!(store.queued().await.unwrap(), 1);
        assert_eq!(
            store
                .earlier_submission(&Owner::ANONYMOUS, &key)
                .await
                .unwrap(),
            None
        );
        refusal
    };
    let full = NewBatch {
        capacity: 3,
        ..new_batch(&three)
    };
    assert_eq!(refused(full).await, Refusal::QueueFull);
    let used = NewBatch {
        owner_capacity: Some(3),
        ..new_batch(&three)
    };
    assert_eq!(refused(used).await, Refusal::OwnerQueueFull);
    let missing = new_batch(&[&mesh, &unknown, &mesh]);
    assert_eq!(refused(missing).await, Refusal::UnknownMesh);

    let fits = NewBatch {
        capacity: 4,
        owner_capacity: Some(4),
        ..new_batch(&three)
    };
    store.submit_batch(&fits).await.unwrap().unwrap();
    assert_eq!(store.queued().await.unwrap(), 4);
    let kept = store
        .mesh_summaries(&Owner::ANONYMOUS, &[mesh.clone(), unknown])
        .await
        .unwrap();
    assert_eq!(kept.keys().collect::<Vec<_>>(), [&mesh]);
    assert_eq!(kept[&mesh].candidates, 12);
    assert_eq!(job(&*store, waiting.id).await.state, JobState::Queued);
}

pub async fn a_batch_is_stopped_and_forgotten_as_one(store: Bench) {
    let mesh = add_mesh(&*store, b"m").await;
    let stopped = submit_batch(&*store, &[&mesh; 3]).await;
    let other = submit_batch(&*store, &[&mesh; 2]).await;
    let running = claim(&*store).await;
    let changed = store
        .cancel_batch(&Owner::ANONYMOUS, stopped.id)
        .await
        .unwrap();
    assert_eq!(changed.len(), 3);
    for (id, revision) in changed {
        let job = job(&*store, id).await;
        assert_eq!((job.revision, job.batch_id), (revision, Some(stopped.id)));
    }
    assert_eq!(
        store.lease_status(&running.lease).await.unwrap(),
        LeaseStatus::Cancelled
    );
    let counts = JobCounts {
        total: 3,
        running: 1,
        cancelled: 2,
        ..JobCounts::default()
    };
    assert_eq!(batch(&*store, stopped.id).await.jobs, counts);
    // Nothing is left to stop, though one has not ended yet.
    let again = store
        .cancel_batch(&Owner::ANONYMOUS, stopped.id)
        .await
        .unwrap();
    assert!(again.is_empty());
    end(&*store, &running, &found()).await;
    assert_eq!(batch(&*store, stopped.id).await.jobs.cancelled, 3);
    assert_eq!(batch(&*store, other.id).await.jobs.queued, 2);

    let running = claim(&*store).await;
    let gone = store
        .delete_batch(&Owner::ANONYMOUS, other.id)
        .await
        .unwrap()
        .unwrap();
    assert_eq!(gone.len(), 2);
    assert_eq!(
        store.lease_status(&running.lease).await.unwrap(),
        LeaseStatus::Lost
    );
    assert!(
        store
            .batch(&Owner::ANONYMOUS, other.id)
            .await
            .unwrap()
            .is_none()
    );
    assert!(
        store
            .delete_batch(&Owner::ANONYMOUS, other.id)
            .await
            .unwrap()
            .is_none()
    );
    assert_eq!(
        (store.rows("jobs").await, store.queued().await.unwrap()),
        (3, 0)
    );
}

pub async fn batches_belong_to_their_owners(store: Bench) {
    let stranger = Owner::of_key("b");
    let mesh = add_mesh(&*store, b"m").await;
    let mine = submit_batch(&*store, &[&mesh; 2]).await;
    // The mesh of another is none.
    let theirs = NewBatch {
        owner: stranger.clone(),
        ..new_batch(&[&mesh])
    };
    assert_eq!(
        store.submit_batch(&theirs).await.unwrap().unwrap_err(),
        Refusal::UnknownMesh
    );
    assert!(
        store
            .mesh_summaries(&stranger, &[mesh])
            .await
            .unwrap()
            .is_empty()
    );
    assert!(store.batch(&stranger, mine.id).await.unwrap().is_none());
    assert!(
        store
            .batches(&stranger, None, 10)
            .await
            .unwrap()
            .unwrap()
            .batches
            .is_empty()
    );
    assert!(
        store
            .batch_results(&stranger, mine.id, None, None, 10)
            .await
            .unwrap()
            .is_empty()
    );
    assert!(
        store
            .cancel_batch(&stranger, mine.id)
            .await
            .unwrap()
            .is_empty()
    );
    assert!(
        store
            .delete_batch(&stranger, mine.id)
            .await
            .unwrap()
            .is_none()
    );
    assert_eq!(batch(&*store, mine.id).await.jobs.queued, 2);
}

pub async fn results_come_in_order_and_by_piece(store: Bench) {
    let mesh = add_mesh(&*store, b"m").await;
    let mut batches = Vec::new();
    for jobs in [5, 1, 2] {
        batches.push(submit_batch(&*store, &vec![&mesh; jobs]).await.id);
    }
    for index in 0..4 {
        let claim = claim(&*store).await;
        let ending = match index {
            1 => RunOutcome::Problem(exhausted()),
            _ => found(),
        };
        end(&*store, &claim, &ending).await;
    }
    let owner = Owner::ANONYMOUS;
    let places = async |state, after, limit| -> Vec<u32> {
        let results = store.batch_results(&owner, batches[0], state, after, limit);
        results
            .await
            .unwrap()
            .iter()
            .map(|line| line.index)
            .collect()
    };
    assert_eq!(places(None, None, 100).await, [0, 1, 2, 3, 4]);
    assert_eq!(places(None, None, 2).await, [0, 1]);
    assert_eq!(places(None, Some(1), 2).await, [2, 3]);
    assert_eq!(places(None, Some(4), 2).await, [0; 0]);
    assert_eq!(
        places(Some(JobState::Succeeded), None, 100).await,
        [0, 2, 3]
    );
    assert_eq!(places(Some(JobState::Succeeded), Some(0), 1).await, [2]);
    assert_eq!(places(Some(JobState::Queued), None, 100).await, [4]);
    for line in store
        .batch_results(&owner, batches[0], None, None, 100)
        .await
        .unwrap()
    {
        let job = job(&*store, line.job_id).await;
        assert_eq!((job.batch_index, job.state), (Some(line.index), line.state));
        assert_eq!((&job.label, &job.mesh_id), (&line.label, &line.mesh_id));
        assert_eq!(job.problem, line.problem);
        let text = |result: &Option<Box<serde_json::value::RawValue>>| {
            result.as_ref().map(|result| result.get().to_owned())
        };
        assert_eq!(text(&job.result), text(&line.result));
        assert_eq!(job.result.is_some(), [0, 2, 3].contains(&line.index));
    }

    // Jobs of a batch, and batches, in pages.
    let filter = JobFilter {
        batch_id: Some(batches[0].to_string()),
        ..JobFilter::default()
    };
    let page = store.jobs(&filter, None, 3).await.unwrap().unwrap();
    let rest = store
        .jobs(&filter, page.next_cursor.as_deref(), 3)
        .await
        .unwrap()
        .unwrap();
    let listed = page
        .jobs
        .iter()
        .chain(&rest.jobs)
        .map(|job| job.batch_index.unwrap());
    assert_eq!(listed.collect::<Vec<_>>(), [4, 3, 2, 1, 0]);
    let page = store.batches(&owner, None, 2).await.unwrap().unwrap();
    let cursor = page.next_cursor.unwrap();
    let rest = store
        .batches(&owner, Some(&cursor), 2)
        .await
        .unwrap()
        .unwrap();
    assert_eq!(rest.next_cursor, None);
    let listed = page.batches.iter().chain(&rest.batches);
    let listed: Vec<_> = listed
        .map(|batch| (batch.id, batch.jobs.total, batch.jobs.queued))
        .collect();
    assert_eq!(
        listed,
        [(batches[2], 2, 2), (batches[1], 1, 1), (batches[0], 5, 1)]
    );
    assert!(
        store
            .batches(&owner, Some("forged"), 2)
            .await
            .unwrap()
            .is_none()
    );
    assert!(
        store
            .jobs(&filter, Some(&cursor), 2)
            .await
            .unwrap()
            .is_none()
    );
}

pub async fn a_batch_expires_with_the_last_of_its_jobs(store: Bench) {
    let owner = Owner::ANONYMOUS;
    let mesh = add_mesh(&*store, b"m").await;
    let id = submit_batch(&*store, &[&mesh; 2]).await.id;
    let (first, second) = (claim(&*store).await, claim(&*store).await);
    end(&*store, &first, &found()).await;
    age(&store, 2).await;
    assert_eq!(store.expire(DAY).await.unwrap().jobs, 1);
    let counts = JobCounts {
        total: 2,
        running: 1,
        forgotten: 1,
        ..JobCounts::default()
    };
    assert_eq!(batch(&*store, id).await.jobs, counts);
    assert!(!store.batch_has_expired(&owner, id).await.unwrap());
    end(&*store, &second, &found()).await;
    assert_eq!(store.expire(DAY).await.unwrap().jobs, 0);
    assert_eq!(batch(&*store, id).await.jobs.succeeded, 1);
    age(&store, 2).await;
    assert_eq!(store.expire(DAY).await.unwrap().jobs, 1);
    assert!(store.batch(&owner, id).await.unwrap().is_none());
    assert!(store.batch_has_expired(&owner, id).await.unwrap());
    assert!(
        !store
            .batch_has_expired(&Owner::of_key("b"), id)
            .await
            .unwrap()
    );
    age(&store, 2).await;
    store.expire(DAY).await.unwrap();
    assert!(!store.batch_has_expired(&owner, id).await.unwrap());
    assert_eq!(
        (store.rows("batches").await, store.rows("expired").await),
        (0, 0)
    );
}

pub async fn a_key_makes_one_batch(store: Bench) {
    let owner = Owner::ANONYMOUS;
    let mesh = add_mesh(&*store, b"m").await;
    let key = Submission {
        key: "k".to_owned(),
        fingerprint: [1; 32],
    };
    let batch = || NewBatch {
        submission: Some(key.clone()),
        ..new_batch(&[&mesh; 3])
    };
    let made = store.submit_batch(&batch()).await.unwrap().unwrap();
    let Some(EarlierSubmission::Same(earlier)) =
        store.earlier_submission(&owner, &key).await.unwrap()
    else {
        panic!("the key is used");
    };
    assert_eq!(BatchId::from(earlier), made.id);
    assert_eq!(
        store.submit_batch(&batch()).await.unwrap().unwrap_err(),
        Refusal::KeyInUse
    );
    assert_eq!(
        (store.rows("batches").await, store.rows("jobs").await),
        (1, 3)
    );
}
