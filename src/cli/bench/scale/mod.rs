//! `uvsegnet bench scale`: what an unwrap costs, and into how many charts it cuts, as meshes grow, get noisy
//! and come in more pieces: closed bodies of the program's own, each unwrapped by a process of its own.

mod body;
mod exponent;
mod plot;
mod table;

use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result, ensure};

use super::files::{appending, read_rows};
use crate::synth::{BodyKind, NoiseKind};
use body::{Case, Row};

/// Sizes by default, triangles.
const SIZES: [u32; 7] = [5_000, 20_000, 50_000, 150_000, 500_000, 1_200_000, 2_000_000];

/// Noise by default, mean edges.
const NOISES: [f64; 3] = [0.0, 1.0 / 6.0, 1.0 / 3.0];

/// Pieces by default.
const COPIES: [u32; 4] = [1, 8, 64, 500];

/// Arguments of `uvsegnet bench scale`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Which bodies; all by default.
    #[arg(long, value_enum, value_delimiter = ',')]
    pub bodies: Vec<BodyKind>,
    /// How many triangles; 5,000 to 2,000,000 in seven sizes by default.
    #[arg(long, value_delimiter = ',')]
    pub triangles: Vec<u32>,
    /// How much noise, in mean edge lengths; none, a sixth and a third by default.
    #[arg(long, value_delimiter = ',')]
    pub noise: Vec<f64>,
    /// Which way the noise moves a vertex.
    #[arg(long, value_enum, default_value_t)]
    pub noise_kind: NoiseKind,
    /// How many of a body stand in the mesh, where there is no noise; 1, 8, 64 and 500 by default.
    #[arg(long, value_delimiter = ',')]
    pub copies: Vec<u32>,
    /// Times that each is unwrapped; the figures are of the run with the median of the seconds.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=99))]
    pub repeat: u32,
    /// Another build of this program to be measured beside it, run by run.
    #[arg(long)]
    pub beside: Option<PathBuf>,
    /// Folder for scale.jsonl (a line a mesh and program), scale.md and scale.svg. Meshes that have their
    /// lines are not measured again.
    #[arg(short, long, default_value = "scale")]
    pub output: PathBuf,
    /// What the programs are told besides, as in `-- --quality fast`.
    #[arg(last = true)]
    pub options: Vec<String>,
}

/// Run it.
pub fn run(args: Args) -> Result<()> {
    std::fs::create_dir_all(&args.output)
        .with_context(|| format!("cannot make the folder {}", args.output.display()))?;
    let cases = cases(&args);
    ensure!(!cases.is_empty(), "no body has so few triangles in so many pieces: ask for more");
    let lines = args.output.join("scale.jsonl");
    let mut rows: Vec<Row> = if lines.exists() { read_rows(&lines)? } else { Vec::new() };
    let this = std::env::current_exe().context("cannot find this program")?;
    let programs: Vec<(&str, &PathBuf)> =
        [("this", &this)].into_iter().chain(args.beside.iter().map(|p| ("beside", p))).collect();
    let folder = std::env::temp_dir().join(format!("uvsegnet-scale-{}", std::process::id()));
    std::fs::create_dir_all(&folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let mut file = appending(&lines)?;
    for case in &cases {
        if rows.iter().any(|row| row.case == *case) {
            continue;
        }
        let mesh = case.write(&folder)?;
        let measured = body::measure(case, &programs, &mesh, args.repeat, &args.options, &folder)?;
        for row in &measured {
            eprintln!("{}", table::brief(row));
            writeln!(file, "{}", serde_json::to_string(row)?).context("cannot write a line")?;
        }
        rows.extend(measured);
    }
    std::fs::remove_dir_all(&folder).ok();
    let write = |name: &str, text: &str| {
        let path = args.output.join(name);
        std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))
    };
    let table = table::table(&rows);
    write("scale.md", &table)?;
    write("scale.svg", &plot::plot(&rows))?;
    println!("{table}");
    Ok(())
}

/// Every mesh that is asked for: the smallest first, so that a run that is stopped has shown something.
fn cases(args: &Args) -> Vec<Case> {
    fn or<T: Clone>(asked: &[T], default: &[T]) -> Vec<T> {
        if asked.is_empty() { default } else { asked }.to_vec()
    }
    let mut cases = Vec::new();
    for triangles in or(&args.triangles, &SIZES) {
        for body in or(&args.bodies, &BodyKind::SCANNED) {
            for copies in or(&args.copies, &COPIES) {
                for noise in or(&args.noise, &NOISES) {
                    let large_enough = (triangles / copies) as usize >= body.fewest();
                    if large_enough && (copies == 1 || noise == 0.0) {
                        let noise_kind = args.noise_kind;
                        cases.push(Case { body, triangles, noise, noise_kind, copies });
                    }
                }
            }
        }
    }
    cases.sort_by_key(|case| case.triangles);
    cases
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(clap::Parser)]
    struct Line {
        #[command(flatten)]
        args: Args,
    }

    fn asked(line: &str) -> Vec<Case> {
        let words = std::iter::once("scale").chain(line.split_whitespace());
        cases(&<Line as clap::Parser>::parse_from(words).args)
    }

    #[test]
    fn every_size_and_noise_of_one_piece_and_the_smooth_ones_of_more() {
        let all = asked("");
        let count = |of: &dyn Fn(&Case) -> bool| all.iter().filter(|case| of(case)).count();
        assert_eq!(count(&|case| case.copies == 1), BodyKind::SCANNED.len() * 7 * 3);
        assert_eq!(count(&|case| case.copies > 1 && case.noise > 0.0), 0);
        assert!(count(&|case| case.copies == 500) >= 6);
        assert!(all.is_sorted_by_key(|case| case.triangles));
        // 5,000 triangles are too few for two animals.
        assert!(asked("--bodies animal --triangles 5000 --copies 2").is_empty());
        assert_eq!(asked("--bodies hand,vase --triangles 20000 --noise 0 --copies 1,2").len(), 4);
    }
}
