//! Start, stop and start again.

use super::*;

#[tokio::test(flavor = "multi_thread")]
async fn shutdown_puts_running_jobs_back_and_burns_no_attempt() {
    let data = data();
    let service = start(options(&data)).await;
    let running = submit(&service, "endless").await.id;
    let waiting = submit(&service, "quick").await.id;
    until(&service, running, JobState::Running).await;
    service.begin_drain();
    assert!(matches!(service.ready().await, Err(Error::Draining)));
    assert!(matches!(service.begin_upload().await, Err(Error::Draining)));
    assert_eq!(
        service
            .job(&Owner::ANONYMOUS, &running.to_string())
            .await
            .unwrap()
            .state,
        JobState::Running
    );
    service.shutdown().await;
    drop(service);

    let service = start(options_with_workers(&data, 2)).await;
    until(&service, waiting, JobState::Succeeded).await;
    let record = until(&service, running, JobState::Running).await;
    assert_eq!(record.attempt, 1);
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_run_that_does_not_stop_cannot_hold_its_job() {
    let data = data();
    let (runner, stuck) = deaf();
    let service = Service::start_with(options(&data), runner).await.unwrap();
    let job = submit(&service, "").await.id;
    until(&service, job, JobState::Running).await;
    service.stop_workers(Duration::from_millis(50)).await;
    let record = service
        .job(&Owner::ANONYMOUS, &job.to_string())
        .await
        .unwrap();
    assert_eq!((record.state, record.attempt), (JobState::Queued, 1));
    stuck.store(false, Ordering::Relaxed);
    service.stop_workers(Duration::from_secs(10)).await;
    let record = service
        .job(&Owner::ANONYMOUS, &job.to_string())
        .await
        .unwrap();
    assert_eq!(
        record.state,
        JobState::Queued,
        "a late result changes nothing"
    );
    assert!(record.result.is_none());
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_mesh_is_read_again_after_a_restart() {
    let data = data();
    let service = start(options(&data)).await;
    let (mesh, _) = service
        .add_mesh(
            &Owner::ANONYMOUS,
            incoming(
                upload(&service, TETRAHEDRON).await,
                MeshOptions::default(),
                None,
            ),
        )
        .await
        .unwrap();
    service.shutdown().await;
    drop(service);
    let service = start(options(&data)).await;
    let job = service
        .submit(&Owner::ANONYMOUS, mesh.id.as_str(), request(""), None)
        .await
        .unwrap();
    until(&service, job.id, JobState::Succeeded).await;
    // A file that is gone fails the jobs on it, and nothing else.
    fs::remove_file(data.path().join("meshes").join(mesh.id.as_str())).unwrap();
    service.shutdown().await;
    drop(service);
    let service = start(options(&data)).await;
    let refused = service
        .submit(&Owner::ANONYMOUS, mesh.id.as_str(), request(""), None)
        .await;
    assert!(matches!(refused, Err(Error::UnknownMesh)), "{refused:?}");
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn two_services_cannot_share_a_directory() {
    let data = data();
    let service = start(options(&data)).await;
    let second = Service::start_with(options(&data), scripted()).await.err();
    let second = second.expect("the second is refused").to_string();
    assert!(second.contains("in use by another graspd"), "{second}");
    assert!(Path::new(&data.path().join("graspd.db")).exists());
    service.shutdown().await;
}
