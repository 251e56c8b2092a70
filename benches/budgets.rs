//! What each stage is counted to do on a few objects, and what a unit of it costs, held against what was kept in
//! budgets.txt, so that the next slow stage is seen. `cargo bench --bench budgets`; with `-- --write` what it finds
//! is kept. On one thread, default options, the least of three runs. Counts are the same on every machine; seconds
//! are held against those of a piece of work that is always the same, which is timed beside.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use uvsegnet::contract::{Limits, MeshKind, Run, Stage, UnwrapOptions};
use uvsegnet::device::Device;
use uvsegnet::pipeline::{Engine, Input, unwrap_input};
use uvsegnet::synth::BodyKind;
use uvsegnet::synth::body::{self, BodyStyle};

const SAMPLES: [&str; 6] = ["chair", "chair_small", "knife", "laptop", "skateboard", "table"];
const BODIES: [BodyKind; 2] = [BodyKind::Knot, BodyKind::Mug];
/// Triangles of a body.
const TRIANGLES: usize = 9_000;
/// Times that each object is unwrapped.
const RUNS: usize = 3;
/// More work than was kept by this factor is told, and so is a unit that costs more by that.
const MORE_WORK: f64 = 1.03;
const DEARER: f64 = 1.5;
/// Seconds of a stage over all objects below which a unit's cost is noise.
const NOISE_S: f64 = 0.02;

/// What a stage did on an object.
#[derive(Debug, Clone, Copy, Default)]
struct Did {
    work: u64,
    seconds: f64,
}

type Table = BTreeMap<(String, usize), Did>;

fn main() -> ExitCode {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/budgets.txt");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread starts");
    let (yardstick, table) = pool.install(|| {
        let before = yardstick();
        let table = measure();
        (before.min(yardstick()), table)
    });
    let kept = std::fs::read_to_string(&file).ok().map(|text| Kept::read(&text));
    let worse = tell(&table, yardstick, kept.as_ref());
    if std::env::args().any(|arg| arg == "--write") {
        std::fs::write(&file, Kept::write(&table, yardstick)).expect("the file can be written");
    } else if worse {
        eprintln!(
            "a stage does more, or a unit of it costs more, than was kept; -- --write keeps it"
        );
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

/// Seconds of a piece of work that never changes: numbers drawn, sorted and added up.
fn yardstick() -> f64 {
    let once = || {
        let begun = Instant::now();
        let mut state = 1u64;
        let mut numbers: Vec<f64> = (0..2_000_000)
            .map(|_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                (state >> 11) as f64
            })
            .collect();
        numbers.sort_unstable_by(f64::total_cmp);
        std::hint::black_box(numbers.iter().map(|n| n.sqrt()).sum::<f64>());
        begun.elapsed().as_secs_f64()
    };
    (0..RUNS).map(|_| once()).fold(f64::INFINITY, f64::min)
}

fn objects() -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let samples = SAMPLES.map(|name| {
        let bytes = std::fs::read(folder.join(format!("{name}.glb")));
        (name.to_owned(), bytes.expect("the samples are in the tree"))
    });
    let bodies = BODIES.map(|kind| {
        let style = BodyStyle { triangles: TRIANGLES, seed: 1, copies: 1, ..Default::default() };
        (kind.as_str().to_owned(), body::make(kind, style).glb(kind.as_str()))
    });
    samples.into_iter().chain(bodies).collect()
}

fn measure() -> Table {
    let (options, limits) = (UnwrapOptions::default(), Limits::default());
    let engine = Engine::new(Device::cpu());
    let mut table = Table::new();
    for (name, bytes) in objects() {
        let input = Input::new(MeshKind::Glb, &bytes);
        for _ in 0..RUNS {
            let result = unwrap_input(&input, &options, &limits, &engine, &Run::quiet());
            let cost = result.expect("the objects are sound").metrics.cost;
            for row in cost.stages {
                let stage = Stage::ALL.iter().position(|stage| stage.as_str() == row.name);
                let stage = stage.expect("every row is of a stage");
                let did = table
                    .entry((name.clone(), stage))
                    .or_insert(Did { work: row.work, seconds: f64::INFINITY });
                assert_eq!(did.work, row.work, "{name}: work is counted anew in each run");
                did.seconds = did.seconds.min(row.wall_s);
            }
        }
    }
    table
}

