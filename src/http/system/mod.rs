//! The service itself: landing page, health, metrics, the page and the API explorer.

pub mod explorer;
mod landing;
pub mod metrics;
pub mod page;
pub mod status;
