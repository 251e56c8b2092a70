//! The OpenAPI document, made from the handlers and the types themselves, and Swagger UI to read it
//! with, from the program's own bytes.

use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock};

use axum::extract::Path;
use axum::http::header;
use axum::response::{Html, IntoResponse, Redirect, Response};
use utoipa::openapi::schema::AdditionalProperties;
use utoipa::openapi::{
    ContentBuilder, OpenApi as Document, Ref, RefOr, Response as ApiResponse, ResponseBuilder,
    Schema,
};
use utoipa::{OpenApi, ToSchema};
use utoipa_swagger_ui::Config;

use super::links::add_links;
use super::problem::MEDIA_TYPE;
use super::routes::ApiPaths;
use super::{Problem, ProblemBody};
use crate::contract::{ArtifactKind, ErrorCode, MeshKind, Metrics, UnwrapOptions};

/// The document's head. The operations come from [`ApiPaths`], the schemas from what they name.
#[derive(OpenApi)]
#[openapi(
    info(
        title = "UVSegNet",
        description = "UV unwrapping as a service: a mesh goes in; the same mesh comes back with UV charts whose \
            seams follow the object's parts, a certificate that the UVs are valid, and metrics.\n\nEvery error is \
            `application/problem+json` (RFC 9457). Every answer carries `X-Request-Id`.",
    ),
    tags(
        (name = "jobs", description = "Meshes to unwrap"),
        (name = "events", description = "What happens to jobs"),
        (name = "artifacts", description = "What jobs made"),
        (name = "service", description = "The service itself"),
    ),
    components(schemas(Metrics, ProblemBody)),
)]
struct ApiHead;

fn document() -> Document {
    let mut document = ApiHead::openapi();
    document.merge(ApiPaths::openapi());
    add_formats(&mut document);
    add_artifacts(&mut document);
    add_links(&mut document);
    document
}

/// The document as YAML.
pub fn openapi_yaml() -> Result<String, String> {
    document().to_yaml().map_err(|error| error.to_string())
}

/// A job's request takes every format of the table, under each of its media types.
fn add_formats(document: &mut Document) {
    let submit = document.paths.paths.get_mut("/v1/jobs").and_then(|path| path.post.as_mut());
    if let Some(RefOr::T(body)) = submit.and_then(|operation| operation.request_body.as_mut())
        && let Some(bytes) = body.content.get("application/octet-stream").cloned()
    {
        let types = MeshKind::ALL.iter().flat_map(|kind| kind.media_types());
        body.content.extend(types.map(|&media_type| (media_type.to_owned(), bytes.clone())));
    }
    let schemas = document.components.as_mut().map(|components| &mut components.schemas);
    let form = schemas.and_then(|schemas| schemas.get_mut(&*JobForm::name()));
    if let Some(RefOr::T(Schema::Object(form))) = form
        && let Some(RefOr::T(Schema::Object(file))) = form.properties.get_mut("file")
    {
        form.additional_properties = Some(Box::new(AdditionalProperties::FreeForm(false)));
        file.description = Some(format!("The mesh: {}.", MeshKind::inputs()));
    }
}

/// A file is answered under each media type of the table.
fn add_artifacts(document: &mut Document) {
    let path = document.paths.paths.get_mut("/v1/jobs/{id}/artifacts/{name}");
    let Some(fetch) = path.and_then(|path| path.get.as_mut()) else { return };
    for status in ["200", "206"] {
        if let Some(RefOr::T(answer)) = fetch.responses.responses.get_mut(status)
            && let Some(bytes) = answer.content.swap_remove("application/octet-stream")
        {
            let types = ArtifactKind::ALL.iter().map(|kind| kind.media_type().to_owned());
            answer.content.extend(types.map(|media_type| (media_type, bytes.clone())));
            // A range of it is no JSON.
            if status == "200" {
                let metrics = Ref::from_schema_name(Metrics::name());
                let metrics = ContentBuilder::new().schema(Some(metrics)).build();
                let media_type = ArtifactKind::Metrics.media_type().to_owned();
                answer.content.insert(media_type, metrics.into());
            }
        }
    }
}

/// A form with a mesh.
#[derive(ToSchema)]
#[allow(dead_code)]
pub struct JobForm {
    /// The mesh, in a format of the table: [`add_formats`].
    #[schema(value_type = String, format = Binary)]
    file: Vec<u8>,
    /// What to do; what is left out has its default.
    #[schema(value_type = UnwrapOptions, required = false)]
    options: Option<UnwrapOptions>,
    /// Part labels as text: one integer a line, line i is face i, -1 for unknown.
    #[schema(value_type = String, required = false, min_length = 1)]
    labels: Option<String>,
}

