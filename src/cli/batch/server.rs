//! The client of a batch, which repeats requests after temporary failures.

use std::error::Error;
use std::io;
use std::time::{Duration, Instant};

use axum::body::{Body, to_bytes};
use axum::http::header::{AUTHORIZATION, HeaderValue, RETRY_AFTER, USER_AGENT};
use axum::http::request::Builder;
use axum::http::{Method, Request, StatusCode};
use hyper_rustls::{HttpsConnector, HttpsConnectorBuilder};
use hyper_util::client::legacy::Client;
use hyper_util::client::legacy::connect::HttpConnector;
use hyper_util::rt::TokioExecutor;
use parking_lot::Mutex;
use tokio::time::timeout;
use tokio_rustls::rustls::crypto::ring;
use url::Url;
use uuid::Uuid;

use super::error::BatchError;
use super::report::Board;
use crate::wire::Problem;

/// How long to wait for a connection, and for an answer on it.
const CONNECT_TIME: Duration = Duration::from_secs(10);
pub const ANSWER_TIME: Duration = Duration::from_secs(60);
/// First and longest pause before another try, unless the server asks for a longer one.
const PAUSES: [Duration; 2] = [Duration::from_millis(200), Duration::from_secs(10)];
/// After how many internal errors of the server (500) a request is given up.
const MAX_SERVER_ERRORS: u32 = 3;

/// A request and the time that the whole exchange may take.
pub struct Call {
    pub request: Request<Body>,
    pub time: Duration,
}

/// The answer to a request.
pub struct Answer {
    pub status: StatusCode,
    pub body: Vec<u8>,
    retry_after: Option<Duration>,
}

/// The server and the state of the connection to it.
pub struct Server {
    client: Client<HttpsConnector<HttpConnector>, Body>,
    root: String,
    authorization: Option<HeaderValue>,
    patience: Duration,
    /// When the server last answered any request.
    answered: Mutex<Instant>,
    board: Board,
}

impl Server {
    /// Creates the client. It gives up once the server has not answered for `patience`.
    pub fn new(
        url: &Url,
        key: Option<&str>,
        patience: Duration,
        board: Board,
    ) -> Result<Self, String> {
        let authorization = key.map(|key| HeaderValue::try_from(format!("Bearer {key}")));
        let authorization = authorization
            .transpose()
            .map_err(|_| "the API key contains characters that no key has".to_owned())?;
        let mut connector = HttpConnector::new();
        connector.enforce_http(false);
        connector.set_connect_timeout(Some(CONNECT_TIME));
        connector.set_nodelay(true);
        // Use the authorities that this system trusts, which may include those of a company.
        let connector = HttpsConnectorBuilder::new()
            .with_provider_and_native_roots(ring::default_provider())
            .map_err(|fault| format!("the certificates of this system cannot be read: {fault}"))?
            .https_or_http()
            .enable_http1()
            .wrap_connector(connector);
        Ok(Self {
            client: Client::builder(TokioExecutor::new()).build(connector),
            root: url.as_str().trim_end_matches('/').to_owned(),
            authorization,
            patience,
            answered: Mutex::new(Instant::now()),
            board,
        })
    }

    /// Returns a GET request for `path`.
    pub fn get(&self, path: &str) -> io::Result<Call> {
        let request = self.request(Method::GET, path).body(Body::empty());
        Ok(Call {
            request: request.map_err(io::Error::other)?,
            time: ANSWER_TIME,
        })
    }

    /// Returns the head of a request.
    pub fn request(&self, method: Method, path: &str) -> Builder {
        let request = Request::builder()
            .method(method)
            .uri(format!("{}{path}", self.root))
            .header(USER_AGENT, concat!("graspd/", env!("CARGO_PKG_VERSION")));
        match &self.authorization {
            Some(key) => request.header(AUTHORIZATION, key),
            None => request,
        }
    }

