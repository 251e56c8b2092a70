//! `uvsegnet demo`: from nothing to the four files, and no trace of the service behind it.

use std::process::Command;

#[test]
fn the_demo_leaves_four_files_and_nothing_else() {
    let (output, temporary) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let folder = output.path().join("made/by/demo");
    let demo = Command::new(env!("CARGO_BIN_EXE_uvsegnet"))
        .args(["demo", "--device", "cpu", "-o"])
        .arg(&folder)
        .env("TMPDIR", temporary.path())
        .env("UVSEGNET_LOG", "warn")
        // What a server would be told says nothing to a demo.
        .env("UVSEGNET_MAX_UPLOAD", "1")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&demo.stdout);
    assert!(demo.status.success(), "{said}\n{}", String::from_utf8_lossy(&demo.stderr));
    for name in ["model.glb", "metrics.json", "uv_layout.svg", "preview.png"] {
        assert!(std::fs::metadata(folder.join(name)).unwrap().len() > 0, "{name} is empty");
        assert!(said.contains(name), "it says where {name} is");
    }
    for event in ["snapshot", "stage", "part_completed", "succeeded"] {
        assert!(said.contains(event), "{event} was not shown:\n{said}");
    }
    assert_eq!(std::fs::read_dir(temporary.path()).unwrap().count(), 0);
}
