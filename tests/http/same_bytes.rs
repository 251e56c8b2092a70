//! A file made on the command line and one made by the service are the same bytes.

use std::path::Path;
use std::process::Command;

use reqwest::multipart::{Form, Part};
use serde_json::{Value, json};
use uvsegnet::contract::ArtifactKind;

use crate::app::TestApp;

const SAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/knife.glb");

/// Every file of the command line that was written into `folder`, flags being options and their values.
fn unwrap(flags: &[&str], folder: &Path) -> Vec<(ArtifactKind, Vec<u8>)> {
    let kinds = ArtifactKind::ALL.iter().copied().filter(|kind| !kind.flag().is_empty());
    let mut command = Command::new(env!("CARGO_BIN_EXE_uvsegnet"));
    command.args(["unwrap", SAMPLE, "--device", "cpu"]).args(flags);
    for kind in kinds.clone() {
        command.arg(format!("--{}", kind.flag())).arg(folder.join(kind.name()));
    }
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    kinds.filter_map(|kind| Some((kind, std::fs::read(folder.join(kind.name())).ok()?))).collect()
}

/// The figures, without what is a matter of the hour: `cost` holds the seconds and the memory that this run
/// took, and the summary repeats the seconds.
fn figures(metrics: &[u8]) -> Value {
    let mut metrics: Value = serde_json::from_slice(metrics).unwrap();
    let cost = metrics.as_object_mut().unwrap().remove("cost");
    assert!(cost.unwrap()["stages"].is_array());
    let seconds = metrics["summary"].as_object_mut().unwrap().remove("seconds");
    assert!(seconds.unwrap().is_f64());
    metrics
}

async fn assert_same(app: &TestApp, flags: &[&str], options: Value, want: &[ArtifactKind]) {
    let folder = tempfile::tempdir().unwrap();
    let files = unwrap(flags, folder.path());
    let kinds: Vec<_> = files.iter().map(|(kind, _)| *kind).collect();
    assert_eq!(kinds, want, "{flags:?}");

    let mesh = Part::bytes(std::fs::read(SAMPLE).unwrap()).file_name("knife.glb");
    let form = Form::new().part("file", mesh).text("options", options.to_string());
    let response = app.post("/v1/jobs").multipart(form).send().await.unwrap();
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    let over = app.over(&job).await;
    assert_eq!(over["state"], "succeeded", "{over}");
    let listed = over["artifacts"].as_array().unwrap().iter();
    let listed: Vec<_> = listed.map(|artifact| artifact["name"].as_str().unwrap()).collect();
    // The log of its worker is the service's own.
    let names = kinds.iter().chain([&ArtifactKind::Log]).map(|kind| kind.name());
    assert_eq!(listed, names.collect::<Vec<_>>());

    for (kind, here) in &files {
        let url = format!("{job}/artifacts/{}", kind.name());
        let there = app.get(&url).send().await.unwrap().bytes().await.unwrap();
        match kind {
            ArtifactKind::Metrics => assert_eq!(figures(here), figures(&there)),
            kind => assert!(here == &there, "{} differs: {options}", kind.name()),
        }
    }
}

#[tokio::test]
async fn the_command_line_and_the_service_write_the_same_files() {
    use ArtifactKind::{Labels, Layout, Metrics, Model, Preview};
    let app = TestApp::start(&[]).await;
    let (flags, options) =
        (["--padding", "4", "--steps", "60"], json!({"padding": 4, "steps": 60}));
    assert_same(&app, &flags, options, &[Model, Metrics, Layout, Preview]).await;
    let (flags, options) =
        (["--stop-after", "segmentation"], json!({"stop_after": "segmentation"}));
    assert_same(&app, &flags, options, &[Model, Labels, Metrics, Preview]).await;
}
