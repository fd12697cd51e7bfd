//! The numbers for Prometheus, read by a parser that is stricter than Prometheus itself.

use std::collections::{BTreeMap, HashSet};

use reqwest::StatusCode;
use serde_json::json;

use crate::common::{Server, file, problem, server, server_with, small_box};

/// Sample name with its labels as `name{a="b",c="d"}`, sorted, to value.
type Samples = BTreeMap<String, f64>;

/// Reads the text format 0.0.4 and panics at whatever is not quite as it is specified.
fn parse(text: &str) -> Samples {
    assert!(text.ends_with('\n'));
    let mut samples = Samples::new();
    let mut families = HashSet::new();
    let mut family: Option<(String, String)> = None;
    let mut help: Option<String> = None;
    for line in text.lines() {
        if let Some(rest) = line.strip_prefix("# HELP ") {
            let (name, words) = rest.split_once(' ').expect("a help text");
            assert!(!words.is_empty() && help.is_none(), "{line}");
            assert!(families.insert(name.to_owned()), "twice: {line}");
            help = Some(name.to_owned());
        } else if let Some(rest) = line.strip_prefix("# TYPE ") {
            let (name, kind) = rest.split_once(' ').expect("a type");
            assert_eq!(help.take().as_deref(), Some(name), "{line}");
            assert!(["counter", "gauge", "histogram"].contains(&kind), "{line}");
            assert!(name.starts_with("graspd_"), "{line}");
            assert_eq!(name.ends_with("_total"), kind == "counter", "{line}");
            family = Some((name.to_owned(), kind.to_owned()));
        } else {
            let (name, labels, value) = sample(line);
            let (of, kind) = family.as_ref().expect("a type before any sample");
            let suffix = name
                .strip_prefix(of.as_str())
                .expect("a sample of its family");
            let fits = match kind.as_str() {
                "histogram" => ["_bucket", "_sum", "_count"].contains(&suffix),
                _ => suffix.is_empty(),
            };
            assert!(fits, "{line}");
            let labels: Vec<_> = labels.iter().map(|(k, v)| format!("{k}=\"{v}\"")).collect();
            let key = match labels.is_empty() {
                true => name,
                false => format!("{name}{{{}}}", labels.join(",")),
            };
            assert!(samples.insert(key, value).is_none(), "twice: {line}");
        }
    }
    assert!(help.is_none());
    check_histograms(&samples);
    samples
}

/// Name, labels by name, value.
fn sample(line: &str) -> (String, BTreeMap<String, String>, f64) {
    let is_name = |name: &str| {
        !name.is_empty()
            && !name.starts_with(|c: char| c.is_ascii_digit())
            && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
    };
    let end = line.find(['{', ' ']).expect("a value");
    let (name, mut rest) = line.split_at(end);
    assert!(is_name(name), "{line}");
    let mut labels = BTreeMap::new();
    if let Some(inside) = rest.strip_prefix('{') {
        rest = inside;
        loop {
            let (label, after) = rest.split_once("=\"").expect("a label");
            assert!(is_name(label), "{line}");
            let mut value = String::new();
            let mut characters = after.char_indices();
            let end = loop {
                match characters.next().expect("the end of a label") {
                    (_, '\\') => match characters.next().expect("an escape").1 {
                        'n' => value.push('\n'),
                        c @ ('\\' | '"') => value.push(c),
                        _ => panic!("{line}"),
                    },
                    (at, '"') => break at,
                    (_, c) => value.push(c),
                }
            };
            assert!(labels.insert(label.to_owned(), value).is_none(), "{line}");
            rest = &after[end + 1..];
            match rest.strip_prefix(',') {
                Some(more) => rest = more,
                None => break,
            }
        }
        rest = rest.strip_prefix('}').expect("the end of the labels");
    }
    let value = rest.strip_prefix(' ').expect("a value");
    let value = match value {
        "+Inf" => f64::INFINITY,
        "NaN" => f64::NAN,
        value => value.parse().unwrap_or_else(|_| panic!("{line}")),
    };
    (name.to_owned(), labels, value)
}

