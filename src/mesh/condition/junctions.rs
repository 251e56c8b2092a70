//! T-junctions: where a vertex lies on an edge of a face that does not have it, as exporters leave them where they
//! divide one side of an edge and not the other. The long edge is no border of the object: a cap, a face that no
//! file has, closes what lies between it and the short ones. For the solvers its middle vertex stands off the long
//! edge by a thousandth of it, so that the cap has an area: a map in which it is not turned over keeps the two
//! sides from lying on each other. Lines are followed from vertex to vertex along borders; nothing is searched.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use glam::DVec3;

use super::pairing::{EdgeGroups, MOST_WINGS, Wings};
use super::{FLAT, has_area, weld};

/// How far a vertex may lie from an edge that it is on: in weld tolerances …
const NEAR: f64 = 4.0;

/// … or over the edge's length, whichever is more.
const NEAR_OF_EDGE: f64 = 1e-4;

/// How far the vertex of a cap is put off its long edge, over that edge's length …
const RISE: f64 = 1.0 / 1024.0;

/// … and over the diagonal, whichever is more: a multiple of the least height that counts.
const LEAST_RISE: f64 = 4.0 * FLAT;

/// Cosine of the angle between two edges at their common vertex from which on they lie along each other.
const ALONG: f64 = 0.99;

/// Cosine of the angle between the faces on a line from which on they lie on each other.
const FOLDED: f64 = 0.9;

/// Cosine of the angle by which a face may turn where its vertices are put off an edge.
const TURNED: f64 = 0.9;

/// Share of its area that it keeps at least.
const LEFT: f64 = 0.5;

/// Times that vertices which would spoil a face are left out, and the others tried again.
const ROUNDS: usize = 4;

/// The caps of a surface.
#[derive(Debug, Default)]
pub struct Junctions {
    /// Vertices of each cap: the ends of its long edge and the vertex between; wound as the face is whose edge it
    /// closes.
    pub caps: Vec<[u32; 3]>,
    /// That face.
    pub closes: Vec<u32>,
    /// Where the vertices between are put, off the edges that they are on.
    pub raised: BTreeMap<u32, DVec3>,
}

/// An edge of one face.
#[derive(Clone, Copy)]
struct Open {
    /// Its ends in the face's winding.
    ends: [u32; 2],
    /// The face; of a cap, the one whose edge it closes.
    face: u32,
    /// Where that lies, seen from the edge.
    wing: DVec3,
}

impl Junctions {
    /// Find them.
    pub fn find(wings: &Wings, groups: &EdgeGroups, diagonal: f64) -> Self {
        let borders = borders(wings, groups);
        if borders.is_empty() {
            return Self::default();
        }
        let mut kept: BTreeSet<u32> = BTreeSet::new();
        for _ in 0..ROUNDS {
            let lines = Lines::new(wings.positions, borders.clone(), &kept, diagonal);
            let found = lines.close();
            let spoilt = found.spoilt(wings, diagonal);
            if spoilt.is_empty() {
                return found;
            }
            kept.extend(spoilt);
        }
        Self::default()
    }

    /// Vertices on edges that would spoil a face.
    fn spoilt(&self, wings: &Wings, diagonal: f64) -> Vec<u32> {
        let old = |v: u32| wings.positions[v as usize];
        let new = |v: u32| self.raised.get(&v).copied().unwrap_or_else(|| old(v));
        let cross = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
        let is_raised = |t: &&[u32; 3]| t.iter().any(|v| self.raised.contains_key(v));
        let spoils = |t: &&[u32; 3]| {
            let (before, after) = (cross(t.map(old)), cross(t.map(new)));
            let turned = before.dot(after) < TURNED * before.length() * after.length();
            turned || after.length() < LEFT * before.length() || !has_area(t.map(new), diagonal)
        };
        let flat = |t: &&[u32; 3]| !has_area(t.map(new), diagonal);
        let faces = wings.triangles.iter().filter(is_raised).filter(spoils);
        let spoilt = faces.chain(self.caps.iter().filter(flat)).flatten();
        spoilt.copied().filter(|v| self.raised.contains_key(v)).collect()
    }
}

