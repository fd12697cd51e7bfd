//! How a setting is defined: its name, kind, range, default, unit and help, each once.
//!
//! [`super::table`] holds the definitions. Everything that knows about settings is derived from them: the
//! reader of JSON and its messages ([`super::check`]), form fields and flags ([`super::text`]), the text of
//! `--help` and of the reference ([`super::describe`]) and the OpenAPI schema ([`super::schema`]).

use serde_json::{Map, Value};
use utoipa::openapi::{RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

use super::checked::Checked;

/// One setting of a request, or one member of a setting that is an object.
#[derive(Clone, Copy)]
pub struct Setting {
    /// The name in JSON and forms; flags write `-` for `_`.
    pub name: &'static str,
    pub kind: Kind,
    pub default: Default,
    /// The unit, as it follows "in"; empty for what has none.
    pub unit: &'static str,
    /// What it means: one sentence for flags, and more behind it for those who read on.
    pub help: &'static str,
    /// An example in JSON; empty where the kind says enough.
    pub example: &'static str,
    pub scope: Scope,
}

/// Which requests take a setting.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Scope {
    /// What the quality of given contacts depends on: planning and evaluation take it.
    Quality,
    /// What else is computed for a grasp: planning and evaluation take it.
    Analysis,
    /// How grasps are searched: only planning takes it.
    Search,
    /// How a server treats the job: planning takes it, but a run without a server has no use for it.
    Job,
}