/// What was kept: the work of each object and stage, and yardsticks a unit of each stage.
#[derive(Debug, Default)]
struct Kept {
    work: BTreeMap<(String, String), u64>,
    cost: BTreeMap<String, f64>,
}

impl Kept {
    fn read(text: &str) -> Self {
        let mut kept = Self::default();
        for line in text.lines().filter(|line| !line.starts_with('#')) {
            match line.split('\t').collect::<Vec<_>>()[..] {
                [object, stage, work] => {
                    let work = work.parse().expect("budgets.txt: work is a number");
                    kept.work.insert((object.to_owned(), stage.to_owned()), work);
                }
                [stage, cost] => {
                    let cost = cost.parse().expect("budgets.txt: a cost is a number");
                    kept.cost.insert(stage.to_owned(), cost);
                }
                _ => {}
            }
        }
        kept
    }

    fn write(table: &Table, yardstick: f64) -> String {
        let mut text = "# object, stage, work: see budgets.rs\n".to_owned();
        for ((object, stage), did) in table {
            let _ = writeln!(text, "{object}\t{}\t{}", Stage::ALL[*stage].as_str(), did.work);
        }
        text += "# stage, yardsticks a unit\n";
        for (stage, did) in sums(table).into_iter().filter(|(_, did)| did.work > 0) {
            let cost = did.seconds / did.work as f64 / yardstick;
            let _ = writeln!(text, "{}\t{cost:.4e}", Stage::ALL[stage].as_str());
        }
        text
    }
}

/// Each stage over all objects.
fn sums(table: &Table) -> BTreeMap<usize, Did> {
    let mut sums: BTreeMap<usize, Did> = BTreeMap::new();
    for ((_, stage), did) in table {
        let sum = sums.entry(*stage).or_default();
        sum.work += did.work;
        sum.seconds += did.seconds;
    }
    sums
}

/// Print what was found beside what was kept. Whether something is worse.
fn tell(table: &Table, yardstick: f64, kept: Option<&Kept>) -> bool {
    let mut worse = false;
    println!("{} objects, one thread; yardstick {:.0} ms", objects().len(), 1e3 * yardstick);
    println!("| stage | counted in | work | seconds | ns a unit | over kept |");
    println!("|---|---|---|---|---|---|");
    for (stage, Did { work, seconds }) in sums(table).into_iter().filter(|(_, did)| did.work > 0) {
        let (name, unit) = (Stage::ALL[stage].as_str(), Stage::ALL[stage].unit());
        let each = seconds / work as f64;
        let over = kept.and_then(|kept| kept.cost.get(name)).map(|cost| each / yardstick / cost);
        let dearer = seconds >= NOISE_S && over.is_some_and(|over| over > DEARER);
        let (mark, over) = (if dearer { " !" } else { "" }, over.unwrap_or(f64::NAN));
        println!(
            "| {name} | {unit} | {work} | {seconds:.3} | {:.1} | {over:.2}{mark} |",
            1e9 * each
        );
        worse |= dearer;
    }
    for ((object, stage), did) in table {
        let name = Stage::ALL[*stage].as_str();
        let before = kept.and_then(|kept| kept.work.get(&(object.clone(), name.to_owned())));
        if let Some(&before) = before
            && did.work as f64 > MORE_WORK * before as f64
        {
            println!(
                "{object}: {name} does {} {}, not {before}",
                did.work,
                Stage::ALL[*stage].unit()
            );
            worse = true;
        }
    }
    worse
}

/// As in the program.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;
