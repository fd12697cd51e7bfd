//! The server as a patient client sees it: what fails for a while is tried again.

use std::error::Error;
use std::io;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use axum::body::{Body, to_bytes};
use axum::http::header::{AUTHORIZATION, HeaderValue, RETRY_AFTER, USER_AGENT};
use axum::http::request::Builder;
use axum::http::{Method, Request, StatusCode};
use hyper_rustls::{HttpsConnector, HttpsConnectorBuilder};
use hyper_util::client::legacy::Client;
use hyper_util::client::legacy::connect::HttpConnector;
use hyper_util::rt::TokioExecutor;
use tokio::time::timeout;
use tokio_rustls::rustls::crypto::ring;
use url::Url;
use uuid::Uuid;

use super::error::BatchError;
use super::report::Board;
use crate::wire::Problem;

/// Longest that a connection is waited for, and an answer on it.
const CONNECT_TIME: Duration = Duration::from_secs(10);
pub const ANSWER_TIME: Duration = Duration::from_secs(60);
/// First and longest pause before another try, where the server does not say.
const PAUSES: [Duration; 2] = [Duration::from_millis(200), Duration::from_secs(10)];
/// Most tries of what ends in a fault of the server itself.
const FAULTS: u32 = 3;

/// A request on its way out, and how long all of it may take.
pub struct Call {
    pub request: Request<Body>,
    pub time: Duration,
}

/// An answer that trying again would not change.
pub struct Answer {
    pub status: StatusCode,
    pub body: Vec<u8>,
    retry_after: Option<Duration>,
}

/// One server.
pub struct Server {
    client: Client<HttpsConnector<HttpConnector>, Body>,
    root: String,
    authorization: Option<HeaderValue>,
    patience: Duration,
    /// When it last answered anything.
    answered: Mutex<Instant>,
    board: Board,
}

impl Server {
    /// `patience` is how long it may not answer at all before it is given up.
    pub fn new(
        url: &Url,
        key: Option<&str>,
        patience: Duration,
        board: Board,
    ) -> Result<Self, String> {
        let authorization = key.map(|key| HeaderValue::try_from(format!("Bearer {key}")));
        let authorization = authorization
            .transpose()
            .map_err(|_| "the API key has characters that no key has".to_owned())?;
        let mut connector = HttpConnector::new();
        connector.enforce_http(false);
        connector.set_connect_timeout(Some(CONNECT_TIME));
        connector.set_nodelay(true);
        // The authorities that this system trusts, so that those of a company are among them.
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

    /// What is at `path`, to be asked for.
    pub fn get(&self, path: &str) -> io::Result<Call> {
        let request = self.request(Method::GET, path).body(Body::empty());
        Ok(Call {
            request: request.map_err(io::Error::other)?,
            time: ANSWER_TIME,
        })
    }

    /// The head of a request.
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

    /// Asks until there is an answer that trying again would not change. `call` makes the request anew for
    /// each try; where it cannot, its fault is the outcome.
    pub async fn ask(
        &self,
        call: impl AsyncFn() -> io::Result<Call>,
    ) -> Result<io::Result<Answer>, BatchError> {
        let (mut tries, mut faults) = (0, 0);
        loop {
            let call = match call().await {
                Ok(call) => call,
                Err(fault) => return Ok(Err(fault)),
            };
            let (why, wanted) = match self.exchange(call).await {
                Ok(answer) => {
                    faults += u32::from(answer.status == StatusCode::INTERNAL_SERVER_ERROR);
                    if !answer.is_for_now() || faults >= FAULTS {
                        return Ok(Ok(answer));
                    }
                    (answer.words(), answer.retry_after)
                }
                Err(fault) => {
                    let why = format!("no answer from {}: {fault}", self.root);
                    let since = self.answered().elapsed();
                    if since >= self.patience {
                        return Err(BatchError::Refused(format!(
                            "{why}, for {} s",
                            since.as_secs()
                        )));
                    }
                    (why, None)
                }
            };
            self.board.waits(&why);
            tokio::time::sleep(pause(tries).max(wanted.unwrap_or_default())).await;
            tries += 1;
        }
    }

    /// One try; what goes wrong with it is told in words.
    async fn exchange(&self, Call { request, time }: Call) -> Result<Answer, String> {
        let exchange = async {
            let response = self
                .client
                .request(request)
                .await
                .map_err(|fault| cause(&fault))?;
            *self.answered() = Instant::now();
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

    fn answered(&self) -> MutexGuard<'_, Instant> {
        self.answered.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Answer {
    /// Whether the same request may do later.
    fn is_for_now(&self) -> bool {
        match self.status.as_u16() {
            408 | 425 | 429 | 500 | 502..=504 | 507 => true,
            // A request under the same Idempotency-Key is being dealt with.
            409 => self.retry_after.is_some(),
            _ => false,
        }
    }

    /// The refusal in words.
    pub fn words(&self) -> String {
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

/// Twice as long each time, and at random, so that clients do not come back all at once.
fn pause(tries: u32) -> Duration {
    let [first, longest] = PAUSES;
    let pause = first.saturating_mul(1 << tries.min(16)).min(longest);
    let random = f64::from(Uuid::new_v4().as_u128() as u32) / f64::from(u32::MAX);
    pause.mul_f64(0.5 + random / 2.0)
}

/// What a fault comes from in the end: the faults around it say less.
fn cause(fault: &dyn Error) -> String {
    let mut inner = fault;
    while let Some(source) = inner.source() {
        inner = source;
    }
    inner.to_string()
}
