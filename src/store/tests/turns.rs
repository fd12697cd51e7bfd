//! Whose job goes next.

use super::*;

async fn mesh_of(store: &dyn Store, owner: &Owner) -> MeshId {
    let received = receive(store, b"m").await;
    let mesh = NewMesh {
        owner: owner.clone(),
        ..new_mesh()
    };
    store.add_mesh(received, &mesh).await.unwrap().unwrap().0.id
}

async fn submit_for(store: &dyn Store, owner: &str, priority: Priority) -> JobId {
    let owner = Owner::of_key(owner);
    let mesh = mesh_of(store, &owner).await;
    let job = NewJob {
        owner,
        priority,
        ..new_job(100_000)
    };
    store.submit(&mesh, &job).await.unwrap().unwrap().id
}

async fn claim(store: &dyn Store, class: Priority) -> Option<(String, Lease)> {
    let claim = store.claim(class).await.unwrap()?;
    Some((claim.owner.as_str().to_owned(), claim.lease))
}

pub async fn owners_take_turns_however_much_one_submits(store: Bench) {
    for _ in 0..6 {
        submit_for(&*store, "greedy", Priority::Interactive).await;
    }
    for owner in ["modest", "shy", "modest"] {
        submit_for(&*store, owner, Priority::Interactive).await;
    }
    let mut order = Vec::new();
    while let Some((owner, lease)) = claim(&*store, Priority::Interactive).await {
        store
            .finish(&lease, &found(), &progress(), 2)
            .await
            .unwrap();
        order.push(owner);
    }
    let served = |upto: usize, owner: &str| order[..upto].iter().filter(|o| *o == owner).count();
    assert_eq!(
        (served(3, "greedy"), served(3, "modest"), served(3, "shy")),
        (1, 1, 1),
        "{order:?}"
    );
    assert_eq!(served(5, "modest"), 2, "{order:?}");
    assert_eq!(served(9, "greedy"), 6);
}

pub async fn who_has_fewer_running_goes_first(store: Bench) {
    for owner in ["a", "a", "a", "b", "b"] {
        submit_for(&*store, owner, Priority::Interactive).await;
    }
    let mut running = std::collections::BTreeMap::new();
    for _ in 0..4 {
        let (owner, _) = claim(&*store, Priority::Interactive).await.unwrap();
        *running.entry(owner).or_insert(0) += 1;
    }
    assert_eq!((running["a"], running["b"]), (2, 2));
}

pub async fn each_class_goes_first_in_its_turn_and_never_makes_the_other_wait_for_nothing(
    store: Bench,
) {
    let batch = [
        submit_for(&*store, "a", Priority::Batch).await,
        submit_for(&*store, "a", Priority::Batch).await,
    ];
    let urgent = [
        submit_for(&*store, "b", Priority::Interactive).await,
        submit_for(&*store, "b", Priority::Interactive).await,
    ];
    // After its first job "a" has one running and "b" none: the class counts before the owner.
    for (first, expected) in [
        (Priority::Batch, Some(batch[0])),
        (Priority::Batch, Some(batch[1])),
        (Priority::Batch, Some(urgent[0])),
        (Priority::Interactive, Some(urgent[1])),
        (Priority::Interactive, None),
        (Priority::Batch, None),
    ] {
        let claimed = claim(&*store, first).await;
        assert_eq!(claimed.map(|(_, lease)| lease.job), expected);
    }
}

pub async fn jobs_of_one_owner_and_class_keep_the_order_of_submission(store: Bench) {
    let mut batch = Vec::new();
    for _ in 0..3 {
        batch.push(submit_for(&*store, "a", Priority::Batch).await);
    }
    let urgent = submit_for(&*store, "a", Priority::Interactive).await;
    for id in [urgent].into_iter().chain(batch) {
        let claimed = claim(&*store, Priority::Interactive).await;
        assert_eq!(claimed.unwrap().1.job, id);
    }
    assert!(claim(&*store, Priority::Interactive).await.is_none());
}
