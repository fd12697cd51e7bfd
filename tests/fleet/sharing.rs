//! What one member puts into the database is there for all, who share nothing else.

use reqwest::Method;
use testkit::load::oracle::{orders, timeless};
use testkit::postgres::Cluster;

use crate::fleet::Fleet;
use crate::member::{Member, Role};

#[test]
fn servers_that_come_at_the_same_moment_make_the_tables_once() {
    let folder = tempfile::tempdir().unwrap();
    for round in 0..3 {
        let database = Cluster::shared().database();
        let mut servers: Vec<Member> = (0..3)
            .map(|number| {
                let place = folder.path().join(format!("{round}-{number}"));
                Member::new(Role::Server, &database.url, place, &[])
            })
            .collect();
        std::thread::scope(|scope| {
            for server in &mut servers {
                scope.spawn(|| server.start());
            }
        });
        for mut server in servers {
            assert_eq!(server.lives, 1, "{}", server.last_words());
            assert!(server.end("-TERM").success());
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_mesh_that_one_server_took_is_planned_by_a_worker_that_has_the_database_alone() {
    let folder = tempfile::tempdir().unwrap();
    let mut fleet = Fleet::start(2, &[]);
    for order in orders(folder.path(), 1).iter().take(4) {
        let mesh = fleet.mesh(0, order.mesh.clone()).await;
        let mut request = order.request.clone();
        request["mesh_id"] = mesh.as_str().into();
        let job = fleet.job(1, &request).await;
        if fleet.workers.is_empty() {
            fleet.hire();
        }
        for server in [0, 1] {
            let view = fleet.wait_for(server, &job, &["succeeded", "failed"]).await;
            assert_eq!(timeless(view["result"].clone()), order.result, "{view}");
        }
    }
    fleet.stop();
}

#[tokio::test(flavor = "multi_thread")]
async fn a_mesh_is_the_same_at_every_server() {
    let fleet = Fleet::start(2, &[]);
    let mesh = fleet.small_box(0).await;
    assert_eq!(fleet.small_box(1).await, mesh);
    let path = format!("/meshes/{mesh}/file?format=stl");
    let mut files = Vec::new();
    for server in [0, 1] {
        let answer = fleet.request(server, Method::GET, &path).send().await;
        let answer = answer.unwrap();
        assert_eq!(answer.status(), 200);
        files.push(answer.bytes().await.unwrap());
    }
    assert!(!files[0].is_empty() && files[0] == files[1]);
    let path = format!("/meshes/{mesh}");
    let forget = fleet.request(1, Method::DELETE, &path);
    assert_eq!(forget.send().await.unwrap().status(), 204);
    let gone = fleet.request(0, Method::GET, &path);
    assert_eq!(gone.send().await.unwrap().status(), 404);
    fleet.stop();
}
