//! What a seam costs at an edge: seams belong where parts meet, where the surface bends and, above
//! all, in concave creases, which are hidden and where materials change (pipeline: cut cost).

use super::part_mesh::PartMesh;

/// Cost of a unit of seam where the surface is flat.
pub const FLAT: f64 = 1.0;

/// Least cost of a unit of seam.
pub const LEAST: f64 = 0.05;

/// Cost of a unit length of seam at a signed dihedral angle (radians, positive convex): 1 where
/// flat, falling to a third at a convex crease of 90° and to a tenth at a concave one.
pub fn seam_cost(dihedral: f64) -> f64 {
    let bend = (dihedral.abs() / std::f64::consts::FRAC_PI_6).powi(2);
    let weight = if dihedral < 0.0 { 1.0 } else { 0.22 };
    (FLAT / (1.0 + weight * bend)).max(LEAST)
}

/// Length times cost of the seam along a local half-edge.
pub fn edge_cost(mesh: &PartMesh, h: u32) -> f64 {
    mesh.length(h) * seam_cost(mesh.surface.dihedral(mesh.surface_half_edge(h)))
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
