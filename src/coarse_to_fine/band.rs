//! Seams on the fine surface: labels that were carried over from the proxy, straightened in a band about
//! each seam by one minimum cut, so that seams run short, smooth and along the proxy's creases. Curves that
//! the proxy keeps, and borders of parts, are crossed by no label.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use super::pieces::Seams;
use crate::charts::seam_cost;
use crate::mesh::{Flow, NONE, Proxy, Surface};

/// Width of a band on each side, in mean edges of the proxy.
const WIDTH: f64 = 0.6;

/// Least and most of it, in rings of faces.
const RINGS: [u32; 2] = [2, 16];

/// Capacity of what must not be cut, in seams of mean length.
const UNCUT: f64 = 1e6;

/// Capacity that holds a face where it is, where nothing else does.
const HOLD: f64 = 1e-4;

/// Labels on the fine surface.
pub struct Band<'a, S: Seams> {
    pub(super) fine: &'a Surface,
    proxy: &'a Proxy,
    pub(super) seams: &'a S,
    /// Label of each face, or [`NONE`].
    pub labels: Vec<u32>,
    /// Whether each face belongs to a component that was collapsed: only there do seams move.
    pub(super) dense: Vec<bool>,
    /// Whether each face keeps its label.
    pub held: Vec<bool>,
    /// What each face may not leave: faces of one class are connected without crossing a curve.
    pub(super) class: Vec<u32>,
    /// Classes and groups that occur in them.
    occurs: BTreeSet<(u32, u32)>,
    /// Width, in rings.
    rings: u32,
    /// Length of a mean edge of a fine face that was collapsed.
    edge: f64,
    /// Scratch: the node of each face in a cut.
    node: Vec<u32>,
}

impl<'a, S: Seams> Band<'a, S> {
    /// Labels before they are straightened. `parts`: what faces of different entries never share.
    pub fn new(
        fine: &'a Surface,
        proxy: &'a Proxy,
        seams: &'a S,
        labels: Vec<u32>,
        parts: Option<&[u32]>,
    ) -> Self {
        let class = fine.components(|h| {
            let [f, g] = [h, fine.twin[h as usize]].map(|h| h as usize / 3);
            proxy.features[h as usize] == 0 && parts.is_none_or(|parts| parts[f] == parts[g])
        });
        let occurs = class.iter().zip(&labels).filter(|(_, l)| **l != NONE);
        let occurs = occurs.map(|(&class, &label)| (class, seams.group(label))).collect();
        let mean = |surface: &Surface, own: &dyn Fn(usize) -> bool| {
            let faces = (0..surface.face_count()).filter(|&f| own(f));
            let (area, count) = faces.fold((0.0, 0.0), |(a, n), f| (a + surface.areas[f], n + 1.0));
            // The edge of an equilateral triangle of the mean area.
            (area / f64::max(count, 1.0) * 4.0 / 3f64.sqrt()).sqrt()
        };
        let is_dense = |&on: &u32| on != NONE && proxy.collapsed[on as usize];
        let dense: Vec<bool> = proxy.face.iter().map(is_dense).collect();
        let edge = mean(fine, &|f| dense[f]);
        let coarse = mean(&proxy.surface, &|f| proxy.collapsed[f]);
        // A ring of triangles is about half an edge wide.
        let rings = (2.0 * WIDTH * coarse / edge).round() as u32;
        Self {
            rings: rings.clamp(RINGS[0], RINGS[1]),
            node: vec![NONE; fine.face_count()],
            fine,
            proxy,
            seams,
            labels,
            held: vec![false; dense.len()],
            dense,
            class,
            occurs,
            edge,
        }
    }

    pub(super) fn label(&self, h: u32) -> u32 {
        self.labels[h as usize / 3]
    }

    /// Whether a half-edge is a seam.
    pub fn is_seam(&self, h: u32) -> bool {
        let t = self.fine.twin[h as usize];
        if t == NONE {
            return false;
        }
        let (a, b) = (self.label(h), self.label(t));
        a != NONE && b != NONE && self.seams.parts(a, b)
    }

    /// Deal the faces about every seam anew, each pair of labels once.
    pub fn straighten(&mut self) {
        let mut seams: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
        for h in 0..self.fine.twin.len() as u32 {
            if self.is_free_seam(h) {
                let mut pair = self.pair(self.label(h), self.label(self.fine.twin[h as usize]));
                pair.sort_unstable();
                seams.entry(pair).or_default().push(h / 3);
            }
        }
        let depth = self.depths();
        for (pair, faces) in seams {
            self.deal(pair, &faces, &depth);
        }
    }

    /// What is dealt between two labels: their groups, or within a group the labels themselves, above all
    /// groups.
    fn pair(&self, a: u32, b: u32) -> [u32; 2] {
        let [g, h] = [a, b].map(|label| self.seams.group(label));
        if g == h { [a, b] } else { [g, h] }
    }

    /// A seam that may move: one of a dense component that runs on no curve, nor between faces that are held.
    fn is_free_seam(&self, h: u32) -> bool {
        let t = self.fine.twin[h as usize];
        self.is_seam(h)
            && self.dense[h as usize / 3]
            && self.class[h as usize / 3] == self.class[t as usize / 3]
            && !(self.held[h as usize / 3] && self.held[t as usize / 3])
    }

    /// Rings between each face and the nearest seam, up to those of a band and one.
    fn depths(&self) -> Vec<u32> {
        let far = self.rings + 1;
        let mut depth = vec![far; self.fine.face_count()];
        let mut queue = VecDeque::new();
        for h in 0..self.fine.twin.len() as u32 {
            let f = h / 3;
            if depth[f as usize] != 0 && self.is_seam(h) {
                depth[f as usize] = 0;
                queue.push_back(f);
            }
        }
        while let Some(f) = queue.pop_front() {
            let next = depth[f as usize] + 1;
            for h in 3 * f..3 * f + 3 {
                let t = self.fine.twin[h as usize];
                if t != NONE && !self.is_seam(h) && depth[t as usize / 3] > next && next < far {
                    depth[t as usize / 3] = next;
                    queue.push_back(t / 3);
                }
            }
        }
        depth
    }

