//! A client that asks again until it has an answer.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use reqwest::multipart::{Form, Part};
use reqwest::{Client, Method, Response, StatusCode};
use serde_json::Value;
use tokio::sync::watch;

/// Longest time that a client tries to get one answer.
const PATIENCE: Duration = Duration::from_secs(60);
/// Pause after a failure.
const PAUSE: Duration = Duration::from_millis(30);

/// A client of servers that come and go.
#[derive(Clone)]
pub struct Caller {
    http: Client,
    /// The current addresses of the servers.
    urls: watch::Receiver<Vec<String>>,
    /// Tries so far: each goes to the next server.
    tries: Arc<AtomicUsize>,
}

/// The body of a request.
pub enum Body<'a> {
    Nothing,
    Json(&'a Value, Option<&'a str>),
    Mesh(&'a [u8]),
    /// Settings, mesh file and key, as a multipart form.
    Form(&'a Value, &'a [u8], &'a str),
}

/// An answer, whole.
pub struct Answer {
    pub status: u16,
    pub body: Value,
    /// How often it was asked for.
    pub tries: usize,
}

impl Caller {
    /// `patience` is the longest that one try may take.
    pub fn new(urls: watch::Receiver<Vec<String>>, patience: Duration) -> Self {
        let http = Client::builder().no_proxy().timeout(patience).build();
        Self {
            http: http.expect("a client"),
            urls,
            tries: Arc::default(),
        }
    }

    /// Repeats a request until the answer is not "later".
    pub async fn call(
        &self,
        method: Method,
        path: &str,
        body: &Body<'_>,
    ) -> Result<Answer, String> {
        let end = Instant::now() + PATIENCE;
        let mut last = String::new();
        for tries in 1.. {
            if Instant::now() > end {
                break;
            }
            match self.once(&method, path, body).await {
                Ok(response) => {
                    let status = response.status();
                    let later = response.headers().contains_key("retry-after")
                        && (status == StatusCode::SERVICE_UNAVAILABLE
                            || status == StatusCode::CONFLICT);
                    match response.bytes().await {
                        Ok(bytes) if !later => {
                            let body = serde_json::from_slice(&bytes).unwrap_or_default();
                            let status = status.as_u16();
                            return Ok(Answer {
                                status,
                                body,
                                tries,
                            });
                        }
                        Ok(_) => last = status.to_string(),
                        Err(fault) => last = fault.to_string(),
                    }
                }
                Err(fault) => last = fault.to_string(),
            }
            tokio::time::sleep(PAUSE).await;
        }
        Err(format!("{method} {path}: no answer, at last {last}"))
    }

    async fn once(
        &self,
        method: &Method,
        path: &str,
        body: &Body<'_>,
    ) -> Result<Response, reqwest::Error> {
        let url = {
            let urls = self.urls.borrow();
            let turn = self.tries.fetch_add(1, Ordering::Relaxed);
            format!("{}{path}", urls[turn % urls.len()])
        };
        let mut request = self.http.request(method.clone(), url);
        request = match body {
            Body::Nothing => request,
            Body::Json(value, key) => {
                if let Some(key) = key {
                    request = request.header("idempotency-key", *key);
                }
                request.json(value)
            }
            Body::Mesh(bytes) => request
                .header("content-type", "model/stl")
                .body(bytes.to_vec()),
            Body::Form(settings, mesh, key) => request
                .header("idempotency-key", *key)
                .multipart(form(settings, mesh)),
        };
        request.send().await
    }
}

fn form(settings: &Value, mesh: &[u8]) -> Form {
    let file = Part::bytes(mesh.to_vec()).file_name("mesh.stl");
    let fields = settings.as_object().into_iter().flatten();
    fields.fold(Form::new().part("mesh", file), |form, (name, value)| {
        let text = value
            .as_str()
            .map_or_else(|| value.to_string(), str::to_owned);
        form.text(name.clone(), text)
    })
}
