//! Double-sided faces: of the two sheets of a body only the outer one is read for its shape, since
//! on the inner one every ridge is a valley.

use crate::mesh::{NONE, Surface};

/// For each face, whether it lies on the inner sheet: its mate has the same label and is on another
/// sheet that encloses more (signed volume), or as much and comes first.
pub fn inner(surface: &Surface, label: &[i32]) -> Vec<bool> {
    let faces = surface.face_count();
    if surface.sheet_mate.iter().all(|&m| m == NONE) {
        return vec![false; faces];
    }
    let mut sheet = vec![NONE; faces];
    let mut volumes: Vec<f64> = Vec::new();
    let mut stack = Vec::new();
    for seed in 0..faces {
        if sheet[seed] != NONE || !surface.usable[seed] {
            continue;
        }
        let id = volumes.len() as u32;
        let origin = surface.centroid(seed);
        let mut volume = 0.0;
        sheet[seed] = id;
        stack.push(seed);
        while let Some(f) = stack.pop() {
            let [a, b, c] = surface.corners(f).map(|p| p - origin);
            volume += a.dot(b.cross(c)) / 6.0;
            for h in 3 * f..3 * f + 3 {
                let t = surface.twin[h];
                if t != NONE && sheet[t as usize / 3] == NONE && label[t as usize / 3] == label[f] {
                    sheet[t as usize / 3] = id;
                    stack.push(t as usize / 3);
                }
            }
        }
        volumes.push(volume);
    }
    let follows = |f: usize| {
        let mate = surface.sheet_mate[f];
        if mate == NONE || label[mate as usize] != label[f] {
            return false;
        }
        let (own, other) = (sheet[f], sheet[mate as usize]);
        let enclosed = |s: u32| volumes.get(s as usize).copied().unwrap_or(0.0);
        match enclosed(other).total_cmp(&enclosed(own)) {
            std::cmp::Ordering::Greater => own != other,
            std::cmp::Ordering::Equal => other < own,
            std::cmp::Ordering::Less => false,
        }
    };
    (0..faces).map(follows).collect()
}
