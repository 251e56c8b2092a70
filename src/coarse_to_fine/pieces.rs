//! Charts of the proxy as labels. A cut that has one chart on both sides, as along a tube or at a slit, is no
//! border between labels: the faces at each of its sides become *pieces* of their own, of which it is known
//! whether they are cut or glued where they meet.

use std::collections::{BTreeMap, BTreeSet};

use crate::charts::Chart;
use crate::mesh::{DisjointSets, NONE, Surface};

/// Faces around a cut's side that become a piece, in rings.
const RINGS: usize = 5;

/// What labels mean: where they part, and what they stand for.
pub trait Seams {
    /// Whether two labels are parted where they meet.
    fn parts(&self, a: u32, b: u32) -> bool;
    /// Labels of one group are dealt anew together: those of one chart.
    fn group(&self, label: u32) -> u32;
}

/// Plain labels: each parts from every other.
pub struct Plain;

impl Seams for Plain {
    fn parts(&self, a: u32, b: u32) -> bool {
        a != b
    }
    fn group(&self, label: u32) -> u32 {
        label
    }
}

/// The proxy's charts, dealt into pieces.
pub struct Pieces {
    /// Piece of each face, or [`NONE`].
    pub of_face: Vec<u32>,
    /// Chart of each piece. The first pieces are the charts.
    pub chart: Vec<u32>,
    /// Pairs of pieces (lower first) of one chart that are glued where they meet: length that is glued more
    /// than is cut. Those that meet in a corner at most are cut if they come to meet.
    glued: BTreeMap<(u32, u32), f64>,
}

impl Pieces {
    /// Deal charts into pieces.
    pub fn new(proxy: &Surface, charts: &[Chart]) -> Self {
        let mut chart_of = vec![NONE; proxy.face_count()];
        let mut corner = vec![[NONE; 3]; proxy.face_count()];
        for (c, chart) in (0u32..).zip(charts) {
            for (&f, triangle) in chart.faces.iter().zip(&chart.disk.triangles) {
                (chart_of[f as usize], corner[f as usize]) = (c, *triangle);
            }
        }
        // Twins in one chart are closed where they share their vertices, and cut where they do not.
        let at = |h: u32, k: u32| corner[h as usize / 3][((h % 3 + k) % 3) as usize];
        let within = |h: u32| {
            let t = proxy.twin[h as usize];
            let f = h as usize / 3;
            t != NONE && chart_of[f] != NONE && chart_of[f] == chart_of[t as usize / 3]
        };
        let glued = |h: u32| {
            let t = proxy.twin[h as usize];
            within(h) && at(h, 0) == at(t, 1) && at(h, 1) == at(t, 0)
        };
        let half_edges = 0..3 * proxy.face_count() as u32;
        let cuts: Vec<u32> = half_edges.clone().filter(|&h| within(h) && !glued(h)).collect();
        let mut pieces = Self {
            of_face: chart_of.clone(),
            chart: (0..charts.len() as u32).collect(),
            glued: BTreeMap::new(),
        };
        if cuts.is_empty() {
            return pieces;
        }
        let next = |h: u32| h - h % 3 + (h % 3 + 1) % 3;
        let after = |h: u32| {
            let mut n = next(h);
            while glued(n) {
                n = next(proxy.twin[n as usize]);
            }
            n
        };
        // A side of a cut: half-edges that follow each other, as their twins do on the other side.
        let mut sides = DisjointSets::new(proxy.twin.len());
        for &h in &cuts {
            let n = after(h);
            let twin = |h: u32| proxy.twin[h as usize];
            if within(n) && !glued(n) && n != twin(h) && after(twin(n)) == twin(h) {
                sides.join(h, n);
                sides.join(twin(h), twin(n));
            }
        }
        let mut number = BTreeMap::new();
        let mut reached: Vec<u32> = Vec::new();
        for &h in &cuts {
            let side = sides.root(h);
            let f = h / 3;
            let piece = *number.entry(side).or_insert_with(|| {
                pieces.chart.push(chart_of[f as usize]);
                pieces.chart.len() as u32 - 1
            });
            if pieces.of_face[f as usize] == chart_of[f as usize] {
                pieces.of_face[f as usize] = piece;
                reached.push(f);
            }
        }
        for _ in 0..RINGS {
            for f in std::mem::take(&mut reached) {
                let piece = pieces.of_face[f as usize];
                for h in (3 * f..3 * f + 3).filter(|&h| glued(h)) {
                    let g = proxy.twin[h as usize] / 3;
                    if pieces.of_face[g as usize] == chart_of[g as usize] {
                        pieces.of_face[g as usize] = piece;
                        reached.push(g);
                    }
                }
            }
        }
        // Beyond its end the two sides of a cut would meet where they are glued, and a short cut would be no
        // more than that: what lies there stays with the chart.
        let mut is_cut_beside = vec![false; chart_of.len()];
        cuts.iter().for_each(|&h| is_cut_beside[h as usize / 3] = true);
        let at_cut: BTreeSet<(u32, u32)> = cuts
            .iter()
            .map(|&h| pair(&pieces.of_face, h, proxy.twin[h as usize]))
            .filter(|(a, b)| a != b)
            .collect();
        for h in half_edges.clone().filter(|&h| glued(h)) {
            let pair = pair(&pieces.of_face, h, proxy.twin[h as usize]);
            if at_cut.contains(&pair) {
                // The fans of both ends.
                for start in [h, next(h)] {
                    let mut g = start;
                    loop {
                        let f = g as usize / 3;
                        if !is_cut_beside[f] {
                            pieces.of_face[f] = chart_of[f];
                        }
                        g = proxy.twin[(g - g % 3 + (g % 3 + 2) % 3) as usize];
                        if g == NONE || g == start || chart_of[g as usize / 3] != chart_of[f] {
                            break;
                        }
                    }
                }
            }
        }
        for h in half_edges.filter(|&h| within(h)) {
            let [a, b] = [h, proxy.twin[h as usize]].map(|h| pieces.of_face[h as usize / 3]);
            if a < b {
                let length = proxy.length(h);
                *pieces.glued.entry((a, b)).or_default() += if glued(h) { length } else { -length };
            }
        }
        pieces.glued.retain(|_, length| *length > 0.0);
        pieces
    }
}

/// The pieces on both sides of an edge, the lower first.
fn pair(of_face: &[u32], h: u32, twin: u32) -> (u32, u32) {
    let [a, b] = [h, twin].map(|h| of_face[h as usize / 3]);
    (a.min(b), a.max(b))
}

impl Seams for Pieces {
    fn parts(&self, a: u32, b: u32) -> bool {
        a != b
            && (self.chart[a as usize] != self.chart[b as usize]
                || !self.glued.contains_key(&(a.min(b), a.max(b))))
    }
    fn group(&self, label: u32) -> u32 {
        self.chart[label as usize]
    }
}
