//! What is wrong is refused with its code, or fails its job with its code; the service stays up, the
//! next job succeeds, and nothing is left on disk that no row names.

use std::io::Write;
use std::net::TcpStream;
use std::time::Duration;

use futures::stream;
use reqwest::multipart::{Form, Part};
use reqwest::{Body, RequestBuilder};
use serde_json::{Value, json};

use crate::app::{TestApp, problem};
use crate::meshes::{CUBE_OBJ, glb, parts, tetrahedron, tetrahedron_glb};

/// Bytes that the service of these tests takes.
const LIMIT: usize = 100_000;

async fn start() -> TestApp {
    TestApp::start(&["--max-upload", &LIMIT.to_string()]).await
}

/// The service works as ever, and keeps only what its rows name.
async fn assert_unharmed(app: &TestApp) {
    let jobs = app.json("/v1/jobs?limit=100").await["data"].as_array().unwrap().len();
    app.uploads_become(jobs).await;
    assert_eq!(app.get("/healthz").send().await.unwrap().status(), 200);
    let job = app.submit(tetrahedron_glb(), "").await;
    assert_eq!(app.over(&job).await["state"], "succeeded");
}

fn file() -> Part {
    Part::text(CUBE_OBJ).file_name("cube.obj")
}

/// A body without a declared length.
fn chunked(bytes: Vec<u8>) -> Body {
    let chunks: Vec<_> =
        bytes.chunks(10_000).map(|c| Ok::<_, std::io::Error>(c.to_vec())).collect();
    Body::wrap_stream(stream::iter(chunks))
}

/// An OBJ file that is over the limit.
fn large() -> Vec<u8> {
    "v 0 0 0\n".repeat(LIMIT / 4).into_bytes()
}

#[tokio::test]
async fn refused_uploads_leave_nothing() {
    let app = start().await;
    let jobs = || app.post("/v1/jobs");
    let form = |form: Form| jobs().multipart(form);
    let options =
        |text: &str| form(Form::new().part("file", file()).text("options", text.to_owned()));
    let typed = |name: &str| jobs().header("Content-Type", name).body(CUBE_OBJ);
    let requests: Vec<(&str, RequestBuilder, u16, &str)> = vec![
        ("empty body", jobs(), 400, "malformed_request"),
        ("empty file part", form(Form::new().text("file", "")), 400, "malformed_request"),
        ("no file part", form(Form::new().text("options", "{}")), 400, "malformed_request"),
        (
            "file twice",
            form(Form::new().part("file", file()).part("file", file())),
            400,
            "malformed_request",
        ),
        (
            "unknown part",
            form(Form::new().part("file", file()).text("mesh", "x")),
            400,
            "malformed_request",
        ),
        (
            "empty labels",
            form(Form::new().part("file", file()).text("labels", "")),
            400,
            "malformed_request",
        ),
        ("no boundary", typed("multipart/form-data"), 400, "malformed_request"),
        ("no form", typed("multipart/form-data; boundary=x"), 400, "malformed_request"),
        ("options not JSON", options("{padding: 4}"), 400, "malformed_request"),
        ("options not an object", options("[]"), 422, "invalid_option"),
        ("not a mesh", jobs().body("hello world"), 415, "unsupported_media_type"),
        ("a picture", jobs().body(&b"\x89PNG\r\n\x1a\n"[..]), 415, "unsupported_media_type"),
        ("not the type declared", typed("model/gltf-binary"), 415, "unsupported_media_type"),
        ("unknown model type", typed("model/stl"), 415, "unsupported_media_type"),
        ("JSON", typed("application/json"), 415, "unsupported_media_type"),
        (
            "not the type declared in the part",
            form(Form::new().part("file", file().mime_str("model/gltf-binary").unwrap())),
            415,
            "unsupported_media_type",
        ),
        ("over the limit", jobs().body(large()), 413, "upload_too_large"),
        ("over the limit, undeclared", jobs().body(chunked(large())), 413, "upload_too_large"),
        (
            "over the limit in a form",
            form(Form::new().part("file", Part::bytes(large()))),
            413,
            "upload_too_large",
        ),
        (
            "over the limit in a form, undeclared",
            form(Form::new().part("file", Part::stream(chunked(large())))),
            413,
            "upload_too_large",
        ),
        (
            "over the limit with the labels",
            form(Form::new().part("file", file()).part("labels", Part::bytes(vec![b'0'; LIMIT]))),
            413,
            "upload_too_large",
        ),
    ];
    for (name, request, status, code) in requests {
        println!("{name}");
        problem(request.send().await.unwrap(), status, code).await;
    }
    assert_unharmed(&app).await;
}

#[tokio::test]
async fn every_wrong_option_is_named() {
    let app = start().await;
    let pointers = |body: &Value| -> Vec<String> {
        let errors = body["errors"].as_array().unwrap();
        errors.iter().map(|e| e["pointer"].as_str().unwrap().to_owned()).collect()
    };
    for (options, want) in [
        (json!({"paddign": 4}), vec!["/paddign"]),
        (json!({"padding": "wide", "quality": "worst", "seed": 1}), vec!["/padding", "/quality"]),
        (json!({"padding": 65, "uv_channel": 8}), vec!["/uv_channel", "/padding"]),
        (json!({"steps": 1.5}), vec!["/steps"]),
        (json!({"max_charts": 0}), vec!["/max_charts"]),
    ] {
        let form = Form::new().part("file", file()).text("options", options.to_string());
        let response = app.post("/v1/jobs").multipart(form).send().await.unwrap();
        assert_eq!(pointers(&problem(response, 422, "invalid_option").await), want);
    }
    for (query, want) in [
        ("padding=wide&steps=3", vec!["/padding"]),
        ("no_such=1&steps=x", vec!["/no_such", "/steps"]),
        ("padding=1&padding=2", vec!["/padding"]),
        ("tag=a&tag=b", vec!["/tag"]),
    ] {
        let request = app.post(&format!("/v1/jobs?{query}")).body(CUBE_OBJ);
        let body = problem(request.send().await.unwrap(), 422, "invalid_option").await;
        assert_eq!(pointers(&body), want);
    }
    // A form has its options inside.
    let form = Form::new().part("file", file());
    let response = app.post("/v1/jobs?padding=4").multipart(form).send().await.unwrap();
    assert_eq!(pointers(&problem(response, 422, "invalid_option").await), ["/padding"]);
    assert_unharmed(&app).await;
}

