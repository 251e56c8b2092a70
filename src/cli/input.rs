//! Reading the mesh that a command is given, and the files beside it: one flag for each role of the table
//! of inputs.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow};
use clap::{Arg, ArgMatches, Command, FromArgMatches, value_parser};

use crate::contract::{InputRole, MeshKind};
use crate::pipeline::{Input, InputFile};

/// The files beside the mesh that were named.
#[derive(Debug, Clone, Default)]
pub struct Beside(Vec<(InputRole, PathBuf)>);

impl Beside {
    /// Only part labels.
    pub fn labels(path: PathBuf) -> Self {
        Self(vec![(InputRole::Labels, path)])
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// The roles that have a flag: all but the mesh, which needs none.
fn roles() -> impl Iterator<Item = InputRole> {
    InputRole::ALL.iter().copied().filter(|role| *role != InputRole::Mesh)
}

impl clap::Args for Beside {
    fn augment_args(command: Command) -> Command {
        command.args(roles().map(|role| {
            let flag = Arg::new(role.form_part()).long(role.form_part()).value_name("FILE");
            flag.value_parser(value_parser!(PathBuf)).help(role.what())
        }))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Beside {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given =
            |role: InputRole| Some((role, matches.get_one::<PathBuf>(role.form_part())?.clone()));
        Ok(Self(roles().filter_map(given).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// Files in memory.
pub struct Files {
    mesh: Vec<u8>,
    kind: MeshKind,
    beside: Vec<(InputRole, Vec<u8>)>,
}

impl Files {
    /// Read a mesh and the files beside it.
    pub fn read(mesh: &Path, beside: &Beside) -> Result<Self> {
        let read = |path: &Path| {
            std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))
        };
        let bytes = read(mesh)?;
        let beside = beside.0.iter().map(|(role, path)| Ok((*role, read(path)?)));
        let beside = beside.collect::<Result<_>>()?;
        let kind = MeshKind::detect(&bytes).ok_or_else(|| {
            anyhow!("{} is no {} file: convert it first", mesh.display(), MeshKind::names())
        })?;
        Ok(Self { mesh: bytes, kind, beside })
    }

    /// What the pipeline takes.
    pub fn input(&self) -> Input<'_> {
        let files = self.beside.iter();
        let files = files.map(|(role, bytes)| InputFile { role: *role, name: "", bytes });
        Input::new(self.kind, &self.mesh).with(files)
    }
}
