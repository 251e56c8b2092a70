//! Where the files of a result go: one flag for each of the table of artifacts that the command line
//! writes, or one folder for all of them.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::{Arg, ArgMatches, Command, FromArgMatches, value_parser};

use super::ending;
use crate::contract::ArtifactKind;
use crate::pipeline::Unwrapped;

/// The flag of the folder.
const FOLDER: &str = "folder";

/// Where the files go.
#[derive(Debug, Clone)]
pub enum Outputs {
    /// A path for each file that was asked for, of one mesh.
    Files(Vec<(ArtifactKind, PathBuf)>),
    /// A folder, in which each mesh gets one of its own that is named as the mesh is, with every file of its result.
    Folder(PathBuf),
}

impl Outputs {
    /// Whether pictures may be among them.
    pub fn hold_pictures(&self) -> bool {
        let is_picture = |kind| matches!(kind, ArtifactKind::Layout | ArtifactKind::Preview);
        match self {
            Self::Files(files) => files.iter().any(|(kind, _)| is_picture(*kind)),
            Self::Folder(_) => true,
        }
    }

    /// An error where the files of two of these meshes would be one, or several meshes were given for one file.
    pub fn hold(&self, meshes: &[PathBuf]) -> Result<()> {
        if let (Self::Files(_), [_, _, ..]) = (self, meshes) {
            let meshes = meshes.len();
            bail!(
                "{meshes} meshes were given: say with --{FOLDER} where their files go, and not with --output"
            );
        }
        let mut names: BTreeMap<&OsStr, &Path> = BTreeMap::new();
        for mesh in meshes {
            if let Some(other) = names.insert(name(mesh), mesh) {
                let (mesh, other) = (mesh.display(), other.display());
                bail!("{other} and {mesh} have one name: their files would go into one folder");
            }
        }
        Ok(())
    }

    /// Write what was asked for of a mesh's result. A file that the result does not have is told of.
    pub fn write(&self, mesh: &Path, result: &Unwrapped) -> Result<()> {
        let write = |path: &Path, bytes: &[u8]| {
            std::fs::write(path, bytes).with_context(|| format!("cannot write {}", path.display()))
        };
        match self {
            Self::Folder(folder) => {
                let folder = folder.join(name(mesh));
                std::fs::create_dir_all(&folder)
                    .with_context(|| format!("cannot make the folder {}", folder.display()))?;
                for artifact in result.artifacts() {
                    write(&folder.join(artifact.kind.name()), &artifact.bytes)?;
                }
            }
            Self::Files(files) => {
                for (kind, path) in files {
                    match result.artifact(*kind) {
                        Some(bytes) => write(path, bytes)?,
                        None => {
                            let (name, when) = (kind.name(), kind.when().as_str());
                            eprintln!("note: there is no {name}; it is written {when}");
                        }
                    }
                }
            }
        }
        Ok(())
    }
}

/// A mesh's name: that of its file, without the ending.
fn name(mesh: &Path) -> &OsStr {
    mesh.file_stem().unwrap_or_default()
}

/// The kinds that have a flag.
fn kinds() -> impl Iterator<Item = ArtifactKind> {
    ArtifactKind::ALL.iter().copied().filter(|kind| !kind.flag().is_empty())
}

impl clap::Args for Outputs {
    fn augment_args(command: Command) -> Command {
        let files = kinds().map(|kind| {
            let flag = Arg::new(kind.flag()).long(kind.flag()).value_name("FILE");
            let flag = flag.value_parser(ending::of(vec![kind])).conflicts_with(FOLDER);
            match kind {
                ArtifactKind::Model => {
                    flag.short('o').required_unless_present(FOLDER).help(kind.what())
                }
                _ => flag.help(format!("{} ({})", kind.what(), kind.name())),
            }
        });
        let folder = Arg::new(FOLDER).long(FOLDER).value_name("FOLDER");
        let folder = folder.value_parser(value_parser!(PathBuf)).help(
            "Write all files, by the names that the service gives them, into a folder in this one for each mesh, named as it is",
        );
        command.args(files).arg(folder)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Outputs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        if let Some(folder) = matches.get_one::<PathBuf>(FOLDER) {
            return Ok(Self::Folder(folder.clone()));
        }
        let given =
            |kind: ArtifactKind| Some((kind, matches.get_one::<PathBuf>(kind.flag())?.clone()));
        Ok(Self::Files(kinds().filter_map(given).collect()))
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

    fn parsed(flags: &[&str]) -> Result<Outputs, clap::Error> {
        Flags::try_parse_from([&["x"], flags].concat()).map(|flags| flags.outputs)
    }

    #[test]
    fn every_file_must_end_as_what_is_written_there() {
        let files = parsed(&["-o", "a.glb", "--preview", "p.png", "--layout", "l"]).unwrap();
        assert!(matches!(files, Outputs::Files(files) if files.len() == 3));
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

    #[test]
    fn either_files_are_named_or_a_folder_is() {
        assert!(matches!(parsed(&["--folder", "d"]), Ok(Outputs::Folder(_))));
        for wrong in [&[][..], &["-o", "a.glb", "--folder", "d"], &["--preview", "p.png"]] {
            assert!(parsed(wrong).is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn two_meshes_never_share_a_file() {
        let folder = Outputs::Folder("d".into());
        let hold = |outputs: &Outputs, meshes: &[&str]| {
            let meshes: Vec<PathBuf> = meshes.iter().map(PathBuf::from).collect();
            outputs.hold(&meshes).map_err(|error| error.to_string())
        };
        assert_eq!(hold(&folder, &["a/x.glb", "a/y.glb"]), Ok(()));
        let error = hold(&folder, &["a/x.glb", "y.glb", "b/x.obj"]).unwrap_err();
        assert!(error.starts_with("a/x.glb and b/x.obj have one name"), "{error}");
        let file = parsed(&["-o", "a.glb"]).unwrap();
        assert_eq!(hold(&file, &["x.glb"]), Ok(()));
        assert!(hold(&file, &["x.glb", "y.glb"]).unwrap_err().contains("--folder"));
    }
}
