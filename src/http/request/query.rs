//! Query parameters. Each is defined once, as a [`Param`]: the reader, the words of a refusal and the
//! entry in the OpenAPI document all come from the definition.
//!
//! [`query!`] puts parameters together to the query of a route. It is an extractor that refuses any
//! other parameter, and the same type describes the route. serde's `Query` would name neither the
//! parameter that is wrong nor all that are accepted.

use std::time::Duration;

use axum::extract::{FromRequestParts, Path, Query};
use axum::http::request::Parts;
use utoipa::openapi::path::{Parameter, ParameterBuilder, ParameterIn};
use utoipa::openapi::schema::{KnownFormat, SchemaFormat, SchemaType, Type};
use utoipa::openapi::{ObjectBuilder, Ref, RefOr, Required, Schema};

use crate::http::response::error::Error;
use crate::wire::JobState;

/// Most items of one page of a list.
pub const MAX_LIMIT: u32 = 1000;
/// Items of a page when the client does not say.
pub const DEFAULT_LIMIT: u32 = 50;
/// The longest that a client may let its answer wait, in seconds.
const MAX_WAIT_S: f64 = 60.0;

/// A query parameter whose value is a `T`.
pub struct Param<T> {
    pub name: &'static str,
    /// For the OpenAPI document.
    pub description: &'static str,
    /// What a value must be, as a refusal says it after "must be".
    pub expected: &'static str,
    pub parse: fn(&str) -> Option<T>,
    pub schema: fn() -> RefOr<Schema>,
}

impl<T> Param<T> {
    /// Returns the value of the parameter, or the refusal of one that cannot be used.
    pub fn read(&self, given: &Pairs) -> Result<Option<T>, Error> {
        let Some(text) = given.get(self.name) else {
            return Ok(None);
        };
        (self.parse)(text).map(Some).ok_or_else(|| {
            let detail = format!("must be {}", self.expected);
            Error::query(self.name, detail)
        })
    }

    /// Returns the entry of the parameter in the OpenAPI document.
    pub fn describe(&self) -> Parameter {
        ParameterBuilder::new()
            .name(self.name)
            .parameter_in(ParameterIn::Query)
            .required(Required::False)
            .description(Some(self.description))
            .schema(Some((self.schema)()))
            .build()
    }
}

/// The schema of any text.
pub fn text() -> RefOr<Schema> {
    ObjectBuilder::new()
        .schema_type(SchemaType::new(Type::String))
        .into()
}

/// The schema of a whole number within bounds.
pub fn whole_number(least: u32, most: u32) -> RefOr<Schema> {
    ObjectBuilder::new()
        .schema_type(SchemaType::new(Type::Integer))
        .format(Some(SchemaFormat::KnownFormat(KnownFormat::Int32)))
        .minimum(Some(least))
        .maximum(Some(most))
        .into()
}

/// The schema of a number within bounds.
pub fn number(least: f64, most: f64) -> RefOr<Schema> {
    ObjectBuilder::new()
        .schema_type(SchemaType::new(Type::Number))
        .format(Some(SchemaFormat::KnownFormat(KnownFormat::Double)))
        .minimum(Some(least))
        .maximum(Some(most))
        .into()
}

/// The schema of one of some words.
pub fn one_of(words: &[&str]) -> RefOr<Schema> {
    ObjectBuilder::new()
        .schema_type(SchemaType::new(Type::String))
        .enum_values(Some(words.iter().copied()))
        .into()
}

/// The schema `name` among the components of the document.
pub fn component(name: &str) -> RefOr<Schema> {
    Ref::from_schema_name(name).into()
}

/// The most items in one page of a list.
pub const LIMIT: Param<u32> = Param {
    name: "limit",
    description: "Most items of one page; default 50",
    expected: "a whole number from 1 to 1000",
    parse: |text| {
        let limit = text.parse().ok()?;
        (1..=MAX_LIMIT).contains(&limit).then_some(limit)
    },
    schema: || whole_number(1, MAX_LIMIT),
};

