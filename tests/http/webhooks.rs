//! Webhooks: a real receiver gets a message at the end of a job, or the job says why not.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use reqwest::Client;
use serde_json::{Value, json};
use testkit::process::Graspd;

use crate::common::{
    Server, file, pointers, problem, server, server_adjusted, server_with, small_box,
};
use crate::receiver::{Answer, receiver};

const KEYS: [&[u8]; 2] = [b"0123456789abcdefghijklmn", &[7; 64]];

fn secrets() -> String {
    KEYS.map(|key| format!("whsec_{}", BASE64_STANDARD.encode(key)))
        .join(" ")
}

/// A server that may call these hosts on loopback, with these pauses between attempts.
async fn server_for(hosts: &str, retries: &'static [u64]) -> Server {
    let secrets = secrets();
    let flags = [
        "--webhook-hosts",
        hosts,
        "--webhook-private-hosts",
        "localhost,127.0.0.1",
        "--webhook-secret",
        &secrets,
    ];
    server_adjusted(&flags, |options| {
        let pauses = retries.iter().map(|pause| Duration::from_millis(*pause));
        options.webhooks.retries = pauses.collect();
    })
    .await
}

fn quick(url: &str) -> Value {
    json!({"population": 20, "generations": 3, "seed": 7, "callback_url": url})
}

