//! A rough component's proxy without its noise, so that the cut sees the shape: normals averaged with those
//! beside them that look much the same way (bilateral normal filtering; Zheng et al. 2011,
//! doi:10.1109/TVCG.2010.264), then vertices moved to where their faces have these normals (Sun et al. 2007,
//! doi:10.1109/TVCG.2007.1065). Creases stay, and what lies on features does not move.

use glam::DVec3;

use super::collapse::Collapsed;
use crate::mesh::NONE;

/// Passes over the normals, and over the vertices.
const NORMALS: u32 = 6;
const VERTICES: u32 = 10;

/// Difference of two unit normals at which one counts 0.6 for the other: 20°.
const ALIKE: f64 = 0.35;

/// Least cosine between a face's normals before and after.
const TURN: f64 = 0.2;

/// Move the vertices of what is left of a sheet.
pub fn denoise(collapsed: &mut Collapsed) {
    let faces: Vec<u32> =
        (0..collapsed.alive.len() as u32).filter(|&f| collapsed.alive[f as usize]).collect();
    let before = collapsed.sheet.positions.clone();
    let wanted = filtered(collapsed, &faces);
    let moves = movable(collapsed, &faces);
    for _ in 0..VERTICES {
        follow(collapsed, &faces, &wanted, &moves);
    }
    // Faces that this would turn over stay where they were.
    loop {
        let sheet = &mut collapsed.sheet;
        let turned: Vec<u32> = faces
            .iter()
            .map(|&f| sheet.triangles[f as usize])
            .filter(|t| {
                let [old, new] =
                    [&before, &sheet.positions].map(|p| cross(t, p).normalize_or_zero());
                old.dot(new) < TURN
                    && t.iter().any(|&v| before[v as usize] != sheet.positions[v as usize])
            })
            .flatten()
            .collect();
        if turned.is_empty() {
            break;
        }
        turned.iter().for_each(|&v| sheet.positions[v as usize] = before[v as usize]);
    }
}

/// Twice a face's area along its normal.
fn cross(t: &[u32; 3], positions: &[DVec3]) -> DVec3 {
    let [a, b, c] = t.map(|v| positions[v as usize]);
    (b - a).cross(c - a)
}

/// The filtered normal of each face.
fn filtered(collapsed: &Collapsed, faces: &[u32]) -> Vec<DVec3> {
    let sheet = &collapsed.sheet;
    let twice: Vec<DVec3> = sheet.triangles.iter().map(|t| cross(t, &sheet.positions)).collect();
    let mut normals: Vec<DVec3> = twice.iter().map(|n| n.normalize_or_zero()).collect();
    for _ in 0..NORMALS {
        let mut next = normals.clone();
        for &f in faces {
            let own = normals[f as usize];
            let mut sum = own * twice[f as usize].length();
            for h in 3 * f as usize..3 * f as usize + 3 {
                let t = sheet.twin[h];
                if t != NONE && sheet.feature[h] == 0 {
                    let beside = t as usize / 3;
                    let apart = normals[beside].distance_squared(own) / (ALIKE * ALIKE);
                    sum += normals[beside] * twice[beside].length() * (-0.5 * apart).exp();
                }
            }
            next[f as usize] = sum.normalize_or(own);
        }
        normals = next;
    }
    normals
}

/// Faces around each vertex that may move; 0 where it may not.
fn movable(collapsed: &Collapsed, faces: &[u32]) -> Vec<u32> {
    let sheet = &collapsed.sheet;
    let mut count = vec![0; sheet.positions.len()];
    faces.iter().flat_map(|&f| sheet.triangles[f as usize]).for_each(|v| count[v as usize] += 1);
    for (f, k) in faces.iter().flat_map(|&f| [0, 1, 2].map(|k| (f as usize, k))) {
        if sheet.feature[3 * f + k] != 0 || sheet.twin[3 * f + k] == NONE {
            let t = sheet.triangles[f];
            (count[t[k] as usize], count[t[(k + 1) % 3] as usize]) = (0, 0);
        }
    }
    count
}

