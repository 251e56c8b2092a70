//! Many files in one process: `uvsegnet unwrap A B … --folder DIR`. The weights are laid out once and threads
//! stay warm; while one file is at a stretch that runs on one thread, another has the rest.

use std::any::Any;
use std::io::IsTerminal;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use anyhow::{Context, Result, anyhow, bail};
use indicatif::{ProgressBar, ProgressStyle};

use super::input::{Beside, Files};
use super::told;
use crate::contract::{Budget, Cancel, Limits, Progress, Run, UnwrapOptions};
use crate::pipeline::{self, Engine, STACK, Unwrapped};

/// How many meshes are worked on at once where nobody says: half as many again as there are threads, since each has
/// stretches that run on one thread. Of 40 chairs of 1,000 triangles two cores do 267 a minute two at once, 330
/// three at once and 336 four at once.
pub fn at_once(threads: usize) -> usize {
    threads + threads / 2
}

/// Unwrap meshes, `at_once` of them at a time, and hand each result to `write`. A file that fails is told, and
/// the others go on; in the end it is an error.
pub fn unwrap(
    meshes: &[PathBuf],
    at_once: usize,
    (options, engine): (&UnwrapOptions, &Engine),
    quiet: bool,
    write: &(impl Fn(&Path, &Unwrapped) -> Result<()> + Sync),
) -> Result<()> {
    let bar = bar(meshes.len(), quiet);
    let say = |mesh: &Path, what: &str| {
        bar.suspend(|| eprintln!("{}: {}", mesh.display(), told::as_flags(what)));
    };
    let one = |mesh: &Path| -> Result<String> {
        let files = Files::read(mesh, &Beside::default())?;
        let (name, bar) = (mesh.to_owned(), bar.clone());
        let tell = move |progress| {
            if let Progress::Warning(warning) = progress {
                let line = told::as_flags(&warning.message);
                bar.suspend(|| eprintln!("{}: warning: {line}", name.display()));
            }
        };
        let budget = Budget::new(options.budget_s, options.budget_mib);
        let run = Run::new(tell, Cancel::default(), budget);
        let limits = Limits::default();
        let result = pipeline::unwrap_input(&files.input(), options, &limits, engine, &run)?;
        write(mesh, &result)?;
        Ok(result.summary())
    };
    let (next, failed) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let work = || {
        while let Some(mesh) = meshes.get(next.fetch_add(1, Ordering::Relaxed)) {
            match catch_unwind(AssertUnwindSafe(|| one(mesh))).unwrap_or_else(panicked) {
                Ok(_) if quiet => {}
                Ok(summary) => say(mesh, &summary),
                Err(error) => {
                    failed.fetch_add(1, Ordering::Relaxed);
                    say(mesh, &format!("error: {error:#}"));
                }
            }
            bar.inc(1);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..at_once.clamp(1, meshes.len().max(1)) {
            let thread = std::thread::Builder::new().name("pipeline".into()).stack_size(STACK);
            thread.spawn_scoped(scope, work).context("cannot start a thread")?;
        }
        anyhow::Ok(())
    })?;
    bar.finish_and_clear();
    match failed.into_inner() {
        0 => Ok(()),
        failed => bail!("{failed} of {} files failed: each is told above", meshes.len()),
    }
}

/// What the panic was has been printed by then.
fn panicked(_: Box<dyn Any + Send>) -> Result<String> {
    Err(anyhow!("it made the program panic: a mistake of ours, please report it with the file"))
}

/// How many files are done, on a terminal.
fn bar(files: usize, quiet: bool) -> ProgressBar {
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(files as u64);
    let style = ProgressStyle::with_template("{pos}/{len} files {wide_bar} {elapsed}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;
    use crate::contract::{ArtifactKind, Quality, SegmentationSource};
    use crate::device::Device;

    #[test]
    fn each_file_comes_out_as_it_does_alone_and_one_that_fails_stops_no_other() {
        let options = UnwrapOptions {
            quality: Quality::Fast,
            segmentation: SegmentationSource::Geometric,
            preview: false,
            ..Default::default()
        };
        let engine = Engine::new(Device::cpu());
        let sample =
            |name| PathBuf::from(format!("{}/examples/{name}.glb", env!("CARGO_MANIFEST_DIR")));
        let sound = ["table", "knife"].map(sample);
        let broken = PathBuf::from(file!());
        let meshes = [sound[0].clone(), broken, sound[1].clone()];
        let made = Mutex::new(Vec::new());
        let keep = |mesh: &Path, result: &Unwrapped| {
            let model = result.artifact(ArtifactKind::Model).map(<[u8]>::to_vec);
            made.lock().unwrap().push((mesh.to_owned(), model));
            Ok(())
        };
        let error = unwrap(&meshes, 2, (&options, &engine), true, &keep).unwrap_err();
        assert_eq!(error.to_string(), "1 of 3 files failed: each is told above");
        let mut made = made.into_inner().unwrap();
        made.sort();
        let mut alone = sound.map(|mesh| {
            let files = Files::read(&mesh, &Beside::default()).unwrap();
            let (limits, run) = (Limits::default(), Run::quiet());
            let result = pipeline::unwrap_input(&files.input(), &options, &limits, &engine, &run);
            let model = result.unwrap().artifact(ArtifactKind::Model).map(<[u8]>::to_vec);
            (mesh, model)
        });
        alone.sort();
        assert_eq!(made, alone);
    }
}