/// Waits until the callback of a job passes `test`, and gives it.
async fn read_callback(server: &Server, job: &str, test: impl Fn(&Value) -> bool) -> Value {
    let end = Instant::now() + Duration::from_secs(60);
    loop {
        let callback = &server.json(&format!("/jobs/{job}")).await["callback"];
        if test(callback) {
            return callback.clone();
        }
        assert!(Instant::now() < end, "{callback}");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}

fn is_over(callback: &Value) -> bool {
    callback["state"] != "pending"
}

#[tokio::test(flavor = "multi_thread")]
async fn every_end_is_posted_once_and_signed() {
    let mut receiver = receiver(|_| Answer::Status(204)).await;
    let server = server_for(&receiver.host(), &[10, 10, 10]).await;
    let mesh = server.mesh(small_box()).await;
    let url = receiver.url();

    let job = server.job(&mesh, quick(&url)).await;
    let message = receiver.message().await;
    message.assert_signed(&KEYS);
    assert_eq!(message.path, "/hook?x=1");
    assert_eq!(message.header("content-type"), "application/json");
    assert_eq!(
        message.header("host"),
        format!("127.0.0.1:{}", receiver.port)
    );
    assert!(message.header("user-agent").starts_with("graspd/"));
    assert_eq!(message.header("webhook-id"), format!("msg_{job}"));
    let callback = read_callback(&server, &job, is_over).await;
    assert_eq!(callback["state"], "delivered", "{callback}");
    assert_eq!(
        (&callback["url"], &callback["attempts"]),
        (&json!(url), &json!(1))
    );
    assert!(callback["last_attempt_at"].is_string() && callback["next_attempt_at"].is_null());

    let event = message.json();
    let mut record = server.json(&format!("/jobs/{job}")).await;
    assert_eq!(event["type"], "job.succeeded");
    assert_eq!(event["timestamp"], record["finished_at"]);
    let result_url = event["data"]["result_url"].as_str().unwrap();
    assert_eq!(server.json(result_url).await, record["result"]);
    record["result_url"] = json!(result_url);
    for member in ["callback", "mesh_report", "result"] {
        record.as_object_mut().unwrap().remove(member);
    }
    assert_eq!(event["data"], record);

    let endless = json!({"population": 10_000, "generations": 90_000, "callback_url": url});
    let running = server.job(&mesh, endless.clone()).await;
    let waiting = server.job(&mesh, endless).await;
    server.wait_for(&running, &["running"]).await;
    let pending = read_callback(&server, &running, |_| true).await;
    assert_eq!(
        pending,
        json!({"url": url, "state": "pending", "attempts": 0})
    );
    receiver.assert_silent();
    for job in [&waiting, &running] {
        let cancel = server.post(&format!("/jobs/{job}/cancel")).send().await;
        assert_eq!(cancel.unwrap().status(), 202);
        let message = receiver.message().await;
        message.assert_signed(&KEYS);
        let event = message.json();
        assert_eq!(event["type"], "job.cancelled");
        assert_eq!(event["data"]["id"], json!(job));
    }

    let mut impossible = quick(&url);
    impossible["constraints"] = json!({"include": [{"triangles": [99_999]}]});
    let failing = server.job(&mesh, impossible).await;
    let event = receiver.message().await.json();
    assert_eq!(
        (&event["type"], &event["data"]["id"]),
        (&json!("job.failed"), &json!(failing))
    );
    assert!(event["data"]["problem"]["detail"].is_string(), "{event}");
    assert!(event["data"].get("result_url").is_none());
    read_callback(&server, &failing, is_over).await;
    receiver.assert_silent();
}

#[tokio::test(flavor = "multi_thread")]
async fn a_receiver_that_fails_is_tried_again_with_the_same_message() {
    let script = |before| Answer::Status(if before < 2 { 500 } else { 200 });
    let mut receiver = receiver(script).await;
    let server = server_for(&receiver.host(), &[10, 10, 10]).await;
    let mesh = server.mesh(small_box()).await;
    let job = server.job(&mesh, quick(&receiver.url())).await;
    let first = receiver.message().await;
    for _ in 0..2 {
        let again = receiver.message().await;
        again.assert_signed(&KEYS);
        assert_eq!(again.header("webhook-id"), first.header("webhook-id"));
        assert_eq!(again.body, first.body);
    }
    let callback = read_callback(&server, &job, is_over).await;
    assert_eq!(callback["state"], "delivered", "{callback}");
    assert_eq!(callback["attempts"], 3);
    assert!(callback["last_error"].is_null(), "{callback}");
    receiver.assert_silent();
}

#[tokio::test(flavor = "multi_thread")]
async fn a_message_that_is_never_accepted_is_given_up() {
    let mut receiver = receiver(|before| match before {
        0 => Answer::Status(410),
        1 | 2 => Answer::Redirect("/elsewhere"),
        _ => Answer::Status(200),
    })
    .await;
    let server = server_for(&receiver.host(), &[10]).await;
    let mesh = server.mesh(small_box()).await;
    for (attempts, why) in [(1, "410"), (2, "redirect")] {
        let job = server.job(&mesh, quick(&receiver.url())).await;
        let callback = read_callback(&server, &job, is_over).await;
        assert_eq!(callback["state"], "failed", "{callback}");
        assert_eq!(callback["attempts"], attempts, "{callback}");
        assert!(
            callback["last_error"].as_str().unwrap().contains(why),
            "{callback}"
        );
        assert!(callback["next_attempt_at"].is_null(), "{callback}");
        for _ in 0..attempts {
            assert_eq!(receiver.message().await.path, "/hook?x=1");
        }
    }
    receiver.assert_silent();
}

#[tokio::test(flavor = "multi_thread")]
async fn a_host_that_hangs_holds_up_only_itself() {
    let mut dead = receiver(|_| Answer::Never).await;
    let mut alive = receiver(|_| Answer::Status(200)).await;
    let hosts = format!("{},{}", dead.host(), alive.host());
    let server = server_for(&hosts, &[600_000]).await;
    let mesh = server.mesh(small_box()).await;
    // Those behind it end at once when they are cancelled.
    let endless = json!({"population": 10_000, "generations": 90_000});
    server.job(&mesh, endless).await;
    let end = async |url: &str| {
        let job = server.job(&mesh, quick(url)).await;
        let cancel = server.post(&format!("/jobs/{job}/cancel")).send().await;
        assert_eq!(cancel.unwrap().status(), 202);
        job
    };
    let mut hanging = Vec::new();
    for _ in 0..20 {
        hanging.push(end(&dead.url()).await);
    }
    for _ in 0..4 {
        dead.message().await;
    }
    for _ in 0..6 {
        end(&alive.url()).await;
    }
    for _ in 0..6 {
        alive.message().await;
    }
    let tried = |callback: &Value| callback["attempts"] != 0;
    let callback = read_callback(&server, &hanging[0], tried).await;
    assert_eq!(
        (&callback["state"], &callback["attempts"]),
        (&json!("pending"), &json!(1))
    );
    assert!(
        callback["last_error"]
            .as_str()
            .unwrap()
            .contains("15 seconds"),
        "{callback}"
    );
    assert!(callback["next_attempt_at"].is_string());
    // The next one hangs too; the server does not wait for its end.
    dead.message().await;
    assert_eq!(dead.most.load(Ordering::SeqCst), 4);
    let start = Instant::now();
    server.stop().await;
    assert!(
        start.elapsed() < Duration::from_secs(12),
        "{:?}",
        start.elapsed()
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn a_name_for_an_address_that_is_not_public_is_refused() {
    let mut receiver = receiver(|_| Answer::Status(200)).await;
    let port = receiver.port;
    let hosts = format!("http://localhost:{port},{}", receiver.host());
    let secrets = secrets();
    let flags = ["--webhook-hosts", &hosts, "--webhook-secret", &secrets];
    let server = server_with(&flags).await;
    let mesh = server.mesh(small_box()).await;
    for host in ["localhost", "127.0.0.1"] {
        let request = quick(&format!("http://{host}:{port}/"));
        let job = server.job(&mesh, request).await;
        let tried = |callback: &Value| callback["attempts"] != 0;
        let callback = read_callback(&server, &job, tried).await;
        let why = callback["last_error"].as_str().unwrap();
        assert!(
            why.contains("not public") && !why.contains("127"),
            "{callback}"
        );
        assert_eq!(callback["state"], "pending");
    }
    receiver.assert_silent();
}

#[tokio::test(flavor = "multi_thread")]
async fn only_what_the_operator_allows_may_be_called() {
    let off = server().await;
    let mesh = off.mesh(small_box()).await;
    let url = "https://hooks.example.com/";
    let mut request = quick(url);
    request["mesh_id"] = json!(mesh);
    let kept = off.kept_files();
    let form = file(small_box())
        .text("callback_url", url)
        .text("scale", "2");
    for request in [
        off.post("/jobs").json(&request),
        off.post("/jobs").multipart(form),
    ] {
        let problem = problem(request.send().await.unwrap(), 422).await;
        assert_eq!(pointers(&problem), ["/callback_url"]);
        assert!(
            problem.to_string().contains("webhooks are off"),
            "{problem}"
        );
    }
    assert_eq!(off.kept_files(), kept);

    let server = server_for("hooks.example.com", &[]).await;
    let mesh = server.mesh(small_box()).await;
    let long = format!("https://hooks.example.com/{}", "x".repeat(2048));
    for bad in [
        json!("https://evil.example.com/"),
        json!("http://hooks.example.com/"),
        json!("https://u:p@hooks.example.com/"),
        json!("https://hooks.example.com/#x"),
        json!("https://hooks.example.com/\u{202e}"),
        json!("not a URL"),
        json!(long),
        json!(7),
        json!(null),
    ] {
        let request = json!({"mesh_id": mesh, "callback_url": bad});
        let answer = server.post("/jobs").json(&request).send().await.unwrap();
        assert_eq!(
            pointers(&problem(answer, 422).await),
            ["/callback_url"],
            "{bad}"
        );
    }
    // In its normal form, and nowhere but in a planning request.
    let job = server
        .job(&mesh, quick("HTTPS://Hooks.Example.com:443/a/../b"))
        .await;
    let record = server.json(&format!("/jobs/{job}")).await;
    assert_eq!(
        record["request"]["callback_url"],
        "https://hooks.example.com/b"
    );
    let evaluation = json!({"mesh_id": mesh, "callback_url": url, "grasps": [[{"triangle": 0}]]});
    let answer = server.post("/evaluations").json(&evaluation).send().await;
    problem(answer.unwrap(), 422).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_entity_tag_of_a_job_changes_with_its_callback() {
    let receiver = receiver(|before| Answer::Status(if before == 0 { 503 } else { 200 })).await;
    let server = server_for(&receiver.host(), &[1500]).await;
    let mesh = server.mesh(small_box()).await;
    let job = server.job(&mesh, quick(&receiver.url())).await;
    let path = format!("/jobs/{job}");
    let mut last = String::new();
    for state in ["pending", "delivered"] {
        let reached = |callback: &Value| callback["attempts"] != 0 && callback["state"] == state;
        read_callback(&server, &job, reached).await;
        let unchanged = server.get(&path).header("if-none-match", &last).send();
        let answer = unchanged.await.unwrap();
        assert_eq!(answer.status(), 200);
        last = answer.headers()["etag"].to_str().unwrap().to_owned();
    }
    let unchanged = server.get(&path).header("if-none-match", &last).send();
    assert_eq!(unchanged.await.unwrap().status(), 304);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_killed_server_still_posts_the_end() {
    let script = |before| match before {
        0 => Answer::Never,
        _ => Answer::Status(200),
    };
    let mut receiver = receiver(script).await;
    let folder = tempfile::tempdir().unwrap();
    let (hosts, secrets) = (receiver.host(), secrets());
    let flags = [
        "--webhook-hosts",
        &hosts,
        "--webhook-private-hosts",
        "127.0.0.1",
        "--webhook-secret",
        &secrets,
    ];
    let log = folder.path().join("log");
    let start = || {
        let log = std::fs::File::options()
            .create(true)
            .append(true)
            .open(&log);
        Graspd::start_with(folder.path(), &flags, log.unwrap().into())
    };
    let mut server = start();
    let client = Client::builder().no_proxy().build().unwrap();
    let form = file(small_box())
        .text("population", "20")
        .text("generations", "3")
        .text("callback_url", receiver.url());
    let answer = client.post(format!("{}/jobs", server.url)).multipart(form);
    let job: Value = answer.send().await.unwrap().json().await.unwrap();
    let first = receiver.message().await;
    server.signal("-KILL");
    drop(server);

    let mut server = start();
    let again = receiver.message().await;
    again.assert_signed(&KEYS);
    assert_eq!(again.header("webhook-id"), first.header("webhook-id"));
    assert_eq!(again.body, first.body);
    assert_eq!(again.json()["data"]["id"], job["id"]);
    assert!(server.signal("-TERM").success());
    drop(server);
    receiver.assert_silent();
    let log = std::fs::read_to_string(log).unwrap();
    assert!(
        log.contains("webhook delivered") && !log.contains("whsec_"),
        "{log}"
    );
}

#[test]
fn settings_that_do_not_work_are_said_at_the_start_without_their_secrets() {
    let folder = tempfile::tempdir().unwrap();
    let graspd = |arguments: &[&str], secret: Option<&str>| {
        let mut command = std::process::Command::new(testkit::process::binary());
        command.args(["serve", "--listen", "127.0.0.1:0", "--data-dir"]);
        command.arg(folder.path()).args(arguments);
        command.envs(secret.map(|secret| ("GRASPD_WEBHOOK_SECRET", secret)));
        let output = command.output().unwrap();
        let said = [output.stdout, output.stderr].concat();
        (output.status.code(), String::from_utf8(said).unwrap())
    };
    let hosts = ["--webhook-hosts", "hooks.example.com"];
    let (code, said) = graspd(&hosts, None);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("GRASPD_WEBHOOK_SECRET"), "{said}");
    let (code, said) = graspd(&hosts, Some("whsec_hunter2"));
    assert_eq!(code, Some(1), "{said}");
    assert!(
        said.contains("--webhook-secret") && !said.contains("hunter2"),
        "{said}"
    );
    let (code, said) = graspd(&["--webhook-hosts", "ftp://x.example"], None);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("ftp://x.example"), "{said}");
    let (code, said) = graspd(&["--help"], Some("whsec_hunter2"));
    assert_eq!(code, Some(0), "{said}");
    assert!(
        said.contains("GRASPD_WEBHOOK_SECRET") && !said.contains("hunter2"),
        "{said}"
    );
}
