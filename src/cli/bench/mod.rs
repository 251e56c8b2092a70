//! `uvsegnet bench`: how good the results are on a folder of meshes, whether they are the same bytes
//! every time, and what they look like.

mod arms;
mod by_name;
mod cell;
mod cores;
mod determinism;
mod files;
mod names;
mod object;
mod options;
mod peer;
mod plot;
mod program;
mod progress;
mod quality;
mod row;
mod same;
mod scale;
mod segmentation;
mod sheet;
mod stages;
mod table;
mod tellings;

use anyhow::Result;
use clap::Subcommand;

/// Arguments of `uvsegnet bench`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Unwrap objects with one thread and with two, and record one run each: work and span of every stage, the
    /// seconds to expect of 4, 16 and 64 threads, and what the longest chain of tasks is made of.
    Cores(cores::Args),
    /// Unwrap every mesh of a folder, next to the classical unwrapper on the same conditioned surface; write
    /// one JSON line an object and print the table.
    Quality(quality::Args),
    /// Unwrap objects with one thread, two, three and eight, and compare every file byte for byte.
    Determinism(determinism::Args),
    /// Name the parts of labelled objects, and tell how often the names are right, by how sure they are.
    Names(names::Args),
    /// Unwrap objects and tell how far the fraction that each job tells lies from the time that has gone.
    Progress(progress::Args),
    /// Unwrap objects with this program and with another build of it, with one thread and with two, and
    /// compare every file.
    Same(same::Args),
    /// Unwrap bodies of the program's own from 5,000 to 2,000,000 triangles, smooth and noisy, of one piece and
    /// of many: seconds of each stage, memory, charts, seams, and how they grow.
    Scale(scale::Args),
    /// Find the parts of labelled objects, by each source alone and by all together, and compare them with
    /// the labels.
    Segmentation(segmentation::Args),
    /// Unwrap objects and show them on one picture: checker, seams, layout, figures.
    Sheet(sheet::Args),
    /// Unwrap one object and draw what each stage makes of it, a picture each.
    Stages(stages::Args),
    /// Tell objects in many ways, as exporters do (faces shuffled, windings turned, faces twice, noise, and more),
    /// unwrap each telling, and hold it against the first: charts, seam, parts, division.
    Tellings(tellings::Args),
}

/// Run it.
pub fn run(args: Args) -> Result<()> {
    match args.what {
        What::Cores(args) => cores::run(args),
        What::Quality(args) => quality::run(args),
        What::Determinism(args) => determinism::run(args),
        What::Names(args) => names::run(args),
        What::Progress(args) => progress::run(args),
        What::Same(args) => same::run(args),
        What::Scale(args) => scale::run(args),
        What::Segmentation(args) => segmentation::run(args),
        What::Sheet(args) => sheet::run(args),
        What::Stages(args) => stages::run(args),
        What::Tellings(args) => tellings::run(args),
    }
}
