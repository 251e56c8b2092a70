//! Flips that a map carried over from a coarser mesh leaves at its border, at slivers and in noise are mended
//! where they are, in a patch about them, which grows. First each vertex in turn goes where its faces are most
//! nearly rigid (Liu et al. 2008, "A local/global approach to mesh parameterization",
//! doi:10.1111/j.1467-8659.2008.01290.x), which turns most flipped faces back. Then it takes Newton steps on a
//! symmetric Dirichlet energy that is finite through flips: det J gives way to χ(det J) = (det J + √(det² J +
//! ε²))/2, and ε falls with the worst flip (Garanzha et al. 2021, doi:10.1145/3450626.3459847; Escobar et al. 2003,
//! doi:10.1016/S0045-7825(02)00594-4).

use glam::{DMat2, DVec2};

use super::fans::{Fans, shortened};
use super::lscm::hat_gradients;
use super::{Disk, UvMap, is_positive};

/// Rings of faces about the flipped ones that a patch has at first …
const RINGS: u32 = 3;

/// … and times that they are doubled.
const GROWTHS: u32 = 3;

/// Rounds in which a patch is made rigid.
const RIGID: u32 = 40;

/// Rounds of sweeps over a patch, each with an ε of its own, before it grows.
const ROUNDS: u32 = 30;

/// Sweeps of a round.
const SWEEPS: u32 = 4;

/// ε² over the square of the worst determinant, and the least ε².
const EPSILON: [f64; 2] = [0.04, 1e-10];

/// Times that a step is halved before the vertex stays.
const HALVINGS: u32 = 6;

/// Share of faces that may be flipped where mending is tried.
const FEW: f64 = 0.1;

/// The map, at the scale of the disk, without flips, where they could be mended; the flipped faces where they
/// are too many, or stay.
pub fn untangle(disk: &Disk, mut uv: UvMap) -> Result<UvMap, Vec<u32>> {
    let mut flipped = flips(disk, &uv);
    if flipped.len() as f64 > FEW * disk.triangles.len() as f64 + 8.0 {
        return Err(flipped);
    }
    let fans = if flipped.is_empty() { return Ok(uv) } else { Fans::of(disk) };
    for growth in 0..=GROWTHS {
        let patch = around(disk, &fans, &flipped, RINGS << growth);
        for round in 0..RIGID {
            for &v in &patch {
                make_rigid(disk, &mut uv, v as usize, fans.at(v as usize));
            }
            if round % 8 == 7 && flips_at(disk, &fans, &patch, &uv).is_empty() {
                break;
            }
        }
        flipped = flips_at(disk, &fans, &patch, &uv);
        if flipped.is_empty() {
            return Ok(uv);
        }
        let patch = around(disk, &fans, &flipped, RINGS << growth);
        for _ in 0..ROUNDS {
            let worst = flipped.iter().map(|&f| disk.jacobian(f as usize, &uv).determinant());
            let worst = worst.fold(0.0, f64::min);
            let epsilon = EPSILON[0] * worst * worst + EPSILON[1];
            for _ in 0..SWEEPS {
                for &v in &patch {
                    step(disk, &mut uv, v as usize, fans.at(v as usize), epsilon);
                }
            }
            flipped = flips_at(disk, &fans, &patch, &uv);
            if flipped.is_empty() {
                return Ok(uv);
            }
        }
    }
    Err(flips(disk, &uv))
}

/// χ and its first two derivatives, ε² given.
fn regularised(det: f64, epsilon: f64) -> [f64; 3] {
    let root = (det * det + epsilon).sqrt();
    // For negative determinants without the difference of like numbers.
    let value = if det > 0.0 { 0.5 * (det + root) } else { 0.5 * epsilon / (root - det) };
    [value, value / root, 0.5 * epsilon / (root * root * root)]
}

fn energy(disk: &Disk, uv: &[DVec2], fan: &[u32], epsilon: f64) -> f64 {
    let mut sum = 0.0;
    for f in fan.iter().map(|&c| c as usize / 3) {
        if disk.areas[f] > 0.0 {
            let j = disk.jacobian(f, uv);
            let [chi, ..] = regularised(j.determinant(), epsilon);
            let squares = j.x_axis.length_squared() + j.y_axis.length_squared();
            sum += disk.areas[f] * squares * (1.0 + 1.0 / (chi * chi));
        }
    }
    sum
}

