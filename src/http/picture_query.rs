//! What a query says of a picture.

use utoipa::{IntoParams, ToSchema};

use super::error::Error;
use super::query::Parameters;
use crate::picture::{self, Background, MAX_WIDTH, MIN_WIDTH, Options};

/// What a picture is shown on.
#[derive(ToSchema)]
#[schema(rename_all = "lowercase")]
#[allow(
    dead_code,
    reason = "only described; the query is read as a Background"
)]
pub enum Theme {
    Light,
    Dark,
}

/// How wide a picture is, and what it is shown on.
#[derive(IntoParams)]
#[into_params(parameter_in = Query)]
#[allow(dead_code, reason = "only described; the query is read as Options")]
pub struct PictureParameters {
    /// Width in pixels; default 1024. In SVG that of the body inside
    #[param(minimum = 64, maximum = 4096)]
    width: Option<u32>,
    /// Background; default `light`, in SVG what the reader prefers
    #[param(inline)]
    theme: Option<Theme>,
}

/// How a picture is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    Png,
    Svg,
}

impl Format {
    pub fn media_type(self) -> &'static str {
        match self {
            Self::Png => "image/png",
            Self::Svg => "image/svg+xml",
        }
    }

    /// What a picture is shown on when nobody says. Pixels are opaque, since nobody knows what they are shown on.
    fn background(self) -> Background {
        match self {
            Self::Png => Background::Light,
            Self::Svg => Background::Transparent,
        }
    }
}

/// Width and theme of a picture, and no other parameter.
pub fn options(query: Parameters, format: Format) -> Result<Options, Error> {
    of_query(&query.only(&["width", "theme"])?, format)
}

/// Width and theme of a picture.
pub fn of_query(query: &Parameters, format: Format) -> Result<Options, Error> {
    let width = query.parse("width", "a whole number from 64 to 4096", |text| {
        let width = text.parse().ok()?;
        (MIN_WIDTH..=MAX_WIDTH).contains(&width).then_some(width)
    })?;
    let theme = query.parse("theme", "light or dark", |text| match text {
        "light" => Some(Background::Light),
        "dark" => Some(Background::Dark),
        _ => None,
    })?;
    Ok(Options {
        width: width.unwrap_or(picture::DEFAULT_WIDTH),
        background: theme.unwrap_or(format.background()),
    })
}
