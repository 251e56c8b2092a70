//! Reading the mesh that a command is given, and the labels beside it.

use std::path::Path;

use anyhow::{Context, Result, anyhow};

use crate::contract::{InputRole, MeshKind};
use crate::pipeline::{Input, InputFile};

/// Files in memory.
pub struct Files {
    mesh: Vec<u8>,
    kind: MeshKind,
    labels: Option<Vec<u8>>,
}

impl Files {
    /// Read a mesh and, if given, its labels.
    pub fn read(mesh: &Path, labels: Option<&Path>) -> Result<Self> {
        let read = |path: &Path| {
            std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))
        };
        let (bytes, labels) = (read(mesh)?, labels.map(read).transpose()?);
        let kind = MeshKind::detect(&bytes).ok_or_else(|| {
            anyhow!("{} is no {} file: convert it first", mesh.display(), MeshKind::names())
        })?;
        Ok(Self { mesh: bytes, kind, labels })
    }

    /// What the pipeline takes.
    pub fn input(&self) -> Input<'_> {
        let labels = self.labels.as_deref();
        let labels = labels.map(|bytes| InputFile { role: InputRole::Labels, name: "", bytes });
        Input::new(self.kind, &self.mesh).with(labels)
    }
}
