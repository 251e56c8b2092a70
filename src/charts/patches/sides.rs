//! The sides of a tube: lateral faces, cut along the axis where that costs least, and unrolled.

use super::tube::{self, Tube};
use crate::charts::chart::StartKind;
use crate::charts::limits::fit::Fit;
use crate::charts::part_mesh::PartMesh;
use crate::flatten;
use crate::mesh::NONE;

/// The side of a tube, cut along its axis and unrolled.
pub struct Side {
    /// Local faces, ascending.
    pub faces: Vec<u32>,
    /// Local half-edges of the axial cut.
    pub cut: Vec<u32>,
    /// Its map.
    pub fit: Fit,
}

/// The sides of a tube that open to a disk and unroll within the bound.
pub fn sides(mesh: &PartMesh, tube: Option<&Tube>, bound: f64) -> Vec<Side> {
    let Some(tube) = tube else { return Vec::new() };
    let mut lateral = vec![false; mesh.len()];
    tube.lateral.iter().for_each(|&f| lateral[f as usize] = true);
    let same = |h: u32| lateral[mesh.twin[h as usize] as usize / 3];
    let pieces = mesh.components(&tube.lateral, same);
    pieces.into_iter().filter_map(|faces| unroll(mesh, faces, tube, bound)).collect()
}

fn unroll(mesh: &PartMesh, faces: Vec<u32>, tube: &Tube, bound: f64) -> Option<Side> {
    let cut = tube::axial_cut(mesh, &faces, tube.axis)?;
    let mut glued = vec![false; mesh.twin.len()];
    glue_side(mesh, &faces, &cut, &mut glued);
    let piece = mesh.cut_open(faces, &glued);
    if !flatten::is_disk(&piece.disk) {
        return None;
    }
    let rolled = flatten::unroll(&piece.disk, tube.origin, tube.axis, tube.radius, tube.taper);
    // A faceted tube is developable: unfolding it is exact, where the round one is only near.
    let unfolded = flatten::unfold(&piece.disk);
    let candidates = [(Some(rolled), StartKind::Unroll), (unfolded, StartKind::Unfold)];
    let (energy, uv, kind) = candidates
        .into_iter()
        .filter_map(|(uv, kind)| {
            let uv = flatten::rescale(&piece.disk, uv?);
            let quality = flatten::quality(&piece.disk, &uv);
            let proved = quality.flips == 0 && flatten::certify(&piece.disk, &uv).is_injective();
            proved.then_some((quality.mean - 1.0, uv, kind))
        })
        .min_by(|a, b| a.0.total_cmp(&b.0))?;
    let fits = energy <= bound;
    fits.then_some(Side { faces: piece.faces, cut, fit: Fit { uv, energy, kind } })
}

/// Close every edge within a side but those of its cut.
pub fn glue_side(mesh: &PartMesh, faces: &[u32], cut: &[u32], glued: &mut [bool]) {
    let mut own = vec![false; mesh.len()];
    faces.iter().for_each(|&f| own[f as usize] = true);
    for h in faces.iter().flat_map(|&f| 3 * f..3 * f + 3) {
        let t = mesh.twin[h as usize];
        glued[h as usize] = t != NONE && own[t as usize / 3];
    }
    for &h in cut {
        glued[h as usize] = false;
        glued[mesh.twin[h as usize] as usize] = false;
    }
}
