//! The API: HTTP in front of the queue. Handlers read and write [`jobs`](crate::jobs) and nothing
//! else; no mesh is parsed here (a worker does that), so no upload can harm the service.
//!
//! `edge` stands around everything, `routes` has one file a resource, and the files between are
//! one concern each: what an upload is, how a stream is framed, how a wait is kept.

mod body;
mod conditional;
mod docs;
mod edge;
mod incoming;
mod prefer;
mod problem;
mod routes;
mod sse;
mod state;
mod upload;
mod wait;

pub use body::{ArtifactBody, ArtifactList, EventBody, EventList, JobBody, JobList};
pub use docs::openapi_yaml;
pub use problem::{Problem, ProblemBody};
pub use routes::{InfoBody, QueueBody};
pub use state::AppState;

use std::io;
use std::time::Duration;

use axum::Router;
use tokio::net::TcpListener;

/// How long open requests may go on after the service was told to stop.
const DRAIN: Duration = Duration::from_secs(10);

/// The whole API as a service.
pub fn router(state: AppState) -> Router {
    edge::around(routes::all().with_state(state))
}

/// Answer on `listener` until `state.shutdown`. From then on event streams end, waits are cut short,
/// new jobs are refused (`draining`), and what is still open after ten seconds is dropped.
pub async fn serve(listener: TcpListener, state: AppState) -> io::Result<()> {
    let shutdown = state.shutdown.clone();
    let patience = {
        let shutdown = shutdown.clone();
        async move {
            shutdown.cancelled().await;
            tokio::time::sleep(DRAIN).await;
        }
    };
    let serve = axum::serve(listener, router(state))
        .with_graceful_shutdown(async move { shutdown.cancelled().await });
    tokio::select! {
        done = serve => done,
        () = patience => {
            tracing::warn!("some requests were still open and are dropped");
            Ok(())
        }
    }
}
