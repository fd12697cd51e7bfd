//! The schemas of request bodies: settings with a mesh file or the id of an uploaded one.

use utoipa::openapi::schema::{
    AdditionalProperties, ArrayBuilder, KnownFormat, OneOfBuilder, Schema, SchemaFormat,
    SchemaType, Type,
};
use utoipa::openapi::{ObjectBuilder, Ref, RefOr};
use utoipa::{PartialSchema, ToSchema};

use crate::wire::settings::{SETTINGS, Scope, schema};
use crate::wire::{MAX_BATCH_JOBS, PlanRequestInput};
use graspd_core::effort::ExternalWrench;

/// Bytes of a file.
pub struct Binary;

impl PartialSchema for Binary {
    fn schema() -> RefOr<Schema> {
        ObjectBuilder::new()
            .schema_type(SchemaType::new(Type::String))
            .format(Some(SchemaFormat::KnownFormat(KnownFormat::Binary)))
            .into()
    }
}

impl ToSchema for Binary {
    fn name() -> std::borrow::Cow<'static, str> {
        "Binary".into()
    }
}

/// A form with a mesh file.
pub struct MeshForm;

impl PartialSchema for MeshForm {
    fn schema() -> RefOr<Schema> {
        ObjectBuilder::new()
            .property("mesh", Ref::from_schema_name("Binary"))
            .required("mesh")
            .into()
    }
}

impl ToSchema for MeshForm {
    fn name() -> std::borrow::Cow<'static, str> {
        "MeshForm".into()
    }
}

/// The settings of a job with the id of an uploaded mesh.
pub struct JobRequest;

impl PartialSchema for JobRequest {
    fn schema() -> RefOr<Schema> {
        let id = ObjectBuilder::new()
            .schema_type(SchemaType::new(Type::String))
            .description(Some("Id of the mesh, as its upload returned it."));
        settings_and("mesh_id", id)
    }
}

impl ToSchema for JobRequest {
    fn name() -> std::borrow::Cow<'static, str> {
        "JobRequest".into()
    }

    fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
        PlanRequestInput::schemas(schemas);
    }
}

/// A mesh file and the settings, each as a simple field or all in one JSON part `request`.
pub struct JobForm;

impl PartialSchema for JobForm {
    fn schema() -> RefOr<Schema> {
        let mut form = settings_and("mesh", Ref::from_schema_name("Binary"));
        if let RefOr::T(Schema::Object(object)) = &mut form {
            let all = Ref::from_schema_name("PlanRequestInput");
            object.properties.insert("request".to_owned(), all.into());
        }
        form
    }
}

impl ToSchema for JobForm {
    fn name() -> std::borrow::Cow<'static, str> {
        "JobForm".into()
    }

    fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
        PlanRequestInput::schemas(schemas);
        schemas.push((PlanRequestInput::name().into(), PlanRequestInput::schema()));
        schemas.push((Binary::name().into(), Binary::schema()));
    }
}

/// Many jobs: the same on each of some meshes, or each with its own settings.
pub struct BatchBody;

impl PartialSchema for BatchBody {
    fn schema() -> RefOr<Schema> {
        let id = ObjectBuilder::new().schema_type(SchemaType::new(Type::String));
        let meshes = jobs(
            id,
            "Ids of the meshes, as their uploads returned them; an id may be repeated.",
        );
        let requests = jobs(
            Ref::from_schema_name("JobRequest"),
            "The jobs, each with its mesh.",
        );
        let label = || {
            ObjectBuilder::new()
                .schema_type(SchemaType::new(Type::String))
                .max_length(Some(200))
                .description(Some(
                    "A name by which people recognise the batch, without control characters.",
                ))
        };
        let form = |name: &str, jobs: ArrayBuilder| {
            ObjectBuilder::new()
                .property(name, jobs)
                .required(name)
                .property("label", label())
                .additional_properties(Some(AdditionalProperties::FreeForm(false)))
        };
        let shared = Ref::from_schema_name("PlanRequestInput");
        OneOfBuilder::new()
            .item(form("meshes", meshes).property("request", shared))
            .item(form("requests", requests))
            .into()
    }
}

