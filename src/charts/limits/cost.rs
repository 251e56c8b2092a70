//! What a seam costs at an edge: seams belong where the surface bends and, above all, in concave creases,
//! where the file has seams already, and where they are hidden (docs/method.md, 4.1).

use crate::charts::part_mesh::PartMesh;
use crate::mesh::NONE;

/// Cost of a unit of seam where the surface is flat.
pub const FLAT: f64 = 1.0;

/// Least cost of a unit of seam.
pub const LEAST: f64 = 0.05;

/// Share of its cost that a seam saves where nobody can see it.
const HIDDEN: f64 = 0.6;

/// Share of its cost that a seam saves where the file's own texture coordinates have one.
const EXISTING: f64 = 0.5;

/// Cost of a unit length of seam at a signed dihedral angle (radians, positive convex): 1 where
/// flat, falling to a third at a convex crease of 90° and to a tenth at a concave one.
pub fn seam_cost(dihedral: f64) -> f64 {
    let bend = (dihedral.abs() / std::f64::consts::FRAC_PI_6).powi(2);
    let weight = if dihedral < 0.0 { 1.0 } else { 0.22 };
    (FLAT / (1.0 + weight * bend)).max(LEAST)
}

/// Length times cost of the seam along a local half-edge: the bend's cost, less where it is hidden, and
/// less where there was a seam before.
pub fn edge_cost(mesh: &PartMesh, h: u32) -> f64 {
    let surface_half_edge = mesh.surface_half_edge(h);
    let bend = seam_cost(mesh.surface.dihedral(surface_half_edge));
    let existing = mesh.surface.existing_seams.get(surface_half_edge as usize);
    let kept = if existing == Some(&true) { 1.0 - EXISTING } else { 1.0 };
    mesh.length(h) * bend * kept * (1.0 - HIDDEN * (1.0 - seen(mesh, h)))
}

/// Ambient visibility of an edge, 0 to 1: the mean of its faces'.
fn seen(mesh: &PartMesh, h: u32) -> f64 {
    let Some(visibility) = mesh.visibility else { return 1.0 };
    let of = |h: u32| f64::from(visibility[mesh.faces[h as usize / 3] as usize]);
    let twin = mesh.twin[h as usize];
    if twin == NONE { of(h) } else { 0.5 * (of(h) + of(twin)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seams_prefer_bends_and_above_all_valleys() {
        let right = std::f64::consts::FRAC_PI_2;
        assert_eq!(seam_cost(0.0), 1.0);
        assert!(seam_cost(right) < 0.4 && seam_cost(right) > 0.2);
        assert!(seam_cost(-right) < 0.5 * seam_cost(right));
        assert!(seam_cost(-3.0) >= LEAST);
    }
}