/// Vertices go to the mean of their feet on the planes that their faces are to lie in.
fn follow(collapsed: &mut Collapsed, faces: &[u32], wanted: &[DVec3], around: &[u32]) {
    let sheet = &mut collapsed.sheet;
    let mut moves = vec![DVec3::ZERO; sheet.positions.len()];
    for &f in faces {
        let corners = sheet.triangles[f as usize];
        let middle = corners.iter().map(|&v| sheet.positions[v as usize]).sum::<DVec3>() / 3.0;
        let normal = wanted[f as usize];
        for v in corners.map(|v| v as usize) {
            moves[v] += normal * normal.dot(middle - sheet.positions[v]);
        }
    }
    for ((p, by), &count) in sheet.positions.iter_mut().zip(moves).zip(around) {
        if count > 0 {
            *p += by / f64::from(count);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::Seeded;
    use crate::mesh::proxy::collapse::Sheet;

    /// A sheet of `n` × `n` cells of side 1 with a roof's ridge along its middle, shaken by so much.
    fn roof(n: u32, noise: f64) -> Collapsed {
        let mut random = Seeded::new(3, 0);
        let mut shake = || noise * (2.0 * random.unit_f64() - 1.0);
        let at = |i: u32| {
            let (x, y) = (f64::from(i % (n + 1)), f64::from(i / (n + 1)));
            DVec3::new(x, y, -(x - f64::from(n / 2)).abs())
        };
        let positions: Vec<DVec3> =
            (0..(n + 1) * (n + 1)).map(|i| at(i) + DVec3::new(shake(), shake(), shake())).collect();
        let cells = (0..n * n).map(|i| i / n * (n + 1) + i % n);
        let triangles: Vec<[u32; 3]> =
            cells.flat_map(|a| [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]).collect();
        let vertex = |h: u32| triangles[h as usize / 3][h as usize % 3];
        let ends = |h: u32| (vertex(h), vertex(h - h % 3 + (h % 3 + 1) % 3));
        let half_edges = 0..3 * triangles.len() as u32;
        let twin = half_edges
            .clone()
            .map(|h| {
                half_edges.clone().find(|&t| ends(t) == (ends(h).1, ends(h).0)).unwrap_or(NONE)
            })
            .collect();
        let feature = vec![0; 3 * triangles.len()];
        let alive = vec![true; triangles.len()];
        let sheet = Sheet { positions, triangles, twin, feature };
        Collapsed { sheet, alive, ..Collapsed::default() }
    }

    /// Root mean square distance from the roof, without the border.
    fn off(roof: &Collapsed, n: u32) -> f64 {
        let inner = |i: &usize| {
            let (x, y) = (*i as u32 % (n + 1), *i as u32 / (n + 1));
            (2..n - 1).contains(&x) && (2..n - 1).contains(&y)
        };
        let inner: Vec<usize> = (0..roof.sheet.positions.len()).filter(inner).collect();
        let square = |&i: &usize| {
            let p = roof.sheet.positions[i];
            (p.z + (p.x - f64::from(n / 2)).abs()).powi(2) / 2.0
        };
        (inner.iter().map(square).sum::<f64>() / inner.len() as f64).sqrt()
    }

    #[test]
    fn noise_goes_and_a_ridge_stays() {
        let mut roof = roof(16, 0.12);
        let before = off(&roof, 16);
        denoise(&mut roof);
        let after = off(&roof, 16);
        assert!(after < 0.6 * before, "{before} {after}");
    }

    #[test]
    fn what_has_no_noise_stays_and_so_does_the_border() {
        let exact = roof(12, 0.0);
        let mut same = exact.clone();
        denoise(&mut same);
        let moved = same.sheet.positions.iter().zip(&exact.sheet.positions);
        assert!(moved.clone().all(|(p, q)| p.distance(*q) < 0.05));
        assert!(moved.take(13).all(|(p, q)| p == q), "the first row is the border");
    }
}
