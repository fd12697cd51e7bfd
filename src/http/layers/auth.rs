//! Authentication by API key, and the rate limit of each client.
//!
//! Both stand in one layer because one depends on the other: the rate is counted per key where keys
//! are on, and per network where they are off; a flood of bad keys is counted per network in any case.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::num::NonZeroU32;
use std::sync::Arc;

use axum::extract::{ConnectInfo, FromRequestParts, Request, State};
use axum::http::HeaderMap;
use axum::http::header::AUTHORIZATION;
use axum::http::request::Parts;
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::client::{Client, client_network};
use super::rate_limit::{RATE_LIMIT, RateLimit};
use crate::http::response::error::Error;
use crate::jobs::{Owner, Service};

/// Bad keys that one network may send in a minute before it has to wait.
const BAD_KEYS: NonZeroU32 = NonZeroU32::new(20).expect("not zero");

/// Identifies the sender of a request and counts the request against its rate limit.
pub struct AuthLayer {
    service: Service,
    /// Whether an API key is required.
    keys: bool,
    requests: Option<RateLimit>,
    bad_keys: RateLimit,
}

/// On whose behalf a request is made.
#[derive(Debug, Clone)]
pub struct Caller(pub Owner);

impl<S: Send + Sync> FromRequestParts<S> for Caller {
    type Rejection = Error;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Error> {
        let caller = parts.extensions.get::<Self>().cloned();
        caller.ok_or_else(|| Error::internal("the route of this request has no AuthLayer"))
    }
}

impl AuthLayer {
    /// `rate_limit` is the most requests in a minute for each key or, where keys are off, each network.
    pub fn new(service: Service, keys: bool, rate_limit: Option<NonZeroU32>) -> Self {
        Self {
            service,
            keys,
            requests: rate_limit.map(|limit| RateLimit::new("requests", limit)),
            bad_keys: RateLimit::new("bad-keys", BAD_KEYS),
        }
    }

    /// Returns whom the request counts against, and who owns what it sends.
    async fn identify(
        &self,
        address: IpAddr,
        key: Option<String>,
    ) -> Result<(Client, Owner), Error> {
        let address = Client::Address(client_network(address));
        if !self.keys {
            return Ok((address, Owner::ANONYMOUS));
        }
        let Some(key) = key else {
            return Err(Error::unauthorized(
                "send an API key in the header Authorization: Bearer KEY",
            ));
        };
        match self.service.owner_of(&key).await? {
            Some(owner) => Ok((Client::Key(owner.clone()), owner)),
            None => Err(match self.bad_keys.count(&address) {
                Ok(_) => Error::unauthorized("this API key is unknown, expired or revoked"),
                Err(state) => {
                    Error::too_many("too many bad API keys came from this address", state)
                }
            }),
        }
    }
}

/// Passes on a request that may come in, with its [`Caller`] and, in the response, the state of its
/// rate limit; refuses any other with 401 or 429.
pub async fn authenticate(
    State(auth): State<Arc<AuthLayer>>,
    mut request: Request,
    next: Next,
) -> Response {
    let peer = request.extensions().get::<ConnectInfo<SocketAddr>>();
    let address = peer.map_or(Ipv4Addr::UNSPECIFIED.into(), |ConnectInfo(peer)| peer.ip());
    let key = bearer(request.headers()).map(str::to_owned);
    let (client, owner) = match auth.identify(address, key).await {
        Ok(known) => known,
        Err(refused) => return refused.into_response(),
    };
    let state = match auth.requests.as_ref().map(|limit| limit.count(&client)) {
        Some(Err(state)) => {
            return Error::too_many("too many requests; ask less often", state).into_response();
        }
        within => within.and_then(Result::ok),
    };
    request.extensions_mut().insert(Caller(owner));
    let mut response = next.run(request).await;
    // A refusal for a used-up quota carries the state of that quota instead.
    if let Some(state) = state
        && !response.headers().contains_key(RATE_LIMIT)
    {
        response.headers_mut().extend(state.headers());
    }
    response
}

/// The key in `Authorization: Bearer KEY`.
///
/// Not read by a crate of typed headers: those take the first of several such headers, and this
/// service refuses a request that carries two keys.
fn bearer(headers: &HeaderMap) -> Option<&str> {
    let mut lines = headers.get_all(AUTHORIZATION).iter();
    let (line, None) = (lines.next()?, lines.next()) else {
        return None;
    };
    let (scheme, key) = line.to_str().ok()?.split_once(' ')?;
    scheme.eq_ignore_ascii_case("bearer").then(|| key.trim())
}