/// A Newton step of one vertex: for it |J|² is quadratic and det J linear.
fn step(disk: &Disk, uv: &mut UvMap, v: usize, fan: &[u32], epsilon: f64) {
    let (mut gradient, mut hessian, mut before) = (DVec2::ZERO, DMat2::ZERO, 0.0);
    for &c in fan {
        let (f, k) = (c as usize / 3, c as usize % 3);
        let area = disk.areas[f];
        if area <= 0.0 {
            continue;
        }
        let j = disk.jacobian(f, uv);
        let hat = hat_gradients(&disk.rest[f])[k];
        let squares = j.x_axis.length_squared() + j.y_axis.length_squared();
        let of_squares = 2.0 * (j * hat);
        // det J = x · y⊥ for its columns: moving the vertex by d adds hat.x (d × y) + hat.y (x × d).
        let of_det = hat.x * DVec2::new(j.y_axis.y, -j.y_axis.x)
            + hat.y * DVec2::new(-j.x_axis.y, j.x_axis.x);
        let [chi, first, second] = regularised(j.determinant(), epsilon);
        let over = 1.0 / (chi * chi);
        let slope = -2.0 * first * over / chi;
        let curve = (6.0 * first * first / chi - 2.0 * second) * over / chi;
        before += area * squares * (1.0 + over);
        gradient += area * (of_squares * (1.0 + over) + squares * slope * of_det);
        let outer = |a: DVec2, b: DVec2| DMat2::from_cols(a * b.x, a * b.y);
        // Without the mixed term where it would take away from what is positive.
        hessian += area
            * (DMat2::from_diagonal(DVec2::splat(2.0 * hat.length_squared() * (1.0 + over)))
                + outer(of_det, of_det) * (squares * curve.max(0.0))
                + (outer(of_squares, of_det) + outer(of_det, of_squares)) * slope);
    }
    let direction = newton(hessian, gradient);
    shortened(uv, v, direction, HALVINGS, |uv| energy(disk, uv, fan, epsilon) < before);
}

/// −H⁻¹ g with the eigenvalues of H made positive.
fn newton(hessian: DMat2, gradient: DVec2) -> DVec2 {
    let (a, b, d) = (hessian.x_axis.x, hessian.x_axis.y, hessian.y_axis.y);
    let (mean, half) = (0.5 * (a + d), (0.5 * (a - d)).hypot(b));
    let least = 1e-6 * (mean.abs() + half);
    let turn = 0.5 * (2.0 * b).atan2(a - d);
    let axis = DVec2::from_angle(turn);
    let across = axis.perp();
    let over = |value: f64| 1.0 / value.abs().max(least);
    let step = axis * axis.dot(gradient) * over(mean + half)
        + across * across.dot(gradient) * over(mean - half);
    if step.is_finite() { -step } else { DVec2::ZERO }
}

/// Vertices within so many rings of faces.
fn around(disk: &Disk, fans: &Fans, faces: &[u32], rings: u32) -> Vec<u32> {
    let corners: Vec<u32> = faces.iter().flat_map(|&f| disk.triangles[f as usize]).collect();
    fans.around(disk, &corners, rings).into_iter().map(|(v, _)| v).collect()
}

/// Move a vertex to where its faces are nearest to the rotations that they are nearest to.
pub(super) fn make_rigid(disk: &Disk, uv: &mut UvMap, v: usize, fan: &[u32]) {
    let (mut pull, mut stiffness) = (DVec2::ZERO, 0.0);
    for &c in fan {
        let (f, k) = (c as usize / 3, c as usize % 3);
        let area = disk.areas[f];
        if area > 0.0 {
            let j = disk.jacobian(f, uv);
            let turn = DMat2::from_angle((j.x_axis.y - j.y_axis.x).atan2(j.x_axis.x + j.y_axis.y));
            let hat = hat_gradients(&disk.rest[f])[k];
            pull += (j - turn) * hat * area;
            stiffness += area * hat.length_squared();
        }
    }
    let step = pull / stiffness;
    if step.is_finite() {
        uv[v] -= step;
    }
}

/// Flipped faces at some vertices, in ascending order.
fn flips_at(disk: &Disk, fans: &Fans, vertices: &[u32], uv: &[DVec2]) -> Vec<u32> {
    let mut faces: Vec<u32> =
        vertices.iter().flat_map(|&v| fans.at(v as usize)).map(|c| c / 3).collect();
    faces.sort_unstable();
    faces.dedup();
    faces.retain(|&f| is_flipped(disk, f as usize, uv));
    faces
}

fn is_flipped(disk: &Disk, f: usize, uv: &[DVec2]) -> bool {
    disk.areas[f] > 0.0 && !is_positive(disk.triangles[f].map(|v| uv[v as usize]))
}

fn flips(disk: &Disk, uv: &[DVec2]) -> Vec<u32> {
    (0..disk.triangles.len() as u32).filter(|&f| is_flipped(disk, f as usize, uv)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::samples;

    #[test]
    fn a_vertex_pushed_through_its_neighbours_comes_back() {
        let (disk, mut uv) = samples::plane(12, 12, 1.0, 1.0);
        uv[70] += DVec2::splat(0.2);
        assert!(!flips(&disk, &uv).is_empty());
        let mended = untangle(&disk, uv).unwrap();
        assert!(flips(&disk, &mended).is_empty());
    }

    #[test]
    fn a_mirrored_map_is_not_tried() {
        let (disk, uv) = samples::plane(12, 12, 1.0, 1.0);
        let mirrored = uv.iter().map(|p| DVec2::new(-p.x, p.y)).collect();
        assert_eq!(untangle(&disk, mirrored).unwrap_err().len(), disk.triangles.len());
    }
}
