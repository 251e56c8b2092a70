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
mod links;
mod prefer;
mod problem;
mod routes;
mod sse;
mod state;
mod upload;
mod wait;

pub use body::{ArtifactBody, ArtifactList, EventBody, EventDataBody, EventList, JobBody, JobList};
pub use docs::openapi_yaml;
pub use problem::{Problem, ProblemBody};
pub use routes::{InfoBody, QueueBody};
pub use state::AppState;

use std::io;
use std::time::Duration;

use axum::Router;
use tokio::net::TcpListener;

/// How long open requests may go on after the close.
const PATIENCE: Duration = Duration::from_secs(10);

/// The whole API as a service.
pub fn router(state: AppState) -> Router {
    edge::around(routes::all().with_state(state))
}

/// Answer on `listener` until `state.closing`. While the service drains, new jobs are refused and
/// everything else goes on, so that a load balancer hears it and clients see their jobs end. At the
/// close event streams end, waits are cut short, and what is still open after ten seconds is dropped.
pub async fn serve(listener: TcpListener, state: AppState) -> io::Result<()> {
    let closing = state.closing.clone();
    let patience = {
        let closing = closing.clone();
        async move {
            closing.cancelled().await;
            tokio::time::sleep(PATIENCE).await;
        }
    };
    let serve = axum::serve(listener, router(state))
        .with_graceful_shutdown(async move { closing.cancelled().await });
    tokio::select! {
        done = serve => done,
        () = patience => {
            tracing::warn!("some requests were still open and are dropped");
            Ok(())
        }
    }
}
