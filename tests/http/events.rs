//! Event streams: nothing lost, nothing repeated.

use std::time::Duration;

use reqwest::StatusCode;
use serde_json::Value;

use crate::app::{EventStream, StreamEvent, TestApp, problem};
use crate::meshes::CUBE_OBJ;

#[tokio::test]
async fn a_stream_goes_from_the_snapshot_to_the_end() {
    let app = TestApp::start(&[]).await;
    let job = app.submit(CUBE_OBJ, "").await;
    let mut stream = EventStream::open(app.get(&format!("{job}/events"))).await;
    let first = stream.block().await.unwrap();
    assert!(first.contains("retry: 2000\n") && first.contains("event: snapshot\n"), "{first}");
    let live = stream.rest().await;
    assert_eq!(live.last().unwrap().event, "succeeded", "and then the service closes");
    let id = job.rsplit('/').next().unwrap();
    assert!(live.iter().all(|event| event.data["job_id"] == id && event.data["at"].is_string()));

    // The same as a list: numbered 1, 2, 3, … without a gap.
    let listed = list(&app, &job, "").await;
    assert!(listed.iter().map(|event| event.id).eq(1..=listed.len() as u64));
    assert!(listed.ends_with(&live), "the stream was the end of the list");
    assert!(listed.iter().any(|event| event.event == "stage"));

    // From any place on it is the rest, in both forms.
    for after in [0, 1, listed.len() as u64 / 2, listed.len() as u64 - 1] {
        let rest = &listed[after as usize..];
        let resumed = app.get(&format!("{job}/events")).header("Last-Event-ID", after);
        assert_eq!(EventStream::open(resumed).await.rest().await, rest);
        let by_query = app.get(&format!("{job}/events?after={after}"));
        assert_eq!(EventStream::open(by_query).await.rest().await, rest);
        assert_eq!(list(&app, &job, &format!("?after={after}")).await, rest);
    }
    let past = app.get(&format!("{job}/events")).header("Last-Event-ID", listed.len());
    assert_eq!(past.send().await.unwrap().status(), StatusCode::NO_CONTENT);
    assert_eq!(list(&app, &job, &format!("?after={}", listed.len())).await, []);

    // Without a place: the snapshot holds it all, and its id is the last that it includes.
    let whole = EventStream::open(app.get(&format!("{job}/events"))).await.rest().await;
    assert_eq!(whole.len(), 1);
    assert_eq!((whole[0].event.as_str(), whole[0].id), ("snapshot", listed.len() as u64));
    assert_eq!(whole[0].data, app.json(&job).await);

    for wrong in ["x", "-1", "+1", "", "1000000000000000000"] {
        let request = app.get(&format!("{job}/events")).header("Last-Event-ID", wrong);
        problem(request.send().await.unwrap(), 400, "malformed_request").await;
        // Also where a header that is right overrules it.
        let request = app.get(&format!("{job}/events?after={wrong}")).header("Last-Event-ID", "0");
        problem(request.send().await.unwrap(), 400, "malformed_request").await;
    }
}

#[tokio::test]
async fn a_stream_that_breaks_off_is_taken_up_again() {
    let app = TestApp::start(&[]).await;
    let job = app.submit(CUBE_OBJ, "").await;
    // A reader that loses its connection after every event.
    let (mut seen, mut last) = (Vec::<StreamEvent>::new(), 0);
    loop {
        let request = app.get(&format!("{job}/events")).header("Last-Event-ID", last);
        let mut stream = EventStream::open(request).await;
        let event = stream.next().await.unwrap();
        last = event.id;
        let over = event.event == "succeeded";
        seen.push(event);
        if over {
            break;
        }
    }
    assert_eq!(seen, list(&app, &job, "").await);
}

#[tokio::test]
async fn one_stream_tells_of_all_jobs() {
    let app = TestApp::start(&[]).await;
    let before = app.submit(CUBE_OBJ, "").await;
    app.over(&before).await;
    let mut stream = EventStream::open(app.get("/v1/events")).await;
    let opening = stream.block().await.unwrap();
    let start = opening.lines().find_map(|line| line.strip_prefix("id: ")).unwrap().to_owned();
    assert!(opening.contains("retry: 2000\n") && !opening.contains("data:"), "{opening}");

    let jobs = [app.submit(CUBE_OBJ, "").await, app.submit(CUBE_OBJ, "").await];
    let (mut live, mut over) = (Vec::new(), 0);
    while over < jobs.len() {
        let event = stream.next().await.unwrap();
        over += usize::from(event.event == "succeeded");
        live.push(event);
    }
    for job in &jobs {
        let id = job.rsplit('/').next().unwrap();
        let of_job = |events: &[StreamEvent]| -> Vec<(String, Value)> {
            let mine = events.iter().filter(|event| event.data["job_id"] == id);
            mine.map(|event| (event.event.clone(), event.data.clone())).collect()
        };
        assert_eq!(of_job(&live), of_job(&list(&app, job, "").await));
    }
    assert!(live.iter().all(|event| !before.ends_with(event.data["job_id"].as_str().unwrap())));
    assert!(live.is_sorted_by(|a, b| a.id < b.id));

    // From the opening's id on it is all the same again.
    let mut again = EventStream::open(app.get("/v1/events").header("Last-Event-ID", start)).await;
    for event in &live {
        assert_eq!(again.next().await.as_ref(), Some(event));
    }
    let wrong = app.get("/v1/events").header("Last-Event-ID", "x").send().await.unwrap();
    problem(wrong, 400, "malformed_request").await;
}

#[tokio::test]
async fn a_quiet_stream_is_kept_open_by_comments() {
    let app = TestApp::start(&["--workers", "0"]).await;
    let job = app.submit(CUBE_OBJ, "").await;
    let mut stream = EventStream::open(app.get(&format!("{job}/events"))).await;
    assert_eq!(stream.next().await.unwrap().data["state"], "queued");
    let comment = tokio::time::timeout(Duration::from_secs(20), stream.block()).await.unwrap();
    assert!(comment.unwrap().starts_with(':'));
}

async fn list(app: &TestApp, job: &str, query: &str) -> Vec<StreamEvent> {
    let request = app.get(&format!("{job}/events{query}")).header("Accept", "application/json");
    let list: Value = request.send().await.unwrap().json().await.unwrap();
    let events = list["data"].as_array().unwrap().iter().map(|event| StreamEvent {
        id: event["id"].as_u64().unwrap(),
        event: event["event"].as_str().unwrap().to_owned(),
        data: event["data"].clone(),
    });
    let events: Vec<StreamEvent> = events.collect();
    if let Some(last) = events.last() {
        assert_eq!(list["next_after"], last.id);
    }
    events
}
