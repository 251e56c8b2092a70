//! Faults, on real processes: workers and servers are killed in the middle of a job, drained, told to
//! cancel; no job is lost, no process is left behind, and every event stream goes on.

use std::fmt::Write as _;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tempfile::TempDir;
use uvsegnet::config::{DataDir, host_name};
use uvsegnet::contract::ErrorCode;
use uvsegnet::jobs::{self, EventData, JobId, JobState, Kept, Policy, Presence, Schema, Worker};

/// Everything that must happen happens within this, even on a busy machine.
const PATIENCE: Duration = Duration::from_secs(120);

/// Steps that no job takes within its budget.
const ENDLESS: u32 = 100_000;

/// All charts train, none is split to spare it the training, and none settles in an eighth of the
/// steps.
const TRAIN: &str = "quality=best&distortion_bound=100";

/// A job that trains for a while and then succeeds: its budget ends the training.
fn long_enough() -> String {
    format!("steps={ENDLESS}&{TRAIN}&budget_s=8&tag=long")
}

/// A job that does not end by itself within a test.
fn endless() -> String {
    format!("steps={ENDLESS}&{TRAIN}&budget_s=600&tag=endless")
}

/// Four doubly curved patches with `side`² vertices each, apart from each other: nothing that has an
/// isometric start, so the training really runs.
fn bumps(side: usize) -> String {
    let mut obj = String::new();
    for patch in 0..4 {
        for y in 0..side {
            for x in 0..side {
                let scale = 4.0 / (side - 1) as f64;
                let (u, v) = (x as f64 * scale, y as f64 * scale);
                let height = (u * (1.0 + 0.2 * f64::from(patch))).sin() * (v * 1.3).cos();
                writeln!(obj, "v {} {} {}", u + 10.0 * f64::from(patch), v, height).unwrap();
            }
        }
        let vertex = |x: usize, y: usize| patch as usize * side * side + y * side + x + 1;
        for y in 0..side - 1 {
            for x in 0..side - 1 {
                let (a, b) = (vertex(x, y), vertex(x + 1, y));
                let (c, d) = (vertex(x + 1, y + 1), vertex(x, y + 1));
                writeln!(obj, "f {a} {b} {c}\nf {a} {c} {d}").unwrap();
            }
        }
    }
    obj
}

/// A server process on a free port.
struct Server {
    process: Child,
    url: String,
    http: reqwest::Client,
}

impl Server {
    fn start(data: &Path, flags: &[&str]) -> Self {
        let mut process = Command::new(env!("CARGO_BIN_EXE_uvsegnet"))
            .args(["serve", "--listen", "127.0.0.1:0", "--device", "cpu", "--data"])
            .arg(data)
            .args(flags)
            .env("UVSEGNET_LOG", "error")
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(process.stdout.take().unwrap()).lines();
        let line = lines.next().expect("the server says where it listens").unwrap();
        let url = line.strip_prefix("uvsegnet listens on ").expect(&line).to_string();
        Self { process, url, http: reqwest::Client::new() }
    }

    async fn submit(&self, query: &str) -> String {
        self.submit_mesh(query, bumps(17)).await
    }

    async fn submit_mesh(&self, query: &str, mesh: String) -> String {
        let request = self.http.post(format!("{}/v1/jobs?{query}", self.url));
        let request = request.header("content-type", "model/obj").body(mesh);
        let answer = request.send().await.unwrap();
        assert_eq!(answer.status(), 202, "{}", answer.text().await.unwrap());
        let job: Value = answer.json().await.unwrap();
        job["id"].as_str().unwrap().to_string()
    }

    async fn get(&self, path: &str) -> Value {
        let answer = self.http.get(format!("{}{path}", self.url)).send().await.unwrap();
        assert_eq!(answer.status(), 200, "{path}");
        answer.json().await.unwrap()
    }

    async fn job(&self, id: &str) -> Value {
        self.get(&format!("/v1/jobs/{id}")).await
    }

