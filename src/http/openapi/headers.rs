//! Request headers that several routes read.

use utoipa::IntoParams;
use utoipa::openapi::Required;
use utoipa::openapi::path::{Parameter, ParameterBuilder, ParameterIn};
use utoipa::openapi::schema::{ObjectBuilder, SchemaType, Type};

/// The name of the header that makes a submission repeatable.
pub const IDEMPOTENCY_KEY: &str = "Idempotency-Key";

/// The header of a submission that may be sent again without being carried out twice.
pub struct IdempotencyKeyHeader;

impl IntoParams for IdempotencyKeyHeader {
    fn into_params(_: impl Fn() -> Option<ParameterIn>) -> Vec<Parameter> {
        let key = ObjectBuilder::new()
            .schema_type(SchemaType::new(Type::String))
            .min_length(Some(1))
            .max_length(Some(255));
        let header = ParameterBuilder::new()
            .name(IDEMPOTENCY_KEY)
            .parameter_in(ParameterIn::Header)
            .required(Required::False)
            .description(Some(
                "A key of the client's choice, such as a UUID: for 24 hours the same request under the same key \
                 submits nothing again but answers with what it submitted first",
            ))
            .schema(Some(key));
        vec![header.build()]
    }
}
