//! The files that a job is given, in memory: a mesh, and what stands beside it.

use crate::contract::{InputRole, MeshKind};

/// The files of a job.
#[derive(Debug, Clone)]
pub struct Input<'a> {
    mesh: &'a [u8],
    kind: MeshKind,
    beside: Vec<InputFile<'a>>,
}

/// A file beside the mesh.
#[derive(Debug, Clone, Copy)]
pub struct InputFile<'a> {
    /// What it is for.
    pub role: InputRole,
    /// Its name, as it was given; may be empty.
    pub name: &'a str,
    /// The file.
    pub bytes: &'a [u8],
}

impl<'a> Input<'a> {
    /// A mesh and nothing beside it.
    pub fn new(kind: MeshKind, mesh: &'a [u8]) -> Self {
        Self { mesh, kind, beside: Vec::new() }
    }

    /// The same with more files beside it.
    pub fn with(mut self, files: impl IntoIterator<Item = InputFile<'a>>) -> Self {
        self.beside.extend(files);
        self
    }

    /// The mesh.
    pub fn mesh(&self) -> &'a [u8] {
        self.mesh
    }

    /// What kind of file the mesh is.
    pub fn kind(&self) -> MeshKind {
        self.kind
    }

    /// Part labels: one integer a line, line i for face i, −1 unknown.
    pub fn labels(&self) -> Option<&'a [u8]> {
        self.of(InputRole::Labels).next().map(|file| file.bytes)
    }

    /// The files of this role that stand beside the mesh, in the order in which they were given.
    pub fn of(&self, role: InputRole) -> impl Iterator<Item = &InputFile<'a>> {
        self.beside.iter().filter(move |file| file.role == role)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_found_by_role() {
        let alone = Input::new(MeshKind::Obj, b"v 0 0 0");
        assert_eq!((alone.kind(), alone.mesh()), (MeshKind::Obj, &b"v 0 0 0"[..]));
        assert_eq!(alone.labels(), None);
        let labels = InputFile { role: InputRole::Labels, name: "parts.txt", bytes: b"0" };
        assert_eq!(alone.with([labels]).labels(), Some(&b"0"[..]));
    }
}
