//! The samples that stand under examples/, as far as the program carries them.

/// The chair of the demo: 6,000 triangles, a node for each part. It was made by
/// `uvsegnet synth chair --seed 1 --triangles 6000 -o examples/chair.glb`.
pub const CHAIR: &[u8] = include_bytes!("../../examples/chair.glb");

/// The same chair with about 1,000 triangles.
pub const CHAIR_SMALL: &[u8] = include_bytes!("../../examples/chair_small.glb");
