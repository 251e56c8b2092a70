//! Downloads: whole, in ranges, not at all when known, and gone after their time.

use reqwest::Method;
use serde_json::Value;
use sha2::{Digest, Sha256};

use crate::app::{TestApp, problem};
use crate::meshes::tetrahedron_glb;

#[tokio::test]
async fn artifacts_have_tags_and_ranges() {
    let app = TestApp::start(&[]).await;
    let job = app.submit(tetrahedron_glb(), "").await;
    let shown = app.over(&job).await;
    assert_eq!(shown["state"], "succeeded", "{shown}");
    let listed = app.json(&format!("{job}/artifacts")).await;
    assert_eq!(listed["data"], shown["artifacts"]);

    for artifact in listed["data"].as_array().unwrap() {
        let url = artifact["url"].as_str().unwrap();
        let response = app.get(url).send().await.unwrap();
        assert_eq!(response.status(), 200);
        let head = response.headers().clone();
        let bytes = response.bytes().await.unwrap();
        let sha256: String = Sha256::digest(&bytes).iter().map(|b| format!("{b:02x}")).collect();
        assert_eq!(artifact["sha256"], sha256);
        assert_eq!(artifact["bytes"], bytes.len());
        assert_eq!(head["etag"], format!("\"{sha256}\""), "a strong tag");
        assert_eq!(head["content-type"], artifact["media_type"].as_str().unwrap());
        assert_eq!(head["content-length"], bytes.len().to_string());
        assert_eq!(head["accept-ranges"], "bytes");
        assert_eq!(head["x-content-type-options"], "nosniff");

        let known = app.get(url).header("If-None-Match", &head["etag"]).send().await.unwrap();
        assert_eq!(known.status(), 304);
        let only_head = app.request(Method::HEAD, url).send().await.unwrap();
        assert_eq!(only_head.status(), 200);
        assert_eq!(only_head.headers()["content-length"], bytes.len().to_string());
        assert!(only_head.bytes().await.unwrap().is_empty());
    }
    for name in ["model.glb", "metrics.json", "uv_layout.svg", "preview.png"] {
        let named = |artifact: &&Value| artifact["name"] == name;
        assert_eq!(listed["data"].as_array().unwrap().iter().filter(named).count(), 1, "{name}");
    }

    let url = format!("{job}/artifacts/model.glb");
    let whole = app.get(&url).send().await.unwrap().bytes().await.unwrap();
    assert_eq!(&whole[..4], b"glTF");
    let length = whole.len();
    for (range, want) in [
        ("bytes=0-3".to_owned(), 0..4),
        (format!("bytes={}-", length - 5), length - 5..length),
        ("bytes=-7".to_owned(), length - 7..length),
        (format!("bytes=8-{}", length + 100), 8..length),
    ] {
        let part = app.get(&url).header("Range", &range).send().await.unwrap();
        assert_eq!(part.status(), 206, "{range}");
        let place = format!("bytes {}-{}/{length}", want.start, want.end - 1);
        assert_eq!(part.headers()["content-range"], place);
        assert_eq!(part.headers()["content-length"], want.len().to_string());
        assert_eq!(part.bytes().await.unwrap(), whole[want]);
    }
    let outside = app.get(&url).header("Range", format!("bytes={length}-")).send().await.unwrap();
    assert_eq!(outside.headers()["content-range"], format!("bytes */{length}"));
    problem(outside, 416, "range_not_satisfiable").await;
    // A range of a file that is another by now is the whole file.
    let stale = app.get(&url).header("Range", "bytes=0-3").header("If-Range", "\"old\"");
    assert_eq!(stale.send().await.unwrap().bytes().await.unwrap(), whole);

    let missing = app.get(&format!("{job}/artifacts/../x")).send().await.unwrap();
    problem(missing, 404, "not_found").await;
    let missing = app.get(&format!("{job}/artifacts/model.obj")).send().await.unwrap();
    let body = problem(missing, 404, "not_found").await;
    assert!(body["detail"].as_str().unwrap().contains("model.glb"), "it says what is there");
}

#[tokio::test]
async fn expired_artifacts_are_gone_and_the_job_stays() {
    let app = TestApp::start(&["--retention", "0"]).await;
    let job = app.submit(tetrahedron_glb(), "").await;
    assert_eq!(app.over(&job).await["state"], "succeeded");
    let gone = app.get(&format!("{job}/artifacts/model.glb")).send().await.unwrap();
    problem(gone, 410, "artifact_expired").await;
    let listed = app.json(&format!("{job}/artifacts")).await;
    assert!(listed["data"][0]["expires_at"].is_string());
    assert_eq!(app.json(&job).await["state"], "succeeded");
}
