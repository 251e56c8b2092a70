//! What every request passes on its way in and out: a request id, a guard against panics, and the
//! writing of errors as `problem+json`, those of axum's own making included.

use std::any::Any;
use std::time::Instant;

use axum::Router;
use axum::extract::Request;
use axum::http::{HeaderMap, HeaderName, HeaderValue, header};
use axum::middleware::{Next, from_fn};
use axum::response::{IntoResponse, Response};
use tower_http::catch_panic::CatchPanicLayer;
use tracing::Instrument;

use super::problem::{MEDIA_TYPE, Problem};

/// Carries the id of a request; taken from the client where it gives a sane one.
pub const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");

/// Put the edge around `routes`.
pub fn around(routes: Router) -> Router {
    routes.layer(CatchPanicLayer::custom(panicked)).layer(from_fn(pass))
}

async fn pass(request: Request, next: Next) -> Response {
    let id = request_id(request.headers());
    let started = Instant::now();
    let span = tracing::info_span!("request", id = %id, method = %request.method(), path = request.uri().path());
    async {
        let mut response = finish(next.run(request).await, &id);
        if let Ok(value) = HeaderValue::from_str(&id) {
            response.headers_mut().insert(REQUEST_ID, value);
        }
        response
            .headers_mut()
            .insert(header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
        let ms = started.elapsed().as_millis() as u64;
        tracing::info!(status = response.status().as_u16(), ms, "answered");
        response
    }
    .instrument(span)
    .await
}

/// Write the problem that `response` carries or stands for; other answers pass unchanged.
fn finish(mut response: Response, id: &str) -> Response {
    if let Some(problem) = response.extensions_mut().remove::<Problem>() {
        return problem.render(id);
    }
    let status = response.status();
    let written = response.headers().get(header::CONTENT_TYPE).is_some_and(|v| v == MEDIA_TYPE);
    if written || !(status.is_client_error() || status.is_server_error()) {
        return response;
    }
    let mut problem = Problem::of_status(status);
    if let Some(allow) = response.headers_mut().remove(header::ALLOW) {
        problem = problem.with_header(header::ALLOW, allow);
    }
    problem.render(id)
}

fn panicked(panic: Box<dyn Any + Send + 'static>) -> Response {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
    Problem::internal(format_args!("a handler panicked: {text}")).into_response()
}

/// The client's id if it is short and plain, else a new one.
fn request_id(headers: &HeaderMap) -> String {
    let plain = |s: &&str| {
        (1..=128).contains(&s.len())
            && s.bytes().all(|b| b.is_ascii_alphanumeric() || b"-_.:".contains(&b))
    };
    let given = headers.get(REQUEST_ID).and_then(|v| v.to_str().ok()).filter(plain);
    given.map_or_else(|| format!("req_{}", uuid::Uuid::now_v7().simple()), str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::http::problem::ProblemBody;
    use axum::body::Body;
    use axum::routing::get;
    use tower::ServiceExt;

    async fn ask(method: &str, path: &str, id: Option<&str>) -> (Response, Option<ProblemBody>) {
        let boom = || async {
            if true {
                panic!("boom")
            }
        };
        let routes = Router::new().route("/boom", get(boom)).route("/ok", get(|| async { "fine" }));
        let mut request = Request::builder().method(method).uri(path);
        if let Some(id) = id {
            request = request.header(REQUEST_ID, id);
        }
        let response = around(routes).oneshot(request.body(Body::empty()).unwrap()).await.unwrap();
        let (parts, body) = response.into_parts();
        let bytes = axum::body::to_bytes(body, 1 << 16).await.unwrap();
        let problem = serde_json::from_slice(&bytes).ok();
        (Response::from_parts(parts, Body::from(bytes)), problem)
    }

    #[tokio::test]
    async fn errors_that_are_not_ours_are_problems_too() {
        for (method, path, status, code) in [
            ("GET", "/nowhere", 404, "not_found"),
            ("POST", "/ok", 405, "method_not_allowed"),
            ("GET", "/boom", 500, "internal"),
        ] {
            let (response, problem) = ask(method, path, None).await;
            let problem = problem.unwrap();
            assert_eq!(response.status(), status);
            assert_eq!(response.headers()[header::CONTENT_TYPE], MEDIA_TYPE);
            assert_eq!((problem.status, problem.code.as_str()), (status, code));
            assert_eq!(response.headers()[REQUEST_ID], problem.request_id.as_str());
            assert!(!problem.detail.contains("boom"), "the cause of a fault of ours stays here");
        }
        assert!(ask("POST", "/ok", None).await.0.headers().contains_key(header::ALLOW));
    }

    #[tokio::test]
    async fn request_id_is_kept_when_sane() {
        let id = |r: Response| r.headers()[REQUEST_ID].to_str().unwrap().to_owned();
        assert_eq!(id(ask("GET", "/ok", Some("a-1")).await.0), "a-1");
        assert!(id(ask("GET", "/ok", Some("a b")).await.0).starts_with("req_"));
        let long = "x".repeat(129);
        assert!(id(ask("GET", "/ok", Some(&long)).await.0).starts_with("req_"));
    }
}