    /// Sends a request until it has an answer that another try would not change. `call` creates the request for each try;
    /// if it fails, its error is returned.
    pub async fn send(
        &self,
        call: impl AsyncFn() -> io::Result<Call>,
    ) -> Result<io::Result<Answer>, BatchError> {
        let (mut tries, mut server_errors) = (0, 0);
        loop {
            let call = match call().await {
                Ok(call) => call,
                Err(fault) => return Ok(Err(fault)),
            };
            let (why, retry_after) = match self.exchange(call).await {
                Ok(answer) => {
                    server_errors += u32::from(answer.status == StatusCode::INTERNAL_SERVER_ERROR);
                    if !answer.is_temporary() || server_errors >= MAX_SERVER_ERRORS {
                        return Ok(Ok(answer));
                    }
                    (answer.message(), answer.retry_after)
                }
                Err(fault) => {
                    let why = format!("no answer from {}: {fault}", self.root);
                    let since = self.answered.lock().elapsed();
                    if since >= self.patience {
                        return Err(BatchError::Refused(format!(
                            "{why}, for {} s",
                            since.as_secs()
                        )));
                    }
                    (why, None)
                }
            };
            self.board.waiting(&why);
            tokio::time::sleep(pause(tries).max(retry_after.unwrap_or_default())).await;
            tries += 1;
        }
    }

    /// Makes one try; an error is returned as text.
    async fn exchange(&self, Call { request, time }: Call) -> Result<Answer, String> {
        let exchange = async {
            let response = self
                .client
                .request(request)
                .await
                .map_err(|fault| cause(&fault))?;
            *self.answered.lock() = Instant::now();
            let seconds = |value: &HeaderValue| value.to_str().ok()?.parse().ok();
            let (head, body) = response.into_parts();
            let body = to_bytes(Body::new(body), usize::MAX).await;
            Ok(Answer {
                status: head.status,
                retry_after: head
                    .headers
                    .get(RETRY_AFTER)
                    .and_then(seconds)
                    .map(Duration::from_secs),
                body: body.map_err(|fault| cause(&fault))?.into(),
            })
        };
        timeout(time, exchange)
            .await
            .unwrap_or_else(|_| Err(format!("it took longer than {} s", time.as_secs())))
    }
}

impl Answer {
    /// Whether the same request may succeed later.
    fn is_temporary(&self) -> bool {
        match self.status.as_u16() {
            408 | 425 | 429 | 500 | 502..=504 | 507 => true,
            // A request under the same Idempotency-Key is in progress.
            409 => self.retry_after.is_some(),
            _ => false,
        }
    }

    /// Describes a refusal.
    pub fn message(&self) -> String {
        let status = self.status;
        match serde_json::from_slice::<Problem>(&self.body) {
            Err(_) => format!("the server answers {status}"),
            Ok(problem) => match &problem.errors[..] {
                [] => format!("{}: {}", problem.title, problem.detail),
                errors => {
                    let fields = errors.iter().map(|field| {
                        format!(
                            "{}: {}",
                            field.pointer.trim_start_matches('/'),
                            field.detail
                        )
                    });
                    let fields: Vec<String> = fields.collect();
                    format!("{}: {}", problem.title, fields.join("; "))
                }
            },
        }
    }
}

/// Returns the pause before the next try. It doubles with each try and is randomised, so that clients do not return at the
/// same moment.
fn pause(tries: u32) -> Duration {
    let [first, longest] = PAUSES;
    let pause = first.saturating_mul(1 << tries.min(16)).min(longest);
    let random = f64::from(Uuid::new_v4().as_u128() as u32) / f64::from(u32::MAX);
    pause.mul_f64(0.5 + random / 2.0)
}

/// Returns the root cause of an error: the errors that wrap it say less.
fn cause(fault: &dyn Error) -> String {
    let mut inner = fault;
    while let Some(source) = inner.source() {
        inner = source;
    }
    inner.to_string()
}
