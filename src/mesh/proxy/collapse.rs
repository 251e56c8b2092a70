//! A sheet collapsed edge by edge, cheapest first (Garland & Heckbert 1997, doi:10.1145/258734.258849), under
//! the link condition (Dey et al. 1999, "Topology preserving edge contraction"), so that its topology stays.
//! Feature edges, borders among them, collapse only along themselves. Every collapse is recorded.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;

use super::quadric::Quadric;
use crate::contract::{Cancel, Canceled};
use crate::mesh::NONE;

/// Least cosine between a face's normal before and after a collapse.
const TURN: f64 = 0.2;

/// Least height of a face over its longest edge, where it was higher before.
const SLIVER: f64 = 0.03;

/// Weight of an edge's length to the fourth besides the quadric: where the surface is flat, short edges go
/// first and faces stay even.
const EVEN: f64 = 1e-3;

/// Weight of the planes that stand on feature edges, across the surface.
const STAND: f64 = 10.0;

/// One connected, oriented manifold of its own, each vertex with one fan of faces.
#[derive(Debug, Clone, Default)]
pub struct Sheet {
    /// Vertex positions.
    pub positions: Vec<DVec3>,
    /// Vertex triples.
    pub triangles: Vec<[u32; 3]>,
    /// The half-edge across, or [`NONE`] at a border. Length: 3 × faces.
    pub twin: Vec<u32>,
    /// What a half-edge is besides, not 0 where it may only collapse along its curve; the same on both sides.
    /// Edges that are joined have the bits of both. Length: 3 × faces.
    pub feature: Vec<u8>,
}

impl Sheet {
    /// The half-edges that start where `first` does.
    pub fn fan(&self, first: u32, fan: &mut Vec<u32>) {
        fan.clear();
        let mut h = first;
        loop {
            fan.push(h);
            h = self.twin[previous(h) as usize];
            if h == first {
                return;
            }
            if h == NONE {
                break;
            }
        }
        h = self.twin[first as usize];
        while h != NONE {
            h = next(h);
            fan.push(h);
            h = self.twin[h as usize];
        }
    }
}

/// What a collapse leaves. Faces and vertices keep their numbers.
#[derive(Debug, Clone, Default)]
pub struct Collapsed {
    /// The sheet; faces that are gone are still listed.
    pub sheet: Sheet,
    /// Whether a face is left.
    pub alive: Vec<bool>,
    /// The record: for each vertex the one that it became part of, itself where it is left.
    pub parent: Vec<u32>,
    /// A half-edge that starts at each vertex that is left.
    pub out: Vec<u32>,
}

impl Collapsed {
    /// The vertex that stands for `v`.
    pub fn root(&self, mut v: u32) -> u32 {
        while self.parent[v as usize] != v {
            v = self.parent[v as usize];
        }
        v
    }
}

fn next(h: u32) -> u32 {
    h - h % 3 + (h % 3 + 1) % 3
}

fn previous(h: u32) -> u32 {
    h - h % 3 + (h % 3 + 2) % 3
}

/// Collapse edges until no more than `target` faces are left, or none can go.
pub fn collapse(sheet: Sheet, target: usize, cancel: &Cancel) -> Result<Collapsed, Canceled> {
    let mut work = Work::new(sheet);
    let mut steps = 0u32;
    while work.faces > target {
        let Some(Reverse(entry)) = work.heap.pop() else { break };
        steps += 1;
        if steps.is_multiple_of(1 << 14) {
            cancel.check()?;
        }
        let h = entry as u32;
        if !work.alive[h as usize / 3] {
            continue;
        }
        if work.stamp(h) != work.stamped[h as usize] {
            work.push(h);
            continue;
        }
        match work.place(h).filter(|&p| work.keeps_link(h) && work.keeps_shape(h, p)) {
            Some(p) => work.collapse(h, p),
            // To be asked again once something near has changed.
            None => work.refused[h as usize] = true,
        }
    }
    let Work { sheet, alive, parent, out, .. } = work;
    Ok(Collapsed { sheet, alive, parent, out })
}

/// A sheet while it collapses.
struct Work {
    sheet: Sheet,
    alive: Vec<bool>,
    faces: usize,
    parent: Vec<u32>,
    quadric: Vec<Quadric>,
    /// Feature edges at each vertex.
    features: Vec<u32>,
    /// A half-edge that starts at each vertex.
    out: Vec<u32>,
    /// How often each vertex has moved.
    moved: Vec<u32>,
    /// Moves of a half-edge's ends when its cost was taken.
    stamped: Vec<u32>,
    refused: Vec<bool>,
    /// Cost (the bits of a positive number, which order as the number does) and half-edge.
    heap: BinaryHeap<Reverse<u64>>,
    /// Half-edges around one end and around the other.
    fans: [Vec<u32>; 2],
    /// Last mark of each vertex, and marks given.
    mark: Vec<u32>,
    marks: u32,
}

