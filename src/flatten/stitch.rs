//! Maps of neighbouring charts sewn to one: the map whose Jacobians are as near as can be to those
//! that its triangles had apart (Poisson stitching, after Yu et al. 2004, "Mesh editing with
//! Poisson-based gradient field manipulation"; doi:10.1145/1015706.1015774). It spreads a gap over the
//! triangles beside it, where moving only the seam's own vertices would turn the small ones over.

use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};
use glam::{DMat2, DVec2};

use super::lscm::hat_gradients;
use super::{Disk, FlattenError, UvMap};

/// The map u that makes Σ A‖J(u) − `frames`‖² least, with the first vertex where `near` has it.
/// `frames`: one Jacobian a triangle. The map may flip triangles.
///
/// # Errors
/// Where the triangles are not one connected component.
pub fn stitch(disk: &Disk, frames: &[DMat2], near: &[DVec2]) -> Result<UvMap, FlattenError> {
    let n = disk.positions.len();
    let mut entries = Vec::with_capacity(6 * disk.triangles.len() + 1);
    let mut rhs = Mat::<f64>::zeros(n, 2);
    let mut used = vec![false; n];
    for ((triangle, rest), (&area, frame)) in
        disk.triangles.iter().zip(&disk.rest).zip(disk.areas.iter().zip(frames))
    {
        let hats = hat_gradients(rest);
        for (k, &v) in triangle.iter().enumerate() {
            let (row, next) = (v as usize, triangle[(k + 1) % 3] as usize);
            used[row] |= area > 0.0;
            let pull = *frame * hats[k] * area;
            rhs[(row, 0)] += pull.x;
            rhs[(row, 1)] += pull.y;
            entries.push(Triplet::new(row, row, area * hats[k].length_squared()));
            let (low, high) = (row.min(next), row.max(next));
            entries.push(Triplet::new(high, low, area * hats[k].dot(hats[(k + 1) % 3])));
        }
    }
    // Translations are free: the first vertex is held by a spring as stiff as all the rest. Vertices
    // that no triangle holds stay.
    let stiff = entries.iter().map(|e| e.val.abs()).fold(0.0, f64::max);
    let held = used.iter().position(|&u| u).unwrap_or(0);
    for v in (0..n).filter(|&v| v == held || !used[v]) {
        entries.push(Triplet::new(v, v, stiff));
        rhs[(v, 0)] += stiff * near[v].x;
        rhs[(v, 1)] += stiff * near[v].y;
    }
    let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(n, n, &entries)
        .map_err(|_| FlattenError::Singular)?;
    let factor = matrix.sp_cholesky(Side::Lower).map_err(|_| FlattenError::Singular)?;
    factor.solve_in_place(&mut rhs);
    Ok((0..n).map(|v| DVec2::new(rhs[(v, 0)], rhs[(v, 1)])).collect())
}

/// Mean of ‖J(uv) − `frames`‖² by area: how far the charts had to be bent.
pub fn misfit(disk: &Disk, frames: &[DMat2], uv: &[DVec2]) -> f64 {
    let off = |f: usize| {
        let off = disk.jacobian(f, uv) - frames[f];
        disk.areas[f] * (off.x_axis.length_squared() + off.y_axis.length_squared())
    };
    (0..frames.len()).map(off).sum::<f64>() / disk.area()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::samples;

    #[test]
    fn jacobians_of_a_map_give_the_map() {
        let disk = samples::barrel(12, 6);
        let uv: UvMap =
            disk.positions.iter().map(|p| DVec2::new(p.x + 0.3 * p.z, p.y * p.y - p.z)).collect();
        let frames: Vec<DMat2> = (0..disk.triangles.len()).map(|f| disk.jacobian(f, &uv)).collect();
        let found = stitch(&disk, &frames, &uv).unwrap();
        let far = found.iter().zip(&uv).map(|(p, q)| p.distance(*q)).fold(0.0, f64::max);
        assert!(far < 1e-9, "{far}");
        assert!(misfit(&disk, &frames, &found) < 1e-18);
    }

    #[test]
    fn a_gap_is_spread() {
        // A plane in two halves that have been pulled 0.02 apart, its triangles 0.1 wide.
        let (disk, uv) = samples::plane(20, 4, 2.0, 0.4);
        let frames: Vec<DMat2> = (0..disk.triangles.len()).map(|f| disk.jacobian(f, &uv)).collect();
        let turned: Vec<DMat2> = frames
            .iter()
            .zip(&disk.triangles)
            .map(|(j, t)| {
                let right = t.iter().all(|&v| uv[v as usize].x > 0.99);
                if right { DMat2::from_angle(0.05) * *j } else { *j }
            })
            .collect();
        let found = stitch(&disk, &turned, &uv).unwrap();
        let quality = crate::flatten::quality(&disk, &found);
        assert_eq!(quality.flips, 0);
        assert!(quality.mean - 1.0 < 1e-3, "{}", quality.mean);
        // One half is turned by 0.05: ‖R − I‖² = 2 · 0.05², and halfway between is half as far from each.
        let bent = misfit(&disk, &turned, &found);
        assert!(bent > 1e-5 && bent < 0.5 * 2.0 * 0.05f64.powi(2), "{bent}");
    }
}
