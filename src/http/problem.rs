//! Every error of the API as `application/problem+json` (RFC 9457,
//! <https://www.rfc-editor.org/rfc/rfc9457>). A [`Problem`] is made where the error happens; its
//! body is written once, at the edge (`edge.rs`), where the request id is known.

use axum::extract::rejection::QueryRejection;
use axum::http::{HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::{ErrorCode, OptionError};

/// Media type of every error.
pub const MEDIA_TYPE: &str = "application/problem+json";

/// Where the service itself tells the meaning of each code; the code is the fragment.
const TYPE_BASE: &str = "/docs/errors#";

/// An error on its way to the client. Handlers return `Result<_, Problem>`.
#[derive(Debug, Clone)]
pub struct Problem {
    code: ErrorCode,
    detail: String,
    errors: Vec<OptionError>,
    headers: Vec<(HeaderName, HeaderValue)>,
}

/// The body of an error.
#[derive(Debug, Clone, Serialize, Deserialize, ToSchema)]
#[schema(as = Problem)]
pub struct ProblemBody {
    /// Address of the description of this kind of problem.
    #[schema(example = "/docs/errors#not_found")]
    pub r#type: String,
    /// What kind of problem it is: the same sentence at every occurrence.
    pub title: String,
    /// The HTTP status.
    #[schema(minimum = 400, maximum = 599)]
    pub status: u16,
    /// What is wrong this time, where it is, and how to mend it.
    pub detail: String,
    /// The kind of problem, for machines.
    pub code: ErrorCode,
    /// The request, as the service's log knows it; also in the header `X-Request-Id`.
    pub request_id: String,
    /// Every option that is wrong, each with a JSON pointer; empty for other problems.
    pub errors: Vec<OptionError>,
}

impl Problem {
    /// A problem of this kind; `detail` says what is wrong, where, and how to mend it.
    pub fn new(code: ErrorCode, detail: impl Into<String>) -> Self {
        Self { code, detail: detail.into(), errors: Vec::new(), headers: Vec::new() }
    }

    /// A request that cannot be read.
    pub fn malformed(detail: impl Into<String>) -> Self {
        Self::new(ErrorCode::MalformedRequest, detail)
    }

    /// Options that are unknown or wrong, each by name.
    pub fn invalid_options(errors: Vec<OptionError>) -> Self {
        let named = |e: &OptionError| match e.pointer.as_str() {
            "" => e.detail.clone(),
            pointer => format!("{pointer}: {}", e.detail),
        };
        let detail = errors.iter().map(named).collect::<Vec<_>>().join("; ");
        Self { errors, ..Self::new(ErrorCode::InvalidOption, detail) }
    }

    /// Something that is not there.
    pub fn not_found(what: impl std::fmt::Display) -> Self {
        Self::new(ErrorCode::NotFound, format!("{what} is not known here"))
    }

    /// A fault of ours. The cause goes to the log, not to the client.
    pub fn internal(cause: impl std::fmt::Display) -> Self {
        tracing::error!(%cause, "internal error");
        Self::new(ErrorCode::Internal, "The request could not be answered; the log tells why")
    }

    /// The same with a header more.
    pub fn with_header(mut self, name: HeaderName, value: HeaderValue) -> Self {
        self.headers.push((name, value));
        self
    }

    /// The code.
    pub fn code(&self) -> ErrorCode {
        self.code
    }

    /// The problem behind an answer that some layer below made without us: an unknown path, a
    /// method that a path does not take, a body that axum could not read.
    pub fn of_status(status: StatusCode) -> Self {
        use ErrorCode as E;
        let (code, detail) = match status {
            StatusCode::NOT_FOUND => {
                (E::NotFound, "This address is not known here; /docs lists the ones that are")
            }
            StatusCode::METHOD_NOT_ALLOWED => {
                (E::MethodNotAllowed, "The header Allow lists the methods that this address takes")
            }
            StatusCode::PAYLOAD_TOO_LARGE => (E::UploadTooLarge, "The body is over the limit"),
            StatusCode::UNSUPPORTED_MEDIA_TYPE => {
                (E::UnsupportedMediaType, "This address does not take that Content-Type")
            }
            status if status.is_client_error() => {
                (E::MalformedRequest, "The request cannot be read")
            }
            _ => (E::Internal, "The request could not be answered; the log tells why"),
        };
        Self::new(code, detail)
    }

    /// The finished answer, with the id of its request.
    pub fn render(self, request_id: &str) -> Response {
        let status =
            StatusCode::from_u16(self.code.status()).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let body = ProblemBody {
            r#type: format!("{TYPE_BASE}{}", self.code.as_str()),
            title: self.code.title().to_owned(),
            status: status.as_u16(),
            detail: self.detail,
            code: self.code,
            request_id: request_id.to_owned(),
            errors: self.errors,
        };
        let headers = [
            (header::CONTENT_TYPE, HeaderValue::from_static(MEDIA_TYPE)),
            (header::CACHE_CONTROL, HeaderValue::from_static("no-store")),
        ];
        let mut response = (status, axum::Json(body)).into_response();
        for (name, value) in headers.into_iter().chain(self.headers) {
            response.headers_mut().insert(name, value);
        }
        response
    }
}

impl From<QueryRejection> for Problem {
    fn from(error: QueryRejection) -> Self {
        Self::malformed(error.body_text())
    }
}

impl IntoResponse for Problem {
    /// An answer without a body that carries the problem to the edge, which writes it.
    fn into_response(self) -> Response {
        let status =
            StatusCode::from_u16(self.code.status()).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let mut response = status.into_response();
        response.extensions_mut().insert(self);
        response
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn body_has_every_member() {
        let errors = vec![OptionError { pointer: "/padding".into(), detail: "too wide".into() }];
        let response = Problem::invalid_options(errors).render("req_1");
        assert_eq!(response.status(), 422);
        assert_eq!(response.headers()[header::CONTENT_TYPE], MEDIA_TYPE);
        let bytes = axum::body::to_bytes(response.into_body(), 1 << 16).await.unwrap();
        let body: ProblemBody = serde_json::from_slice(&bytes).unwrap();
        assert_eq!(body.code, ErrorCode::InvalidOption);
        assert!(body.r#type.ends_with("#invalid_option"));
        assert_eq!(body.title, ErrorCode::InvalidOption.title());
        assert_eq!(body.detail, "/padding: too wide");
        assert_eq!((body.status, body.request_id.as_str()), (422, "req_1"));
        assert_eq!(body.errors[0].pointer, "/padding");
    }

    #[test]
    fn every_code_has_a_status_that_http_knows() {
        for &code in ErrorCode::ALL {
            let response = Problem::new(code, "x").into_response();
            assert_eq!(response.status().as_u16(), code.status());
        }
    }
}