/// The edges of one face that go on, or lie, along another one; none if no two of them lie along each other.
fn borders(wings: &Wings, groups: &EdgeGroups) -> BTreeMap<[u32; 2], Open> {
    let triangles = wings.triangles;
    let ends = |h: u32| [0, 1].map(|k| triangles[h as usize / 3][(h as usize + k) % 3]);
    let mut at: Vec<(u32, u32)> = Vec::new();
    for group in groups.iter() {
        if let [h] = *group {
            at.extend(ends(h).map(|v| (v, h)));
        }
    }
    at.sort_unstable();
    let mut found = BTreeMap::new();
    let mut alongside = false;
    // Where borders meet in hundreds there is no line.
    let stars = at.chunk_by(|a, b| a.0 == b.0).filter(|star| star.len() <= MOST_WINGS);
    for star in stars {
        let place = |v: u32| wings.positions[v as usize];
        let way = |&(v, h): &(u32, u32)| {
            let [a, b] = ends(h);
            (place(if a == v { b } else { a }) - place(v)).normalize_or_zero()
        };
        let ways: Vec<DVec3> = star.iter().map(way).collect();
        for (i, one) in ways.iter().enumerate() {
            for (j, other) in ways[..i].iter().enumerate() {
                let cosine = one.dot(*other);
                if cosine.abs() > ALONG {
                    alongside |= cosine > 0.0;
                    for h in [star[i].1, star[j].1] {
                        let (ends, wing) = (ends(h), wings.wing(h));
                        found.insert(key(ends), Open { ends, face: h / 3, wing });
                    }
                }
            }
        }
    }
    if alongside { found } else { BTreeMap::new() }
}

