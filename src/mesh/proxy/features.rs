//! Edges that a proxy keeps: borders, and where something ends that the file or the caller says (label,
//! primitive, shell), or the file's own texture coordinates have a seam.

use super::EXISTING;
use crate::mesh::{NONE, Surface};

/// The edge is a curve of its own.
pub const CURVE: u8 = 1;

/// Least faces that a shell has in the mean where shells mean something: a file that gives each face
/// vertices of its own says nothing by it.
const SHELL: usize = 64;

/// What each half-edge is, 0 for nothing.
pub fn features(surface: &Surface) -> Vec<u8> {
    let shells = surface.origins.iter().map(|o| o.shell + 1).max().unwrap_or(0);
    let heeds_shells = shells as usize * SHELL <= surface.face_count();
    let labels = surface.labels.as_deref();
    let says = |f: usize| {
        let o = &surface.origins[f];
        let shell = if heeds_shells { o.shell } else { 0 };
        (o.primitive, shell, labels.map_or(-1, |labels| labels[f]))
    };
    let kind = |(h, &t): (usize, &u32)| {
        let seam = surface.existing_seams.get(h).is_some_and(|&seam| seam);
        let ends = t == NONE || says(h / 3) != says(t as usize / 3);
        u8::from(ends || seam) * CURVE + u8::from(seam) * EXISTING
    };
    surface.twin.iter().enumerate().map(kind).collect()
}
