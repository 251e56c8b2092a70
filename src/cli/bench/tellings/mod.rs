//! `uvsegnet bench tellings`: the same object told in many ways, as exporters do. Every telling is unwrapped
//! by a process of its own and held against the first.

mod measure;
mod mesh;
mod remade;
mod table;
mod variants;

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use clap::ValueEnum;

use super::files::{Shard, appending, named, read_rows, stem};
use crate::cli::input::{Beside, Files};
use crate::contract::Limits;
use crate::synth::body::{self, BodyStyle};
use crate::synth::{BodyKind, samples};
use measure::{Row, Told};
use mesh::PlainMesh;
use variants::Variant;

/// Arguments of `uvsegnet bench tellings`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of meshes, searched to the bottom; without one, a sample and bodies of the program's own.
    pub dir: Option<PathBuf>,
    /// Which objects of it: one file name without its extension a line, # begins a comment.
    #[arg(long, requires = "dir")]
    pub names: Option<PathBuf>,
    /// I/N: every N-th object, by file size, from the I-th on.
    #[arg(long, default_value_t)]
    pub shard: Shard,
    /// Objects of more triangles are left out.
    #[arg(long, default_value_t = 30_000)]
    pub most: usize,
    /// Which tellings besides the first; all by default.
    #[arg(long, value_enum, value_delimiter = ',')]
    pub tellings: Vec<Variant>,
    /// What is drawn is drawn from this.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Another build of this program to be measured beside it, telling by telling.
    #[arg(long)]
    pub beside: Option<PathBuf>,
    /// Folder for tellings.jsonl (a line a telling and program) and tellings.md. Objects that have their lines
    /// are not measured again.
    #[arg(short, long, default_value = "tellings")]
    pub output: PathBuf,
    /// Write the files of the tellings here, too: OBJECT_TELLING.obj.
    #[arg(long)]
    pub keep: Option<PathBuf>,
    /// What the programs are told besides, as in `-- --quality fast`.
    #[arg(last = true)]
    pub options: Vec<String>,
}

/// Triangles of the program's own bodies.
const TRIANGLES: usize = 10_000;

/// Run it.
pub fn run(args: Args) -> Result<()> {
    for folder in [Some(&args.output), args.keep.as_ref()].into_iter().flatten() {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    }
    let lines = args.output.join("tellings.jsonl");
    let mut rows: Vec<Row> = if lines.exists() { read_rows(&lines)? } else { Vec::new() };
    let this = std::env::current_exe().context("cannot find this program")?;
    let programs: Vec<(&str, &Path)> = [("this", this.as_path())]
        .into_iter()
        .chain(args.beside.iter().map(|program| ("beside", program.as_path())))
        .collect();
    let folder = std::env::temp_dir().join(format!("uvsegnet-tellings-{}", std::process::id()));
    std::fs::create_dir_all(&folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let mut file = appending(&lines)?;
    let objects = objects(&args)?;
    ensure!(!objects.is_empty(), "there is no object to be told");
    for (object, path) in objects {
        if rows.iter().any(|row| row.object == object) {
            continue;
        }
        let mesh = match load(&object, path.as_deref()) {
            Ok(mesh) => mesh,
            Err(error) => {
                eprintln!("{object}: {error:#}");
                continue;
            }
        };
        if mesh.triangles.len() > args.most {
            continue;
        }
        for row in tell(&object, &mesh, &args, &programs, &folder)? {
            eprintln!("{}", table::brief(&row));
            writeln!(file, "{}", serde_json::to_string(&row)?).context("cannot write a line")?;
            rows.push(row);
        }
    }
    std::fs::remove_dir_all(&folder).ok();
    let table = table::table(&rows);
    let path = args.output.join("tellings.md");
    std::fs::write(&path, &table).with_context(|| format!("cannot write {}", path.display()))?;
    println!("{table}");
    Ok(())
}

/// Every telling of an object by every program.
fn tell(
    object: &str,
    mesh: &PlainMesh,
    args: &Args,
    programs: &[(&str, &Path)],
    folder: &Path,
) -> Result<Vec<Row>> {
    let asked = |v: &&Variant| {
        **v == Variant::AsIs || args.tellings.is_empty() || args.tellings.contains(v)
    };
    let mut first: Vec<Option<Told>> = programs.iter().map(|_| None).collect();
    let mut rows = Vec::new();
    for &variant in Variant::value_variants().iter().filter(asked) {
        let told = variant.tell(mesh, args.seed);
        if let Some(keep) = &args.keep {
            let path = keep.join(format!("{object}_{}.obj", variant.name()));
            std::fs::write(&path, told.obj())
                .with_context(|| format!("cannot write {}", path.display()))?;
        }
        for ((name, program), first) in programs.iter().zip(&mut first) {
            let made = measure::unwrap(program, &told, &args.options, folder).map(|mut made| {
                if let Some(first) = first.as_ref() {
                    made.compare(&told, first);
                }
                made
            });
            let (figures, error) = match &made {
                Ok(made) => (Some(made.figures.clone()), None),
                Err(error) => (None, Some(format!("{error:#}"))),
            };
            let program = (*name).to_owned();
            rows.push(Row { object: object.to_owned(), variant, program, error, figures });
            if variant == Variant::AsIs {
                *first = made.ok();
            }
        }
    }
    Ok(rows)
}

/// Names of the objects, and their files but for the program's own.
fn objects(args: &Args) -> Result<Vec<(String, Option<PathBuf>)>> {
    let files = match (&args.dir, &args.names) {
        (None, _) => {
            let bodies = BodyKind::all().map(|body| body.as_str());
            return Ok(std::iter::once("chair")
                .chain(bodies)
                .map(|n| (n.to_owned(), None))
                .collect());
        }
        (Some(dir), Some(list)) => named(dir, list)?,
        (Some(dir), None) => args.shard.of(dir)?,
    };
    Ok(files.into_iter().map(|path| (stem(&path), Some(path))).collect())
}

/// The mesh of an object.
fn load(object: &str, path: Option<&Path>) -> Result<PlainMesh> {
    if let Some(path) = path {
        let files = Files::read(path, &Beside::default())?;
        let input = files.input();
        let scene = crate::mesh::import(input.mesh(), input.kind(), &Limits::default())?;
        return Ok(PlainMesh::of(&scene));
    }
    let bytes = match BodyKind::all().find(|body| body.as_str() == object) {
        Some(kind) => {
            let style = BodyStyle { triangles: TRIANGLES, ..BodyStyle::default() };
            body::make(kind, style).glb(object)
        }
        None => samples::CHAIR.to_vec(),
    };
    let kind = crate::contract::MeshKind::Glb;
    Ok(PlainMesh::of(&crate::mesh::import(&bytes, kind, &Limits::default())?))
}
