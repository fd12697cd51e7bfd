//! The query of an export.

use utoipa::openapi::path::Parameter as Described;

use crate::export::{Export, Options, Parameter};
use crate::http::request::query::{Pairs, Param, component, one_of, text, whole_number};
use crate::http::response::error::Error;
use crate::picture::{Background, MAX_WIDTH, MIN_WIDTH, Viewpoint};
use crate::wire::{Chosen, Units};

const GRASP: Param<Chosen> = Param {
    name: "grasp",
    description: "`best` (default), `initial`, or the number of one of the `top` grasps from 1 on",
    expected: Chosen::NAMES,
    parse: Chosen::named,
    schema: text,
};

const UNITS: Param<Units> = Param {
    name: "units",
    description: "Unit of the mesh, for a job that does not say",
    expected: Units::NAMES,
    parse: Units::named,
    schema: || component("Units"),
};

const VIEW: Param<Viewpoint> = Param {
    name: "view",
    description: "`both` (default): from the front, right and above, and from the opposite side; `iso`: the first of \
        these; `front`, `back`, `left`, `right`, `top`, `bottom`; or azimuth and elevation in degrees, such as `30,20`",
    expected: Viewpoint::NAMES,
    parse: Viewpoint::named,
    schema: text,
};

const LEGEND: Param<bool> = Param {
    name: "legend",
    description: "Whether the numbers and a legend stand below; default true. Without them the marks are larger",
    expected: "true or false",
    parse: |text| text.parse().ok(),
    schema: || {
        utoipa::openapi::ObjectBuilder::new()
            .schema_type(utoipa::openapi::schema::Type::Boolean)
            .into()
    },
};

const WIDTH: Param<u32> = Param {
    name: "width",
    description: "Width in pixels; default 1024. In SVG that of the image inside",
    expected: "a whole number from 64 to 4096",
    parse: |text| {
        let width = text.parse().ok()?;
        (MIN_WIDTH..=MAX_WIDTH).contains(&width).then_some(width)
    },
    schema: || whole_number(MIN_WIDTH, MAX_WIDTH),
};

const THEME: Param<Background> = Param {
    name: "theme",
    description: "Background; default `light`, in SVG what the reader prefers",
    expected: "light or dark",
    parse: |text| match text {
        "light" => Some(Background::Light),
        "dark" => Some(Background::Dark),
        _ => None,
    },
    schema: || one_of(&["light", "dark"]),
};

/// Reads the query of a request for `export`.
pub fn read(export: &Export, given: &Pairs) -> Result<Options, Error> {
    let names: Vec<&str> = export
        .parameters
        .iter()
        .map(|&parameter| name(parameter))
        .collect();
    given.only(&names)?;
    Ok(Options {
        grasp: GRASP.read(given)?.unwrap_or_default(),
        units: UNITS.read(given)?,
        view: VIEW.read(given)?.unwrap_or_default(),
        legend: LEGEND.read(given)?,
        width: WIDTH.read(given)?,
        theme: THEME.read(given)?,
    })
}

/// Returns the entry of a parameter in the OpenAPI document.
pub fn describe(parameter: Parameter) -> Described {
    match parameter {
        Parameter::Grasp => GRASP.describe(),
        Parameter::Units => UNITS.describe(),
        Parameter::View => VIEW.describe(),
        Parameter::Legend => LEGEND.describe(),
        Parameter::Width => WIDTH.describe(),
        Parameter::Theme => THEME.describe(),
    }
}

fn name(parameter: Parameter) -> &'static str {
    match parameter {
        Parameter::Grasp => GRASP.name,
        Parameter::Units => UNITS.name,
        Parameter::View => VIEW.name,
        Parameter::Legend => LEGEND.name,
        Parameter::Width => WIDTH.name,
        Parameter::Theme => THEME.name,
    }
}