#[tokio::test]
async fn a_broken_mesh_fails_its_job_alone() {
    let app = start().await;
    let (corners, triangles) = tetrahedron();
    let whole = tetrahedron_glb();
    let mut outside = triangles;
    outside[4] = 77;
    let mut not_a_number = corners;
    not_a_number[2][1] = f32::NAN;
    let edited = |edit: fn(&mut Value)| {
        let (mut document, binary) = parts(corners, triangles);
        edit(&mut document);
        glb(&document, &binary)
    };
    let of = |(document, binary): (Value, Vec<u8>)| glb(&document, &binary);
    for (name, mesh, code) in [
        ("truncated", whole[..whole.len() - 30].to_vec(), "invalid_mesh"),
        ("only a head", whole[..12].to_vec(), "invalid_mesh"),
        ("index out of range", of(parts(corners, outside)), "invalid_mesh"),
        ("NaN position", of(parts(not_a_number, triangles)), "invalid_mesh"),
        (
            "node cycle",
            edited(|d| d["nodes"] = json!([{"mesh": 0, "children": [1]}, {"children": [0]}])),
            "invalid_mesh",
        ),
        (
            "external URI",
            edited(|d| d["buffers"][0]["uri"] = "http://127.0.0.1/secret.bin".into()),
            "external_uri_forbidden",
        ),
        (
            "unknown required extension",
            edited(|d| {
                d["extensionsUsed"] = json!(["ACME_mesh"]);
                d["extensionsRequired"] = json!(["ACME_mesh"]);
            }),
            "unsupported_extension",
        ),
        (
            "huge count",
            edited(|d| d["accessors"][0]["count"] = (1u64 << 62).into()),
            "invalid_mesh",
        ),
        ("OBJ index out of range", b"v 0 0 0\nf 1 2 3\n".to_vec(), "invalid_mesh"),
        ("glTF that is no JSON", b"{\"asset\": ".to_vec(), "invalid_mesh"),
    ] {
        let job = app.submit(mesh, "").await;
        let over = app.over(&job).await;
        assert_eq!(
            (&over["state"], &over["error"]["code"]),
            (&"failed".into(), &code.into()),
            "{name}: {over}"
        );
        assert_eq!(over["attempt"], 1, "{name}: what is invalid is not tried again");
        let message = over["error"]["message"].as_str().unwrap();
        assert!(message.len() > 15, "{name}: {message:?} says what is wrong");
    }
    assert_unharmed(&app).await;
}

#[tokio::test]
async fn labels_of_a_wrong_count_fail_the_job() {
    let app = start().await;
    let form = Form::new()
        .part("file", file())
        .text("options", r#"{"segmentation": "labels"}"#)
        .text("labels", "0\n1\n");
    let response = app.post("/v1/jobs").multipart(form).send().await.unwrap();
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    let over = app.over(&job).await;
    assert_eq!(over["error"]["code"], "invalid_option", "{over}");
    let message = over["error"]["message"].as_str().unwrap();
    assert!(message.contains('2') && message.contains("12"), "{message:?} names both counts");
}

#[tokio::test]
async fn an_upload_that_breaks_off_leaves_nothing() {
    let app = start().await;
    let address = app.url.strip_prefix("http://").unwrap();
    for rest in [
        "Content-Length: 90000\r\n\r\nv 0 0 0\nv 1 0 0\n",
        "Transfer-Encoding: chunked\r\n\r\n10\r\nv 0 0 0\nv 1 0 0\n\r\n",
        "Content-Type: multipart/form-data; boundary=x\r\nContent-Length: 90000\r\n\r\n\
         --x\r\nContent-Disposition: form-data; name=\"file\"\r\n\r\nv 0 0 0\nv 1 0 0\n",
    ] {
        let mut socket = TcpStream::connect(address).unwrap();
        write!(socket, "POST /v1/jobs HTTP/1.1\r\nHost: x\r\n{rest}").unwrap();
        // The service has begun to store it.
        app.uploads_become(1).await;
        drop(socket);
        app.uploads_become(0).await;
    }
    assert_unharmed(&app).await;
}

#[tokio::test]
async fn a_full_queue_takes_nothing_more() {
    let app = TestApp::start(&["--workers", "0", "--max-queued", "1"]).await;
    app.submit(CUBE_OBJ, "").await;
    for _ in 0..3 {
        let response = app.post("/v1/jobs").body(CUBE_OBJ).send().await.unwrap();
        assert_eq!(response.headers()["retry-after"], "5");
        problem(response, 429, "queue_quota_exceeded").await;
    }
    tokio::time::sleep(Duration::from_millis(100)).await;
    assert_eq!(app.uploads().len(), 1);
}
