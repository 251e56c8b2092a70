//! What a client sends to have a mesh unwrapped: a multipart form or the bare mesh. Streams into
//! blobs that are under temporary names until the whole request is read and found right, so a refused
//! or broken upload leaves nothing behind.

mod form;
mod mesh;

use axum::extract::{Query, Request};
use axum::http::{HeaderMap, header};
use futures::StreamExt;

use self::mesh::Mesh;
use super::incoming::counted;
use super::{AppState, Problem};
use crate::contract::{ErrorCode, InputRole, Limits, MeshKind, OptionError, UnwrapOptions};
use crate::jobs::BlobWriter;

/// Characters of a tag.
const TAG: usize = 128;

/// A request that was read to its end and found right. Dropped, it leaves nothing behind.
pub struct Upload {
    /// The files, a mesh among them.
    pub inputs: Vec<Received>,
    /// What to do.
    pub options: UnwrapOptions,
    /// The client's word for it.
    pub tag: String,
}

/// A file that has come, and is not in place yet.
pub struct Received {
    /// What it is for.
    pub role: InputRole,
    /// Its name, as the client gave it, cut to 255 characters; empty where it gave none.
    pub name: String,
    /// What kind of file a mesh is.
    pub kind: Option<MeshKind>,
    /// The file.
    pub blob: BlobWriter,
}

impl Received {
    /// A mesh whose bytes have told its kind.
    fn mesh(name: String, (blob, kind): (BlobWriter, MeshKind)) -> Self {
        Self { role: InputRole::Mesh, name, kind: Some(kind), blob }
    }
}

impl Upload {
    /// Read a request.
    pub async fn receive(state: &AppState, request: Request) -> Result<Self, Problem> {
        let shape = Shape::of(request.headers())?;
        let (tag, pairs) = query(request.uri().query().unwrap_or_default())?;
        let mut upload = match shape {
            Shape::Form if !pairs.is_empty() => return Err(misplaced(&pairs)),
            Shape::Form => form::receive(state, request).await?,
            Shape::Mesh(declared) => bare(state, request, declared, &pairs).await?,
        };
        upload.tag = tag;
        upload.options = granted(upload.options, &state.limits);
        Ok(upload)
    }
}

async fn bare(
    state: &AppState,
    request: Request,
    declared: Option<MeshKind>,
    pairs: &[(String, String)],
) -> Result<Upload, Problem> {
    let pairs = pairs.iter().map(|(key, value)| (key.as_str(), value.as_str()));
    let options = UnwrapOptions::from_pairs(pairs).map_err(Problem::invalid_options)?;
    let (head, body) = request.into_parts();
    let mut body = counted(&head.headers, body, state.limits.upload_bytes)?;
    let mut mesh = Mesh::begin(&state.blobs, declared).await?;
    while let Some(chunk) = body.next().await {
        mesh.write(chunk?).await?;
    }
    let inputs = vec![Received::mesh(String::new(), mesh.end()?)];
    Ok(Upload { inputs, options, tag: String::new() })
}

/// How the `Content-Type` says that the mesh comes.
#[derive(Debug, PartialEq, Eq)]
enum Shape {
    /// As a part of a form.
    Form,
    /// As the body, of this kind if the type is one of a mesh.
    Mesh(Option<MeshKind>),
}

impl Shape {
    fn of(headers: &HeaderMap) -> Result<Self, Problem> {
        let value = headers.get(header::CONTENT_TYPE).map_or("", |v| v.to_str().unwrap_or("?"));
        match essence(value).as_str() {
            "multipart/form-data" => Ok(Self::Form),
            // The last is what curl says when it is told nothing.
            "" | "application/octet-stream" | "application/x-www-form-urlencoded" => {
                Ok(Self::Mesh(None))
            }
            other => kind_of(other).map(|kind| Self::Mesh(Some(kind))),
        }
    }
}

/// A media type without its parameters, in lower case.
fn essence(value: &str) -> String {
    value.split(';').next().unwrap_or_default().trim().to_ascii_lowercase()
}

/// The kind that a media type stands for.
fn kind_of(media_type: &str) -> Result<MeshKind, Problem> {
    MeshKind::of_media_type(media_type).ok_or_else(|| {
        let detail = format!(
            "Content-Type: {media_type:?} is not taken here; send multipart/form-data, or the mesh \
             itself as {} or application/octet-stream",
            MeshKind::all_media_types()
        );
        Problem::new(ErrorCode::UnsupportedMediaType, detail)
    })
}

