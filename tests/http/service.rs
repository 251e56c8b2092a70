//! The service itself: what it tells of itself, unknown addresses, and how it ends.

use std::time::{Duration, Instant};

use reqwest::Method;
use serde_json::Value;

use crate::app::{EventStream, TestApp, problem};
use crate::meshes::CUBE_OBJ;

#[tokio::test]
async fn it_tells_what_it_is() {
    let app = TestApp::start(&["--max-upload", "5000"]).await;
    let end = Instant::now() + Duration::from_secs(60);
    while app.get("/readyz").send().await.unwrap().status() != 200 {
        assert!(Instant::now() < end, "no worker gets ready");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    assert_eq!(app.json("/readyz").await["workers"], 1);
    assert_eq!(app.json("/healthz").await["status"], "ok");
    let info = app.json("/v1/info").await;
    assert_eq!(info["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(info["limits"]["upload_bytes"], 5000);
    assert_eq!(info["default_options"]["page_size"], 1024);
    assert_eq!(info["formats"], serde_json::json!(["glb", "gltf", "obj"]));
    assert!(info["workers"][0]["device"].as_str().unwrap().contains("cpu"), "{info}");

    let yaml = app.get("/openapi.yaml").send().await.unwrap();
    assert_eq!(yaml.headers()["content-type"], "application/yaml");
    let committed = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/openapi.yaml"));
    assert!(yaml.text().await.unwrap() == committed.unwrap(), "openapi.yaml is stale");

    let docs = app.get("/docs").send().await.unwrap();
    assert_eq!((docs.status().as_u16(), docs.url().path()), (200, "/docs/"));
    let page = docs.text().await.unwrap();
    assert!(page.contains("swagger-ui") && !page.contains("//"), "nothing comes from elsewhere");
    let start = app.get("/docs/swagger-initializer.js").send().await.unwrap().text().await.unwrap();
    assert!(start.contains("/openapi.yaml"), "{start}");
}

#[tokio::test]
async fn every_error_is_a_problem() {
    let app = TestApp::start(&["--workers", "0"]).await;
    let unknown = "/v1/jobs/job_0190163d8694739baea5966c26f8ad91";
    for path in [
        "/",
        "/v2",
        "/v1/assets",
        "/v1/jobs/",
        "/v1/jobs/x",
        unknown,
        &format!("{unknown}/events"),
        &format!("{unknown}/artifacts"),
        &format!("{unknown}/artifacts/model.glb"),
        "/docs/nothing",
    ] {
        problem(app.get(path).send().await.unwrap(), 404, "not_found").await;
    }
    let cancel = app.post(&format!("{unknown}/cancel")).send().await.unwrap();
    problem(cancel, 404, "not_found").await;
    let delete = app.request(Method::DELETE, unknown).send().await.unwrap();
    problem(delete, 404, "not_found").await;
    for (method, path) in
        [(Method::PUT, "/v1/jobs"), (Method::POST, unknown), (Method::POST, "/healthz")]
    {
        let response = app.request(method, path).send().await.unwrap();
        assert!(response.headers().contains_key("allow"));
        problem(response, 405, "method_not_allowed").await;
    }
    problem(app.get("/readyz").send().await.unwrap(), 503, "no_worker").await;

    let named = app.get("/v1/jobs/x").header("X-Request-Id", "mine-1").send().await.unwrap();
    assert_eq!(problem(named, 404, "not_found").await["request_id"], "mine-1");
}

#[tokio::test]
async fn it_ends_its_streams_and_itself_when_told() {
    let mut app = TestApp::start(&["--workers", "0"]).await;
    let job = app.submit(CUBE_OBJ, "").await;
    let mut of_job = EventStream::open(app.get(&format!("{job}/events"))).await;
    let all = EventStream::open(app.get("/v1/events")).await;
    assert_eq!(of_job.next().await.unwrap().event, "snapshot");
    let poll = tokio::spawn(app.get(&job).header("Prefer", "wait=60").send());
    tokio::time::sleep(Duration::from_millis(200)).await;
    app.terminate();
    assert_eq!(of_job.next().await, None);
    assert_eq!(all.rest().await, []);
    let polled: Value = poll.await.unwrap().unwrap().json().await.unwrap();
    assert_eq!(polled["state"], "queued", "the wait was cut short");
    assert!(app.ended().await.success());
}

#[tokio::test]
async fn it_listens_to_strangers_only_when_told() {
    let refused = std::process::Command::new(env!("CARGO_BIN_EXE_uvsegnet"))
        .args(["serve", "--listen", "0.0.0.0:0", "--workers", "0", "--data"])
        .arg(tempfile::tempdir().unwrap().path())
        .output()
        .unwrap();
    assert!(!refused.status.success());
    assert!(String::from_utf8_lossy(&refused.stderr).contains("--insecure"));
}