/// Buckets never fall, and the last holds all.
fn check_histograms(samples: &Samples) {
    let mut series: BTreeMap<String, Vec<(f64, f64)>> = BTreeMap::new();
    for (key, value) in samples {
        if key.contains("_bucket{") {
            let (before, after) = key.split_once("le=\"").expect("a bound");
            let (bound, after) = after.split_once('"').expect("a bound");
            let bound = match bound {
                "+Inf" => f64::INFINITY,
                bound => bound.parse().expect("a bound"),
            };
            let labels = format!("{before}{}", after.trim_start_matches(','));
            series.entry(labels).or_default().push((bound, *value));
        }
    }
    for (labels, mut buckets) in series {
        buckets.sort_by(|a, b| a.0.total_cmp(&b.0));
        assert!(
            buckets.windows(2).all(|pair| pair[0].1 <= pair[1].1),
            "{labels}"
        );
        assert_eq!(
            buckets.last().expect("a bucket").0,
            f64::INFINITY,
            "{labels}"
        );
        let count = labels
            .replace("_bucket{", "_count{")
            .replace(",}", "}")
            .replace("{}", "");
        assert_eq!(
            samples[&count],
            buckets.last().expect("a bucket").1,
            "{labels}"
        );
        assert!(
            samples.contains_key(&count.replace("_count", "_sum")),
            "{labels}"
        );
    }
}

async fn scrape(server: &Server) -> Samples {
    let answer = server.get("/metrics").send().await.unwrap();
    assert_eq!(answer.status(), StatusCode::OK);
    let kind = &answer.headers()["content-type"];
    assert_eq!(kind, "text/plain; version=0.0.4; charset=utf-8");
    parse(&answer.text().await.unwrap())
}

