//! Symmetric 3 × 3 matrices: the direction in which points spread least, such as the axis of a tube or the
//! normal of a cloud, and how little they do.

use glam::{DMat3, DVec3};

/// Unit eigenvector of the least eigenvalue of a symmetric matrix, by cyclic Jacobi rotations.
pub fn least_eigenvector(m: DMat3) -> DVec3 {
    let mut a = m.to_cols_array_2d();
    let mut v = DMat3::IDENTITY.to_cols_array_2d();
    for _ in 0..24 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q].abs() < 1e-300 {
                continue;
            }
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let t = if theta == 0.0 { 1.0 } else { t };
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            for k in 0..3 {
                let (x, y) = (a[k][p], a[k][q]);
                a[k][p] = c * x - s * y;
                a[k][q] = s * x + c * y;
            }
            for k in 0..3 {
                let (x, y) = (a[p][k], a[q][k]);
                a[p][k] = c * x - s * y;
                a[q][k] = s * x + c * y;
            }
            for row in &mut v {
                let (x, y) = (row[p], row[q]);
                row[p] = c * x - s * y;
                row[q] = s * x + c * y;
            }
        }
    }
    let least = (0..3).min_by(|&i, &j| a[i][i].total_cmp(&a[j][j])).unwrap_or(0);
    let e = DVec3::new(v[0][least], v[1][least], v[2][least]).normalize_or_zero();
    // One of the two directions, always the same.
    let largest =
        [e.x, e.y, e.z].into_iter().fold(0.0, |b: f64, x| if x.abs() > b.abs() { x } else { b });
    if largest < 0.0 { -e } else { e }
}

/// The least eigenvalue of a symmetric matrix, in closed form (Smith 1961,
/// doi:10.1145/355578.366316).
pub fn least_eigenvalue(m: DMat3) -> f64 {
    let third = (m.x_axis.x + m.y_axis.y + m.z_axis.z) / 3.0;
    let off = m.y_axis.x.powi(2) + m.z_axis.x.powi(2) + m.z_axis.y.powi(2);
    let diagonal =
        [m.x_axis.x, m.y_axis.y, m.z_axis.z].map(|d| (d - third).powi(2)).iter().sum::<f64>();
    let size = ((diagonal + 2.0 * off) / 6.0).sqrt();
    if size < 1e-150 {
        return third;
    }
    let turned = (m - DMat3::from_diagonal(DVec3::splat(third))) * (1.0 / size);
    let angle = (0.5 * turned.determinant()).clamp(-1.0, 1.0).acos() / 3.0;
    third + 2.0 * size * (angle + std::f64::consts::TAU / 3.0).cos()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    #[test]
    fn a_turned_diagonal_gives_its_least_axis() {
        for i in 0..50 {
            let turn = DQuat::from_euler(
                glam::EulerRot::XYZ,
                0.3 * f64::from(i),
                1.1,
                -0.7 * f64::from(i),
            );
            let m = DMat3::from_quat(turn);
            assert_eq!(least_eigenvalue(DMat3::from_diagonal(DVec3::splat(0.3))), 0.3);
            let spread = m * DMat3::from_diagonal(DVec3::new(4.0, 0.5, 2.0)) * m.transpose();
            let found = least_eigenvector(spread);
            assert!((found.dot(turn * DVec3::Y).abs() - 1.0).abs() < 1e-12, "{found}");
            assert!((least_eigenvalue(spread) - 0.5).abs() < 1e-12);
        }
    }
}