/// An event of a stream, by its fields.
#[derive(ToSchema)]
#[allow(dead_code)]
pub struct StreamEvent {
    /// A number, which `Last-Event-ID` takes to go on from here.
    #[schema(pattern = "^[0-9]+$")]
    id: String,
    /// `snapshot`, or the kind of the event.
    event: String,
    /// JSON: the job in a snapshot, else the fields of the event.
    #[schema(content_media_type = "application/json")]
    data: String,
}

/// A mesh or another file as it is.
#[derive(ToSchema)]
#[schema(value_type = String, format = Binary)]
#[allow(dead_code)]
pub struct FileBytes(Vec<u8>);

/// The error answers of an operation, one a status, from the table of codes.
pub fn refused(codes: &[ErrorCode]) -> BTreeMap<String, RefOr<ApiResponse>> {
    let mut by_status = BTreeMap::<u16, Vec<String>>::new();
    for code in codes {
        let line = format!("`{}`: {}", code.as_str(), code.title());
        by_status.entry(code.status()).or_default().push(line);
    }
    let answer = |lines: Vec<String>| {
        let schema = Ref::from_schema_name(ProblemBody::name());
        let content = ContentBuilder::new().schema(Some(schema)).build();
        ResponseBuilder::new().description(lines.join("\n\n")).content(MEDIA_TYPE, content).build()
    };
    by_status
        .into_iter()
        .map(|(status, lines)| (status.to_string(), answer(lines).into()))
        .collect()
}

/// `refusals! { Name: Code… }` makes the type that stands for these error answers in the document.
macro_rules! refusals {
    ($name:ident: $($code:ident)*) => {
        struct $name;
        impl utoipa::IntoResponses for $name {
            fn responses() -> std::collections::BTreeMap<
                String,
                utoipa::openapi::RefOr<utoipa::openapi::Response>,
            > {
                $crate::http::docs::refused(&[$($crate::contract::ErrorCode::$code),*])
            }
        }
    };
}
pub(in crate::http) use refusals;

/// `GET /openapi.yaml`
pub async fn yaml() -> Result<Response, Problem> {
    static YAML: LazyLock<Result<String, String>> = LazyLock::new(openapi_yaml);
    let text = YAML.as_ref().map_err(Problem::internal)?;
    Ok(([(header::CONTENT_TYPE, "application/yaml")], text.as_str()).into_response())
}

/// `GET /docs`: the page's own links are relative to the slash.
pub async fn redirect() -> Redirect {
    Redirect::permanent("/docs/")
}

/// `GET /docs/errors`: what each code means; a problem's `type` points here.
pub async fn errors() -> Response {
    let escape = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;");
    let entry = |code: &ErrorCode| {
        let (name, status) = (code.as_str(), code.status());
        let (title, meaning) = (escape(code.title()), escape(code.meaning()));
        format!("<h2 id=\"{name}\">{name}</h2>\n<p><b>{status} {title}.</b> {meaning}</p>\n")
    };
    let entries: String = ErrorCode::ALL.iter().map(entry).collect();
    let page = format!(
        "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>UVSegNet: error codes</title>\n\
         <h1>Error codes</h1>\n<p>They stand in <code>code</code> of every \
         <code>application/problem+json</code> answer and in <code>error.code</code> of a job that \
         failed.</p>\n{entries}</html>\n"
    );
    ([(header::CONTENT_SECURITY_POLICY, POLICY)], Html(page)).into_response()
}

/// `GET /docs/`
pub async fn index() -> Result<Response, Problem> {
    swagger("index.html")
}

/// `GET /docs/{file}`
pub async fn file(Path(file): Path<String>) -> Result<Response, Problem> {
    swagger(&file)
}

/// Nothing but this service is ever asked by the page.
const POLICY: &str = "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; frame-ancestors 'none'";

