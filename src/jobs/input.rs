//! The files that a job was given, in the order of their roles.

use crate::contract::{InputRole, MeshKind};

/// A file that a client gave.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredInput {
    /// What it is for.
    pub role: InputRole,
    /// Its name, as the client gave it; empty where it gave none.
    pub name: String,
    /// What kind of file a mesh is.
    pub kind: Option<MeshKind>,
    /// SHA-256 of its content, in 64 lower-case hexadecimal digits; empty for jobs that a version
    /// before 0.2 took, which did not keep it.
    pub sha256: String,
    /// Its length; 0 for those jobs.
    pub bytes: u64,
    /// Name of the blob that holds it.
    pub blob: String,
}

/// The files that a job was given.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Inputs(Vec<StoredInput>);

impl Inputs {
    /// All of them, in order.
    pub fn iter(&self) -> std::slice::Iter<'_, StoredInput> {
        self.0.iter()
    }

    /// The mesh. Every job that a client submitted has one.
    pub fn mesh(&self) -> Option<&StoredInput> {
        self.of(InputRole::Mesh)
    }

    /// The part labels, where the client gave some.
    pub fn labels(&self) -> Option<&StoredInput> {
        self.of(InputRole::Labels)
    }

    /// The first of this role.
    pub fn of(&self, role: InputRole) -> Option<&StoredInput> {
        self.0.iter().find(|input| input.role == role)
    }

    /// The blobs that hold them.
    pub fn blobs(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|input| input.blob.as_str())
    }
}

impl FromIterator<StoredInput> for Inputs {
    fn from_iter<I: IntoIterator<Item = StoredInput>>(inputs: I) -> Self {
        let mut inputs: Vec<_> = inputs.into_iter().collect();
        inputs.sort_by_key(|input| input.role);
        Self(inputs)
    }
}
