//! Where the files of a result go: one flag for each of the table of artifacts that the command line
//! writes.

use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::{Arg, ArgMatches, Command, FromArgMatches};

use super::ending;
use crate::contract::ArtifactKind;
use crate::pipeline::Unwrapped;

/// A path for each file that was asked for.
#[derive(Debug, Clone, Default)]
pub struct Outputs(Vec<(ArtifactKind, PathBuf)>);

impl Outputs {
    /// Whether pictures are among them.
    pub fn hold_pictures(&self) -> bool {
        self.0.iter().any(|(kind, _)| matches!(kind, ArtifactKind::Layout | ArtifactKind::Preview))
    }

    /// Write what was asked for. A file that the result does not have is told of.
    pub fn write(&self, result: &Unwrapped) -> Result<()> {
        for (kind, path) in &self.0 {
            match result.artifact(*kind) {
                Some(bytes) => std::fs::write(path, bytes)
                    .with_context(|| format!("cannot write {}", path.display()))?,
                None => {
                    let (name, when) = (kind.name(), kind.when().as_str());
                    eprintln!("note: there is no {name}; it is written {when}");
                }
            }
        }
        Ok(())
    }
}

/// The kinds that have a flag.
fn kinds() -> impl Iterator<Item = ArtifactKind> {
    ArtifactKind::ALL.iter().copied().filter(|kind| !kind.flag().is_empty())
}

impl clap::Args for Outputs {
    fn augment_args(command: Command) -> Command {
        command.args(kinds().map(|kind| {
            let flag = Arg::new(kind.flag()).long(kind.flag()).value_name("FILE");
            let flag = flag.value_parser(ending::of(vec![kind]));
            match kind {
                ArtifactKind::Model => flag.short('o').required(true).help(kind.what()),
                _ => flag.help(format!("{} ({})", kind.what(), kind.name())),
            }
        }))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Outputs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given =
            |kind: ArtifactKind| Some((kind, matches.get_one::<PathBuf>(kind.flag())?.clone()));
        Ok(Self(kinds().filter_map(given).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Flags {
        #[command(flatten)]
        outputs: Outputs,
    }

    #[test]
    fn every_file_must_end_as_what_is_written_there() {
        let parsed = |flags: &[&str]| {
            Flags::try_parse_from([&["x"], flags].concat()).map(|flags| flags.outputs.0.len())
        };
        assert_eq!(parsed(&["-o", "a.glb", "--preview", "p.png", "--layout", "l"]).unwrap(), 3);
        for wrong in [
            &["-o", "a.obj"][..],
            &["-o", "a.fbx"],
            &["-o", "a.glb", "--preview", "p.jpg"],
            &["-o", "a.glb", "--metrics", "m.glb"],
        ] {
            let error = parsed(wrong).unwrap_err().to_string();
            assert!(error.contains("cannot be written here; what can: ."), "{error}");
        }
    }
}
