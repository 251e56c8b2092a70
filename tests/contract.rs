//! The house rules that a machine can check: who may know whom, and how long a file may be.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Modules in the order in which data flows: each may import what stands before it.
const CHAIN: [&str; 14] = [
    "contract",
    "tasks",
    "device",
    "mesh",
    "flatten",
    "sampling",
    "segmentation",
    "charts",
    "coarse_to_fine",
    "parameterization",
    "atlas",
    "metrics",
    "preview",
    "pipeline",
];

/// What each module may import.
fn allowed() -> BTreeMap<&'static str, Vec<&'static str>> {
    let mut allowed: BTreeMap<&str, Vec<&str>> =
        CHAIN.iter().enumerate().map(|(i, &m)| (m, CHAIN[..i].to_vec())).collect();
    let service = ["contract", "config", "telemetry"];
    allowed.insert("synth", vec!["contract", "mesh"]);
    let trains = CHAIN.iter().take_while(|m| **m != "charts").copied();
    // Its curves are pictures.
    allowed.insert("training", trains.chain(["preview", "synth"]).collect());
    allowed.insert("config", vec!["contract"]);
    allowed.insert("telemetry", vec!["contract"]);
    allowed.insert("jobs", service.to_vec());
    allowed.insert("http", [&service[..], &["jobs"]].concat());
    // A worker drives the pipeline on a device.
    allowed.insert("worker", [&service[..], &["jobs", "pipeline", "device", "tasks"]].concat());
    allowed.insert(
        "cli",
        [&CHAIN[..], &service[1..], &["synth", "training", "jobs", "http", "worker"]].concat(),
    );
    allowed
}

fn sources(dir: &Path, into: &mut Vec<PathBuf>) {
    let mut entries: Vec<_> = fs::read_dir(dir).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            sources(&path, into);
        } else if path.extension().is_some_and(|e| e == "rs") {
            into.push(path);
        }
    }
}

/// Every source file with its module.
fn files() -> Vec<(String, PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut paths = Vec::new();
    sources(&root, &mut paths);
    let module = |p: &Path| {
        let first = p.strip_prefix(&root).unwrap().components().next().unwrap();
        first.as_os_str().to_string_lossy().trim_end_matches(".rs").to_owned()
    };
    paths.into_iter().map(|p| (module(&p), p.clone(), fs::read_to_string(&p).unwrap())).collect()
}

/// Modules that a line of code names behind `crate::`, also inside braces.
fn named(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (at, _) in text.match_indices("crate::") {
        let rest = &text[at + "crate::".len()..];
        if let Some(list) = rest.strip_prefix('{') {
            let list = &list[..list.find("};").unwrap_or(list.len())];
            let mut depth = 0;
            let mut word = String::new();
            for c in list.chars().chain([',']) {
                match c {
                    '{' => depth += 1,
                    '}' => depth -= 1,
                    ',' if depth == 0 => {
                        let first = word.trim().split("::").next().unwrap_or_default();
                        found.push(first.to_owned());
                        word.clear();
                    }
                    c => word.push(c),
                }
            }
        } else {
            found.push(rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect());
        }
    }
    found.retain(|m| !m.is_empty());
    found
}

#[test]
fn every_import_follows_the_arrows() {
    let allowed = allowed();
    let mut wrong = Vec::new();
    let mut edges = 0;
    for (module, path, text) in files() {
        if module == "main" || module == "lib" {
            continue;
        }
        let may = allowed
            .get(module.as_str())
            .unwrap_or_else(|| panic!("{} is in no room of docs/architecture.md", path.display()));
        for name in named(&text) {
            // Lower-case names are modules; a module may always name itself.
            let is_module = allowed.contains_key(name.as_str());
            edges += usize::from(is_module);
            if is_module && name != module && !may.contains(&name.as_str()) {
                wrong.push(format!("{}: {module} may not import {name}", path.display()));
            }
        }
    }
    assert!(edges > 100, "only {edges} imports seen: the reader is broken");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn outer_crates_stay_in_their_rooms() {
    let banned: [(&[&str], &[&str]); 3] = [
        (&CHAIN, &["sqlx::", "axum::", "tokio::"]),
        (&["http"], &["sqlx::", "burn::"]),
        (&["worker"], &["axum::"]),
    ];
    for (module, path, text) in files() {
        for (rooms, crates) in banned {
            if rooms.contains(&module.as_str()) {
                for name in crates {
                    assert!(!text.contains(name), "{} names {name}", path.display());
                }
            }
        }
    }
}

#[test]
fn only_one_function_names_the_database() {
    for (_, path, text) in files() {
        let within = |folder: &str| path.components().any(|part| part.as_os_str() == folder);
        let knows =
            within("sqlite") || path.ends_with("jobs/open.rs") || path.ends_with("jobs/mod.rs");
        assert!(knows || !text.contains("Sqlite"), "{} names a database", path.display());
        let decides = within("states") && !path.ends_with("tests.rs");
        for outer in ["sqlx::", "tokio::", "async fn", "Timestamp::now"] {
            assert!(!decides || !text.contains(outer), "{} names {outer}", path.display());
        }
    }
}

#[test]
fn a_file_does_one_thing_and_says_which() {
    for (_, path, text) in files() {
        let lines = text.lines().count();
        assert!(lines <= 400, "{} has {lines} lines: two things live in it", path.display());
        assert!(text.starts_with("//!"), "{} has no header", path.display());
    }
}

#[test]
fn every_link_between_documents_leads_somewhere() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut links = 0;
    for folder in ["", "docs", "weights"] {
        for entry in fs::read_dir(root.join(folder)).unwrap() {
            let page = entry.unwrap().path();
            if page.extension().is_none_or(|e| e != "md") {
                continue;
            }
            for link in fs::read_to_string(&page).unwrap().split("](").skip(1) {
                let target = link.split([')', '#', ' ']).next().unwrap_or_default();
                if target.is_empty() || target.contains("://") {
                    continue;
                }
                links += 1;
                let there = page.parent().unwrap().join(target).exists();
                assert!(there, "{} links to {target}", page.display());
            }
        }
    }
    assert!(links > 20, "only {links} links seen: the reader is broken");
}
