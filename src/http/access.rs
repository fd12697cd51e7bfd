//! Who may come in: API keys, and how often each client may ask.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::num::NonZeroU32;
use std::sync::Arc;

use axum::extract::{ConnectInfo, FromRequestParts, Request, State};
use axum::http::HeaderMap;
use axum::http::header::AUTHORIZATION;
use axum::http::request::Parts;
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::connections::household;
use super::error::Error;
use super::rate::{RATE_LIMIT, Rate};
use crate::jobs::{Owner, Service};

/// Bad keys a minute from one address after which it is told to wait.
const BAD_KEYS: NonZeroU32 = NonZeroU32::new(20).expect("not zero");

/// Who is counted.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Client {
    Key(Owner),
    Address(IpAddr),
}

/// What stands before everything that is someone's.
pub struct Gate {
    service: Service,
    /// Whether a key is wanted.
    keys: bool,
    requests: Option<Rate>,
    bad_keys: Rate,
}

/// On whose behalf a request is made.
#[derive(Debug, Clone)]
pub struct Caller(pub Owner);

impl<S: Send + Sync> FromRequestParts<S> for Caller {
    type Rejection = Error;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Error> {
        let caller = parts.extensions.get::<Self>().cloned();
        caller.ok_or_else(|| Error::internal("a route without a gate before it"))
    }
}

impl Gate {
    /// `rate_limit` is the most requests a minute of each key or, without keys, each address.
    pub fn new(service: Service, keys: bool, rate_limit: Option<NonZeroU32>) -> Self {
        Self {
            service,
            keys,
            requests: rate_limit.map(|limit| Rate::new("requests", limit)),
            bad_keys: Rate::new("bad-keys", BAD_KEYS),
        }
    }

    /// The client of a request, and the owner of what it sends.
    async fn identify(
        &self,
        address: IpAddr,
        key: Option<String>,
    ) -> Result<(Client, Owner), Error> {
        let address = Client::Address(household(address));
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
            None => Err(match self.bad_keys.take(&address) {
                Ok(_) => Error::unauthorized("this API key is unknown, expired or revoked"),
                Err(standing) => {
                    Error::too_many("too many bad API keys came from this address", standing)
                }
            }),
        }
    }
}

/// Lets a request in that may come in, with its [`Caller`].
pub async fn admit(State(gate): State<Arc<Gate>>, mut request: Request, next: Next) -> Response {
    let peer = request.extensions().get::<ConnectInfo<SocketAddr>>();
    let address = peer.map_or(Ipv4Addr::UNSPECIFIED.into(), |ConnectInfo(peer)| peer.ip());
    let key = bearer(request.headers()).map(str::to_owned);
    let (client, owner) = match gate.identify(address, key).await {
        Ok(known) => known,
        Err(refused) => return refused.into_response(),
    };
    let standing = match gate.requests.as_ref().map(|rate| rate.take(&client)) {
        Some(Err(standing)) => {
            return Error::too_many("too many requests; ask less often", standing).into_response();
        }
        within => within.and_then(Result::ok),
    };
    request.extensions_mut().insert(Caller(owner));
    let mut response = next.run(request).await;
    // A refusal may tell of what was used up instead.
    if let Some(standing) = standing
        && !response.headers().contains_key(RATE_LIMIT)
    {
        response.headers_mut().extend(standing.headers());
    }
    response
}

/// The key in `Authorization: Bearer KEY`.
fn bearer(headers: &HeaderMap) -> Option<&str> {
    let mut lines = headers.get_all(AUTHORIZATION).iter();
    let (line, None) = (lines.next()?, lines.next()) else {
        return None;
    };
    let (scheme, key) = line.to_str().ok()?.split_once(' ')?;
    scheme.eq_ignore_ascii_case("bearer").then(|| key.trim())
}
