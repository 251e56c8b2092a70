//! Double-sided objects: of the two sheets only the outer one is looked at, since on the inner one every
//! convex edge is concave, normals point inwards, and the other side of a wall is never met.

use std::borrow::Cow;

use super::PartScores;
use crate::mesh::{NONE, Surface};
use crate::sampling::PointCloud;

/// A surface and its cloud as they are seen from outside: faces of inner sheets are not usable, have no
/// area and no neighbours; their points lie on their mates.
pub struct Outside<'a> {
    /// The surface; faces have the numbers that they have.
    pub surface: Cow<'a, Surface>,
    /// The cloud; points have the numbers that they have.
    pub cloud: Cow<'a, PointCloud>,
    /// The outer face of each inner one, [`NONE`] for others; empty if there are none.
    outer: Vec<u32>,
}

impl<'a> Outside<'a> {
    /// Look at a surface from outside.
    pub fn of(surface: &'a Surface, cloud: &'a PointCloud) -> Self {
        let mut seen = Self::of_surface(surface);
        seen.cloud = Cow::Borrowed(cloud);
        if !seen.outer.is_empty() {
            let cloud = seen.cloud.to_mut();
            for (face, normal) in cloud.faces.iter_mut().zip(&mut cloud.normals) {
                let outer = seen.outer[*face as usize];
                if outer != NONE {
                    *face = outer;
                    *normal = surface.normals[outer as usize];
                }
            }
        }
        seen
    }

    /// Look at a surface from outside, without a cloud.
    pub fn of_surface(surface: &'a Surface) -> Self {
        let cloud = Cow::Owned(PointCloud::default());
        let seen = Self { surface: Cow::Borrowed(surface), cloud, outer: Vec::new() };
        if surface.sheet_mate.iter().all(|&m| m == NONE) {
            return seen;
        }
        let is_inner = inner(surface);
        let mut own = surface.clone();
        let mut outer = vec![NONE; own.face_count()];
        for f in (0..own.face_count()).filter(|&f| is_inner[f]) {
            outer[f] = surface.sheet_mate[f];
            own.usable[f] = false;
            own.areas[f] = 0.0;
            for h in 3 * f..3 * f + 3 {
                let twin = std::mem::replace(&mut own.twin[h], NONE);
                if twin != NONE {
                    own.twin[twin as usize] = NONE;
                }
            }
        }
        own.sheet_mate.fill(NONE);
        Self { surface: Cow::Owned(own), outer, ..seen }
    }

    /// Scores of the outer sheets hold for the inner ones, too.
    pub fn whole(&self, mut scores: PartScores) -> PartScores {
        for (f, &outer) in self.outer.iter().enumerate().filter(|(_, o)| **o != NONE) {
            scores.fixed[f] = scores.fixed[outer as usize];
        }
        scores
    }
}

/// For each face, whether it lies on an inner sheet: every face of it has its mate on one other sheet that
/// encloses more (signed volume), or as much and comes first. A face that two components share so stays.
fn inner(surface: &Surface) -> Vec<bool> {
    let faces = surface.face_count();
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
            for t in surface.twin[3 * f..3 * f + 3].iter().filter(|t| **t != NONE) {
                let g = *t as usize / 3;
                if sheet[g] == NONE {
                    sheet[g] = id;
                    stack.push(g);
                }
            }
        }
        volumes.push(volume);
    }
    // The sheet that all mates of a sheet lie on: nothing known yet, one, or no single one.
    let mut behind: Vec<Option<u32>> = vec![None; volumes.len()];
    for f in (0..faces).filter(|&f| sheet[f] != NONE) {
        let mate = surface.sheet_mate[f];
        let on = if mate == NONE { NONE } else { sheet[mate as usize] };
        let known = behind[sheet[f] as usize].get_or_insert(on);
        if *known != on {
            *known = NONE;
        }
    }
    let is_inner = |own: u32| {
        let other = behind[own as usize].unwrap_or(NONE);
        other != NONE
            && other != own
            && match volumes[other as usize].total_cmp(&volumes[own as usize]) {
                std::cmp::Ordering::Greater => true,
                std::cmp::Ordering::Equal => other < own,
                std::cmp::Ordering::Less => false,
            }
    };
    sheet.iter().map(|&own| own != NONE && is_inner(own)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::Run;
    use crate::sampling::{SampleCounts, sample};

    #[test]
    fn a_face_that_two_components_share_stays() {
        let cube = |name: &str, z: i32| {
            let mut text = format!("o {name}\n");
            for (x, y, up) in [
                (0, 0, 0),
                (1, 0, 0),
                (1, 1, 0),
                (0, 1, 0),
                (0, 0, 1),
                (1, 0, 1),
                (1, 1, 1),
                (0, 1, 1),
            ] {
                text += &format!("v {x} {y} {}\n", z + up);
            }
            for f in ["1 4 3 2", "5 6 7 8", "1 2 6 5", "2 3 7 6", "3 4 8 7", "4 1 5 8"] {
                let at = |v: &str| v.parse::<i32>().unwrap() + 8 * z;
                let vertices: Vec<String> = f.split(' ').map(|v| at(v).to_string()).collect();
                text += &format!("f {}\n", vertices.join(" "));
            }
            text
        };
        let text = cube("lower", 0) + &cube("upper", 1);
        let limits = crate::contract::Limits::default();
        let scene = crate::mesh::import(text.as_bytes(), crate::contract::MeshKind::Obj, &limits);
        let surface = crate::mesh::condition(&scene.unwrap(), &Run::quiet()).unwrap();
        assert!(surface.sheet_mate.iter().any(|m| *m != NONE), "they stand back to back");
        let seen = Outside::of_surface(&surface);
        assert!(seen.surface.usable.iter().all(|u| *u));
    }

    #[test]
    fn from_outside_a_double_sided_cube_is_a_cube() {
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
            f 1 2 3 4\nf 5 8 7 6\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n\
            f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
        let limits = crate::contract::Limits::default();
        let scene = crate::mesh::import(text.as_bytes(), crate::contract::MeshKind::Obj, &limits);
        let surface = crate::mesh::condition(&scene.unwrap(), &Run::quiet()).unwrap();
        let cloud = sample(&surface, SampleCounts::dense(24), 1, &Run::quiet()).unwrap();
        let seen = Outside::of(&surface, &cloud);
        assert_eq!(seen.surface.usable.iter().filter(|u| **u).count(), 12);
        assert!((seen.surface.areas.iter().sum::<f64>() - 6.0).abs() < 1e-12);
        let middle = glam::DVec3::splat(0.5);
        for ((p, n), &f) in
            seen.cloud.positions.iter().zip(&seen.cloud.normals).zip(&seen.cloud.faces)
        {
            assert!((*p - middle).dot(*n) > 0.0 && seen.surface.usable[f as usize]);
        }
        let fixed = (0..24).map(|f| if seen.surface.usable[f] { f as i32 } else { -1 }).collect();
        let scores = seen.whole(PartScores { fixed, ..Default::default() });
        for (f, &mate) in surface.sheet_mate.iter().enumerate() {
            assert_eq!(scores.fixed[f], scores.fixed[mate as usize]);
        }
    }
}
