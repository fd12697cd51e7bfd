//! How waiting for a batch, and a batch itself, comes to its end.

use super::*;

#[tokio::test(flavor = "multi_thread")]
async fn a_wait_ends_with_its_time_the_batch_or_the_server() {
    let (mut server, mesh) = server(&["--workers", "2"]).await;
    let endless = json!({"meshes": [mesh, mesh], "request": {"label": "endless"}});
    let stays = submitted(&server, endless.clone()).await;
    let clock = Instant::now();
    let answer = server
        .get(&format!("/batches/{stays}?wait=0.5"))
        .send()
        .await
        .unwrap();
    assert!(clock.elapsed() >= Duration::from_millis(500));
    assert!(answer.headers().contains_key("retry-after"));
    assert_eq!(answer.json::<Value>().await.unwrap()["state"], "running");
    let goes = submitted(&server, endless).await;
    let wait = |id: &str| tokio::spawn(server.get(&format!("/batches/{id}?wait=60")).send());
    let (on_stays, on_goes) = (wait(&stays), wait(&goes));
    tokio::time::sleep(Duration::from_millis(200)).await;
    let gone = server.delete(&format!("/batches/{goes}")).send().await;
    assert_eq!(gone.unwrap().status(), 204);
    problem(on_goes.await.unwrap().unwrap(), 404).await;
    assert!(!on_stays.is_finished());
    server.begin_stop();
    let view: Value = on_stays.await.unwrap().unwrap().json().await.unwrap();
    assert_eq!(view["state"], "running");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_batch_expires_with_its_jobs_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let flags = ["--retention", "2s"];
    let server = crate::common::start(folder, &flags, |_| {}, Some(scripted::runner())).await;
    let mesh = server.mesh(small_box()).await;
    let id = submitted(&server, json!({"meshes": [mesh, mesh]})).await;
    ended(&server, &id).await;
    let path = format!("/batches/{id}");
    let end = Instant::now() + Duration::from_secs(60);
    while server.get(&path).send().await.unwrap().status() == 200 {
        assert!(Instant::now() < end);
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    is_gone(&server, &path, 410).await;
    let gone = server.post(&format!("{path}/cancel")).send().await.unwrap();
    problem(gone, 410).await;
    server.stop().await;
}
