//! A receiver of webhooks on loopback, and what it got.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use axum::Router;
use axum::body::Bytes;
use axum::http::{HeaderMap, StatusCode, Uri};
use axum::response::{IntoResponse, Redirect};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use hmac::{Hmac, KeyInit, Mac};
use serde_json::Value;
use sha2::Sha256;
use tokio::net::TcpListener;
use tokio::sync::mpsc;

/// What a receiver got.
#[derive(Debug)]
pub struct Message {
    pub path: String,
    pub headers: HeaderMap,
    pub body: Bytes,
}

impl Message {
    pub fn header(&self, name: &str) -> &str {
        self.headers[name].to_str().unwrap()
    }

    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap()
    }

    /// Asserts that each key has signed, as the specification of Standard Webhooks says it.
    pub fn assert_signed(&self, keys: &[&[u8]]) {
        let timestamp = self.header("webhook-timestamp");
        let age = jiff::Timestamp::now().as_second() - timestamp.parse::<i64>().unwrap();
        assert!((0..60).contains(&age), "{timestamp}");
        let mut signed = format!("{}.{timestamp}.", self.header("webhook-id")).into_bytes();
        signed.extend_from_slice(&self.body);
        let wanted = keys.iter().map(|key| {
            let mut mac = Hmac::<Sha256>::new_from_slice(key).unwrap();
            mac.update(&signed);
            let code = BASE64_STANDARD.encode(mac.finalize().into_bytes());
            format!("v1,{code}")
        });
        let wanted: Vec<String> = wanted.collect();
        let found: Vec<&str> = self.header("webhook-signature").split(' ').collect();
        assert_eq!(found, wanted);
    }
}

/// What a receiver does with a message.
pub enum Answer {
    Status(u16),
    Redirect(&'static str),
    Never,
}

/// A receiver on loopback, open until the end of the test.
pub struct Receiver {
    pub port: u16,
    messages: mpsc::UnboundedReceiver<Message>,
    /// Most messages that were unanswered at the same time.
    pub most: Arc<AtomicUsize>,
}

/// Counts a message for as long as it is unanswered.
struct Unanswered(Arc<AtomicUsize>);

impl Drop for Unanswered {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

/// A receiver whose answers follow a script, given how many messages came before.
pub async fn receiver(script: impl Fn(usize) -> Answer + Send + Sync + 'static) -> Receiver {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let port = listener.local_addr().unwrap().port();
    let (sender, messages) = mpsc::unbounded_channel();
    let count = Arc::new(AtomicUsize::new(0));
    let script = Arc::new(script);
    let (open, most) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicUsize::new(0)));
    let highest = Arc::clone(&most);
    let handler = move |uri: Uri, headers: HeaderMap, body: Bytes| {
        highest.fetch_max(open.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
        let unanswered = Unanswered(Arc::clone(&open));
        let answer = script(count.fetch_add(1, Ordering::SeqCst));
        let path = uri.to_string();
        let _ = sender.send(Message {
            path,
            headers,
            body,
        });
        async move {
            let _unanswered = unanswered;
            match answer {
                Answer::Status(status) => StatusCode::from_u16(status).unwrap().into_response(),
                Answer::Redirect(to) => Redirect::temporary(to).into_response(),
                Answer::Never => std::future::pending().await,
            }
        }
    };
    let router = Router::new().fallback(handler);
    tokio::spawn(async move { axum::serve(listener, router).await });
    Receiver {
        port,
        messages,
        most,
    }
}

impl Receiver {
    pub fn url(&self) -> String {
        format!("http://127.0.0.1:{}/hook?x=1", self.port)
    }

    /// The host as flags name it.
    pub fn host(&self) -> String {
        format!("http://127.0.0.1:{}", self.port)
    }

    pub async fn message(&mut self) -> Message {
        let wait = tokio::time::timeout(Duration::from_secs(60), self.messages.recv());
        wait.await.expect("a message in time").expect("a message")
    }

    /// Asserts that nothing more has come.
    pub fn assert_silent(&mut self) {
        assert!(self.messages.try_recv().is_err());
    }
}
