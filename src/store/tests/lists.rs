//! Queue capacity and paging.

use super::*;

pub async fn the_queue_never_holds_more_than_its_capacity(store: Bench) {
    let mesh = add_mesh(&*store, b"m").await;
    let attempts: Vec<_> = (0..40)
        .map(|_| {
            let (store, mesh) = (store.share(), mesh.clone());
            tokio::spawn(async move { store.submit(&mesh, &new_job(7)).await.unwrap() })
        })
        .collect();
    let mut queued = 0;
    for attempt in attempts {
        match attempt.await.unwrap() {
            Ok(job) => {
                assert_eq!((job.state, job.attempt), (JobState::Queued, 1));
                queued += 1;
            }
            Err(refusal) => assert_eq!(refusal, Refusal::QueueFull),
        }
    }
    assert_eq!((queued, store.queued().await.unwrap()), (7, 7));
    // A claimed job waits no more.
    claim(&*store).await;
    assert!(store.submit(&mesh, &new_job(7)).await.unwrap().is_ok());
    let nowhere = MeshId::parse(&"0".repeat(64)).unwrap();
    let refused = store.submit(&nowhere, &new_job(100)).await.unwrap();
    assert_eq!(refused.unwrap_err(), Refusal::UnknownMesh);
}

pub async fn jobs_are_counted_in_each_state(store: Bench) {
    let mesh = add_mesh(&*store, b"m").await;
    let counts = async || {
        let unfinished = store.unfinished_jobs().await.unwrap();
        let mut ended = store.ended_jobs().await.unwrap();
        ended.retain(|(_, jobs)| *jobs > 0);
        ended.sort_by_key(|(state, _)| state.name());
        let Unfinished {
            queued,
            running,
            oldest_queued,
        } = unfinished;
        (queued, running, oldest_queued, ended)
    };
    assert_eq!(counts().await, (0, 0, None, Vec::new()));
    let mut jobs = Vec::new();
    for _ in 0..6 {
        jobs.push(submit(&*store, &mesh).await.id);
    }
    assert_eq!(counts().await, (6, 0, Some(jobs[0]), Vec::new()));
    for ending in [
        found(),
        found(),
        RunOutcome::Problem(exhausted()),
        RunOutcome::Cancelled,
    ] {
        let lease = claim(&*store).await.lease;
        assert!(store.finish(&lease, &ending, &progress(), 2).await.unwrap());
    }
    claim(&*store).await;
    let ended = vec![
        (JobState::Cancelled, 1),
        (JobState::Failed, 1),
        (JobState::Succeeded, 2),
    ];
    assert_eq!(counts().await, (1, 1, Some(jobs[5]), ended));
}

pub async fn pages_are_complete_and_without_duplicates(store: Bench) {
    let (mut meshes, mut jobs) = (Vec::new(), Vec::new());
    for number in 0..23_u8 {
        let mesh = add_mesh(&*store, &[number]).await;
        jobs.push(submit(&*store, &mesh).await.id);
        meshes.push(mesh);
    }
    let (mut cursor, mut seen) = (None, Vec::new());
    loop {
        let page = store
            .meshes(&Owner::ANONYMOUS, cursor.as_deref(), 5)
            .await
            .unwrap()
            .unwrap();
        assert!(page.meshes.len() == 5 || page.next_cursor.is_none());
        seen.extend(page.meshes.into_iter().map(|mesh| mesh.id));
        // What comes meanwhile is newer than any page to come.
        add_mesh(&*store, format!("late {}", seen.len()).as_bytes()).await;
        cursor = page.next_cursor;
        if cursor.is_none() {
            break;
        }
    }
    meshes.reverse();
    assert_eq!(seen, meshes);

    let (mut cursor, mut seen) = (None, Vec::new());
    let filter = JobFilter {
        owner: Owner::ANONYMOUS,
        state: Some(JobState::Queued),
        ..JobFilter::default()
    };
    loop {
        let page = store
            .jobs(&filter, cursor.as_deref(), 6)
            .await
            .unwrap()
            .unwrap();
        seen.extend(page.jobs.into_iter().map(|job| job.id));
        cursor = page.next_cursor;
        if cursor.is_none() {
            break;
        }
    }
    jobs.reverse();
    assert_eq!(seen, jobs);
    assert_eq!(seen.iter().collect::<HashSet<_>>().len(), 23);

    let one = JobFilter {
        mesh_id: Some(meshes[3].to_string()),
        ..JobFilter::default()
    };
    let page = store.jobs(&one, None, 6).await.unwrap().unwrap();
    assert_eq!((page.jobs.len(), page.next_cursor), (1, None));
    let none = JobFilter {
        owner: Owner::ANONYMOUS,
        state: Some(JobState::Failed),
        ..one
    };
    assert!(
        store
            .jobs(&none, None, 6)
            .await
            .unwrap()
            .unwrap()
            .jobs
            .is_empty()
    );

    let of_meshes = store
        .meshes(&Owner::ANONYMOUS, None, 5)
        .await
        .unwrap()
        .unwrap()
        .next_cursor;
    for forged in ["", "x", &jobs[0].to_string(), &of_meshes.unwrap()] {
        assert!(
            store
                .jobs(&filter, Some(forged), 5)
                .await
                .unwrap()
                .is_none(),
            "{forged}"
        );
    }
}