impl ToSchema for BatchBody {
    fn name() -> std::borrow::Cow<'static, str> {
        "BatchRequest".into()
    }

    fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
        JobRequest::schemas(schemas);
        schemas.push((PlanRequestInput::name().into(), PlanRequestInput::schema()));
        schemas.push((JobRequest::name().into(), JobRequest::schema()));
    }
}

fn jobs(of: impl Into<RefOr<Schema>>, description: &str) -> ArrayBuilder {
    ArrayBuilder::new()
        .items(of.into())
        .min_items(Some(1))
        .max_items(Some(MAX_BATCH_JOBS))
        .description(Some(description))
}

/// The settings of an evaluation with the id of an uploaded mesh.
pub struct EvaluationJson;

impl PartialSchema for EvaluationJson {
    fn schema() -> RefOr<Schema> {
        let id = ObjectBuilder::new()
            .schema_type(SchemaType::new(Type::String))
            .description(Some("Id of the mesh, as its upload returned it."));
        evaluation_and("mesh_id", id)
    }
}

impl ToSchema for EvaluationJson {
    fn name() -> std::borrow::Cow<'static, str> {
        "EvaluationRequest".into()
    }

    fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
        PlanRequestInput::schemas(schemas);
        schemas.push((ExternalWrench::name().into(), ExternalWrench::schema()));
    }
}

/// A mesh file, grasps and settings, each as a field or all but the file in one JSON part `request`.
pub struct EvaluationForm;

impl PartialSchema for EvaluationForm {
    fn schema() -> RefOr<Schema> {
        let mut form = evaluation_and("mesh", Ref::from_schema_name("Binary"));
        if let RefOr::T(Schema::Object(object)) = &mut form {
            let all = ObjectBuilder::new().description(Some(
                "Everything but the mesh as one JSON document, instead of the other fields.",
            ));
            object.properties.insert("request".to_owned(), all.into());
            object.required.retain(|name| name != "grasps");
        }
        form
    }
}

impl ToSchema for EvaluationForm {
    fn name() -> std::borrow::Cow<'static, str> {
        "EvaluationForm".into()
    }

    fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
        EvaluationJson::schemas(schemas);
        schemas.push((Binary::name().into(), Binary::schema()));
    }
}

/// Returns the schema of the grasps and settings of an evaluation with one more required field.
fn evaluation_and(name: &str, field: impl Into<RefOr<Schema>>) -> RefOr<Schema> {
    let grasp = ArrayBuilder::new()
        .items(Ref::from_schema_name("ContactSpec"))
        .min_items(Some(1))
        .max_items(Some(64));
    let grasps = ArrayBuilder::new()
        .items(grasp)
        .min_items(Some(1))
        .max_items(Some(10_000))
        .description(Some("The grasps, each a list of contacts."));
    let wrench = || Ref::from_schema_name("ExternalWrench");
    let wrenches = ArrayBuilder::new().items(wrench()).max_items(Some(16));
    let settings = SETTINGS.iter();
    let settings = settings.filter(|s| matches!(s.scope, Scope::Quality | Scope::Analysis));
    let mut object = schema::object(settings)
        .property("grasps", grasps)
        .property("external_wrench", wrench())
        .property("external_wrenches", wrenches)
        .property(name, field)
        .additional_properties(Some(AdditionalProperties::FreeForm(false)))
        .build();
    object.required = vec!["grasps".to_owned(), name.to_owned()];
    Schema::Object(object).into()
}

/// Returns the schema of the settings with one more required field.
fn settings_and(name: &str, field: impl Into<RefOr<Schema>>) -> RefOr<Schema> {
    let mut schema = PlanRequestInput::schema();
    if let RefOr::T(Schema::Object(object)) = &mut schema {
        object.description = None;
        object.properties.insert(name.to_owned(), field.into());
        object.required.push(name.to_owned());
    }
    schema
}