    /// Wait until the job is as `wanted`, and return it.
    async fn job_when(&self, id: &str, wanted: impl Fn(&Value) -> bool) -> Value {
        eventually("the job is as wanted", async || {
            let job = self.job(id).await;
            wanted(&job).then_some(job)
        })
        .await
    }

    /// Wait until this attempt of the job trains.
    async fn training(&self, id: &str, attempt: u32) -> Value {
        self.job_when(id, |job| {
            assert!(!is_over(job), "it was to go on for longer: {job}");
            job["attempt"] == attempt && job["progress"]["stage"] == "train"
        })
        .await
    }

    /// The worker, once there is one.
    async fn worker(&self) -> Value {
        eventually("a worker is there", async || {
            self.get("/v1/info").await["workers"].get(0).cloned()
        })
        .await
    }

    /// Open the job's event stream; it is followed from the first event to its end.
    async fn stream(&self, id: &str) -> tokio::task::JoinHandle<Vec<(u64, String, Value)>> {
        let request = self.http.get(format!("{}/v1/jobs/{id}/events", self.url));
        let request = request.header("accept", "text/event-stream").header("last-event-id", "0");
        let answer = request.send().await.unwrap();
        assert_eq!(answer.status(), 200);
        tokio::spawn(async move { events_of(&answer.text().await.unwrap()) })
    }

    fn kill(&mut self) {
        self.process.kill().unwrap();
        self.process.wait().unwrap();
    }

