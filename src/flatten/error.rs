//! What can go wrong when a disk is flattened.

/// Why a map could not be made.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FlattenError {
    /// The triangles do not form a topological disk with one boundary.
    #[error("the triangles do not form a topological disk")]
    NotADisk,
    /// No map without flips was found (double precision is too short for this shape).
    #[error("no map without flipped triangles was found")]
    NoValidMap,
    /// A linear system could not be factorised.
    #[error("a linear system of the map could not be factorised")]
    Singular,
    /// The classical unwrapper broke down (0.3.0 does in the ordering of its sparse systems, on some
    /// meshes).
    #[error("the classical unwrapper broke down on the mesh")]
    ClassicalBroke,
    /// The classical unwrapper refused the mesh.
    #[error("the classical unwrapper refused the mesh: {0}")]
    Classical(#[from] uvunwrap::Error),
}
