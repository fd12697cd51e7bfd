//! The OpenAPI description of settings.

use serde_json::Value;
use utoipa::ToSchema;
use utoipa::openapi::schema::{
    AdditionalProperties, ArrayBuilder, KnownFormat, OneOfBuilder, Schema, SchemaFormat,
    SchemaType, Type,
};
use utoipa::openapi::{ObjectBuilder, Ref, RefOr};

use super::definition::{Default, Kind, Object, Setting};
use super::describe::default_in_words;
use crate::wire::{Component, ContactSpec};

/// The schemas of types by their names.
pub type Schemas = Vec<(String, RefOr<Schema>)>;

/// An object with these settings. Those that a complete object always has are `required`.
pub fn object<'a>(settings: impl Iterator<Item = &'a Setting>) -> ObjectBuilder {
    settings.fold(ObjectBuilder::new(), |object, setting| {
        let object = object.property(setting.name, property(setting));
        match setting.is_always_there() {
            true => object.required(setting.name),
            false => object,
        }
    })
}

/// Adds the schemas of the types that these settings have.
pub fn add_types<'a>(settings: impl Iterator<Item = &'a Setting>, schemas: &mut Schemas) {
    for setting in settings {
        add_types_of(&setting.kind, schemas);
    }
}

fn add_types_of(kind: &Kind, schemas: &mut Schemas) {
    let mut add = |name: &str, schema| schemas.push((name.to_owned(), schema));
    match kind {
        Kind::Choice(choice) => schemas.push((choice.schema)()),
        // The names are those of a member of the object.
        Kind::NameOr(_, other @ Kind::Object(_)) => add_types_of(other, schemas),
        Kind::NameOr(choice, _) => schemas.push((choice.schema)()),
        Kind::List(list) => add_types_of(list.of, schemas),
        Kind::Object(inner) => {
            add(inner.name, object_of(inner));
            add_types(inner.members.iter(), schemas);
        }
        Kind::OneOf { name, members } => {
            add(name, one_of(name, members));
            add_types(members.iter(), schemas);
        }
        Kind::Contact => schemas.push(of_type::<ContactSpec>()),
        Kind::Component => schemas.push(of_type::<Component>()),
        _ => {}
    }
}

fn of_type<T: ToSchema>() -> (String, RefOr<Schema>) {
    (T::name().into_owned(), T::schema())
}

fn object_of(inner: &Object) -> RefOr<Schema> {
    let described = object(inner.members.iter()).description(Some(inner.help));
    match inner.is_closed {
        true => described.additional_properties(Some(AdditionalProperties::FreeForm(false))),
        false => described,
    }
    .into()
}

fn one_of(name: &str, members: &[Setting]) -> RefOr<Schema> {
    let kinds = members.iter().map(|member| {
        ObjectBuilder::new()
            .title(Some(title(member.name, name)))
            .description(Some(member.help))
            .property(member.name, property(member))
            .required(member.name)
    });
    kinds
        .fold(OneOfBuilder::new(), |all, kind| all.item(kind))
        .into()
}

/// `HalfSpaceRegion` for the member `half_space` of a `Region`.
fn title(member: &str, name: &str) -> String {
    let capital = |word: &str| {
        let (first, rest) = word.split_at(1.min(word.len()));
        first.to_ascii_uppercase() + rest
    };
    member.split('_').map(capital).collect::<String>() + name
}

impl Setting {
    fn is_always_there(&self) -> bool {
        match self.default {
            Default::Required | Default::Value(_) => true,
            Default::Absent(_) => false,
            Default::From { may_be_absent, .. } => !may_be_absent,
        }
    }

    /// The help with unit and default.
    pub fn description(&self) -> String {
        let mut text = self.help.to_owned();
        if !self.unit.is_empty() {
            text.push_str(&format!(" In {}.", self.unit));
        }
        if let Some(default) = default_in_words(self) {
            text.push_str(&format!(" Default: {default}."));
        }
        text
    }
}

/// The schema of one setting.
fn property(setting: &Setting) -> RefOr<Schema> {
    let description = setting.description();
    let example = || serde_json::from_str::<Value>(setting.example).ok();
    match schema_of(&setting.kind) {
        RefOr::Ref(mut reference) => {
            reference.description = description;
            reference.into()
        }
        RefOr::T(Schema::Object(mut object)) => {
            object.description = Some(description);
            object.example = example();
            Schema::Object(object).into()
        }
        RefOr::T(Schema::Array(mut array)) => {
            array.description = Some(description);
            array.example = example();
            Schema::Array(array).into()
        }
        other => other,
    }
}

fn schema_of(kind: &Kind) -> RefOr<Schema> {
    let of_type = |kind| ObjectBuilder::new().schema_type(SchemaType::new(kind));
    let known = |format| Some(SchemaFormat::KnownFormat(format));
    match kind {
        Kind::Whole { min, max, or_zero } => {
            let is_short = *max < 1_000_000_000;
            let format = if is_short {
                KnownFormat::Int32
            } else {
                KnownFormat::Int64
            };
            let min = if *or_zero { 0 } else { *min };
            of_type(Type::Integer)
                .format(known(format))
                .minimum(Some(min))
                .maximum((*max < u64::MAX).then_some(*max))
                .into()
        }
        Kind::Number(range) => of_type(Type::Number)
            .format(known(KnownFormat::Double))
            .minimum((!range.above).then_some(range.min))
            .exclusive_minimum(range.above.then_some(range.min))
            .maximum(range.max.is_finite().then_some(range.max))
            .into(),
        Kind::Boolean => of_type(Type::Boolean).into(),
        Kind::NameOr(_, Kind::Object(object)) => Ref::from_schema_name(object.name).into(),
        Kind::Choice(choice) | Kind::NameOr(choice, _) => {
            Ref::from_schema_name((choice.schema)().0).into()
        }
        Kind::Text { max_chars } => of_type(Type::String).max_length(Some(*max_chars)).into(),
        Kind::Url { max_bytes } => of_type(Type::String)
            .format(Some(SchemaFormat::Custom("uri".to_owned())))
            .max_length(Some(*max_bytes))
            .into(),
        Kind::Vector(_) => ArrayBuilder::new()
            .items(of_type(Type::Number).format(known(KnownFormat::Double)))
            .into(),
        Kind::List(list) => ArrayBuilder::new()
            .items(schema_of(list.of))
            .min_items((list.min > 0).then_some(list.min))
            .max_items(Some(list.max))
            .into(),
        Kind::Object(Object { name, .. }) | Kind::OneOf { name, .. } => {
            Ref::from_schema_name(*name).into()
        }
        Kind::Triangles { .. } => {
            let index = of_type(Type::Integer)
                .format(known(KnownFormat::Int32))
                .minimum(Some(0));
            ArrayBuilder::new().items(index).into()
        }
        Kind::Contact => Ref::from_schema_name("ContactSpec").into(),
        Kind::Component => Ref::from_schema_name("Component").into(),
        Kind::Document => ObjectBuilder::new().into(),
    }
}
