//! Jobs are followed and cancelled at any server, whoever took them and whoever runs them.

use futures_util::future::join_all;
use reqwest::Method;
use serde_json::{Value, json};
use testkit::environment::number;
use testkit::events::{Event, Reader};

use crate::fleet::{Fleet, PATIENCE};

/// A search that does not end by itself, and when it is cancelled hands in what it found in a few milliseconds, since on
/// a busy machine a run that needs many does not get them in the time that it is given.
fn endless(mesh: &str) -> Value {
    json!({
        "mesh_id": mesh, "seed": 7, "method": "modified_ga", "candidates": "triangles",
        "population": 20, "generations": 90_000, "time_limit_s": 600,
        "contacts": 3, "cone_edges": 4, "polish": false,
    })
}

async fn open(fleet: &Fleet, server: usize, job: &str) -> Reader {
    let path = format!("/jobs/{job}/events");
    Reader::open(fleet.request(server, Method::GET, &path)).await
}

/// The next events up to the end of a job, revisions growing.
async fn to_the_end(reader: &mut Reader) -> Vec<Event> {
    let mut events: Vec<Event> = Vec::new();
    while let Some(event) = reader.next().await {
        let newest = events.iter().filter_map(|event| event.id).max();
        assert!(event.id > newest, "{event:?} after {newest:?}");
        events.push(event);
    }
    let last = events.last().expect("an event");
    assert_eq!(last.name, "end", "{events:?}");
    events
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_is_submitted_at_one_server_followed_at_another_and_cancelled_at_a_third() {
    let mut fleet = Fleet::start(3, &[]);
    let mesh = fleet.small_box(0).await;
    let job = fleet.job(0, &endless(&mesh)).await;
    let mut reader = open(&fleet, 1, &job).await;
    let snapshot = reader.next().await.unwrap();
    assert_eq!(snapshot.name, "snapshot");
    assert_eq!(snapshot.data["state"], "queued", "{snapshot:?}");
    fleet.hire();
    let mut generations: Vec<u64> = Vec::new();
    while generations.len() < 5 {
        let event = reader.next().await.unwrap();
        assert_eq!(event.name, "progress");
        generations.extend(event.data["progress"]["generation"].as_u64());
    }
    assert!(generations.is_sorted(), "{generations:?}");
    assert!(generations[0] < generations[4], "{generations:?}");

    let path = format!("/jobs/{job}?wait=60");
    let waiting = fleet.answer(fleet.request(0, Method::GET, &path));
    let cancelling = async {
        let path = format!("/jobs/{job}/cancel");
        fleet.answer(fleet.request(2, Method::POST, &path)).await
    };
    let ((_, waited), (status, _)) = tokio::join!(waiting, cancelling);
    assert_eq!(status, 202);
    assert_eq!(waited["state"], "cancelled", "{waited}");
    let events = to_the_end(&mut reader).await;
    let end = &events[events.len() - 1].data;
    assert_eq!(end["state"], "cancelled");
    for server in 0..3 {
        let mut view = fleet.view(server, &job).await;
        // What was found so far is kept, and an event leaves it out.
        let result = view.as_object_mut().unwrap().remove("result");
        assert!(result.is_some(), "at {server}: {view}");
        assert_eq!(&view, end);
    }
    fleet.stop();
}

#[tokio::test(flavor = "multi_thread")]
async fn a_crowd_at_two_servers_sees_every_job_end() {
    let followers = number("GRASPD_FOLLOWERS", 200) as usize;
    let jobs = followers / 10;
    rlimit::increase_nofile_limit(2 * followers as u64 + 1024).unwrap();
    let mut fleet = Fleet::start(2, &["--max-connections", "8192"]);
    let mesh = fleet.small_box(0).await;
    let mut ids = Vec::new();
    for seed in 0..jobs {
        let request = json!({
            "mesh_id": mesh, "seed": seed, "method": "random", "candidates": "triangles",
            "population": 3, "generations": 3,
        });
        ids.push(fleet.job(seed % 2, &request).await);
    }
    // Each job is followed at both servers.
    let open = |follower: usize| open(&fleet, follower % 2, &ids[follower / 2 % jobs]);
    let mut readers = join_all((0..followers).map(open)).await;
    for reader in &mut readers {
        assert_eq!(reader.next().await.unwrap().data["state"], "queued");
    }
    for _ in 0..2 {
        fleet.hire();
    }
    let all = join_all(readers.iter_mut().map(to_the_end));
    let all = tokio::time::timeout(PATIENCE, all).await;
    for (follower, events) in all.expect("every end").iter().enumerate() {
        let end = &events[events.len() - 1].data;
        assert_eq!(end["state"], "succeeded", "{end}");
        assert_eq!(end["id"], ids[follower / 2 % jobs].as_str());
    }
    println!("{followers} followers saw the ends of {jobs} jobs");
    fleet.stop();
}
