//! `uvsegnet demo`: the whole service at work, from upload to files, as any client sees it.

use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow, bail, ensure};
use clap::{Args as _, FromArgMatches as _};
use reqwest::{Client, Response};
use serde_json::Value;
use tokio_util::sync::CancellationToken;
use uuid::Uuid;

use super::serve::{self, Service};
use super::signals;
use crate::device::DeviceChoice;
use crate::http::JobBody;
use crate::synth::samples::CHAIR;

/// What is to come of it.
const FILES: [&str; 4] = ["model.glb", "metrics.json", "uv_layout.svg", "preview.png"];
/// A demo that takes longer than this has failed.
const PATIENCE: Duration = Duration::from_secs(15 * 60);

/// Arguments of `uvsegnet demo`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Where the files go. Made if need be.
    #[arg(short, long, value_name = "DIR", default_value = "uvsegnet-demo")]
    pub output: PathBuf,
    /// Where to compute: auto, cpu, gpu or gpu:N.
    #[arg(long, default_value_t)]
    pub device: DeviceChoice,
}

/// Run it.
pub fn run(args: Args) -> Result<()> {
    let runtime = tokio::runtime::Runtime::new().context("cannot start the runtime")?;
    runtime.block_on(async {
        let data = TemporaryDir::new()?;
        let stop = CancellationToken::new();
        signals::cancel_on_signal(stop.clone(), false)?;
        let service = Service::start(serve_args(&data.0, args.device)?).await?;
        let url = format!("http://{}", service.address());
        println!("the service listens on {url}, its data is in {}", data.0.display());
        let result = tokio::select! {
            result = tokio::time::timeout(PATIENCE, show(&url, &args.output)) => {
                result.unwrap_or_else(|_| Err(anyhow!("no result after {} s", PATIENCE.as_secs())))
            }
            () = stop.cancelled() => Err(anyhow!("told to stop")),
        };
        let stopped = service.stop().await;
        result?;
        stopped?;
        println!("the service has stopped");
        Ok(())
    })
}

/// The flags of `uvsegnet serve` that a demo needs; all others have their defaults, whatever the
/// environment says.
fn serve_args(data: &Path, device: DeviceChoice) -> Result<serve::Args> {
    let command = serve::Args::augment_args(clap::Command::new("serve").no_binary_name(true));
    let matches = command.mut_args(|arg| arg.env(None)).try_get_matches_from::<_, &str>([])?;
    let mut args = serve::Args::from_arg_matches(&matches)?;
    args.listen = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
    args.data.root = data.to_path_buf();
    args.workers = 1;
    // Its output is its own.
    args.log.quiet = true;
    args.device = device;
    Ok(args)
}

/// A directory that goes when the demo does.
struct TemporaryDir(PathBuf);

impl TemporaryDir {
    fn new() -> Result<Self> {
        let path = std::env::temp_dir().join(format!("uvsegnet-demo-{}", Uuid::now_v7().simple()));
        std::fs::create_dir(&path).with_context(|| format!("cannot make {}", path.display()))?;
        Ok(Self(path))
    }
}

impl Drop for TemporaryDir {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Everything that a client does: submit, follow, download.
async fn show(url: &str, output: &Path) -> Result<()> {
    let client = Client::new();
    let submitted = client
        .post(format!("{url}/v1/jobs"))
        .header("Content-Type", "model/gltf-binary")
        .body(CHAIR);
    let job: JobBody = checked(submitted.send().await?).await?.json().await?;
    println!("POST /v1/jobs with chair.glb ({} bytes): {}", CHAIR.len(), job.id);

    let job_url = format!("{url}{}", JobBody::url(job.id));
    follow(checked(client.get(format!("{job_url}/events")).send().await?).await?).await?;
    let job: JobBody = checked(client.get(&job_url).send().await?).await?.json().await?;
    if let Some(error) = job.error {
        bail!("the job failed: {error}");
    }

    std::fs::create_dir_all(output).with_context(|| format!("cannot make {}", output.display()))?;
    println!("the files:");
    for name in FILES {
        let file = client.get(format!("{job_url}/artifacts/{name}")).send().await?;
        let bytes = checked(file).await?.bytes().await?;
        ensure!(!bytes.is_empty(), "{name} is empty");
        let path = output.join(name);
        std::fs::write(&path, &bytes)
            .with_context(|| format!("cannot write {}", path.display()))?;
        println!("  {:<28} {:>9} bytes", path.display(), bytes.len());
    }
    let metrics = job.metrics.context("the job has no metrics")?;
    let figure = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.4}"));
    let valid = if metrics.valid { "valid" } else { "NOT VALID" };
    println!("the metrics:");
    println!(
        "  {valid}: {} flipped faces, {} overlapping pairs; {} parts, {} charts",
        metrics.flipped, metrics.overlapping_pairs, metrics.parts, metrics.charts
    );
    println!(
        "  symmetric Dirichlet {} (1 is isometric), quasi-conformal {} (1 is conformal)",
        figure(metrics.symmetric_dirichlet_chart),
        figure(metrics.quasi_conformal)
    );
    println!(
        "  seam length {} √area, {:.1} % of the page covered, {:.2} s on {}",
        figure(metrics.seam_length),
        metrics.packing_efficiency * 100.0,
        metrics.wall_s,
        job.device.as_deref().unwrap_or("no device")
    );
    Ok(())
}