/// What a setting is when it is not given.
#[derive(Clone, Copy)]
pub enum Default {
    /// It has to be given.
    Required,
    /// It stays absent; the text says what then holds.
    Absent(&'static str),
    /// This JSON text.
    Value(&'static str),
    /// It follows from other settings. The function may leave it absent where the text says so.
    From {
        text: &'static str,
        of: fn(&Map<String, Value>) -> Option<Value>,
        may_be_absent: bool,
    },
}

/// Which JSON values a setting takes.
#[derive(Clone, Copy)]
pub enum Kind {
    /// A whole number from `min` to `max`, or 0 where `or_zero` allows that.
    Whole {
        min: u64,
        max: u64,
        or_zero: bool,
    },
    Number(Range),
    Boolean,
    /// One of some names.
    Choice(Choice),
    /// One of some names, or what the other kind takes; the schema is that of a type of its own.
    NameOr(Choice, &'static Kind),
    /// A text of at most so many characters that can be shown again as it is.
    Text {
        max_chars: usize,
    },
    /// A URL of at most so many bytes.
    Url {
        max_bytes: usize,
    },
    Vector(Vector),
    List(List),
    /// An object of which all members are known.
    Object(Object),
    /// An object with exactly one of these members.
    OneOf {
        name: &'static str,
        members: &'static [Setting],
    },
    /// The numbers of triangles of the mesh.
    Triangles {
        max: usize,
    },
    /// A [`ContactSpec`](crate::wire::ContactSpec).
    Contact,
    /// A [`Component`](crate::wire::Component).
    Component,
    /// A JSON document that is accepted as it is, because its request reads it by itself.
    Document,
}

/// Bounds of a number.
#[derive(Clone, Copy)]
pub struct Range {
    pub min: f64,
    /// Whether `min` itself is left out.
    pub above: bool,
    /// Infinite where there is no upper bound.
    pub max: f64,
}

/// Names to choose from.
#[derive(Clone, Copy)]
pub struct Choice {
    /// Each name with what it stands for.
    pub names: &'static [(&'static str, &'static str)],
    /// The name of the type in the OpenAPI description, and its schema.
    pub schema: fn() -> (String, RefOr<Schema>),
}

/// Some numbers from -1e12 to 1e12 in a list.
#[derive(Clone, Copy)]
pub struct Vector {
    pub length: usize,
    /// Whether it must have a direction, that is, not be zero.
    pub is_direction: bool,
    /// Whether a fault points at the component rather than at the vector.
    pub faults_by_component: bool,
    /// What its numbers are, as `[x, y, z]`.
    pub shape: &'static str,
}

/// A list of values of one kind.
#[derive(Clone, Copy)]
pub struct List {
    pub of: &'static Kind,
    pub min: usize,
    pub max: usize,
    /// What the values are, in the plural.
    pub what: &'static str,
}

/// An object of which all members are known.
#[derive(Clone, Copy)]
pub struct Object {
    /// The name of the type in the OpenAPI description.
    pub name: &'static str,
    pub help: &'static str,
    pub members: &'static [Setting],
    /// What must hold between members; called when all of them have been read.
    pub rules: fn(&mut Checked<'_>),
    /// Whether the OpenAPI description says that there are no other members.
    pub is_closed: bool,
}

/// The unit of lengths.
pub const MESH_UNIT: &str = "the mesh's unit";

/// Most contacts of a grasp.
pub const MAX_CONTACTS: usize = graspd_core::contact::MAX_CONTACTS;

/// The components of vectors, and lengths, are at most this large.
pub const MAX_COORDINATE: f64 = 1e12;

/// Least length of a vector that still has a direction to the last digit.
pub const MIN_DIRECTION: f64 = 1e-150;

impl Setting {
    /// A setting that may be left out and then is absent.
    pub const fn new(name: &'static str, kind: Kind, help: &'static str) -> Self {
        Self {
            name,
            kind,
            default: Default::Absent("none"),
            unit: "",
            help,
            example: "",
            scope: Scope::Search,
        }
    }

    pub const fn required(self) -> Self {
        Self {
            default: Default::Required,
            ..self
        }
    }

    /// What holds when it is absent.
    pub const fn absent(self, text: &'static str) -> Self {
        Self {
            default: Default::Absent(text),
            ..self
        }
    }

    /// A default, in JSON.
    pub const fn default(self, json: &'static str) -> Self {
        Self {
            default: Default::Value(json),
            ..self
        }
    }

    /// A default that follows from other settings.
    pub const fn default_from(
        self,
        text: &'static str,
        of: fn(&Map<String, Value>) -> Option<Value>,
    ) -> Self {
        let default = Default::From {
            text,
            of,
            may_be_absent: false,
        };
        Self { default, ..self }
    }

    /// A default that follows from other settings, which may also leave the setting absent.
    pub const fn default_if(
        self,
        text: &'static str,
        of: fn(&Map<String, Value>) -> Option<Value>,
    ) -> Self {
        let default = Default::From {
            text,
            of,
            may_be_absent: true,
        };
        Self { default, ..self }
    }

    pub const fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    pub const fn example(self, json: &'static str) -> Self {
        Self {
            example: json,
            ..self
        }
    }

    pub const fn scope(self, scope: Scope) -> Self {
        Self { scope, ..self }
    }
}

/// A whole number.
pub const fn whole(min: u64, max: u64) -> Kind {
    Kind::Whole {
        min,
        max,
        or_zero: false,
    }
}

/// A number from `min` to `max`.
pub const fn from(min: f64, max: f64) -> Kind {
    Kind::Number(Range {
        min,
        above: false,
        max,
    })
}

/// A number above `min`, up to `max`.
pub const fn above(min: f64, max: f64) -> Kind {
    Kind::Number(Range {
        min,
        above: true,
        max,
    })
}

/// One of the names of a type.
pub const fn choice<T: ToSchema>(names: &'static [(&'static str, &'static str)]) -> Kind {
    Kind::Choice(names_of::<T>(names))
}

/// One of the names of a type, or what `other` takes.
pub const fn name_or<T: ToSchema>(
    names: &'static [(&'static str, &'static str)],
    other: &'static Kind,
) -> Kind {
    Kind::NameOr(names_of::<T>(names), other)
}

const fn names_of<T: ToSchema>(names: &'static [(&'static str, &'static str)]) -> Choice {
    fn schema<T: ToSchema + PartialSchema>() -> (String, RefOr<Schema>) {
        (T::name().into_owned(), T::schema())
    }
    Choice {
        names,
        schema: schema::<T>,
    }
}

/// A point or a corner.
pub const POINT: Kind = Kind::Vector(Vector {
    length: 3,
    is_direction: false,
    faults_by_component: true,
    shape: "[x, y, z]",
});

/// A direction whose faults point at its components.
pub const NORMAL: Kind = Kind::Vector(Vector {
    length: 3,
    is_direction: true,
    faults_by_component: true,
    shape: "[x, y, z]",
});

/// A direction.
pub const DIRECTION: Kind = Kind::Vector(Vector {
    length: 3,
    is_direction: true,
    faults_by_component: false,
    shape: "[x, y, z]",
});

/// A force, and a torque about the centre of mass.
pub const WRENCH: Kind = Kind::Vector(Vector {
    length: 6,
    is_direction: true,
    faults_by_component: false,
    shape: "a force and a torque about the centre of mass, [fx, fy, fz, tx, ty, tz]",
});

impl Range {
    pub fn contains(&self, value: f64) -> bool {
        let is_high_enough = if self.above {
            value > self.min
        } else {
            value >= self.min
        };
        value.is_finite() && is_high_enough && value <= self.max
    }
}
