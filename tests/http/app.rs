//! A service of its own for a test: `uvsegnet serve` on a free port with a directory that goes with
//! it.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use reqwest::{Client, Method, RequestBuilder, Response};
use serde_json::Value;
use tempfile::TempDir;

/// Nothing that a test waits for takes longer.
const PATIENCE: Duration = Duration::from_secs(120);

/// A service that runs; it is killed when this is dropped, and its workers with it.
pub struct TestApp {
    child: Child,
    data: TempDir,
    client: Client,
    pub url: String,
}

impl TestApp {
    /// Start a service with these flags besides its address and its directory.
    pub async fn start(flags: &[&str]) -> Self {
        let data = tempfile::tempdir().unwrap();
        let mut child = Command::new(env!("CARGO_BIN_EXE_uvsegnet"))
            .args(["serve", "--listen", "127.0.0.1:0", "--device", "cpu", "--data"])
            .arg(data.path())
            .args(flags)
            .env("UVSEGNET_LOG", "warn")
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let url = line.trim().rsplit(' ').next().unwrap().to_owned();
        assert!(url.starts_with("http://127.0.0.1:"), "the service said {line:?}");
        Self { child, data, client: Client::new(), url }
    }

    /// A request to a path of the service.
    pub fn request(&self, method: Method, path: &str) -> RequestBuilder {
        self.client.request(method, format!("{}{path}", self.url)).timeout(PATIENCE)
    }

    pub fn get(&self, path: &str) -> RequestBuilder {
        self.request(Method::GET, path)
    }

    pub fn post(&self, path: &str) -> RequestBuilder {
        self.request(Method::POST, path)
    }

    /// The JSON at a path.
    pub async fn json(&self, path: &str) -> Value {
        let response = self.get(path).send().await.unwrap();
        assert_eq!(response.status(), 200, "{path}");
        response.json().await.unwrap()
    }

    /// Submit a mesh as a bare body, with the options in the query, and return the job's address.
    pub async fn submit(&self, mesh: impl Into<reqwest::Body>, query: &str) -> String {
        let response = self.post(&format!("/v1/jobs?{query}")).body(mesh).send().await.unwrap();
        assert_eq!(response.status(), 202);
        response.headers()["location"].to_str().unwrap().to_owned()
    }

    /// Wait until a job is over.
    pub async fn over(&self, job: &str) -> Value {
        let end = Instant::now() + PATIENCE;
        loop {
            let response = self.get(job).header("Prefer", "wait=10").send().await.unwrap();
            let body: Value = response.json().await.unwrap();
            if ["succeeded", "failed", "canceled"].iter().any(|state| body["state"] == *state) {
                return body;
            }
            assert!(Instant::now() < end, "the job is still {}", body["state"]);
        }
    }

    /// The files that hold uploads, those under temporary names included.
    pub fn uploads(&self) -> Vec<PathBuf> {
        files(self.data.path().join("blobs/uploads"))
    }

    /// The files that hold artifacts.
    pub fn artifacts(&self) -> Vec<PathBuf> {
        files(self.data.path().join("blobs/artifacts"))
    }

    /// Wait until there are this many uploads.
    pub async fn uploads_become(&self, count: usize) {
        let end = Instant::now() + Duration::from_secs(10);
        while self.uploads().len() != count {
            assert!(Instant::now() < end, "there are {:?}", self.uploads());
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    }

    /// Ask the service to finish, as a supervisor would.
    pub fn terminate(&self) {
        let kill = Command::new("kill").args(["-TERM", &self.child.id().to_string()]).status();
        assert!(kill.unwrap().success());
    }

    /// Wait until the service has finished.
    pub async fn ended(&mut self) -> ExitStatus {
        let end = Instant::now() + Duration::from_secs(30);
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status;
            }
            assert!(Instant::now() < end, "the service does not end");
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    }
}

impl Drop for TestApp {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn files(folder: PathBuf) -> Vec<PathBuf> {
    std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect()
}

/// Check that a response is the problem it should be, whole and with its headers, and return it.
pub async fn problem(response: Response, status: u16, code: &str) -> Value {
    assert_eq!(response.headers()["content-type"], "application/problem+json");
    let id = response.headers()["x-request-id"].to_str().unwrap().to_owned();
    let got = response.status().as_u16();
    let body: Value = response.json().await.unwrap();
    assert_eq!((got, &body["code"]), (status, &Value::from(code)), "{body}");
    assert_eq!(body["status"], status);
    assert_eq!(body["request_id"], id);
    assert!(body["type"].as_str().unwrap().ends_with(&format!("#{code}")), "{body}");
    assert!(
        !body["title"].as_str().unwrap().is_empty() && !body["detail"].as_str().unwrap().is_empty()
    );
    assert!(body["errors"].is_array());
    body
}

/// An event as it came over a stream.
#[derive(Debug, Clone, PartialEq)]
pub struct StreamEvent {
    pub id: u64,
    pub event: String,
    pub data: Value,
}

/// Reads a stream of server-sent events.
pub struct EventStream {
    response: Response,
    text: String,
}

impl EventStream {
    pub async fn open(request: RequestBuilder) -> Self {
        let response = request.send().await.unwrap();
        assert_eq!(response.status(), 200);
        assert_eq!(response.headers()["content-type"], "text/event-stream");
        assert_eq!(response.headers()["cache-control"], "no-cache, no-transform");
        assert_eq!(response.headers()["x-accel-buffering"], "no");
        Self { response, text: String::new() }
    }

    /// The next block of lines, as it is written; `None` at the end of the stream.
    pub async fn block(&mut self) -> Option<String> {
        loop {
            if let Some(end) = self.text.find("\n\n") {
                return Some(self.text.drain(..end + 2).collect());
            }
            let chunk = self.response.chunk();
            let chunk = tokio::time::timeout(PATIENCE, chunk).await.expect("the stream is silent");
            self.text.push_str(std::str::from_utf8(&chunk.unwrap()?).unwrap());
        }
    }

    /// The next event.
    pub async fn next(&mut self) -> Option<StreamEvent> {
        loop {
            let block = self.block().await?;
            let field = |name: &str| block.lines().find_map(|line| line.strip_prefix(name));
            if let Some(data) = field("data: ") {
                return Some(StreamEvent {
                    id: field("id: ").unwrap().parse().unwrap(),
                    event: field("event: ").unwrap().to_owned(),
                    data: serde_json::from_str(data).unwrap(),
                });
            }
        }
    }

    /// All events to the end of the stream.
    pub async fn rest(mut self) -> Vec<StreamEvent> {
        let mut events = Vec::new();
        while let Some(event) = self.next().await {
            events.push(event);
        }
        events
    }
}
