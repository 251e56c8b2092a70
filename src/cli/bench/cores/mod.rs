//! `uvsegnet bench cores`: what more cores would gain. Each object is unwrapped with one thread and with two, and
//! recorded on one: work and span of every stage, and so the seconds to expect of any number of threads, held
//! against those that two take.

mod objects;
mod plan;
mod table;

use std::path::{Path, PathBuf};

use anyhow::{Context, Error, Result};
use rayon::ThreadPool;
use serde::{Deserialize, Serialize};

use super::options::{BenchOptions, unwrap};
use super::{plot, program};
use crate::cli::input::{Beside, Files};
use crate::contract::{Metrics, StageCost};
use crate::pipeline::{Engine, STACK};
use crate::synth::BodyKind;
use objects::Object;
use plan::Plan;

/// Sizes by default, triangles.
const SIZES: [u32; 4] = [6_000, 20_000, 150_000, 1_000_000];

/// Threads of the process whose memory is held against that of a single thread.
const MANY: usize = 8;

/// Threads that are measured.
const MEASURED: [usize; 2] = [1, 2];

/// Arguments of `uvsegnet bench cores`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Meshes to be measured instead of the program's own objects.
    #[arg(value_name = "MESH")]
    pub meshes: Vec<PathBuf>,
    /// Which body.
    #[arg(long, value_enum, default_value = "hand")]
    pub body: BodyKind,
    /// How many triangles it has; 6,000, 20,000, 150,000 and 1,000,000 by default.
    #[arg(long, value_delimiter = ',')]
    pub triangles: Vec<u32>,
    /// Parts of an object that is measured besides, of made-up objects side by side; 0 for none.
    #[arg(long, default_value_t = 100)]
    pub parts: usize,
    /// Times that each is unwrapped with one thread and with two, in turn; the medians count.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=99))]
    pub repeat: u32,
    /// Folder for cores.json, cores.md and cores.svg. Made if need be.
    #[arg(short, long, default_value = "cores")]
    pub output: PathBuf,
    #[command(flatten)]
    pub bench: BenchOptions,
}

/// What so many threads took.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    pub threads: usize,
    /// From the file's bytes to the artifacts: the median.
    pub seconds: f64,
    /// Seconds of each stage, medians.
    pub stages: Vec<(String, f64)>,
}

/// One object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    pub name: String,
    pub triangles: u64,
    pub measured: Vec<Measured>,
    /// MiB that each thread beyond the first adds to the most memory that a process holds.
    pub memory_a_thread: Option<f64>,
    /// What was recorded: of several runs that with the median of the work.
    pub plan: Plan,
}

/// Run it.
pub fn run(args: Args) -> Result<()> {
    std::fs::create_dir_all(&args.output)
        .with_context(|| format!("cannot make the folder {}", args.output.display()))?;
    let engine = args.bench.engine()?;
    let folder = std::env::temp_dir().join(format!("uvsegnet-cores-{}", std::process::id()));
    std::fs::create_dir_all(&folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let bench = Bench::new(&args, &engine)?;
    let mut rows = Vec::new();
    for object in Object::all(&args) {
        let row = bench.row(&object, &object.write(&folder)?, &folder)?;
        eprintln!("{}", table::brief(&row));
        rows.push(row);
        let write = |name: &str, text: &str| {
            let path = args.output.join(name);
            std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))
        };
        write("cores.json", &serde_json::to_string_pretty(&rows)?)?;
        write("cores.md", &table::table(&rows))?;
        write("cores.svg", &plot::plot(&table::curves(&rows), "threads", " ×"))?;
    }
    std::fs::remove_dir_all(&folder).ok();
    println!("{}", table::table(&rows));
    Ok(())
}

/// What every object is measured with.
struct Bench<'a> {
    args: &'a Args,
    engine: &'a Engine,
    /// Of the threads of [`MEASURED`].
    pools: Vec<ThreadPool>,
}

impl<'a> Bench<'a> {
    fn new(args: &'a Args, engine: &'a Engine) -> Result<Self> {
        let pool = |&threads: &usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK);
            pool.build().context("cannot start the threads")
        };
        Ok(Self { args, engine, pools: MEASURED.iter().map(pool).collect::<Result<_>>()? })
    }

    /// One thread, two, and a recording in turn, so that what else the machine does falls on all.
    fn row(&self, object: &Object, mesh: &Path, folder: &Path) -> Result<Row> {
        let files = Files::read(mesh, &Beside::default())?;
        let options = &self.args.bench.options;
        let unwrap = || Ok::<_, Error>(unwrap(&files, options, self.engine)?.metrics);
        // The first run lays out the weights and warms the allocator.
        let first = self.pools[0].install(unwrap)?;
        let (mut runs, mut plans) = (MEASURED.map(|_| Vec::new()), Vec::new());
        for _ in 0..self.args.repeat {
            for (pool, runs) in self.pools.iter().zip(&mut runs) {
                runs.push(pool.install(unwrap)?);
            }
            plans.push(self.pools[0].install(|| plan::record(&files, options, self.engine))?);
        }
        plans.sort_by(|a, b| a.whole.work.total_cmp(&b.whole.work));
        let plan = plans.swap_remove(plans.len() / 2);
        let measured = |(&threads, runs): (&usize, &Vec<Metrics>)| {
            let stage = |(i, stage): (usize, &StageCost)| {
                let seconds = runs.iter().filter_map(|m| Some(m.cost.stages.get(i)?.wall_s));
                (stage.name.clone(), median(seconds.collect()))
            };
            Measured {
                threads,
                seconds: median(runs.iter().map(|m| m.cost.wall_s).collect()),
                stages: first.cost.stages.iter().enumerate().map(stage).collect(),
            }
        };
        Ok(Row {
            name: object.name(),
            triangles: first.parts.iter().map(|part| part.faces).sum(),
            measured: MEASURED.iter().zip(&runs).map(measured).collect(),
            memory_a_thread: memory_a_thread(mesh, folder)?,
            plan,
        })
    }
}

/// What a process of [`MANY`] threads holds more than one of a single thread, for each thread more. Memory is told
/// of a process, so each needs one of its own.
fn memory_a_thread(mesh: &Path, folder: &Path) -> Result<Option<f64>> {
    let program = std::env::current_exe().context("cannot find this program")?;
    let held = |threads: usize| {
        let options = ["--threads".into(), threads.to_string()];
        let ran = program::unwrap(&program, mesh, &options, folder)?;
        Ok::<_, Error>(ran.at("/cost/peak_memory_mib"))
    };
    let (one, many) = (held(1)?, held(MANY)?);
    Ok(one.zip(many).map(|(one, many)| (many - one) / (MANY - 1) as f64))
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
