//! Walls: where two solids touch, both have a face at the same place. A patch of faces that stand twice is a
//! wall if at each of its edges two other faces go on, one on either side: then both its sides are put back,
//! and each solid keeps its own. Everything else that stands twice is the two sides of a sheet, or a copy.

use std::f64::consts::TAU;

use glam::DVec3;

use super::pairing::{EdgeGroups, MOST_WINGS, Wings};
use crate::mesh::{DisjointSets, NONE};

/// The walls of a surface.
#[derive(Debug, Default)]
pub struct Walls {
    /// The faces of walls, in ascending order; the second side of the i-th is face `faces + i`.
    pub faces: Vec<u32>,
    /// Faces before the second sides were added.
    before: u32,
}

impl Walls {
    /// Find them. `twice`: whether each face stands more than once.
    pub fn find(groups: &EdgeGroups, twice: &[bool]) -> Self {
        let before = twice.len() as u32;
        if !twice.contains(&true) {
            return Self { faces: Vec::new(), before };
        }
        let double = |h: &u32| twice[*h as usize / 3];
        let mut patches = DisjointSets::new(twice.len());
        for group in groups.iter().filter(|group| group.iter().all(double)) {
            if let [a, b] = *group {
                patches.join(a / 3, b / 3);
            }
        }
        let mut whole = vec![true; twice.len()];
        for group in groups.iter() {
            let doubles = group.iter().filter(|h| double(h)).count();
            let inner = doubles == group.len() && doubles % 2 == 0 && doubles <= MOST_WINGS / 2;
            let rim = doubles == 1 && group.len() == 3;
            if doubles > 0 && !inner && !rim {
                for h in group.iter().filter(|h| double(h)) {
                    whole[patches.root(h / 3) as usize] = false;
                }
            }
        }
        // A closed patch has no rim at all: its faces are a double-sided body.
        let mut rimmed = vec![false; twice.len()];
        for group in groups.iter().filter(|group| group.len() == 3) {
            for h in group.iter().filter(|h| double(h)) {
                rimmed[patches.root(h / 3) as usize] = true;
            }
        }
        let is_wall = |f: &u32| {
            let patch = patches.root(*f) as usize;
            twice[*f as usize] && whole[patch] && rimmed[patch]
        };
        Self { faces: (0..before).filter(is_wall).collect(), before }
    }

    /// The second side of a wall's face, or [`NONE`].
    pub fn second(&self, face: u32) -> u32 {
        self.faces.binary_search(&face).map_or(NONE, |i| self.before + i as u32)
    }

    /// The pairs at an edge of which a wall is a wing: each of its sides goes on with the wing that is next on
    /// that side. `None` at other edges.
    pub fn pairs(&self, wings: &Wings, group: &[u32]) -> Option<Vec<(u32, u32)>> {
        let of_wall =
            |h: &u32| *h / 3 >= self.before || self.faces.binary_search(&(*h / 3)).is_ok();
        if self.faces.is_empty() || !group.iter().any(of_wall) {
            return None;
        }
        // Second sides lie where the first do.
        let first: Vec<u32> = group.iter().copied().filter(|h| h / 3 < self.before).collect();
        let from = *first.iter().find(|h| of_wall(h))?;
        let (t, k) = (wings.triangles[from as usize / 3], from as usize % 3);
        let along = wings.positions[t[(k + 1) % 3] as usize] - wings.positions[t[k] as usize];
        let turn = along.cross(wings.wing(from));
        let ring = angles(first.iter().map(|&h| (wings.wing(h), h)), wings.wing(from), turn);
        // The side of a wing that faces the sector after it, in the sense of turning, or before it: a wall has
        // one for each, the first where its own normal looks.
        let side = |h: u32, after: bool| {
            let second = self.second(h / 3);
            let [a, b, c] = wings.triangles[h as usize / 3].map(|v| wings.positions[v as usize]);
            let ahead = along.cross(wings.wing(h)).dot((b - a).cross(c - a)) > 0.0;
            match second {
                NONE => h,
                _ if ahead == after => h,
                _ => 3 * second + h % 3,
            }
        };
        let next = |i: usize| ring[(i + 1) % ring.len()].1;
        let mut pairs = Vec::new();
        let mut used: Vec<u32> = Vec::new();
        for (i, &(_, h)) in ring.iter().enumerate() {
            // A sector beside a wall is the inside of a solid.
            if !of_wall(&h) && !of_wall(&next(i)) {
                continue;
            }
            let pair = (side(h, true), side(next(i), false));
            if !used.contains(&pair.0) && !used.contains(&pair.1) {
                used.extend([pair.0, pair.1]);
                pairs.push(pair);
            }
        }
        Some(pairs)
    }
}

/// Things in the order of their direction's angle from `zero` towards `turn`.
fn angles(things: impl Iterator<Item = (DVec3, u32)>, zero: DVec3, turn: DVec3) -> Vec<(f64, u32)> {
    let angle = |(wing, h): (DVec3, u32)| {
        (turn.normalize_or_zero().dot(wing).atan2(zero.dot(wing)).rem_euclid(TAU), h)
    };
    let mut angles: Vec<(f64, u32)> = things.map(angle).collect();
    angles.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    angles
}
