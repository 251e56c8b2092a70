//! Maps of neighbouring charts sewn to one: the map whose Jacobians are as near as can be to those
//! that its triangles had apart (Poisson stitching, after Yu et al. 2004, "Mesh editing with
//! Poisson-based gradient field manipulation"; doi:10.1145/1015706.1015774). It spreads a gap over the
//! triangles beside it, where moving only the seam's own vertices would turn the small ones over.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, Mat, Par, Side};
use glam::{DMat2, DVec2};

use super::lscm::hat_gradients;
use super::pattern::{PINNED, Pattern};
use super::{Disk, FlattenError, UvMap};

/// The map u that makes Σ A‖J(u) − `frames`‖² least, with the first vertex where `near` has it.
/// `frames`: one Jacobian a triangle. `pattern`: that of the disk. The map may flip triangles.
///
/// # Errors
/// Where the triangles are not one connected component.
pub fn stitch(
    disk: &Disk,
    pattern: &Pattern,
    frames: &[DMat2],
    near: &[DVec2],
) -> Result<UvMap, FlattenError> {
    let n = disk.positions.len();
    let mut rhs = Mat::<f64>::zeros(n, 2);
    let mut used = vec![false; n];
    // The column of v: its diagonal, then its edges to higher vertices.
    let starts = &pattern.starts;
    let place = |e: u32| e as usize + pattern.edges[e as usize].0 as usize + 1;
    let diagonal = |v: usize| starts[v] as usize + v;
    let mut values = vec![0.0; n + pattern.edges.len()];
    for (f, (triangle, frame)) in disk.triangles.iter().zip(frames).enumerate() {
        let (area, hats) = (disk.areas[f], hat_gradients(&disk.rest[f]));
        for (k, &v) in triangle.iter().enumerate() {
            let row = v as usize;
            used[row] |= area > 0.0;
            let pull = *frame * hats[k] * area;
            rhs[(row, 0)] += pull.x;
            rhs[(row, 1)] += pull.y;
            values[diagonal(row)] += area * hats[k].length_squared();
            let edge = pattern.edge_of[f][k];
            if edge != PINNED {
                values[place(edge)] += area * hats[k].dot(hats[(k + 1) % 3]);
            }
        }
    }
    // Translations are free: the first vertex is held by a spring as stiff as all the rest. Vertices
    // that no triangle holds stay.
    let stiff = values.iter().map(|value| value.abs()).fold(0.0, f64::max);
    let held = used.iter().position(|&u| u).unwrap_or(0);
    for v in (0..n).filter(|&v| v == held || !used[v]) {
        values[diagonal(v)] += stiff;
        rhs[(v, 0)] += stiff * near[v].x;
        rhs[(v, 1)] += stiff * near[v].y;
    }
    solve(pattern, &values, &mut rhs)?;
    Ok((0..n).map(|v| DVec2::new(rhs[(v, 0)], rhs[(v, 1)])).collect())
}

/// Solve for both coordinates at once, in place.
fn solve(pattern: &Pattern, values: &[f64], rhs: &mut Mat<f64>) -> Result<(), FlattenError> {
    let n = pattern.unknowns;
    let starts = &pattern.starts;
    let columns: Vec<u32> = (0u32..).zip(starts).map(|(v, start)| start + v).collect();
    let own = |v: u32| {
        let edges = starts[v as usize] as usize..starts[v as usize + 1] as usize;
        std::iter::once(v).chain(pattern.edges[edges].iter().map(|e| e.1))
    };
    let rows: Vec<u32> = (0..n as u32).flat_map(own).collect();
    let lower = SymbolicSparseColMatRef::new_checked(n, n, &columns, None, &rows);
    let (order, inverse) = pattern.permutation(1);
    let ordering = SymmetricOrdering::Custom(PermRef::new_checked(&order, &inverse, n));
    let singular = |_| FlattenError::Singular;
    let symbolic = factorize_symbolic_cholesky(
        lower,
        Side::Lower,
        ordering,
        CholeskySymbolicParams::default(),
    )
    .map_err(singular)?;
    let request = symbolic
        .factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default())
        .or(symbolic.solve_in_place_scratch::<f64>(2, Par::Seq));
    let mut memory = MemBuffer::new(request);
    let mut factor = vec![0.0; symbolic.len_val()];
    symbolic
        .factorize_numeric_llt(
            &mut factor,
            SparseColMatRef::new(lower, values),
            Side::Lower,
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        )
        .map_err(|_| FlattenError::Singular)?;
    LltRef::new(&symbolic, &factor).solve_in_place_with_conj(
        Conj::No,
        rhs.as_mut(),
        Par::Seq,
        MemStack::new(&mut memory),
    );
    Ok(())
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

    fn pattern(disk: &Disk) -> Pattern {
        disk.pattern().unwrap()
    }

    #[test]
    fn jacobians_of_a_map_give_the_map() {
        let disk = samples::barrel(12, 6);
        let uv: UvMap =
            disk.positions.iter().map(|p| DVec2::new(p.x + 0.3 * p.z, p.y * p.y - p.z)).collect();
        let frames: Vec<DMat2> = (0..disk.triangles.len()).map(|f| disk.jacobian(f, &uv)).collect();
        let found = stitch(&disk, &pattern(&disk), &frames, &uv).unwrap();
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
        let found = stitch(&disk, &pattern(&disk), &turned, &uv).unwrap();
        let quality = crate::flatten::quality(&disk, &found);
        assert_eq!(quality.flips, 0);
        assert!(quality.mean - 1.0 < 1e-3, "{}", quality.mean);
        // One half is turned by 0.05: ‖R − I‖² = 2 · 0.05², and halfway between is half as far from each.
        let bent = misfit(&disk, &turned, &found);
        assert!(bent > 1e-5 && bent < 0.5 * 2.0 * 0.05f64.powi(2), "{bent}");
    }
}
