//! HTTP: routes, extraction, problem responses, OpenAPI.