    /// Send SIGTERM and wait for the end.
    async fn terminate(&mut self) -> ExitStatus {
        signal("TERM", u64::from(self.process.id()));
        let process = &mut self.process;
        eventually("the server ends", async || process.try_wait().unwrap()).await
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Frames of an event stream: id, event, data.
fn events_of(text: &str) -> Vec<(u64, String, Value)> {
    let field = |frame: &str, name: &str| {
        let line = frame.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'));
        line.map(|value| value.trim_start().to_string())
    };
    let frames = text.split("\n\n").filter_map(|frame| {
        let data = serde_json::from_str(&field(frame, "data")?).unwrap();
        Some((field(frame, "id")?.parse().unwrap(), field(frame, "event")?, data))
    });
    frames.collect()
}

async fn eventually<T>(what: &str, mut look: impl AsyncFnMut() -> Option<T>) -> T {
    let began = Instant::now();
    while began.elapsed() < PATIENCE {
        if let Some(found) = look().await {
            return found;
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    panic!("waited in vain until {what}");
}

fn is_over(job: &Value) -> bool {
    ["succeeded", "failed", "canceled"].contains(&job["state"].as_str().unwrap())
}

fn signal(name: &str, pid: u64) {
    let status = Command::new("sh").args(["-c", &format!("kill -{name} {pid}")]).status().unwrap();
    assert!(status.success());
}

fn kill(worker: &Value) {
    signal("KILL", worker["pid"].as_u64().unwrap());
}

fn data_dir(folder: &TempDir) -> DataDir {
    DataDir { root: folder.path().to_path_buf(), blobs: None }
}

/// What a server keeps, seen without it.
async fn kept(folder: &TempDir) -> Kept {
    let now = Schema::Await(Duration::ZERO);
    jobs::open(&data_dir(folder), Policy::default(), now).await.unwrap()
}

/// Wait until none of these workers lives: not what any table says, but whether the kernel still
/// holds their locks.
async fn all_dead(presence: &dyn Presence, workers: &[Worker], within: Duration) {
    let began = Instant::now();
    while !workers.iter().all(|worker| presence.is_dead(&worker.id)) {
        assert!(began.elapsed() < within, "a worker is left behind");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}

fn artifact_names(job: &Value) -> Vec<&str> {
    let artifacts = job["artifacts"].as_array().unwrap().iter();
    artifacts.map(|artifact| artifact["name"].as_str().unwrap()).collect()
}

#[tokio::test]
async fn a_killed_worker_costs_an_attempt_and_the_stream_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let id = server.submit(&long_enough()).await;
    let stream = server.stream(&id).await;
    server.training(&id, 1).await;
    let killed = server.worker().await;
    kill(&killed);
    let began = Instant::now();
    server.job_when(&id, |job| job["attempt"] == 2).await;
    assert!(began.elapsed() < Duration::from_secs(15), "{:?}", began.elapsed());

    let job = server.job_when(&id, is_over).await;
    assert_eq!((&job["state"], &job["attempt"]), (&json!("succeeded"), &json!(2)), "{job}");
    let names = ["model.glb", "metrics.json", "uv_layout.svg", "preview.png", "log.jsonl"];
    let mut found = artifact_names(&job);
    found.sort_unstable_by_key(|name| names.iter().position(|known| known == name));
    assert_eq!(found, names);
    assert_ne!(server.worker().await["id"], killed["id"]);

    let events = stream.await.unwrap();
    let ids: Vec<u64> = events.iter().map(|(id, ..)| *id).collect();
    assert_eq!(ids, (1..=ids.len() as u64).collect::<Vec<_>>(), "nothing lost, nothing repeated");
    let retrying: Vec<_> = events.iter().filter(|(_, kind, _)| kind == "retrying").collect();
    assert_eq!(retrying.len(), 1);
    assert_eq!(retrying[0].2["attempt"], 1);
    assert_eq!(retrying[0].2["code"], "worker_crashed");
    assert!(events.iter().any(|(_, kind, data)| kind == "stage" && data["attempt"] == 2));
    assert_eq!(events.last().unwrap().1, "succeeded");

    let log = server.http.get(format!("{}/v1/jobs/{id}/artifacts/log.jsonl", server.url));
    let log = log.send().await.unwrap().text().await.unwrap();
    let stages = log.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    assert!(stages.into_iter().any(|line| line["stage"] == "train"), "{log}");
}

#[tokio::test]
async fn a_job_that_kills_every_worker_fails_and_the_next_one_runs() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let id = server.submit(&endless()).await;
    for attempt in 1..=3 {
        server.training(&id, attempt).await;
        kill(&server.worker().await);
    }
    let job = server.job_when(&id, is_over).await;
    assert_eq!(job["state"], "failed");
    assert_eq!(job["error"]["code"], "worker_crashed", "{job}");
    let next = server.submit(&endless()).await;
    server.training(&next, 1).await;
}

#[tokio::test]
async fn a_killed_server_leaves_no_worker_and_its_job_is_taken_up_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut server = Server::start(folder.path(), &["--workers", "2"]);
    let id = server.submit(&long_enough()).await;
    server.training(&id, 1).await;
    let Kept { queue, presence, .. } = kept(&folder).await;
    let workers = eventually("both workers are there", async || {
        Some(queue.workers_on(&host_name()).await.unwrap()).filter(|all| all.len() == 2)
    })
    .await;
    server.kill();
    all_dead(&*presence, &workers, Duration::from_secs(5)).await;
    let left = queue.get(id.parse().unwrap()).await.unwrap().unwrap();
    assert_eq!(left.state, JobState::Running, "nobody could say that its worker is gone");

    let server = Server::start(folder.path(), &[]);
    let began = Instant::now();
    server.job_when(&id, |job| job["attempt"] == 2).await;
    assert!(began.elapsed() < Duration::from_secs(15), "{:?}", began.elapsed());
    let job = server.job_when(&id, is_over).await;
    assert_eq!((&job["state"], &job["attempt"]), (&json!("succeeded"), &json!(2)), "{job}");
}

#[tokio::test]
async fn cancel_frees_the_device_within_two_seconds() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let (first, second) = (server.submit(&endless()).await, server.submit(&endless()).await);
    server.training(&first, 1).await;
    assert_eq!(server.job(&second).await["state"], "queued");
    let began = Instant::now();
    let cancel = server.http.post(format!("{}/v1/jobs/{first}/cancel", server.url));
    assert_eq!(cancel.send().await.unwrap().status(), 202);
    server.job_when(&first, |job| job["state"] == "canceled").await;
    assert!(began.elapsed() < Duration::from_millis(2500), "{:?}", began.elapsed());
    server.training(&second, 1).await;
}

#[tokio::test]
async fn a_drained_server_hands_its_job_back_and_no_attempt_is_spent() {
    let folder = tempfile::tempdir().unwrap();
    let mut server = Server::start(folder.path(), &["--drain-timeout", "1"]);
    let id = server.submit(&endless()).await;
    server.training(&id, 1).await;
    let Kept { queue, presence, .. } = kept(&folder).await;
    let workers = queue.workers_on(&host_name()).await.unwrap();
    let stream = server.stream(&id).await;
    assert!(server.terminate().await.success());
    all_dead(&*presence, &workers, Duration::ZERO).await;
    stream.await.unwrap();

    let id_parsed: JobId = id.parse().unwrap();
    let job = queue.get(id_parsed).await.unwrap().unwrap();
    assert_eq!((job.state, job.attempt), (JobState::Queued, 0));
    let last = queue.events_after(id_parsed, job.last_seq - 1, 1).await.unwrap();
    let EventData::Retrying(retrying) = &last[0].data else { panic!("{last:?}") };
    assert_eq!(retrying.code, ErrorCode::Draining);

    let server = Server::start(folder.path(), &[]);
    server.training(&id, 1).await;
}

#[tokio::test]
async fn while_its_last_job_ends_a_drained_server_says_so_and_its_streams_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let mut server = Server::start(folder.path(), &["--drain-timeout", "100"]);
    let id = server.submit(&long_enough()).await;
    server.training(&id, 1).await;
    let stream = server.stream(&id).await;
    signal("TERM", u64::from(server.process.id()));
    // A new connection each time: that the old ones stay is not enough.
    let ask = |method: reqwest::Method, path: &str| {
        reqwest::Client::new().request(method, format!("{}{path}", server.url))
    };
    let ready = eventually("it is not ready any more", async || {
        let answer = ask(reqwest::Method::GET, "/readyz").send().await.unwrap();
        (answer.status() == 503).then_some(answer)
    })
    .await;
    assert_eq!(ready.json::<Value>().await.unwrap()["code"], "draining");
    let upload = ask(reqwest::Method::POST, "/v1/jobs").body(bumps(2)).send().await.unwrap();
    assert_eq!(upload.status(), 503);
    assert!(upload.headers().contains_key("retry-after"));
    assert_eq!(upload.json::<Value>().await.unwrap()["code"], "draining");
    assert_eq!(server.job(&id).await["state"], "running");
    assert_eq!(stream.await.unwrap().last().unwrap().1, "succeeded");
    let process = &mut server.process;
    let status = eventually("the server ends", async || process.try_wait().unwrap()).await;
    assert!(status.success());
}

#[tokio::test]
async fn a_job_that_runs_too_long_fails() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &["--job-timeout", "1"]);
    // Half a million triangles: even the cheapest form of every stage takes longer than that.
    let id = server.submit_mesh("", bumps(257)).await;
    let job = server.job_when(&id, is_over).await;
    assert_eq!((&job["state"], &job["attempt"]), (&json!("failed"), &json!(1)), "{job}");
    assert_eq!(job["error"]["code"], "timed_out", "{job}");
    assert_eq!(artifact_names(&job), ["log.jsonl"]);
}

#[tokio::test]
async fn a_service_that_anybody_may_use_stays_on_this_host() {
    let folder = tempfile::tempdir().unwrap();
    let refused = Command::new(env!("CARGO_BIN_EXE_uvsegnet"))
        .args(["serve", "--listen", "0.0.0.0:0", "--data"])
        .arg(folder.path())
        .output()
        .unwrap();
    assert!(!refused.status.success());
    let why = String::from_utf8_lossy(&refused.stderr);
    assert!(why.contains("--insecure"), "{why}");
}