    fn deal(&mut self, pair: [u32; 2], seam: &[u32], depth: &[u32]) {
        let fine = self.fine;
        let within = self.seams.group(pair[0]) == self.seams.group(pair[1]);
        let side = |label: u32, seams: &S| {
            let of = if within || label == NONE { label } else { seams.group(label) };
            pair.iter().position(|&p| p == of)
        };
        // The band: faces within its width of the seam.
        let mut band: Vec<u32> = Vec::new();
        let mut ring = 0;
        for &f in seam {
            if self.node[f as usize] == NONE {
                self.node[f as usize] = band.len() as u32;
                band.push(f);
            }
        }
        let mut from = 0;
        while ring < self.rings && from < band.len() {
            let to = band.len();
            for i in from..to {
                for h in 3 * band[i]..3 * band[i] + 3 {
                    let t = fine.twin[h as usize];
                    if t == NONE || self.node[t as usize / 3] != NONE {
                        continue;
                    }
                    let g = t / 3;
                    let own = side(self.labels[g as usize], self.seams).is_some();
                    if own && self.class[g as usize] == self.class[h as usize / 3] {
                        self.node[g as usize] = band.len() as u32;
                        band.push(g);
                    }
                }
            }
            (from, ring) = (to, ring + 1);
        }
        // A thin label keeps its middle.
        let mut most = [0; 2];
        for &f in &band {
            if let Some(k) = side(self.labels[f as usize], self.seams) {
                most[k] = most[k].max(depth[f as usize]);
            }
        }
        let (source, sink) = (band.len(), band.len() + 1);
        let mut flow = Flow::new(band.len() + 2);
        for (i, &f) in band.iter().enumerate() {
            let Some(k) = side(self.labels[f as usize], self.seams) else { continue };
            let other = if within { self.seams.group(pair[0]) } else { pair[1 - k] };
            let may = self.occurs.contains(&(self.class[f as usize], other));
            let deep = most[k] > 0 && 2 * depth[f as usize] > most[k].min(2 * self.rings);
            let mut hold = if may && !deep && !self.held[f as usize] { HOLD } else { UNCUT };
            for h in 3 * f..3 * f + 3 {
                let t = fine.twin[h as usize];
                if t == NONE || self.class[f as usize] != self.class[t as usize / 3] {
                    continue;
                }
                match self.node[t as usize / 3] {
                    NONE => {
                        let there = side(self.labels[t as usize / 3], self.seams);
                        // Beside a third label of the group a seam could end for nothing.
                        let third = within && there.is_none();
                        if there == Some(k) || third {
                            hold = UNCUT;
                        }
                    }
                    j if f < t / 3 => {
                        let capacity = self.cost(h);
                        flow.edge(i, j as usize, capacity, capacity);
                    }
                    _ => {}
                }
            }
            if k == 0 {
                flow.edge(source, i, hold, 0.0);
            } else {
                flow.edge(i, sink, hold, 0.0);
            }
        }
        let first = flow.source_side(source, sink);
        let mut moved: Vec<(u32, usize)> = Vec::new();
        for (i, &f) in band.iter().enumerate() {
            self.node[f as usize] = NONE;
            let Some(k) = side(self.labels[f as usize], self.seams) else { continue };
            let now = usize::from(!first[i]);
            if now != k {
                moved.push((f, now));
            }
        }
        self.relabel(moved, pair, within);
    }

    /// Faces change sides. In a group they take the label of a neighbour there.
    fn relabel(&mut self, moved: Vec<(u32, usize)>, pair: [u32; 2], within: bool) {
        if within {
            moved.iter().for_each(|&(f, now)| self.labels[f as usize] = pair[now]);
            return;
        }
        let mut waiting: BTreeMap<u32, usize> = moved.into_iter().collect();
        while !waiting.is_empty() {
            let found: Vec<(u32, u32)> = waiting
                .iter()
                .filter_map(|(&f, &now)| {
                    let beside = (3 * f..3 * f + 3).filter_map(|h| {
                        let t = self.fine.twin[h as usize];
                        let g = (t != NONE).then_some(t / 3)?;
                        let label = self.labels[g as usize];
                        let fits = label != NONE
                            && !waiting.contains_key(&g)
                            && self.seams.group(label) == pair[now];
                        fits.then_some(label)
                    });
                    // The side of a cut before the rest of its chart, so that the cut goes on.
                    Some((f, beside.max()?))
                })
                .collect();
            if found.is_empty() {
                break;
            }
            for (f, label) in found {
                self.labels[f as usize] = label;
                waiting.remove(&f);
            }
        }
        // What touches none of its new label takes the group's own.
        for (f, now) in waiting {
            self.labels[f as usize] = pair[now];
        }
    }

    /// Length times cost of a seam there, in mean edges: the bend is the proxy's.
    fn cost(&self, h: u32) -> f64 {
        let t = self.fine.twin[h as usize];
        let normal = |h: u32| {
            let on = self.proxy.face[h as usize / 3];
            self.proxy.surface.normals[on as usize]
        };
        let (n, m) = (normal(h), normal(t));
        let edge = self.fine.positions[self.fine.to(h) as usize]
            - self.fine.positions[self.fine.from(h) as usize];
        let bend = n.cross(m).dot(edge.normalize_or_zero()).atan2(n.dot(m));
        edge.length() * seam_cost(bend) / self.edge
    }
}
