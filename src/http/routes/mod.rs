//! The addresses of the API: one file a resource.

mod artifacts;
mod events;
mod health;
mod info;
mod jobs;

use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::routing::{get, post};

pub use info::{InfoBody, QueueBody};

use super::{AppState, docs};

/// Every address with its methods.
pub fn all() -> Router<AppState> {
    // An upload is counted by `incoming`, against a limit that is configured.
    let submit = post(jobs::submit).layer(DefaultBodyLimit::disable());
    Router::new()
        .route("/v1/jobs", get(jobs::list).merge(submit))
        .route("/v1/jobs/{id}", get(jobs::show).delete(jobs::delete))
        .route("/v1/jobs/{id}/cancel", post(jobs::cancel))
        .route("/v1/jobs/{id}/events", get(events::of_job))
        .route("/v1/jobs/{id}/artifacts", get(artifacts::list))
        .route("/v1/jobs/{id}/artifacts/{name}", get(artifacts::fetch))
        .route("/v1/events", get(events::of_all))
        .route("/v1/info", get(info::info))
        .route("/healthz", get(health::live))
        .route("/readyz", get(health::ready))
        .route("/openapi.yaml", get(docs::yaml))
        .route("/docs", get(docs::redirect))
        .route("/docs/", get(docs::index))
        .route("/docs/errors", get(docs::errors))
        .route("/docs/{file}", get(docs::file))
}

pub use paths::ApiPaths;

/// The operations, for the OpenAPI document.
mod paths {
    use super::{artifacts, events, health, info, jobs};

    /// Every documented operation, in the order of the document.
    #[derive(utoipa::OpenApi)]
    #[openapi(paths(
        jobs::submit,
        jobs::list,
        jobs::show,
        jobs::delete,
        jobs::cancel,
        events::of_job,
        artifacts::list,
        artifacts::fetch,
        events::of_all,
        info::info,
        health::live,
        health::ready,
    ))]
    pub struct ApiPaths;
}
