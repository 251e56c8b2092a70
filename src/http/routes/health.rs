//! Whether the service lives, and whether it can work: for whatever supervises it.

use axum::Json;
use axum::extract::State;
use serde::Serialize;
use utoipa::ToSchema;

use crate::contract::ErrorCode;
use crate::http::docs::refusals;
use crate::http::{AppState, Problem};

/// The service lives.
#[derive(Debug, Serialize, ToSchema)]
pub struct Health {
    /// Always `ok`.
    status: &'static str,
}

/// The service can work.
#[derive(Debug, Serialize, ToSchema)]
pub struct Readiness {
    /// Always `ready`.
    status: &'static str,
    /// Workers that can take a job.
    workers: usize,
}

/// Does the service live?
///
/// Asks nothing but the process itself.
#[utoipa::path(
    get, path = "/healthz", tag = "service", operation_id = "health",
    responses((status = 200, description = "It lives", body = Health)),
)]
pub async fn live() -> Json<Health> {
    Json(Health { status: "ok" })
}

refusals! { NotReady: Draining NoWorker Internal }

/// Can the service work?
///
/// False while it shuts down, and when no worker can compute.
#[utoipa::path(
    get, path = "/readyz", tag = "service", operation_id = "ready",
    responses((status = 200, description = "A worker can take a job", body = Readiness), NotReady),
)]
pub async fn ready(State(state): State<AppState>) -> Result<Json<Readiness>, Problem> {
    state.takes_new_work()?;
    match state.queue.stats().await?.workers_ready() {
        0 => {
            let detail = "No worker is alive that takes jobs; jobs wait in the queue until one is";
            Err(Problem::new(ErrorCode::NoWorker, detail))
        }
        workers => Ok(Json(Readiness { status: "ready", workers })),
    }
}