impl Work {
    fn new(sheet: Sheet) -> Self {
        let (vertices, faces) = (sheet.positions.len(), sheet.triangles.len());
        let mut work = Self {
            alive: vec![true; faces],
            faces,
            parent: (0..vertices as u32).collect(),
            quadric: vec![Quadric::default(); vertices],
            features: vec![0; vertices],
            out: vec![NONE; vertices],
            moved: vec![0; vertices],
            stamped: vec![0; 3 * faces],
            refused: vec![false; 3 * faces],
            heap: BinaryHeap::new(),
            fans: [Vec::new(), Vec::new()],
            mark: vec![0; vertices],
            marks: 0,
            sheet,
        };
        for f in 0..faces {
            let t = work.sheet.triangles[f];
            let [a, b, c] = t.map(|v| work.sheet.positions[v as usize]);
            let cross = (b - a).cross(c - a);
            let normal = cross.normalize_or_zero();
            let plane = Quadric::plane(normal, a, cross.length() / 6.0);
            for k in 0..3 {
                let (v, w, h) = (t[k] as usize, t[(k + 1) % 3] as usize, 3 * f + k);
                work.quadric[v] = work.quadric[v].plus(&plane);
                work.out[v] = h as u32;
                if work.sheet.feature[h] == 0 {
                    continue;
                }
                let (p, q) = (work.sheet.positions[v], work.sheet.positions[w]);
                let across = (q - p).cross(normal).normalize_or_zero();
                let stand = Quadric::plane(across, p, STAND * p.distance_squared(q));
                work.quadric[v] = work.quadric[v].plus(&stand);
                work.quadric[w] = work.quadric[w].plus(&stand);
                let twin = work.sheet.twin[h];
                if twin == NONE || (h as u32) < twin {
                    work.features[v] += 1;
                    work.features[w] += 1;
                }
            }
        }
        let mut entries = Vec::with_capacity(3 * faces / 2);
        for h in 0..3 * faces as u32 {
            let twin = work.sheet.twin[h as usize];
            if twin == NONE || h < twin {
                entries.extend(work.entry(h).map(Reverse));
            }
        }
        work.heap = BinaryHeap::from(entries);
        work
    }

    fn ends(&self, h: u32) -> [u32; 2] {
        let t = self.sheet.triangles[h as usize / 3];
        [t[h as usize % 3], t[(h as usize % 3 + 1) % 3]]
    }

    fn position(&self, v: u32) -> DVec3 {
        self.sheet.positions[v as usize]
    }

    fn stamp(&self, h: u32) -> u32 {
        let [a, b] = self.ends(h);
        self.moved[a as usize].wrapping_add(self.moved[b as usize])
    }

    /// Where the vertex of an edge would lie; `None` where the edge may not go.
    fn place(&self, h: u32) -> Option<DVec3> {
        let [a, b] = self.ends(h);
        let [m, n] = [a, b].map(|v| self.features[v as usize]);
        let along = self.sheet.feature[h as usize] != 0;
        // What lies on no curve is free, what lies within one moves along it, what ends one stays.
        match (m, n) {
            (0, 0) => {}
            (2, 2) if along => {}
            (0, _) if !along => return Some(self.position(b)),
            (_, 0) if !along => return Some(self.position(a)),
            (_, 2) if along => return Some(self.position(a)),
            (2, _) if along => return Some(self.position(b)),
            _ => return None,
        }
        let (p, q) = (self.position(a), self.position(b));
        let sum = self.quadric[a as usize].plus(&self.quadric[b as usize]);
        let middle = 0.5 * (p + q);
        // Where planes are nearly parallel the least value may lie far off.
        Some(middle + (sum.least(middle) - middle).clamp_length_max(p.distance(q)))
    }

    fn entry(&mut self, h: u32) -> Option<u64> {
        let place = self.place(h)?;
        let [a, b] = self.ends(h);
        let sum = self.quadric[a as usize].plus(&self.quadric[b as usize]);
        let length = self.position(a).distance_squared(self.position(b));
        let cost = (sum.at(place) + EVEN * length * length) as f32;
        self.stamped[h as usize] = self.stamp(h);
        Some(u64::from(cost.to_bits()) << 32 | u64::from(h))
    }

    fn push(&mut self, h: u32) {
        self.refused[h as usize] = false;
        let entry = self.entry(h);
        self.heap.extend(entry.map(Reverse));
    }

