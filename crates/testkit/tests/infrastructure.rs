//! The infrastructure of other tests: a private PostgreSQL server, and a proxy that fails on demand.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::{sleep, spawn};
use std::time::{Duration, Instant};

use testkit::postgres::Cluster;
use testkit::proxy::Proxy;

/// Longest time to wait for a condition.
const PATIENCE: Duration = Duration::from_secs(60);
/// Names the file into which a copy of this test program writes where its cluster is.
const ORPHAN: &str = "GRASPD_TEST_ORPHAN";

fn waits_until(what: &str, mut happens: impl FnMut() -> bool) {
    let end = Instant::now() + PATIENCE;
    while !happens() {
        assert!(Instant::now() < end, "never: {what}");
        sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_cluster_keeps_what_is_committed_through_stop_and_crash() {
    let cluster = Cluster::shared();
    let (one, other) = (cluster.database(), cluster.database());
    assert_ne!(one.name, other.name);
    cluster.ask(&one.name, "CREATE TABLE kept (number int)");
    for (number, halt) in [Cluster::stop, Cluster::crash].into_iter().enumerate() {
        cluster.ask(&one.name, &format!("INSERT INTO kept VALUES ({number})"));
        halt(cluster);
        assert!(cluster.process().is_none());
        assert!(TcpStream::connect(("127.0.0.1", cluster.port())).is_err());
        cluster.resume();
    }
    let numbers = cluster.ask(&one.name, "SELECT number FROM kept ORDER BY number");
    assert_eq!(numbers, "0\n1");
    let tables = "SELECT count(*) FROM pg_tables WHERE tablename = 'kept'";
    assert_eq!(cluster.ask(&other.name, tables), "0");
    assert!(cluster.log().contains("automatic recovery") || cluster.log().contains("redo"));
    for setting in ["fsync", "synchronous_commit", "full_page_writes"] {
        assert_eq!(cluster.ask("postgres", &format!("SHOW {setting}")), "on");
    }
}

#[test]
fn a_cluster_is_reached_over_tcp_with_its_password_alone() {
    let cluster = Cluster::start();
    let database = cluster.database();
    let proxy = Proxy::start(cluster.port());
    let through = cluster.url_of(&database.name, proxy.port());
    for (url, name) in [
        (cluster.url(), "postgres"),
        (database.url.clone(), &database.name),
        (through, &database.name),
    ] {
        let where_it_is = "SELECT current_database(), inet_server_addr()";
        assert_eq!(cluster.ask(&url, where_it_is), format!("{name}|127.0.0.1"));
    }
    let wrong = database.url.replace("graspd:", "graspd:x");
    let refused = std::panic::catch_unwind(|| cluster.ask(&wrong, "SELECT 1"));
    let said = refused.unwrap_err();
    let said = said.downcast_ref::<String>().unwrap();
    assert!(said.contains("password authentication failed"), "{said}");
}

#[test]
fn a_cluster_that_is_dropped_leaves_nothing() {
    let cluster = Cluster::start_with(&["work_mem=7MB"]);
    assert_eq!(cluster.ask("postgres", "SHOW work_mem"), "7MB");
    assert!(cluster.process().is_some());
    let data = cluster.ask("postgres", "SHOW data_directory");
    assert!(Path::new(&data).exists());
    let port = cluster.port();
    drop(cluster);
    assert!(!Path::new(&data).exists());
    assert!(TcpStream::connect(("127.0.0.1", port)).is_err());
}

/// Run alone, in a process that is killed.
#[test]
fn starts_a_cluster_for_the_test_that_kills_it() {
    let Some(path) = std::env::var_os(ORPHAN) else {
        return;
    };
    let cluster = Cluster::shared();
    let data = cluster.ask("postgres", "SHOW data_directory");
    std::fs::write(path, format!("{data} {} .", cluster.port())).unwrap();
    sleep(PATIENCE);
}

#[test]
fn a_cluster_ends_with_a_process_that_is_killed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("where");
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "starts_a_cluster_for_the_test_that_kills_it"])
        .env(ORPHAN, &path)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let read = || std::fs::read_to_string(&path).unwrap_or_default();
    waits_until("the cluster runs", || read().ends_with(" ."));
    let place = read();
    let mut place = place.split(' ');
    let data = Path::new(place.next().unwrap());
    let port: u16 = place.next().unwrap().parse().unwrap();
    assert!(TcpStream::connect(("127.0.0.1", port)).is_ok());
    child.kill().unwrap();
    child.wait().unwrap();
    waits_until("the server ends", || {
        TcpStream::connect(("127.0.0.1", port)).is_err()
    });
    waits_until("its folder goes", || !data.parent().unwrap().exists());
}

/// A server that sends back what it gets; its port.
fn echo() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    spawn(move || {
        for connection in listener.incoming() {
            let mut connection = connection.unwrap();
            spawn(move || std::io::copy(&mut connection.try_clone().unwrap(), &mut connection));
        }
    });
    port
}

/// Sends a byte and waits a while for its return.
fn returns(connection: &mut TcpStream, byte: u8, patience: Duration) -> bool {
    connection.set_read_timeout(Some(patience)).unwrap();
    let mut back = [0];
    connection.write_all(&[byte]).is_ok()
        && connection.read_exact(&mut back).is_ok()
        && back == [byte]
}

#[test]
fn a_way_that_vanishes_keeps_connections_and_loses_nothing() {
    let proxy = Proxy::start(echo());
    let connect = || TcpStream::connect(("127.0.0.1", proxy.port())).unwrap();
    let mut old = connect();
    assert!(returns(&mut old, 1, PATIENCE));
    proxy.vanish();
    let mut new = connect();
    for connection in [&mut old, &mut new] {
        assert!(!returns(connection, 2, Duration::from_millis(200)));
    }
    proxy.appear();
    for connection in [&mut old, &mut new] {
        connection.set_read_timeout(Some(PATIENCE)).unwrap();
        let mut late = [0];
        connection.read_exact(&mut late).unwrap();
        assert_eq!(late, [2]);
        assert!(returns(connection, 3, PATIENCE));
    }
}

#[test]
fn a_way_that_is_cut_ends_connections_and_takes_new_ones() {
    let proxy = Proxy::start(echo());
    let connect = || TcpStream::connect(("127.0.0.1", proxy.port())).unwrap();
    let mut old = connect();
    assert!(returns(&mut old, 1, PATIENCE));
    proxy.cut();
    assert!(!returns(&mut old, 2, PATIENCE));
    assert!(returns(&mut connect(), 3, PATIENCE));
    let port = proxy.port();
    drop(proxy);
    waits_until("nobody listens", || {
        TcpStream::connect(("127.0.0.1", port)).is_err()
    });
}