#[tokio::test(flavor = "multi_thread")]
async fn numbers_are_those_of_what_was_done() {
    let server = server_with(&["--queue-capacity", "7"]).await;
    let before = scrape(&server).await;
    assert_eq!(before["graspd_jobs{state=\"queued\"}"], 0.0);
    assert_eq!(before["graspd_queue_capacity"], 7.0);
    assert_eq!(before["graspd_queue_oldest_wait_seconds"], 0.0);
    assert_eq!(before["graspd_jobs_submitted_total"], 0.0);
    assert!(
        before
            .keys()
            .any(|key| key.starts_with("graspd_build_info{version=\""))
    );

    let body = small_box();
    let bytes = body.len() as f64;
    let mesh = server.mesh(body).await;
    let id = server
        .job(&mesh, json!({"population": 20, "generations": 3}))
        .await;
    let job = server.wait_for(&id, &["succeeded"]).await;
    let unknown = json!({"mesh_id": "0".repeat(64)});
    problem(
        server.post("/jobs").json(&unknown).send().await.unwrap(),
        422,
    )
    .await;
    for path in ["/no-such-path-1", "/no-such-path-2", "/jobs/no-such-job"] {
        problem(server.get(path).send().await.unwrap(), 404).await;
    }
    let odd = reqwest::Method::from_bytes(b"BREW").unwrap();
    let odd = server.client.request(odd, server.url("/jobs")).send().await;
    problem(odd.unwrap(), 405).await;
    server.service.begin_drain();
    let refused = server.post("/meshes").multipart(file(small_box())).send();
    problem(refused.await.unwrap(), 503).await;
    // Counts of jobs may be a second old.
    tokio::time::sleep(std::time::Duration::from_millis(1100)).await;

    let after = scrape(&server).await;
    for (sample, value) in [
        ("graspd_jobs{state=\"succeeded\"}", 1.0),
        ("graspd_jobs{state=\"queued\"}", 0.0),
        ("graspd_jobs{state=\"failed\"}", 0.0),
        ("graspd_jobs_submitted_total", 1.0),
        ("graspd_job_wait_seconds_count", 1.0),
        ("graspd_job_run_seconds_count{end=\"succeeded\"}", 1.0),
        ("graspd_job_panics_total", 0.0),
        ("graspd_http_panics_total", 0.0),
        ("graspd_http_requests_in_flight", 1.0),
        ("graspd_http_rejections_total{reason=\"not_found\"}", 3.0),
        ("graspd_http_rejections_total{reason=\"draining\"}", 1.0),
        (
            "graspd_http_rejections_total{reason=\"invalid_request\"}",
            1.0,
        ),
        (
            "graspd_http_rejections_total{reason=\"method_not_allowed\"}",
            1.0,
        ),
        ("graspd_store_errors_total{operation=\"read\"}", 0.0),
        ("graspd_store_errors_total{operation=\"write\"}", 0.0),
        (
            "graspd_http_requests_total{method=\"POST\",route=\"/meshes\",status=\"201\"}",
            1.0,
        ),
        (
            "graspd_http_requests_total{method=\"POST\",route=\"/jobs\",status=\"202\"}",
            1.0,
        ),
        (
            "graspd_http_requests_total{method=\"POST\",route=\"/jobs\",status=\"422\"}",
            1.0,
        ),
        (
            "graspd_http_requests_total{method=\"GET\",route=\"none\",status=\"404\"}",
            2.0,
        ),
        (
            "graspd_http_requests_total{method=\"GET\",route=\"/jobs/{id}\",status=\"404\"}",
            1.0,
        ),
        (
            "graspd_http_requests_total{method=\"other\",route=\"/jobs\",status=\"405\"}",
            1.0,
        ),
        (
            "graspd_http_request_duration_seconds_count{method=\"POST\",route=\"/jobs\"}",
            2.0,
        ),
        ("graspd_upload_bytes_total", bytes),
    ] {
        assert_eq!(after.get(sample), Some(&value), "{sample}");
    }
    let evaluations = job["progress"]["evaluations"].as_f64().unwrap();
    assert_eq!(after["graspd_evaluations_total"], evaluations);
    assert!(after["graspd_store_operation_seconds_count{operation=\"write\"}"] >= 3.0);
    assert!(after["graspd_http_connections"] >= 1.0);
    assert!(after["graspd_process_resident_memory_bytes"] > 1e6);
    assert!(after["graspd_process_cpu_seconds_total"] > 0.0);
    assert!(after["graspd_process_open_fds"] > 3.0);
    assert!(after["graspd_process_threads"] > 1.0);
    let names: Vec<_> = after.keys().collect();
    assert!(
        !names.iter().any(|name| name.contains("no-such")),
        "{names:?}"
    );
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn two_servers_in_one_process_count_apart() {
    let (one, other) = (server().await, server().await);
    one.mesh(small_box()).await;
    assert!(scrape(&one).await["graspd_upload_bytes_total"] > 0.0);
    assert_eq!(scrape(&other).await["graspd_upload_bytes_total"], 0.0);
}

#[tokio::test(flavor = "multi_thread")]
async fn the_reader_chooses_the_format() {
    let server = server().await;
    // What Prometheus 3 sends.
    let accept = "application/openmetrics-text;version=1.0.0;escaping=allow-utf-8;q=0.6,\
                  text/plain;version=0.0.4;q=0.3,*/*;q=0.2";
    let open = server
        .get("/metrics")
        .header("accept", accept)
        .send()
        .await
        .unwrap();
    let kind = open.headers()["content-type"].to_str().unwrap().to_owned();
    assert!(kind.starts_with("application/openmetrics-text"), "{kind}");
    let text = open.text().await.unwrap();
    assert!(text.ends_with("# EOF\n") && text.contains("graspd_jobs_submitted_total 0"));
    for accept in ["*/*", "text/plain", "text/html, text/*;q=0.1"] {
        let plain = server
            .get("/metrics")
            .header("accept", accept)
            .send()
            .await
            .unwrap();
        assert!(
            plain.headers()["content-type"]
                .to_str()
                .unwrap()
                .starts_with("text/plain")
        );
    }
    let neither = server
        .get("/metrics")
        .header("accept", "image/png")
        .send()
        .await
        .unwrap();
    problem(neither, 406).await;
    problem(server.get("/metrics?x=1").send().await.unwrap(), 400).await;
}