fn swagger(name: &str) -> Result<Response, Problem> {
    static CONFIG: LazyLock<Arc<Config<'static>>> = LazyLock::new(|| {
        // "none": no badge of a validator on the net.
        Arc::new(Config::from("/openapi.yaml").validator_url("none"))
    });
    let found = utoipa_swagger_ui::serve(name, CONFIG.clone()).map_err(Problem::internal)?;
    let Some(file) = found else {
        return Err(Problem::not_found(format_args!("The file {name:?} of the documentation")));
    };
    let headers = [
        (header::CONTENT_TYPE, file.content_type.as_str()),
        (header::CONTENT_SECURITY_POLICY, POLICY),
    ];
    Ok((headers, file.bytes.into_owned()).into_response())
}

#[cfg(test)]
mod tests {
    use utoipa::openapi::path::Parameter;

    use super::super::links::STEPS;
    use super::*;

    #[test]
    fn committed_document_is_what_the_code_says() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/openapi.yaml");
        let committed = std::fs::read_to_string(path).unwrap();
        let stale = committed != openapi_yaml().unwrap();
        assert!(
            !stale,
            "openapi.yaml is stale: run `cargo run --release -- openapi -o openapi.yaml`"
        );
    }

    #[tokio::test]
    async fn every_code_is_told_where_its_type_points() {
        let page = axum::body::to_bytes(errors().await.into_body(), 1 << 20).await.unwrap();
        let page = std::str::from_utf8(&page).unwrap();
        for code in ErrorCode::ALL {
            let name = code.as_str();
            assert!(page.contains(&format!("id=\"{name}\"")), "{name}");
        }
    }

    #[test]
    fn document_names_every_operation_and_no_other() {
        let document = document();
        let paths: Vec<_> = document.paths.paths.keys().cloned().collect();
        let mut want = vec![
            "/v1/jobs",
            "/v1/jobs/{id}",
            "/v1/jobs/{id}/cancel",
            "/v1/jobs/{id}/events",
            "/v1/jobs/{id}/artifacts",
            "/v1/jobs/{id}/artifacts/{name}",
            "/v1/events",
            "/v1/info",
            "/healthz",
            "/readyz",
        ];
        let mut paths: Vec<&str> = paths.iter().map(String::as_str).collect();
        paths.sort_unstable();
        want.sort_unstable();
        assert_eq!(paths, want);
    }

    #[test]
    fn a_request_may_be_of_every_format() {
        let document = document();
        let submit = document.paths.paths["/v1/jobs"].post.as_ref().unwrap();
        let Some(RefOr::T(body)) = &submit.request_body else { panic!("a body") };
        for media_type in MeshKind::ALL.iter().flat_map(|kind| kind.media_types()) {
            assert!(body.content.contains_key(*media_type), "{media_type} is missing");
        }
        assert!(openapi_yaml().unwrap().contains(&MeshKind::inputs()));
    }

    #[test]
    fn every_reference_has_its_schema() {
        let yaml = openapi_yaml().unwrap();
        let prefix = "#/components/schemas/";
        for line in yaml.lines().filter(|line| line.contains(prefix)) {
            let name = line.split(prefix).nth(1).unwrap().trim_end_matches(['\'', '"']);
            assert!(yaml.contains(&format!("\n    {name}:\n")), "{name} is missing");
        }
    }

    #[test]
    fn every_link_leads_to_an_operation_that_takes_what_it_brings() {
        let document = document();
        let operation = |id: &str| {
            let paths = document.paths.paths.values();
            let all = paths.flat_map(|path| [&path.get, &path.post, &path.delete]).flatten();
            all.into_iter().find(|operation| operation.operation_id.as_deref() == Some(id)).unwrap()
        };
        let mut links = 0;
        for step in STEPS {
            let answers = &operation(step.from).responses.responses;
            for status in step.statuses {
                let Some(RefOr::T(answer)) = answers.get(*status) else { panic!("{status}") };
                assert!(answer.links.contains_key(step.name), "{} {status}", step.from);
            }
            for (name, _) in step.parameters {
                let name = name.trim_start_matches("header.");
                let mut parameters = operation(step.to).parameters.iter().flatten();
                let taken = |p: &RefOr<Parameter>| matches!(p, RefOr::T(p) if p.name == name);
                assert!(parameters.any(taken), "{} does not take {name}", step.to);
                links += 1;
            }
        }
        assert!(links > 10);
    }

    #[test]
    fn swagger_ui_is_in_the_program() {
        for name in
            ["index.html", "swagger-ui.css", "swagger-ui-bundle.js", "swagger-initializer.js"]
        {
            assert_eq!(swagger(name).unwrap().status(), 200, "{name}");
        }
        assert_eq!(swagger("nothing").unwrap_err().code(), ErrorCode::NotFound);
    }
}
