//! The operations of the document.

use utoipa::openapi::OpenApi;
use utoipa::openapi::path::Operation;

/// Returns all operations, each with its path.
pub fn operations(api: &mut OpenApi) -> impl Iterator<Item = (&str, &mut Operation)> {
    api.paths.paths.iter_mut().flat_map(|(path, item)| {
        [&mut item.get, &mut item.post, &mut item.delete]
            .into_iter()
            .flatten()
            .map(|operation| (path.as_str(), operation))
    })
}
