//! What this service is and accepts, so that a client need not guess.

use axum::Json;
use axum::extract::State;
use serde::Serialize;
use utoipa::ToSchema;

use crate::contract::{Limits, MeshKind, UnwrapOptions};
use crate::http::docs::refusals;
use crate::http::upload::granted;
use crate::http::{AppState, Problem};
use crate::jobs::Worker;

/// What this service is and accepts.
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Info)]
pub struct InfoBody {
    /// Name of the program.
    pub name: &'static str,
    /// Version of the program.
    pub version: &'static str,
    /// The meshes that can be read.
    pub formats: Vec<MeshKind>,
    /// What is accepted at most.
    pub limits: Limits,
    /// The options of a job that is told nothing.
    pub default_options: UnwrapOptions,
    /// How busy the service is.
    pub queue: QueueBody,
    /// The workers that are alive, with the device each computes on.
    pub workers: Vec<Worker>,
}

/// How busy the service is.
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Queue)]
pub struct QueueBody {
    /// Jobs that wait.
    pub queued: u64,
    /// Jobs that run.
    pub running: u64,
}

refusals! { Refused: Internal }

/// What is this service, and what does it accept?
#[utoipa::path(
    get, path = "/v1/info", tag = "service", operation_id = "info",
    responses((status = 200, description = "What the service is and accepts", body = InfoBody), Refused),
)]
pub async fn info(State(state): State<AppState>) -> Result<Json<InfoBody>, Problem> {
    let stats = state.queue.stats().await?;
    Ok(Json(InfoBody {
        name: env!("CARGO_PKG_NAME"),
        version: env!("CARGO_PKG_VERSION"),
        formats: MeshKind::ALL.to_vec(),
        default_options: granted(UnwrapOptions::default(), &state.limits),
        limits: state.limits,
        queue: QueueBody { queued: stats.queued, running: stats.running },
        workers: stats.workers,
    }))
}
