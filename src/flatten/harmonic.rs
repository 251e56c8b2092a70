//! Discrete harmonic functions: every free vertex at a positive average of its neighbours, with mean value
//! weights (Floater, "Mean Value Coordinates", 2003). So a function takes its extremes where it is given,
//! and its level sets branch no more than the mesh does.

use faer::Mat;
use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, Triplet};
use glam::{DVec2, DVec3};

use super::{Disk, FlattenError};

/// Least weight of a neighbour, as a share of the largest: below this, neighbours fall together in
/// double precision.
const LEAST_WEIGHT: f64 = 1e-6;

/// For each vertex its neighbours and their weights, each neighbour once, in ascending order.
pub type Weights = Vec<Vec<(u32, f64)>>;

/// The harmonic function that has the values given at some vertices of a mesh. Every component needs one
/// at least.
pub fn harmonic(disk: &Disk, given: &[Option<f64>]) -> Result<Vec<f64>, FlattenError> {
    let fixed: Vec<bool> = given.iter().map(Option::is_some).collect();
    let mut values: Vec<DVec2> = given.iter().map(|g| DVec2::new(g.unwrap_or(0.0), 0.0)).collect();
    spread(&mut values, &fixed, &mean_value_weights(disk))?;
    Ok(values.into_iter().map(|value| value.x).collect())
}

/// Solve for two functions at once: values that are fixed stay, every other vertex that has neighbours gets
/// their average.
pub fn spread(values: &mut [DVec2], fixed: &[bool], weights: &Weights) -> Result<(), FlattenError> {
    let mut unknown = vec![None; values.len()];
    let mut count = 0;
    for (v, i) in unknown.iter_mut().enumerate() {
        if !fixed[v] && !weights[v].is_empty() {
            *i = Some(count);
            count += 1;
        }
    }
    if count == 0 {
        return Ok(());
    }
    let mut triplets = Vec::new();
    let mut rhs = Mat::<f64>::zeros(count, 2);
    for (v, row) in unknown.iter().enumerate() {
        let Some(row) = *row else { continue };
        let total: f64 = weights[v].iter().map(|&(_, w)| w).sum();
        triplets.push(Triplet::new(row, row, 1.0));
        for &(neighbour, weight) in &weights[v] {
            let share = weight / total;
            match unknown[neighbour as usize] {
                Some(column) => triplets.push(Triplet::new(row, column, -share)),
                None => {
                    rhs[(row, 0)] += share * values[neighbour as usize].x;
                    rhs[(row, 1)] += share * values[neighbour as usize].y;
                }
            }
        }
    }
    let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(count, count, &triplets)
        .map_err(|_| FlattenError::Singular)?;
    let lu = matrix.sp_lu().map_err(|_| FlattenError::Singular)?;
    lu.solve_in_place(&mut rhs);
    for (p, row) in values.iter_mut().zip(&unknown) {
        if let Some(row) = *row {
            *p = DVec2::new(rhs[(row, 0)], rhs[(row, 1)]);
        }
    }
    Ok(())
}

/// Weight of neighbour j at vertex i: (tan(α/2) + tan(β/2))/|i − j|, α and β the angles at i beside
/// the edge.
pub fn mean_value_weights(disk: &Disk) -> Weights {
    gather(disk, |apex, side, other| {
        let (e, g) = (side - apex, other - apex);
        let (length, product) = (e.length(), e.length() * g.length());
        // tan(α/2) = (1 − cos α)/sin α = |e × g|/(|e||g| + e·g), without a division by sin α.
        let half_tangent = e.cross(g).length() / (product + e.dot(g));
        half_tangent / length
    })
}

/// All neighbours alike.
pub fn equal_weights(disk: &Disk) -> Weights {
    gather(disk, |_, _, _| 1.0)
}

/// Sum `weight(apex, side, other)` over the triangles beside each edge apex–side, then lift what is
/// too small, or no number at all, to a share of the largest.
fn gather(disk: &Disk, weight: impl Fn(DVec3, DVec3, DVec3) -> f64) -> Weights {
    let mut weights: Weights = vec![Vec::new(); disk.positions.len()];
    for t in &disk.triangles {
        for k in 0..3 {
            let [i, j, l] = [t[k], t[(k + 1) % 3], t[(k + 2) % 3]];
            let [p, q, r] = [i, j, l].map(|v| disk.positions[v as usize]);
            weights[i as usize].push((j, weight(p, q, r)));
            weights[i as usize].push((l, weight(p, r, q)));
        }
    }
    for list in &mut weights {
        list.sort_by_key(|&(j, _)| j);
        list.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            kept.1 += if same { next.1 } else { 0.0 };
            same
        });
        let finite = |w: f64| if w.is_finite() { w } else { 0.0 };
        let largest = list.iter().map(|&(_, w)| finite(w)).fold(0.0, f64::max);
        let least = if largest > 0.0 { LEAST_WEIGHT * largest } else { 1.0 };
        list.iter_mut().for_each(|(_, w)| *w = finite(*w).max(least));
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::samples;

    #[test]
    fn what_is_linear_is_harmonic() {
        let (disk, _) = samples::plane(7, 5, 2.0, 1.0);
        let given: Vec<Option<f64>> = disk
            .positions
            .iter()
            .map(|p| (p.x < 1e-9 || p.x > 2.0 - 1e-9).then_some(p.x))
            .collect();
        let rim = |p: &DVec3| p.y < 1e-9 || p.y > 1.0 - 1e-9;
        let all: Vec<Option<f64>> =
            disk.positions.iter().zip(&given).map(|(p, g)| g.or(rim(p).then_some(p.x))).collect();
        for (p, value) in disk.positions.iter().zip(harmonic(&disk, &all).unwrap()) {
            assert!((value - p.x).abs() < 1e-12, "{value} at {p}");
        }
        // Between two values it keeps between them.
        assert!(harmonic(&disk, &given).unwrap().iter().all(|v| (0.0..=2.0).contains(v)));
    }
}
