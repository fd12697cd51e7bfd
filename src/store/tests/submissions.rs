//! Submissions under a key.

use super::*;

fn under(key: &str, content: u8) -> Submission {
    Submission {
        key: key.to_owned(),
        fingerprint: [content; 32],
    }
}

fn job_under(submission: &Submission) -> NewJob {
    NewJob {
        submission: Some(submission.clone()),
        ..new_job(1000)
    }
}

pub async fn a_key_makes_one_job_across_a_restart(store: Bench) {
    let mesh = add_mesh(&*store, b"m").await;
    let submission = under("k", 1);
    assert_eq!(
        store
            .earlier_submission(&Owner::ANONYMOUS, &submission)
            .await
            .unwrap(),
        None
    );
    let made = store
        .submit(&mesh, &job_under(&submission))
        .await
        .unwrap()
        .unwrap();
    let store = store.reopen().await;
    let earlier = async |submission: &Submission| {
        store
            .earlier_submission(&Owner::ANONYMOUS, submission)
            .await
            .unwrap()
    };
    let (other, free) = (under("k", 2), under("l", 1));
    assert_eq!(
        earlier(&submission).await,
        Some(EarlierSubmission::Same(made.id))
    );
    assert_eq!(earlier(&other).await, Some(EarlierSubmission::Other));
    assert_eq!(earlier(&free).await, None);
    assert_eq!(
        store
            .earlier_submission(&Owner::of_key("b"), &submission)
            .await
            .unwrap(),
        None
    );
    // Who did not look first makes no second one either, and leaves nothing.
    let again = store.submit(&mesh, &job_under(&submission)).await.unwrap();
    assert_eq!(again.unwrap_err(), Refusal::KeyInUse);
    assert_eq!(store.queued().await.unwrap(), 1);
}

pub async fn a_refused_submission_leaves_its_key_free(store: Bench) {
    let mesh = add_mesh(&*store, b"m").await;
    let submission = under("k", 1);
    let full = NewJob {
        capacity: 0,
        ..job_under(&submission)
    };
    let refused = store.submit(&mesh, &full).await.unwrap();
    assert_eq!(refused.unwrap_err(), Refusal::QueueFull);
    assert_eq!(
        store
            .earlier_submission(&Owner::ANONYMOUS, &submission)
            .await
            .unwrap(),
        None
    );
    store
        .submit(&mesh, &job_under(&submission))
        .await
        .unwrap()
        .unwrap();
}

pub async fn a_key_is_free_again_after_a_day(store: Bench) {
    let mesh = add_mesh(&*store, b"m").await;
    let submission = under("k", 1);
    let first = store
        .submit(&mesh, &job_under(&submission))
        .await
        .unwrap()
        .unwrap();
    store
        .execute("UPDATE submissions SET created_at = created_at - 86400000001")
        .await;
    assert_eq!(
        store
            .earlier_submission(&Owner::ANONYMOUS, &submission)
            .await
            .unwrap(),
        None
    );
    let second = store
        .submit(&mesh, &job_under(&submission))
        .await
        .unwrap()
        .unwrap();
    assert_ne!(first.id, second.id);
    let earlier = store
        .earlier_submission(&Owner::ANONYMOUS, &submission)
        .await
        .unwrap();
    assert_eq!(earlier, Some(EarlierSubmission::Same(second.id)));
}
