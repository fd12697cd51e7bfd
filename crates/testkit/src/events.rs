//! Server-Sent Events as a client reads them.

use std::time::Duration;

use reqwest::{RequestBuilder, Response, StatusCode};
use serde_json::Value;

/// One event, or a comment, which has no name.
#[derive(Debug)]
pub struct Event {
    pub name: String,
    pub id: Option<u64>,
    pub retry: bool,
    pub data: Value,
}

/// A reader of an open stream.
pub struct Reader {
    response: Response,
    text: String,
}

impl Reader {
    /// Opens the stream that is asked for.
    pub async fn open(request: RequestBuilder) -> Self {
        let response = request.send().await.expect("an answer");
        assert_eq!(response.status(), StatusCode::OK);
        assert_eq!(response.headers()["content-type"], "text/event-stream");
        assert_eq!(response.headers()["cache-control"], "no-cache");
        Self {
            response,
            text: String::new(),
        }
    }

    /// The next event, comments among them; `None` at the end of the stream.
    pub async fn next_of_all(&mut self) -> Option<Event> {
        loop {
            if let Some((block, rest)) = self.text.split_once("\n\n") {
                let event = parse(block);
                self.text = rest.to_owned();
                return Some(event);
            }
            let piece = tokio::time::timeout(Duration::from_secs(30), self.response.chunk());
            let piece = piece.await.expect("a sign of life").expect("a clean end");
            self.text
                .push_str(std::str::from_utf8(&piece?).expect("UTF-8"));
        }
    }

    pub async fn next(&mut self) -> Option<Event> {
        loop {
            let event = self.next_of_all().await?;
            if !event.name.is_empty() {
                return Some(event);
            }
        }
    }
}

fn parse(block: &str) -> Event {
    let mut event = Event {
        name: String::new(),
        id: None,
        retry: false,
        data: Value::Null,
    };
    for line in block.lines() {
        let (field, value) = line.split_once(':').expect("a field");
        let value = value.strip_prefix(' ').unwrap_or(value);
        match field {
            "event" => event.name = value.to_owned(),
            "id" => event.id = Some(value.parse().expect("a revision")),
            "retry" => event.retry = true,
            "data" => {
                assert!(event.data.is_null(), "one line of data: {block}");
                event.data = serde_json::from_str(value).expect("JSON");
            }
            "" => {}
            _ => panic!("{block}"),
        }
    }
    event
}