fn key([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Borders that are followed.
struct Lines<'a> {
    positions: &'a [DVec3],
    /// Edges of one face.
    borders: BTreeMap<[u32; 2], Open>,
    /// The other ends of those at each vertex.
    ends: BTreeMap<u32, Vec<u32>>,
    /// Vertices that stay where they are.
    kept: &'a BTreeSet<u32>,
    diagonal: f64,
    found: Junctions,
}

impl<'a> Lines<'a> {
    fn new(
        positions: &'a [DVec3],
        borders: BTreeMap<[u32; 2], Open>,
        kept: &'a BTreeSet<u32>,
        diagonal: f64,
    ) -> Self {
        let mut ends: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for &[a, b] in borders.keys() {
            ends.entry(a).or_default().push(b);
            ends.entry(b).or_default().push(a);
        }
        Self { positions, borders, ends, kept, diagonal, found: Junctions::default() }
    }

    /// Close every edge that has vertices of others on it. What is left of one is an edge like others.
    fn close(mut self) -> Junctions {
        let mut queue: VecDeque<[u32; 2]> = self.borders.keys().copied().collect();
        while let Some(edge) = queue.pop_front() {
            let Some(open) = self.borders.get(&edge).copied() else { continue };
            let on_it = self.on(&open);
            if !on_it.is_empty() {
                self.remove(edge);
                self.cap(open, &on_it, &mut queue);
            }
        }
        self.found
    }

    /// The vertices on an edge, from its first end to its second: along borders from either.
    fn on(&self, open: &Open) -> Vec<u32> {
        let [a, b] = open.ends;
        let (mut on_it, whole) = self.follow(open, a, b);
        if !whole {
            on_it.extend(self.follow(open, b, a).0);
            let at = |v: u32| self.at(open, v);
            on_it.sort_by(|&v, &w| at(v).total_cmp(&at(w)).then(v.cmp(&w)));
            on_it.dedup();
        }
        on_it
    }

    /// Where on an edge a vertex is, 0 to 1.
    fn at(&self, open: &Open, v: u32) -> f64 {
        let [a, b, p] = [open.ends[0], open.ends[1], v].map(|v| self.positions[v as usize]);
        (p - a).dot(b - a) / (b - a).length_squared()
    }

    /// The vertices on an edge that borders lead to from one of its ends, and whether they lead to the other.
    fn follow(&self, open: &Open, from: u32, to: u32) -> (Vec<u32>, bool) {
        let (a, b) = (self.positions[from as usize], self.positions[to as usize]);
        let (length, along) = (a.distance(b), (b - a).normalize_or_zero());
        let near = (NEAR * weld::TOLERANCE * self.diagonal).max(NEAR_OF_EDGE * length);
        // Where borders meet in hundreds there is no line, and work would grow with the square.
        let ends = |v: u32| match self.ends.get(&v) {
            Some(ends) if ends.len() <= MOST_WINGS => &ends[..],
            _ => &[],
        };
        let (mut found, mut last, mut reached) = (Vec::new(), from, 0.0);
        loop {
            let next = ends(last).iter().filter_map(|&v| {
                let to_it = self.positions[v as usize] - a;
                let t = along.dot(to_it);
                let other = self.borders.get(&key([last, v]))?;
                let opposite = other.wing.dot(open.wing) < FOLDED && other.face != open.face;
                let is_on = v == to || (t < length && (to_it - along * t).length() <= near);
                let free =
                    v == to || !(self.kept.contains(&v) || self.found.raised.contains_key(&v));
                (t > reached && is_on && free && opposite && key([last, v]) != key(open.ends))
                    .then_some((t, v))
            });
            match next.min_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1))) {
                Some((_, v)) if v == to => return (found, true),
                Some((t, v)) => {
                    found.push(v);
                    (last, reached) = (v, t);
                }
                None => return (found, false),
            }
        }
    }

    /// Caps between an edge and the vertices on it, the one in the middle first.
    fn cap(&mut self, open: Open, on_it: &[u32], queue: &mut VecDeque<[u32; 2]>) {
        let [a, b] = open.ends;
        let Some(&middle) = on_it.get(on_it.len() / 2) else {
            // The half of a cap: closed by the edge that lies there, or open itself.
            let edge = key([a, b]);
            if !self.remove(edge) {
                self.borders.insert(edge, open);
                self.ends.entry(a).or_default().push(b);
                self.ends.entry(b).or_default().push(a);
                queue.push_back(edge);
            }
            return;
        };
        let (before, after) = (&on_it[..on_it.len() / 2], &on_it[on_it.len() / 2 + 1..]);
        let beside = [before.last().map_or(a, |&v| v), after.first().map_or(b, |&v| v)]
            .map(|v| self.borders.get(&key([middle, v])).map_or(DVec3::ZERO, |open| open.wing));
        // Into the faces on the other side.
        let away = match (beside[0] + beside[1]).normalize_or_zero() {
            DVec3::ZERO => -open.wing,
            away => away,
        };
        let at = |v: u32| self.positions[v as usize];
        let off = |v: u32| self.found.raised.get(&v).map_or(DVec3::ZERO, |p| *p - at(v));
        let t = self.at(&open, middle);
        let rise = (RISE * at(a).distance(at(b))).max(LEAST_RISE * self.diagonal);
        let moved = at(middle) + off(a).lerp(off(b), t) + away * rise;
        self.found.raised.insert(middle, moved);
        self.found.caps.push([b, a, middle]);
        self.found.closes.push(open.face);
        self.cap(Open { ends: [a, middle], ..open }, before, queue);
        self.cap(Open { ends: [middle, b], ..open }, after, queue);
    }

    /// Take an edge out, if it is one.
    fn remove(&mut self, edge: [u32; 2]) -> bool {
        if self.borders.remove(&edge).is_none() {
            return false;
        }
        for (v, w) in [(edge[0], edge[1]), (edge[1], edge[0])] {
            if let Some(ends) = self.ends.get_mut(&v) {
                ends.retain(|end| *end != w);
            }
        }
        true
    }
}

#[cfg(test)]
mod tests;