/// The answer if it is a good one, else what the service says is wrong.
async fn checked(response: Response) -> Result<Response> {
    let status = response.status();
    if status.is_success() {
        return Ok(response);
    }
    let url = response.url().clone();
    bail!("{url} answered {status}: {}", response.text().await.unwrap_or_default())
}

/// Print the events of a stream, one a line, to its end.
async fn follow(mut stream: Response) -> Result<()> {
    let started = Instant::now();
    let (mut text, mut last) = (Vec::new(), String::new());
    while let Some(chunk) = stream.chunk().await.context("the event stream broke off")? {
        text.extend_from_slice(&chunk);
        // An event ends with an empty line.
        while let Some(end) = text.windows(2).position(|pair| pair == b"\n\n") {
            let event: Vec<u8> = text.drain(..end + 2).collect();
            let event = String::from_utf8_lossy(&event);
            let field = |name: &str| event.lines().find_map(|line| line.strip_prefix(name));
            let (Some(kind), Some(data)) = (field("event: "), field("data: ")) else { continue };
            let data: Value = serde_json::from_str(data).context("an event is not JSON")?;
            println!(
                "  {:7.2} s  {kind:<14} {}",
                started.elapsed().as_secs_f64(),
                gist(kind, &data)
            );
            last = kind.to_owned();
        }
    }
    match last.as_str() {
        "succeeded" | "failed" | "canceled" | "snapshot" => Ok(()),
        _ => bail!("the event stream ended before the job was over"),
    }
}

/// What an event says, in a few words.
fn gist(kind: &str, data: &Value) -> String {
    let text = |name: &str| match &data[name] {
        Value::String(text) => text.clone(),
        Value::Number(number) => match number.as_f64() {
            Some(x) if !number.is_i64() && !number.is_u64() => format!("{x:.4}"),
            _ => number.to_string(),
        },
        other => other.to_string(),
    };
    match kind {
        "snapshot" => text("state"),
        "stage" => text("stage"),
        "progress" => {
            let percent = data["fraction"].as_f64().unwrap_or(0.0) * 100.0;
            let parts = format!("{} of {} parts", text("parts_done"), text("parts_total"));
            format!("{} {percent:.0} %, {parts}", text("stage"))
        }
        "part_completed" => {
            let figure = text("symmetric_dirichlet");
            format!("{}: {} charts, symmetric Dirichlet {figure}", text("name"), text("charts"))
        }
        "warning" | "retrying" => format!("{}: {}", text("code"), text("message")),
        "failed" => data["error"]["message"].as_str().unwrap_or_default().to_owned(),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn serve_gets_the_demo_s_values_and_else_defaults() {
        let args = serve_args(Path::new("/x"), DeviceChoice::default()).unwrap();
        assert_eq!((args.listen.port(), args.workers, args.insecure), (0, 1, false));
        assert!(args.listen.ip().is_loopback());
        assert_eq!(args.data.root, Path::new("/x"));
        assert_eq!(args.limits.limits(), crate::contract::Limits::default());
    }

    #[test]
    fn events_are_told_in_a_line() {
        let data = json!({"stage": "train", "fraction": 0.42, "parts_done": 5, "parts_total": 12});
        assert_eq!(gist("progress", &data), "train 42 %, 5 of 12 parts");
        let data = json!({"part": 3, "name": "leg", "charts": 2, "symmetric_dirichlet": 1.00034});
        assert_eq!(gist("part_completed", &data), "leg: 2 charts, symmetric Dirichlet 1.0003");
        let data = json!({"state": "failed", "error": {"code": "invalid_mesh", "message": "no"}});
        assert_eq!(gist("failed", &data), "no");
    }
}