/// The position at which the next page of a list begins.
pub const CURSOR: Param<String> = Param {
    name: "cursor",
    description: "The `next_cursor` of the page before this one",
    expected: "a next_cursor of this list",
    parse: |text| Some(text.to_owned()),
    schema: text,
};

/// The state of the jobs in a list.
pub const STATE: Param<JobState> = Param {
    name: "state",
    description: "Only jobs in this state",
    expected: "queued, running, succeeded, failed or cancelled",
    parse: JobState::named,
    schema: || component("JobState"),
};

/// How long the answer may wait for the end of a job or a batch.
pub const WAIT: Param<Duration> = Param {
    name: "wait",
    description: "The longest that the answer may wait for the end, in seconds; default 0",
    expected: "a number of seconds from 0 to 60",
    parse: |text| {
        let seconds = text.parse().ok()?;
        let is_allowed = (0.0..=MAX_WAIT_S).contains(&seconds);
        is_allowed.then(|| Duration::from_secs_f64(seconds))
    },
    schema: || number(0.0, MAX_WAIT_S),
};

/// Defines the query of a route as a struct with one optional field for each parameter. The struct
/// extracts itself from a request and describes itself to utoipa.
macro_rules! query {
    ($(#[$doc:meta])* $vis:vis struct $name:ident { $($field:ident: $kind:ty = $param:expr),* $(,)? }) => {
        $(#[$doc])*
        $vis struct $name {
            $(pub $field: Option<$kind>,)*
        }

        impl utoipa::IntoParams for $name {
            fn into_params(
                _: impl Fn() -> Option<utoipa::openapi::path::ParameterIn>,
            ) -> Vec<utoipa::openapi::path::Parameter> {
                vec![$($param.describe(),)*]
            }
        }

        impl<S: Send + Sync> axum::extract::FromRequestParts<S> for $name {
            type Rejection = crate::http::response::error::Error;

            async fn from_request_parts(
                parts: &mut axum::http::request::Parts,
                _: &S,
            ) -> Result<Self, Self::Rejection> {
                let given = $crate::http::request::query::Pairs::of(parts)?;
                given.only(&[$($param.name,)*])?;
                Ok(Self { $($field: $param.read(&given)?,)* })
            }
        }
    };
}
pub(crate) use query;

query! {
    /// The query of a route without parameters.
    pub struct NoQuery {}
}

query! {
    /// Which page of a list.
    pub struct PageQuery { limit: u32 = LIMIT, cursor: String = CURSOR }
}

query! {
    /// How long to wait.
    pub struct WaitQuery { wait: Duration = WAIT }
}

/// The parameters of a request as they came, in their order.
pub struct Pairs(Vec<(String, String)>);

impl Pairs {
    /// Splits the query of a request into its parameters.
    pub fn of(parts: &Parts) -> Result<Self, Error> {
        Query::try_from_uri(&parts.uri)
            .map(|Query(pairs)| Self(pairs))
            .map_err(|_| Error::bad_request("the query string cannot be read"))
    }

    /// Refuses parameters that are not among `known` or are given twice.
    pub fn only(&self, known: &[&str]) -> Result<(), Error> {
        for (index, (name, _)) in self.0.iter().enumerate() {
            if !known.contains(&name.as_str()) {
                let accepted = match known {
                    [] => "this route accepts none".to_owned(),
                    known => format!("this route accepts {}", known.join(", ")),
                };
                return Err(Error::query(name, format!("unknown; {accepted}")));
            }
            if self.0[..index].iter().any(|(earlier, _)| earlier == name) {
                return Err(Error::query(name, "given more than once; give it once"));
            }
        }
        Ok(())
    }

    fn get(&self, name: &str) -> Option<&str> {
        let found = self.0.iter().find(|(given, _)| given == name);
        found.map(|(_, value)| value.as_str())
    }
}

impl<S: Send + Sync> FromRequestParts<S> for Pairs {
    type Rejection = Error;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Error> {
        Self::of(parts)
    }
}

/// The one variable segment of a path. A segment that cannot be a name is a name that does not exist: 404.
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
