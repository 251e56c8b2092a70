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