/// Take the `tag` out of a query; the other pairs are options.
fn query(text: &str) -> Result<(String, Vec<(String, String)>), Problem> {
    let broken = |why: String| Problem::malformed(format!("The query cannot be read: {why}"));
    let uri = format!("/?{text}").parse().map_err(|_| broken("it is no query".into()))?;
    let Query(pairs) = Query::<Vec<(String, String)>>::try_from_uri(&uri)
        .map_err(|error| broken(error.body_text()))?;
    let (tags, options): (Vec<_>, Vec<_>) = pairs.into_iter().partition(|(key, _)| key == "tag");
    let plain = |tag: &str| tag.chars().count() <= TAG && !tag.chars().any(char::is_control);
    match &tags[..] {
        [] => Ok((String::new(), options)),
        [(_, tag)] if plain(tag) => Ok((tag.clone(), options)),
        _ => {
            let detail =
                format!("give it once, in at most {TAG} characters, none of them a control");
            Err(Problem::invalid_options(vec![OptionError { pointer: "/tag".into(), detail }]))
        }
    }
}

/// Options in the query of a form: they belong into its part.
fn misplaced(pairs: &[(String, String)]) -> Problem {
    let wrong = |(key, _): &(String, String)| OptionError {
        pointer: format!("/{key}"),
        detail: "with multipart/form-data, options belong into the part \"options\"".to_owned(),
    };
    Problem::invalid_options(pairs.iter().map(wrong).collect())
}

/// A job never gets more time or memory than the service grants.
pub fn granted(mut options: UnwrapOptions, limits: &Limits) -> UnwrapOptions {
    let most = limits.job_seconds as f64;
    options.budget_s = options.budget_s.map(|s| s.min(most));
    options.budget_mib = options.budget_mib.min(limits.job_mib);
    options
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(content_type: &str) -> HeaderMap {
        HeaderMap::from_iter([(header::CONTENT_TYPE, content_type.parse().unwrap())])
    }

    #[test]
    fn content_type_decides_the_shape() {
        assert_eq!(Shape::of(&HeaderMap::new()).unwrap(), Shape::Mesh(None));
        for (value, shape) in [
            ("multipart/form-data; boundary=x", Shape::Form),
            ("application/x-www-form-urlencoded", Shape::Mesh(None)),
            ("application/octet-stream", Shape::Mesh(None)),
            ("Model/OBJ; charset=utf-8", Shape::Mesh(Some(MeshKind::Obj))),
            ("model/gltf-binary", Shape::Mesh(Some(MeshKind::Glb))),
        ] {
            assert_eq!(Shape::of(&headers(value)).unwrap(), shape, "{value}");
        }
        for media_type in MeshKind::ALL.iter().flat_map(|kind| kind.media_types()) {
            assert!(matches!(Shape::of(&headers(media_type)).unwrap(), Shape::Mesh(Some(_))));
        }
        for value in ["application/json", "model/unheard-of", "text/plain"] {
            let problem = Shape::of(&headers(value)).unwrap_err();
            assert_eq!(problem.code(), ErrorCode::UnsupportedMediaType, "{value}");
        }
    }

    #[test]
    fn tag_is_no_option() {
        let (tag, options) = query("tag=a%20b&padding=4").unwrap();
        assert_eq!(tag, "a b");
        assert_eq!(options, [("padding".to_owned(), "4".to_owned())]);
        assert_eq!(query("").unwrap(), (String::new(), Vec::new()));
        for wrong in ["tag=a&tag=b", "tag=a%0Ab", &format!("tag={}", "x".repeat(TAG + 1))] {
            assert_eq!(query(wrong).unwrap_err().code(), ErrorCode::InvalidOption, "{wrong}");
        }
    }

    #[test]
    fn time_and_memory_are_cut_to_what_is_granted() {
        let limits = Limits { job_seconds: 30, ..Limits::default() };
        let asked = |budget_s| UnwrapOptions { budget_s, ..UnwrapOptions::default() };
        assert_eq!(granted(asked(None), &limits).budget_s, None);
        assert_eq!(granted(asked(Some(600.0)), &limits).budget_s, Some(30.0));
        assert_eq!(granted(asked(Some(5.0)), &limits).budget_s, Some(5.0));
        let greedy = UnwrapOptions { budget_mib: 1 << 20, ..UnwrapOptions::default() };
        assert_eq!(granted(greedy, &limits).budget_mib, limits.job_mib);
    }
}