    /// Whether the ends have no common neighbours but the corners of the faces at the edge, and no face's
    /// other edges are both features: then shape and curves keep their topology. Fills the fans.
    fn keeps_link(&mut self, h: u32) -> bool {
        let [a, b] = self.ends(h);
        let mut fans = std::mem::take(&mut self.fans);
        self.sheet.fan(self.out[a as usize], &mut fans[0]);
        self.sheet.fan(self.out[b as usize], &mut fans[1]);
        self.marks += 1;
        let mut common = 0;
        for &g in &fans[0] {
            for v in [self.ends(g)[1], self.ends(previous(g))[0]] {
                self.mark[v as usize] = self.marks;
            }
        }
        for &g in &fans[1] {
            for v in [self.ends(g)[1], self.ends(previous(g))[0]] {
                if self.mark[v as usize] == self.marks {
                    self.mark[v as usize] = 0;
                    common += 1;
                }
            }
        }
        self.fans = fans;
        let twin = self.sheet.twin[h as usize];
        let sides: &[u32] = if twin == NONE { &[h] } else { &[h, twin] };
        let curved = |&g: &u32| {
            self.sheet.feature[next(g) as usize] != 0
                && self.sheet.feature[previous(g) as usize] != 0
        };
        common == sides.len() && !sides.iter().any(curved) && self.faces > 2 * sides.len() + 2
    }

    /// Whether no face near the edge turns far or becomes a sliver. Needs the fans.
    fn keeps_shape(&self, h: u32, place: DVec3) -> bool {
        let [a, b] = self.ends(h);
        self.fans.iter().flatten().all(|&g| {
            let t = self.sheet.triangles[g as usize / 3];
            if t.contains(&a) && t.contains(&b) {
                return true;
            }
            let k = g as usize % 3;
            let [p, q, r] = [k, (k + 1) % 3, (k + 2) % 3].map(|k| self.position(t[k]));
            let (before, after) = ((q - p).cross(r - p), (q - place).cross(r - place));
            let longest = |p: DVec3| {
                p.distance_squared(q).max(p.distance_squared(r)).max(q.distance_squared(r))
            };
            let sliver = |cross: DVec3, p: DVec3| cross.length() / longest(p);
            before.dot(after) > TURN * before.length() * after.length()
                && sliver(after, place) > SLIVER.min(0.9 * sliver(before, p))
        })
    }

    /// Make one vertex of an edge's ends, at `place`. Needs the fans.
    fn collapse(&mut self, h: u32, place: DVec3) {
        let [keep, gone] = self.ends(h);
        let twin = self.sheet.twin[h as usize];
        for k in 0..self.fans[1].len() {
            let g = self.fans[1][k] as usize;
            self.sheet.triangles[g / 3][g % 3] = keep;
        }
        self.parent[gone as usize] = keep;
        self.sheet.positions[keep as usize] = place;
        let added = self.quadric[gone as usize];
        self.quadric[keep as usize] = self.quadric[keep as usize].plus(&added);
        let along = 2 * u32::from(self.sheet.feature[h as usize] != 0);
        let both = self.features[keep as usize] + self.features[gone as usize];
        self.features[keep as usize] = both - along;
        self.moved[keep as usize] += self.moved[gone as usize] + 1;
        for g in [h, twin].into_iter().filter(|&g| g != NONE) {
            self.close(g);
        }
        let mut fan = std::mem::take(&mut self.fans[0]);
        self.sheet.fan(self.out[keep as usize], &mut fan);
        for &g in &fan {
            for g in [g, previous(g), self.sheet.twin[g as usize]] {
                if g != NONE && self.refused[g as usize] {
                    self.push(g);
                }
            }
        }
        self.fans[0] = fan;
    }

    /// Take away the face of `h`, whose ends are one by now, and join its other two edges.
    fn close(&mut self, h: u32) {
        let (one, other) = (next(h), previous(h));
        let [s, t] = [one, other].map(|g| self.sheet.twin[g as usize]);
        let corner = self.ends(other)[0];
        let feature = self.sheet.feature[one as usize] | self.sheet.feature[other as usize];
        self.alive[h as usize / 3] = false;
        self.faces -= 1;
        for (g, across) in [(s, t), (t, s)] {
            if g != NONE {
                self.sheet.twin[g as usize] = across;
                self.sheet.feature[g as usize] = feature;
            }
        }
        // s runs from the corner to the kept vertex, t from there to the corner.
        let kept = self.sheet.triangles[h as usize / 3][h as usize % 3];
        if s != NONE {
            (self.out[corner as usize], self.out[kept as usize]) = (s, next(s));
        } else {
            (self.out[corner as usize], self.out[kept as usize]) = (next(t), t);
        }
        self.push(if s == NONE { t } else { s });
    }
}
