//! The three levels at which every figure is taken: the atlas, each part, each chart. A level is a
//! set of faces, the edges they touch, and the charts they are in.

use super::{EdgeTable, Measured};

/// Which faces a level holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scope {
    Atlas,
    Part(u32),
    Chart(u32),
}

impl Scope {
    /// Whether a face belongs to it (given that it is measured at all).
    pub(super) fn holds(self, input: &Measured, face: u32) -> bool {
        match self {
            Scope::Atlas => true,
            Scope::Part(p) => input.part_of[face as usize] == p,
            Scope::Chart(c) => input.chart_of[face as usize] == c,
        }
    }
}

/// One level.
#[derive(Debug, Clone)]
pub(super) struct Level {
    pub scope: Scope,
    /// Measured faces, ascending.
    pub faces: Vec<u32>,
    /// Edges of those faces, ascending.
    pub edges: Vec<u32>,
    /// How often each of `edges` is cut, as far as those faces are concerned: a cut has two sides,
    /// or one where the other is outside, so ⌈sides/2⌉, and no more than there are in all.
    pub cuts: Vec<u32>,
    /// Charts of those faces, ascending.
    pub charts: Vec<u32>,
}

impl Level {
    fn push_edge(&mut self, e: u32, cuts: u32) {
        self.edges.push(e);
        self.cuts.push(cuts);
    }

    /// Its edges, and how often each is cut.
    pub(super) fn edges_with_cuts(&self) -> impl Iterator<Item = (usize, u32)> {
        self.edges.iter().map(|&e| e as usize).zip(self.cuts.iter().copied())
    }
}

/// The levels of an atlas.
#[derive(Debug, Clone)]
pub(super) struct Levels {
    pub atlas: Level,
    pub parts: Vec<Level>,
    pub charts: Vec<Level>,
}

impl Levels {
    /// Sorts faces and edges by part and by chart.
    pub(super) fn new(input: &Measured, faces: Vec<u32>, edges: &EdgeTable) -> Self {
        let empty =
            |scope| Level { scope, faces: vec![], edges: vec![], cuts: vec![], charts: vec![] };
        let mut parts: Vec<Level> =
            (0..input.parts as u32).map(|p| empty(Scope::Part(p))).collect();
        let mut charts: Vec<Level> =
            (0..input.charts as u32).map(|c| empty(Scope::Chart(c))).collect();
        let part = |f: u32| input.part_of[f as usize];
        let chart = |f: u32| input.chart_of[f as usize];
        for &f in &faces {
            if let Some(level) = parts.get_mut(part(f) as usize) {
                level.faces.push(f);
                level.charts.push(chart(f));
            }
            if let Some(level) = charts.get_mut(chart(f) as usize) {
                level.faces.push(f);
            }
        }
        let mut around: Vec<(u32, u32, u32)> = vec![];
        for e in 0..edges.len() {
            // Each chart, with its part, and how many sides of the edge's cuts are its.
            around.clear();
            around.extend(edges.half_edges(e).map(|(h, _)| (part(h / 3), chart(h / 3), 0)));
            around.extend(edges.rim(e).map(|h| (part(h / 3), chart(h / 3), 1)));
            around.sort_unstable();
            let cuts = |sides: u32| edges.cuts[e].min(sides.div_ceil(2));
            let sides = |group: &[(u32, u32, u32)]| group.iter().map(|x| x.2).sum::<u32>();
            for group in around.chunk_by(|a, b| a.0 == b.0) {
                if let Some(level) = parts.get_mut(group[0].0 as usize) {
                    level.push_edge(e as u32, cuts(sides(group)));
                }
                for group in group.chunk_by(|a, b| a.1 == b.1) {
                    if let Some(level) = charts.get_mut(group[0].1 as usize) {
                        level.push_edge(e as u32, cuts(sides(group)));
                    }
                }
            }
        }
        for level in &mut parts {
            level.charts.sort_unstable();
            level.charts.dedup();
        }
        for (c, level) in charts.iter_mut().enumerate() {
            level.charts.push(c as u32);
        }
        let atlas = Level {
            scope: Scope::Atlas,
            faces,
            edges: (0..edges.len() as u32).collect(),
            cuts: edges.cuts.clone(),
            charts: (0..input.charts as u32).collect(),
        };
        Self { atlas, parts, charts }
    }
}
