//! Where on its proxy a point of a sheet lies: the nearest place that a walk over faces finds, from the
//! vertex that the record of collapses names. A walk stays on its sheet, where a search in space would jump
//! to the other side of a thin shell.

use std::collections::BTreeMap;

use glam::DVec3;

use super::collapse::Collapsed;
use crate::mesh::NONE;

/// Most steps of a walk.
const STEPS: usize = 64;

/// A place on a triangle mesh.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Place {
    /// The face.
    pub face: u32,
    /// Barycentric coordinates in it.
    pub weights: [f32; 3],
}

/// A collapsed sheet, on which places are found.
pub struct Locator<'a> {
    collapsed: &'a Collapsed,
    /// Unit normal of each face.
    normals: &'a [DVec3],
    /// Outline of features that each face lies within.
    within: &'a [u32],
    /// The faces that are left, by outline: each has one at least.
    left: BTreeMap<u32, Vec<u32>>,
}

impl<'a> Locator<'a> {
    /// A sheet's. `normals` and `within`: of each face.
    pub fn new(collapsed: &'a Collapsed, normals: &'a [DVec3], within: &'a [u32]) -> Self {
        let mut left: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (f, &of) in (0u32..).zip(within).filter(|(f, _)| collapsed.alive[*f as usize]) {
            left.entry(of).or_default().push(f);
        }
        Self { collapsed, normals, within, left }
    }

    /// The place nearest to a point with a normal on the faces of an outline, or with [`NONE`] on any, walking
    /// from the vertices that stand for `from`.
    pub fn find(&self, from: &[u32], point: DVec3, normal: DVec3, outline: u32) -> Place {
        let sheet = &self.collapsed.sheet;
        let (mut fan, mut best): (Vec<u32>, Option<(f64, Place)>) = (Vec::new(), None);
        let look = |face: u32, best: &mut Option<(f64, Place)>| {
            if outline != NONE && self.within[face as usize] != outline {
                return false;
            }
            let corners = sheet.triangles[face as usize].map(|v| sheet.positions[v as usize]);
            let weights = nearest(corners, point);
            let there: DVec3 = corners.iter().zip(weights).map(|(c, w)| *c * w).sum();
            // A face that looks the other way is the back of something thin.
            let back = self.normals[face as usize].dot(normal) < 0.0;
            let size = corners[0].distance_squared(corners[1]);
            let far = there.distance_squared(point) + if back { size } else { 0.0 };
            let nearer = best.is_none_or(|(least, _)| far < least);
            if nearer {
                *best = Some((far, Place { face, weights: weights.map(|w| w as f32) }));
            }
            nearer
        };
        // Whether one of the faces around a vertex is nearer; each vertex is asked once.
        let mut asked: Vec<u32> = Vec::new();
        let mut around = |v: u32, best: &mut Option<(f64, Place)>| {
            if asked.contains(&v) {
                return false;
            }
            asked.push(v);
            sheet.fan(self.collapsed.out[v as usize], &mut fan);
            fan.iter().filter(|h| look(**h / 3, best)).count() > 0
        };
        for &v in from {
            around(self.collapsed.root(v), &mut best);
        }
        // None of the outline's faces is near: begin at the nearest of all.
        if best.is_none() {
            for &f in self.left.get(&outline).into_iter().flatten() {
                look(f, &mut best);
            }
        }
        for _ in 0..STEPS {
            let Some((_, Place { face, .. })) = best else { break };
            let corners = sheet.triangles[face as usize];
            if corners.into_iter().filter(|&v| around(v, &mut best)).count() == 0 {
                break;
            }
        }
        best.map(|(_, place)| place).unwrap_or_default()
    }
}

/// Barycentric coordinates of the point of a triangle that is nearest to `p`: by the region of the
/// triangle's edges and corners that p lies in.
fn nearest([a, b, c]: [DVec3; 3], p: DVec3) -> [f64; 3] {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d, e, f) = (ab.length_squared(), ab.dot(ac), ac.length_squared());
    let (g, h) = (ap.dot(ab), ap.dot(ac));
    let area = d * f - e * e;
    let (v, w) = (f * g - e * h, d * h - e * g);
    if area > 0.0 && v >= 0.0 && w >= 0.0 && v + w <= area {
        return [1.0 - (v + w) / area, v / area, w / area];
    }
    // The nearest point lies on an edge.
    let along = |from: DVec3, to: DVec3| {
        let side = to - from;
        ((p - from).dot(side) / side.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)
    };
    let (s, t, u) = (along(a, b), along(b, c), along(c, a));
    let sides = [[1.0 - s, s, 0.0], [0.0, 1.0 - t, t], [u, 0.0, 1.0 - u]];
    let far = |w: &[f64; 3]| (a * w[0] + b * w[1] + c * w[2]).distance_squared(p);
    sides.into_iter().min_by(|x, y| far(x).total_cmp(&far(y))).unwrap_or([1.0, 0.0, 0.0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn no_other_point_is_nearer(
            x in prop::array::uniform9(-1.0..1.0f64), p in prop::array::uniform3(-2.0..2.0f64),
            other in prop::array::uniform2(0.0..1.0f64),
        ) {
            let corners = [0, 3, 6].map(|i| DVec3::from_slice(&x[i..i + 3]));
            let p = DVec3::from(p);
            let at = |w: [f64; 3]| corners.iter().zip(w).map(|(c, w)| *c * w).sum::<DVec3>();
            let weights = nearest(corners, p);
            prop_assert!(weights.iter().all(|w| (-1e-9..=1.0 + 1e-9).contains(w)));
            let [u, v] = other;
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let there = at([1.0 - u - v, u, v]);
            prop_assert!(at(weights).distance(p) <= there.distance(p) + 1e-6);
        }
    }
}
