//! Consistent winding. Twins should run along their edge in opposite directions: a spanning tree over them,
//! grown from the first face of each component, says which faces are to be turned over. Twins that disagree
//! all the same (on a Möbius strip) are parted.

use std::collections::VecDeque;

use crate::mesh::NONE;

/// What was found.
pub struct Orientation {
    /// Which faces are to be turned over. Length: faces.
    pub turned: Vec<bool>,
    /// The first faces of components that have no consistent winding, in ascending order.
    pub without: Vec<u32>,
}

/// Whether a half-edge runs from the vertex of the lower number to that of the higher.
pub fn ascends(triangles: &[[u32; 3]], h: u32) -> bool {
    let (t, k) = (triangles[h as usize / 3], h as usize % 3);
    t[k] < t[(k + 1) % 3]
}

/// Find it; twins that still disagree are parted.
pub fn orient(triangles: &[[u32; 3]], twin: &mut [u32]) -> Orientation {
    let faces = triangles.len();
    let mut turned = vec![false; faces];
    let mut first = vec![NONE; faces];
    let mut queue = VecDeque::new();
    for seed in 0..faces as u32 {
        if first[seed as usize] != NONE {
            continue;
        }
        first[seed as usize] = seed;
        queue.push_back(seed);
        while let Some(f) = queue.pop_front() {
            for h in 3 * f..3 * f + 3 {
                let t = twin[h as usize];
                let g = t / 3;
                if t != NONE && first[g as usize] == NONE {
                    first[g as usize] = seed;
                    let agree = ascends(triangles, h) != ascends(triangles, t);
                    turned[g as usize] = turned[f as usize] == agree;
                    queue.push_back(g);
                }
            }
        }
    }
    let mut without = Vec::new();
    for h in 0..twin.len() as u32 {
        let t = twin[h as usize];
        if t == NONE || t < h {
            continue;
        }
        let one_way = ascends(triangles, h) == ascends(triangles, t);
        if one_way != (turned[h as usize / 3] != turned[t as usize / 3]) {
            (twin[h as usize], twin[t as usize]) = (NONE, NONE);
            without.push(first[h as usize / 3]);
        }
    }
    without.sort_unstable();
    without.dedup();
    Orientation { turned, without }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_face_that_runs_against_its_neighbour_is_turned() {
        let triangles = [[0, 1, 2], [1, 2, 3], [2, 3, 4]];
        let pair = |twin: &mut Vec<u32>, h: usize, t: usize| {
            (twin[h], twin[t]) = (t as u32, h as u32);
        };
        let mut twin = vec![NONE; 9];
        pair(&mut twin, 1, 3);
        pair(&mut twin, 4, 6);
        let Orientation { turned, without } = orient(&triangles, &mut twin);
        assert_eq!(turned, [false, true, false]);
        assert!(without.is_empty() && twin[1] == 3);
    }

    #[test]
    fn a_moebius_strip_is_parted_once() {
        // Five triangles in a ring (the least Möbius strip), all ascending.
        let mut triangles: Vec<[u32; 3]> =
            (0..5u32).map(|i| [i, (i + 1) % 5, (i + 2) % 5]).collect();
        triangles.iter_mut().for_each(|t| t.sort_unstable());
        let mut twin = vec![NONE; 15];
        let edge = |h: u32| {
            let (t, k) = (triangles[h as usize / 3], h as usize % 3);
            let (a, b) = (t[k], t[(k + 1) % 3]);
            (a.min(b), a.max(b))
        };
        for (h, t) in (0..15u32).flat_map(|h| (0..15u32).map(move |t| (h, t))) {
            if h != t && edge(h) == edge(t) {
                twin[h as usize] = t;
            }
        }
        let before = twin.iter().filter(|t| **t != NONE).count();
        let Orientation { without, .. } = orient(&triangles, &mut twin);
        assert_eq!(without, [0]);
        assert_eq!(twin.iter().filter(|t| **t != NONE).count(), before - 2);
    }
}
