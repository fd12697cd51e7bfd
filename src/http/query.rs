//! Query parameters, read strictly.

use std::time::Duration;

use axum::extract::{FromRequestParts, Path, Query};
use axum::http::request::Parts;

use super::error::Error;
use crate::wire::JobState;

/// Most items of one page of a list.
pub const MAX_LIMIT: u32 = 1000;
/// Items of a page when the client does not say.
pub const DEFAULT_LIMIT: u32 = 50;
/// Longest that a client may let its answer wait, in seconds.
const MAX_WAIT_S: f64 = 60.0;

/// The parameters of a request in their order, still to be taken one by one.
pub struct Parameters(Vec<(String, String)>);

impl<S: Send + Sync> FromRequestParts<S> for Parameters {
    type Rejection = Error;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Error> {
        Query::try_from_uri(&parts.uri)
            .map(|Query(pairs)| Self(pairs))
            .map_err(|_| Error::bad_request("the query string cannot be read"))
    }
}

impl Parameters {
    /// Refuses parameters that are not among `known` or come twice.
    pub fn only(self, known: &[&str]) -> Result<Self, Error> {
        for (index, (name, _)) in self.0.iter().enumerate() {
            if !known.contains(&name.as_str()) {
                let accepted = if known.is_empty() {
                    "none is accepted here".to_owned()
                } else {
                    format!("accepted are {}", known.join(", "))
                };
                return Err(Error::query(name, format!("unknown; {accepted}")));
            }
            if self.0[..index].iter().any(|(earlier, _)| earlier == name) {
                return Err(Error::query(name, "given more than once; give it once"));
            }
        }
        Ok(self)
    }

    /// The value of a parameter.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.0
            .iter()
            .find(|(given, _)| given == name)
            .map(|(_, value)| value.as_str())
    }

    /// The value of a parameter as `parse` understands it; `wanted` says what that is.
    pub fn parse<T>(
        &self,
        name: &str,
        wanted: &str,
        parse: impl FnOnce(&str) -> Option<T>,
    ) -> Result<Option<T>, Error> {
        self.get(name)
            .map(|text| {
                parse(text).ok_or_else(|| Error::query(name, format!("{wanted} is wanted")))
            })
            .transpose()
    }

    /// Items wanted in one page of a list.
    pub fn limit(&self) -> Result<u32, Error> {
        self.parse("limit", "a whole number from 1 to 1000", |text| {
            text.parse()
                .ok()
                .filter(|limit| (1..=MAX_LIMIT).contains(limit))
        })
        .map(|limit| limit.unwrap_or(DEFAULT_LIMIT))
    }

    /// The state that jobs are wanted in.
    pub fn state(&self) -> Result<Option<JobState>, Error> {
        let wanted = "queued, running, succeeded, failed or cancelled";
        self.parse("state", wanted, JobState::named)
    }

    /// How long the answer may wait for what is asked.
    pub fn wait(&self) -> Result<Duration, Error> {
        let seconds = self.parse("wait", "a number of seconds from 0 to 60", |text| {
            text.parse()
                .ok()
                .filter(|seconds| (0.0..=MAX_WAIT_S).contains(seconds))
        });
        seconds.map(|seconds| Duration::from_secs_f64(seconds.unwrap_or(0.0)))
    }
}

/// The one variable segment of a path. What cannot be a name is a name that does not exist: 404.
pub struct Name(pub String);

impl<S: Send + Sync> FromRequestParts<S> for Name {
    type Rejection = Error;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Error> {
        Path::<String>::from_request_parts(parts, state)
            .await
            .map(|Path(name)| Self(name))
            .map_err(|_| Error::not_found())
    }
}
