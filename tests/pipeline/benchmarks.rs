//! The benchmarks of the command line: what they write, and what they say of objects that fail.

use std::process::Command;

use super::example;

#[test]
fn the_quality_benchmark_writes_a_line_an_object_and_resumes() {
    let dir = tempfile::tempdir().unwrap();
    let meshes = dir.path().join("meshes");
    std::fs::create_dir(&meshes).unwrap();
    for name in ["table.glb", "knife.glb"] {
        std::fs::copy(example(name), meshes.join(name)).unwrap();
    }
    std::fs::write(meshes.join("broken.obj"), "v 0 0 0\nf 1 2 3\n").unwrap();
    let lines = dir.path().join("quality.jsonl");
    let bench = |limit: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_uvsegnet"))
            .args(["bench", "quality", "--quality", "fast", "--limit", limit, "--output"])
            .args([&lines, &meshes])
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = std::fs::read_to_string(&lines).unwrap();
        let lines: Vec<serde_json::Value> =
            text.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
        (lines, String::from_utf8(output.stdout).unwrap())
    };
    assert_eq!(bench("1").0.len(), 1);
    let (lines, table) = bench("9");
    assert_eq!(lines.len(), 3);
    assert!(table.starts_with("3 objects, 2 unwrapped, 1 refused or failed"), "{table}");
    for line in lines.iter().filter(|l| l["ours"].is_object()) {
        assert_eq!(line["ours"]["valid"], true);
        // The point of it all: fewer charts than the classical unwrapper.
        assert!(line["ours"]["charts"].as_u64() < line["peer"]["charts"].as_u64(), "{line}");
    }
}

#[test]
fn the_determinism_benchmark_says_who_is_the_same_and_who_failed() {
    let dir = tempfile::tempdir().unwrap();
    let (meshes, names) = (dir.path().join("meshes"), dir.path().join("names.txt"));
    std::fs::create_dir_all(meshes.join("deep")).unwrap();
    std::fs::copy(example("knife.glb"), meshes.join("deep/knife.glb")).unwrap();
    std::fs::write(meshes.join("broken.obj"), "v 0 0 0\nf 1 2 3\n").unwrap();
    let bench = |list: &str| {
        std::fs::write(&names, list).unwrap();
        let output = Command::new(env!("CARGO_BIN_EXE_uvsegnet"))
            .args(["bench", "determinism", "--steps", "20", "--names"])
            .args([&names, &meshes])
            .output()
            .unwrap();
        let said = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
        (output.status.code(), said)
    };
    let (code, said) = bench("# knives\n\nknife # with a handle\n");
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains(" triangles, ok\n1 objects: 1 the same bytes, 0 differ"), "{said}");
    let (code, said) = bench("broken\nknife\n");
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("2 objects: 1 the same bytes, 0 differ, 1 failed"), "{said}");
    let (code, said) = bench("spoon\n");
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("no spoon"), "{said}");
}

#[test]
fn the_sheet_shows_every_object_and_says_who_failed() {
    let dir = tempfile::tempdir().unwrap();
    for name in ["knife.glb", "table.glb"] {
        std::fs::copy(example(name), dir.path().join(name)).unwrap();
    }
    let sheet = dir.path().join("sheet.png");
    let bench = || {
        let output = Command::new(env!("CARGO_BIN_EXE_uvsegnet"))
            .args(["bench", "sheet", "--quality", "fast", "--columns", "2", "--output"])
            .args([sheet.as_path(), dir.path()])
            .output()
            .unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        let reader =
            png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&sheet).unwrap()));
        (output.status.success(), said, reader.read_info().unwrap().info().size())
    };
    let (success, said, size) = bench();
    assert!(success, "{said}");
    assert!(said.contains("knife, ") && said.contains(" charts, seam "), "{said}");
    std::fs::write(dir.path().join("broken.obj"), "v 0 0 0\nf 1 2 3\n").unwrap();
    let (success, said, larger) = bench();
    assert!(!success && said.contains("1 of 3 objects could not be unwrapped"), "{said}");
    assert_eq!((larger.0, larger.1 > size.1), (size.0, true));
}
