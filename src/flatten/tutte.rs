//! Tutte's embedding (Tutte, "How to Draw a Graph", 1963) with mean value weights (Floater, "Mean
//! Value Coordinates", 2003): the boundary on a circle by arc length, every other vertex at a
//! positive average of its neighbours. Injective for every disk (Floater, "One-to-one piecewise
//! linear mappings over triangulations", 2003), as far as double precision reaches.

use faer::Mat;
use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, Triplet};
use glam::{DVec2, DVec3};

use super::border::Border;
use super::injective::count_flips;
use super::jacobian::rescale;
use super::{Disk, FlattenError, UvMap};

/// Least weight of a neighbour, as a share of the largest: below this, neighbours fall together in
/// double precision.
const LEAST_WEIGHT: f64 = 1e-6;

/// Map a disk to a circle, scaled to the 3D area. Where mean value weights are too uneven for
/// double precision, equal weights are tried. Errors when the triangles are no disk or neither
/// choice has come out without flips.
pub fn tutte(disk: &Disk) -> Result<UvMap, FlattenError> {
    let border = Border::of(disk);
    let [ring] = &border.loops[..] else { return Err(FlattenError::NotADisk) };
    if !border.is_disk() || ring.len() < 3 {
        return Err(FlattenError::NotADisk);
    }
    for weights in [mean_value_weights(disk), equal_weights(disk)] {
        let uv = rescale(disk, embed(disk, ring, &weights)?);
        if count_flips(disk, &uv) == 0 {
            return Ok(uv);
        }
    }
    Err(FlattenError::NoValidMap)
}

/// For each vertex its neighbours and their weights, each neighbour once, in ascending order.
type Weights = Vec<Vec<(u32, f64)>>;

fn embed(disk: &Disk, ring: &[u32], weights: &Weights) -> Result<UvMap, FlattenError> {
    let mut uv = circle(disk, ring);
    let mut unknown = vec![None; uv.len()];
    let mut count = 0;
    let mut fixed = vec![false; uv.len()];
    ring.iter().for_each(|&v| fixed[v as usize] = true);
    for (v, i) in unknown.iter_mut().enumerate() {
        if !fixed[v] && !weights[v].is_empty() {
            *i = Some(count);
            count += 1;
        }
    }
    if count == 0 {
        return Ok(uv);
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
                    rhs[(row, 0)] += share * uv[neighbour as usize].x;
                    rhs[(row, 1)] += share * uv[neighbour as usize].y;
                }
            }
        }
    }
    let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(count, count, &triplets)
        .map_err(|_| FlattenError::Singular)?;
    let lu = matrix.sp_lu().map_err(|_| FlattenError::Singular)?;
    lu.solve_in_place(&mut rhs);
    for (p, row) in uv.iter_mut().zip(&unknown) {
        if let Some(row) = *row {
            *p = DVec2::new(rhs[(row, 0)], rhs[(row, 1)]);
        }
    }
    Ok(uv)
}

/// The boundary on the unit circle by arc length; edges without length get a little.
fn circle(disk: &Disk, ring: &[u32]) -> UvMap {
    let at = |k: usize| disk.positions[ring[k % ring.len()] as usize];
    let lengths: Vec<f64> = (0..ring.len()).map(|k| at(k).distance(at(k + 1))).collect();
    let whole: f64 = lengths.iter().sum();
    let least = if whole > 0.0 { 1e-4 * whole / ring.len() as f64 } else { 1.0 };
    let total: f64 = lengths.iter().map(|l| l.max(least)).sum();
    let mut uv = vec![DVec2::ZERO; disk.positions.len()];
    let mut walked = 0.0;
    for (&v, length) in ring.iter().zip(&lengths) {
        uv[v as usize] = DVec2::from_angle(std::f64::consts::TAU * walked / total);
        walked += length.max(least);
    }
    uv
}

/// Weight of neighbour j at vertex i: (tan(α/2) + tan(β/2))/|i − j|, α and β the angles at i beside
/// the edge.
fn mean_value_weights(disk: &Disk) -> Weights {
    gather(disk, |apex, side, other| {
        let (e, g) = (side - apex, other - apex);
        let (length, product) = (e.length(), e.length() * g.length());
        // tan(α/2) = (1 − cos α)/sin α = |e × g|/(|e||g| + e·g), without a division by sin α.
        let half_tangent = e.cross(g).length() / (product + e.dot(g));
        half_tangent / length
    })
}

fn equal_weights(disk: &Disk) -> Weights {
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
    use crate::flatten::{certify, samples};
    use proptest::prelude::*;

    /// A triangulation made by putting each point into a triangle of the ones before (every
    /// valence occurs, slivers too), lifted to random heights.
    fn stacked(points: &[(usize, f64, f64, f64)]) -> Disk {
        let mut positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        let mut triangles = vec![[0u32, 1, 2]];
        for &(which, a, b, height) in points {
            let f = which % triangles.len();
            let [i, j, k] = triangles[f];
            let [p, q, r] = triangles[f].map(|v| positions[v as usize].truncate());
            let (a, b) = if a + b < 1.0 { (a, b) } else { (1.0 - a, 1.0 - b) };
            let new = positions.len() as u32;
            positions.push((p + (q - p) * a + (r - p) * b).extend(height));
            triangles[f] = [i, j, new];
            triangles.extend([[j, k, new], [k, i, new]]);
        }
        Disk::new(positions, triangles)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn noisy_height_fields_never_flip(seed in prop::collection::vec(-1.0..1.0f64, 81)) {
            let disk = samples::bent(8, 8, |x, y| {
                let k = (8.0 * y).round() as usize * 9 + (8.0 * x).round() as usize;
                DVec3::new(x, y, seed[k])
            });
            prop_assert!(certify(&disk, &tutte(&disk).unwrap()).is_injective());
        }

        #[test]
        fn random_triangulations_never_flip(
            points in prop::collection::vec((0usize..1000, 0.05..0.95f64, 0.05..0.95f64, -0.3..0.3f64), 1..24),
        ) {
            let disk = stacked(&points);
            prop_assert!(certify(&disk, &tutte(&disk).unwrap()).is_injective());
        }
    }

    #[test]
    fn needles_do_not_break_it() {
        let disk = samples::bent(20, 20, |x, y| DVec3::new(x, 1e-9 * y, x * x));
        assert!(certify(&disk, &tutte(&disk).unwrap()).is_injective());
    }

    #[test]
    fn what_is_no_disk_is_refused() {
        let triangles = vec![[0, 1, 2], [0, 3, 4]];
        let disk =
            Disk::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y], triangles);
        assert_eq!(tutte(&disk), Err(FlattenError::NotADisk));
    }
}
