//! Which half-edges are twins. Windings say nothing here, since files have them any way: the faces at an edge
//! are its wings, and of more than two the flattest pairs go together. A double-sided object, whose faces stand
//! twice, is so one surface, and at the rim where shelf and wall meet the wall goes on. Only among pairs that
//! are equally flat, as where two sheets of other triangles lie on each other, the file's windings are heard.

use glam::DVec3;
use rayon::prelude::*;

use super::orient::ascends;
use super::oriented_sets::OrientedSets;
use super::places::Class;
use super::walls::Walls;
use crate::mesh::NONE;
use crate::tasks;

/// Wings that lie on each other (cosine of the angle between them) are not one surface.
const FOLDED: f64 = 0.9999;

/// Faces of an edge at which the surface goes on; beyond, each ends there: no shape has such edges, and pairs
/// grow with the square.
pub const MOST_WINGS: usize = 64;

/// Half-edges grouped by the (unordered) edge they run along: half-edge numbers sorted by edge, and
/// where each group starts.
pub struct EdgeGroups {
    order: Vec<u32>,
    starts: Vec<u32>,
}

impl EdgeGroups {
    /// Group the half-edges.
    pub fn new(triangles: &[[u32; 3]]) -> Self {
        let key = |h: usize| {
            let t = triangles[h / 3];
            let (a, b) = (u64::from(t[h % 3]), u64::from(t[(h % 3 + 1) % 3]));
            ((a.min(b) << 32) | a.max(b), h as u32)
        };
        let mut keyed = tasks::fill("edges", 3 * triangles.len(), key);
        tasks::even("edges", keyed.len(), || keyed.par_sort_unstable());
        let mut starts = Vec::new();
        for i in 0..keyed.len() {
            if i == 0 || keyed[i].0 != keyed[i - 1].0 {
                starts.push(i as u32);
            }
        }
        starts.push(keyed.len() as u32);
        Self { order: tasks::fill("edges", keyed.len(), |i| keyed[i].1), starts }
    }

    /// The half-edges of each edge, ascending.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        self.starts.windows(2).map(|w| &self.order[w[0] as usize..w[1] as usize])
    }
}

/// The faces that are paired.
pub struct Wings<'a> {
    /// Vertex positions.
    pub positions: &'a [DVec3],
    /// Vertex triples.
    pub triangles: &'a [[u32; 3]],
    /// What must agree first where there is a choice: the class of each face.
    pub class: &'a [Class],
    /// Whether the file winds each face through its vertices in ascending order.
    pub ascending: &'a [bool],
    /// Whether only half-edges of opposite directions are paired: windings count.
    pub directed: bool,
}

impl Wings<'_> {
    /// Direction of a face as seen from its edge, perpendicular to that, of unit length.
    pub fn wing(&self, h: u32) -> DVec3 {
        let (t, k) = (self.triangles[h as usize / 3], h as usize % 3);
        let at = |k: usize| self.positions[t[k % 3] as usize];
        let along = (at(k + 1) - at(k)).normalize_or_zero();
        let to = at(k + 2) - at(k);
        (to - along * along.dot(to)).normalize_or_zero()
    }

    /// Whether the file winds two faces alike at their common edge.
    fn agree(&self, a: u32, b: u32) -> bool {
        let ahead = |h: u32| ascends(self.triangles, h) == self.ascending[h as usize / 3];
        ahead(a) != ahead(b)
    }

    fn may_pair(&self, a: u32, b: u32) -> bool {
        a / 3 != b / 3
            && (!self.directed || ascends(self.triangles, a) != ascends(self.triangles, b))
    }
}

/// The twin of every half-edge, [`NONE`] where there is none. The second sides of `walls` are faces of their
/// own at the end of `triangles`.
pub fn pair(wings: &Wings, groups: &EdgeGroups, walls: &Walls) -> Vec<u32> {
    let mut pairing = Pairing {
        wings,
        twin: vec![NONE; 3 * wings.triangles.len()],
        sheets: OrientedSets::new(wings.triangles.len()),
    };
    let mut crowded: Vec<&[u32]> = Vec::new();
    for group in groups.iter() {
        match *group {
            [_] => {}
            [a, b] => {
                let apart = || wings.wing(a).dot(wings.wing(b)) <= FOLDED;
                if wings.may_pair(a, b) && apart() {
                    pairing.join(a, b, false);
                }
            }
            _ if group.len() <= MOST_WINGS => crowded.push(group),
            _ => {}
        }
    }
    let mut candidates: Vec<(i64, bool, bool, u32, u32)> = Vec::new();
    for group in crowded {
        if let Some(pairs) = walls.pairs(wings, group) {
            pairs.into_iter().for_each(|(a, b)| pairing.join(a, b, false));
            continue;
        }
        let directions: Vec<DVec3> = group.iter().map(|&h| wings.wing(h)).collect();
        for (j, &b) in group.iter().enumerate() {
            for (i, &a) in group[..j].iter().enumerate() {
                let cosine = directions[i].dot(directions[j]);
                if cosine <= FOLDED && wings.may_pair(a, b) {
                    let (f, g) = (a as usize / 3, b as usize / 3);
                    // Rounded, so that layers that lie on each other compare equal.
                    let bend = (cosine * 1e6).round() as i64;
                    let differ = wings.class[f] != wings.class[g];
                    candidates.push((bend, differ, !wings.agree(a, b), a, b));
                }
            }
        }
    }
    candidates.sort_unstable();
    for (.., a, b) in candidates {
        pairing.join(a, b, true);
    }
    pairing.twin
}

/// Pairs as they are made.
struct Pairing<'a> {
    wings: &'a Wings<'a>,
    twin: Vec<u32>,
    sheets: OrientedSets,
}

impl Pairing<'_> {
    /// Make a pair of two half-edges that have none; `soundly`: only if the windings of all that hangs together
    /// stay consistent.
    fn join(&mut self, a: u32, b: u32, soundly: bool) {
        let free = self.twin[a as usize] == NONE && self.twin[b as usize] == NONE;
        let one_way = ascends(self.wings.triangles, a) == ascends(self.wings.triangles, b);
        if free && (self.sheets.join(a / 3, b / 3, one_way) || !soundly) {
            (self.twin[a as usize], self.twin[b as usize]) = (b, a);
        }
    }
}
