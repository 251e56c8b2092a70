//! Small objects on their way through the pipeline, for tests.

use std::f64::consts::PI;
use std::fmt::Write;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use super::charting::Cut;
use super::finish::{self, CertifiedAtlas};
use super::parts::{Found, Solvers};
use super::{Engine, charting, delivery, maps, parts};
use crate::contract::{
    Budget, Cancel, MeshKind, Progress, Quality, Run, SegmentationSource, UnwrapOptions,
};
use crate::device::Device;
use crate::mesh::{self, Scene};

/// A cube of twelve triangles.
pub const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// The same cube's faces with the other winding, to stand behind [`CUBE`].
pub const INSIDE: &str = "f 1 2 3 4\nf 5 8 7 6\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n";

/// A cube beside what `text` has already: `corners` vertices, none of them beyond y = 4.
pub fn and_a_cube(text: &str, corners: u32) -> String {
    let moved = |line: &str| {
        let numbers: Vec<u32> = line[2..].split(' ').flat_map(str::parse).collect();
        match numbers[..] {
            [x, y, z] => format!("v {x} {} {z}\n", y + 5),
            _ => {
                let moved = numbers.iter().map(|i| (i + corners).to_string());
                format!("f {}\n", moved.collect::<Vec<_>>().join(" "))
            }
        }
    };
    text.to_owned() + &CUBE.lines().map(moved).collect::<String>()
}

/// A sheet of `n` × `n` cells of side 1, two triangles each, lifted by `height`.
pub fn sheet(n: u32, height: impl Fn(f64, f64) -> f64) -> String {
    let mut text = String::new();
    for (j, i) in (0..=n).flat_map(|j| (0..=n).map(move |i| (j, i))) {
        let (x, y) = (f64::from(i), f64::from(j));
        let _ = writeln!(text, "v {x} {y} {}", height(x, y));
    }
    for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
        let a = j * (n + 1) + i + 1;
        let _ = writeln!(text, "f {a} {} {} {}", a + 1, a + n + 2, a + n + 1);
    }
    text
}

/// A sphere of `n` rings of 2 `n` cells, the poles being vertices.
pub fn sphere(n: u32) -> String {
    let mut text = String::from("v 0 0 1\nv 0 0 -1\n");
    let m = 2 * n;
    for (j, i) in (1..n).flat_map(|j| (0..m).map(move |i| (j, i))) {
        let (polar, around) = (f64::from(j), f64::from(i));
        let (polar, around) = (polar * PI / f64::from(n), around * 2.0 * PI / f64::from(m));
        let (x, y) = (polar.sin() * around.cos(), polar.sin() * around.sin());
        let _ = writeln!(text, "v {x} {y} {}", polar.cos());
    }
    let at = |j: u32, i: u32| 3 + (j - 1) * m + i % m;
    for i in 0..m {
        let _ = writeln!(text, "f 1 {} {}", at(1, i), at(1, i + 1));
        let _ = writeln!(text, "f 2 {} {}", at(n - 1, i + 1), at(n - 1, i));
    }
    for (j, i) in (1..n - 1).flat_map(|j| (0..m).map(move |i| (j, i))) {
        let (a, b, c, d) = (at(j, i), at(j + 1, i), at(j + 1, i + 1), at(j, i + 1));
        let _ = writeln!(text, "f {a} {b} {c} {d}");
    }
    text
}

/// `count` squares of side 1 beside each other, none of which touches another.
pub fn squares(count: u32) -> String {
    let square = |k: u32| {
        let (x, i) = (2 * k, 4 * k);
        let corners = [(x, 0), (x + 1, 0), (x + 1, 1), (x, 1)].map(|(x, y)| format!("v {x} {y} 0"));
        format!("{}\nf {} {} {} {}\n", corners.join("\n"), i + 1, i + 2, i + 3, i + 4)
    };
    (0..count).map(square).collect()
}

/// The file's own parts, nothing trained.
pub fn options() -> UnwrapOptions {
    let segmentation = SegmentationSource::Authored;
    UnwrapOptions { segmentation, quality: Quality::Fast, page_size: 256, ..Default::default() }
}

pub fn engine() -> Engine {
    Engine::new(Device::cpu())
}

/// A file.
pub fn scene(obj: &str) -> Scene {
    mesh::import(obj.as_bytes(), MeshKind::Obj, &Default::default()).unwrap()
}

/// A file, as far as its parts.
pub fn found(obj: &str, options: &UnwrapOptions, run: &Run) -> (Found, Solvers) {
    parts::find(&scene(obj), options, &engine(), run).unwrap()
}

/// … as far as its charts.
pub fn cut(obj: &str, options: &UnwrapOptions, run: &Run) -> (Found, Solvers, Cut) {
    let (found, solvers) = found(obj, options, run);
    let cut = charting::cut(&found, &solvers, options, &engine(), run).unwrap();
    (found, solvers, cut)
}

/// … as far as its atlas.
pub fn atlas(obj: &str, options: &UnwrapOptions, run: &Run) -> (Found, Solvers, CertifiedAtlas) {
    let (found, solvers, cut) = cut(obj, options, run);
    let charts = maps::untrained(cut.charts);
    let (found, charts) = delivery::deliver(&found, charts, options, run).unwrap();
    let atlas = finish::pack_and_certify(&found, &cut.regions, charts, options, run);
    let atlas = atlas.unwrap();
    (found, solvers, atlas)
}

/// A run of 100 seconds of which so many are over.
pub fn late(seconds: u64) -> Run {
    let started = Instant::now() - Duration::from_secs(seconds);
    Run::new(|_| {}, Cancel::default(), Budget::new(Some(100.0), 6144).since(started))
}

/// A run, and what it tells.
pub fn watched() -> (Run, Arc<Mutex<Vec<Progress>>>) {
    let told = Arc::new(Mutex::new(Vec::new()));
    let listener = told.clone();
    let tell = move |progress| listener.lock().unwrap().push(progress);
    (Run::new(tell, Cancel::default(), Budget::default()), told)
}
