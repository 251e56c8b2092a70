//! Jobs: from submission to deletion, waits, lists.

use std::time::{Duration, Instant};

use reqwest::Method;
use reqwest::multipart::{Form, Part};
use serde_json::Value;

use crate::app::{TestApp, problem};
use crate::meshes::{CUBE_OBJ, ball_obj, tetrahedron_glb};

fn cube_form() -> Form {
    Form::new().part("file", Part::text(CUBE_OBJ).file_name("cube.obj"))
}

#[tokio::test]
async fn a_form_becomes_a_job_that_succeeds() {
    let app = TestApp::start(&[]).await;
    let form = cube_form()
        .text("options", r#"{"padding": 4, "segmentation": "labels"}"#)
        .text("labels", "0\n0\n0\n0\n1\n1\n1\n1\n1\n1\n1\n1\n");
    let response = app
        .post("/v1/jobs?tag=first")
        .header("Prefer", "wait=60")
        .multipart(form)
        .send()
        .await
        .unwrap();
    assert_eq!(response.status(), 200, "over within the wait");
    let location = response.headers()["location"].to_str().unwrap().to_owned();
    let job: Value = response.json().await.unwrap();
    assert_eq!(job["state"], "succeeded", "{job}");
    assert_eq!((&job["tag"], &job["attempt"]), (&"first".into(), &1.into()));
    assert_eq!(job["options"]["padding"], 4);
    assert_eq!(job["options"]["page_size"], 1024, "defaults are filled in");
    assert_eq!(job["error"], Value::Null);
    assert!(job["device"].as_str().unwrap().contains("cpu"));
    assert!(job["finished_at"].as_str().unwrap().ends_with('Z'), "RFC 3339 in UTC");
    assert_eq!(location, format!("/v1/jobs/{}", job["id"].as_str().unwrap()));

    // What it is now it stays: the same bytes, the same tag.
    let shown = app.get(&location).send().await.unwrap();
    let etag = shown.headers()["etag"].clone();
    assert_eq!(shown.json::<Value>().await.unwrap(), job);
    let again = app.get(&location).header("If-None-Match", etag.clone()).send().await.unwrap();
    assert_eq!(again.status(), 304);
    assert_eq!(again.headers()["etag"], etag);
    assert!(again.bytes().await.unwrap().is_empty());

    // One blob for the mesh, one for the labels; nothing stays after deletion.
    assert_eq!(app.uploads().len(), 2);
    assert_eq!(app.artifacts().len(), job["artifacts"].as_array().unwrap().len());
    let deleted = app.request(Method::DELETE, &location).send().await.unwrap();
    assert_eq!(deleted.status(), 204);
    assert!(app.uploads().is_empty() && app.artifacts().is_empty());
    problem(app.get(&location).send().await.unwrap(), 404, "not_found").await;
    problem(app.get(&format!("{location}/events")).send().await.unwrap(), 404, "not_found").await;
}

#[tokio::test]
async fn a_bare_mesh_becomes_a_job_whatever_it_is_called() {
    let app = TestApp::start(&[]).await;
    let glb = tetrahedron_glb();
    for (content_type, mesh) in [
        (Some("model/gltf-binary"), glb.clone()),
        (Some("application/octet-stream"), glb.clone()),
        (Some("application/x-www-form-urlencoded"), glb),
        (Some("model/obj"), CUBE_OBJ.into()),
        (None, CUBE_OBJ.into()),
    ] {
        let mut request = app.post("/v1/jobs?padding=3&quality=fast&seed=18446744073709551615");
        if let Some(value) = content_type {
            request = request.header("Content-Type", value);
        }
        let response = request.body(mesh).send().await.unwrap();
        assert_eq!(response.status(), 202, "{content_type:?}");
        assert_eq!(response.headers()["retry-after"], "1");
        let job: Value = response.json().await.unwrap();
        assert_eq!(job["options"]["padding"], 3);
        assert_eq!(job["options"]["seed"], "18446744073709551615", "kept exact");
        let location = format!("/v1/jobs/{}", job["id"].as_str().unwrap());
        assert_eq!(app.over(&location).await["state"], "succeeded", "{content_type:?}");
    }
}

#[tokio::test]
async fn a_long_poll_answers_when_the_job_changes() {
    let app = TestApp::start(&["--workers", "0"]).await;
    let job = app.submit(CUBE_OBJ, "").await;
    let etag = app.get(&job).send().await.unwrap().headers()["etag"].clone();
    let poll = |seconds: u32| {
        let wait = format!("wait={seconds}");
        app.get(&job).header("If-None-Match", etag.clone()).header("Prefer", wait).send()
    };

    let started = Instant::now();
    assert_eq!(poll(1).await.unwrap().status(), 304, "nothing happened");
    assert!(started.elapsed() >= Duration::from_secs(1), "it waited");

    let started = Instant::now();
    let cancel = async {
        tokio::time::sleep(Duration::from_millis(300)).await;
        app.post(&format!("{job}/cancel")).send().await.unwrap()
    };
    let (polled, canceled) = tokio::join!(poll(30), cancel);
    assert_eq!(canceled.status(), 200, "a job that waits is canceled at once");
    let polled = polled.unwrap();
    assert_eq!(polled.status(), 200);
    assert_eq!(polled.json::<Value>().await.unwrap()["state"], "canceled");
    assert!(started.elapsed() < Duration::from_secs(5), "it did not wait to the end");
}

#[tokio::test]
async fn lists_are_paged_from_the_newest_on() {
    let app = TestApp::start(&["--workers", "0"]).await;
    let mut submitted = Vec::new();
    for tag in ["a", "b", "a", "b", "a"] {
        let job = app.submit(CUBE_OBJ, &format!("tag={tag}")).await;
        submitted.push(job.rsplit('/').next().unwrap().to_owned());
    }
    let ids = |page: &Value| -> Vec<String> {
        let jobs = page["data"].as_array().unwrap();
        jobs.iter().map(|job| job["id"].as_str().unwrap().to_owned()).collect()
    };
    let newest: Vec<String> = submitted.iter().rev().cloned().collect();
    let whole = app.json("/v1/jobs").await;
    assert_eq!(ids(&whole), newest);
    assert_eq!(whole["next_cursor"], Value::Null);

    let (mut seen, mut cursor, mut pages) = (Vec::new(), String::new(), 0);
    loop {
        let page = app.json(&format!("/v1/jobs?limit=2{cursor}")).await;
        seen.extend(ids(&page));
        pages += 1;
        // What comes in between shifts nothing.
        app.submit(CUBE_OBJ, "").await;
        match page["next_cursor"].as_str() {
            Some(next) => cursor = format!("&cursor={next}"),
            None => break,
        }
    }
    assert_eq!((seen, pages), (newest, 3));

    assert_eq!(ids(&app.json("/v1/jobs?tag=b").await), [submitted[3].as_str(), &submitted[1]]);
    assert!(ids(&app.json("/v1/jobs?state=succeeded").await).is_empty());
    assert_eq!(ids(&app.json("/v1/jobs?state=queued&tag=a").await).len(), 3);
    for query in ["cursor=nonsense", "limit=0", "limit=101", "limit=x", "state=asleep", "what=1"] {
        let response = app.get(&format!("/v1/jobs?{query}")).send().await.unwrap();
        problem(response, 400, "malformed_request").await;
    }
}

#[tokio::test]
async fn a_job_that_is_not_over_is_not_deleted() {
    let app = TestApp::start(&["--workers", "0"]).await;
    let job = app.submit(CUBE_OBJ, "").await;
    problem(app.request(Method::DELETE, &job).send().await.unwrap(), 409, "job_not_terminal").await;
    for _ in 0..2 {
        let canceled = app.post(&format!("{job}/cancel")).send().await.unwrap();
        assert_eq!(canceled.status(), 200, "idempotent");
    }
    assert_eq!(app.request(Method::DELETE, &job).send().await.unwrap().status(), 204);
    assert!(app.uploads().is_empty());
}

#[tokio::test]
async fn a_running_job_is_canceled_within_two_seconds() {
    let app = TestApp::start(&[]).await;
    let job = app.submit(ball_obj(60), "steps=100000&quality=best&segmentation=authored").await;
    let end = Instant::now() + Duration::from_secs(60);
    while app.json(&job).await["state"] != "running" {
        assert!(Instant::now() < end, "no worker took the job");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    let canceled = app.post(&format!("{job}/cancel")).send().await.unwrap();
    let asked = Instant::now();
    assert_eq!(canceled.status(), 202);
    assert_eq!(canceled.json::<Value>().await.unwrap()["cancel_requested"], true);
    assert_eq!(app.over(&job).await["state"], "canceled");
    assert!(asked.elapsed() < Duration::from_secs(3), "it took {:?}", asked.elapsed());

    // The worker, or its successor, takes the next job.
    let next = app.submit(CUBE_OBJ, "").await;
    assert_eq!(app.over(&next).await["state"], "succeeded");
}
