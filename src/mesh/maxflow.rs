//! Maximum flow by Dinic's algorithm (1970), for graph cuts over a few thousand faces.

use std::collections::VecDeque;

/// A flow network; nodes are numbered from 0.
pub struct Flow {
    heads: Vec<Vec<u32>>,
    to: Vec<u32>,
    capacity: Vec<f64>,
    level: Vec<u32>,
    next: Vec<usize>,
}

/// Flows below this are rounding.
const EPSILON: f64 = 1e-9;

/// Not reached.
const FAR: u32 = u32::MAX;

impl Flow {
    /// A network without edges.
    pub fn new(nodes: usize) -> Self {
        Self {
            heads: vec![Vec::new(); nodes],
            to: Vec::new(),
            capacity: Vec::new(),
            level: vec![FAR; nodes],
            next: vec![0; nodes],
        }
    }

    /// An edge with a capacity each way.
    pub fn edge(&mut self, a: usize, b: usize, forth: f64, back: f64) {
        self.heads[a].push(self.to.len() as u32);
        self.to.push(b as u32);
        self.capacity.push(forth);
        self.heads[b].push(self.to.len() as u32);
        self.to.push(a as u32);
        self.capacity.push(back);
    }

    /// Push all flow there is; tells which nodes are on the source's side of the least cut.
    pub fn source_side(&mut self, source: usize, sink: usize) -> Vec<bool> {
        while self.levels(source, sink) {
            self.next.iter_mut().for_each(|n| *n = 0);
            while self.augment(source, sink) {}
        }
        self.level.iter().map(|&l| l != FAR).collect()
    }

    /// Breadth-first levels; whether the sink is reached.
    fn levels(&mut self, source: usize, sink: usize) -> bool {
        self.level.iter_mut().for_each(|l| *l = FAR);
        self.level[source] = 0;
        let mut queue = VecDeque::from([source]);
        while let Some(v) = queue.pop_front() {
            for &e in &self.heads[v] {
                let w = self.to[e as usize] as usize;
                if self.level[w] == FAR && self.capacity[e as usize] > EPSILON {
                    self.level[w] = self.level[v] + 1;
                    queue.push_back(w);
                }
            }
        }
        self.level[sink] != FAR
    }

    /// One augmenting path along the levels, without recursion.
    fn augment(&mut self, source: usize, sink: usize) -> bool {
        let mut path: Vec<u32> = Vec::new();
        let mut v = source;
        loop {
            if v == sink {
                let least =
                    path.iter().map(|&e| self.capacity[e as usize]).fold(f64::MAX, f64::min);
                for &e in &path {
                    self.capacity[e as usize] -= least;
                    self.capacity[(e ^ 1) as usize] += least;
                }
                return true;
            }
            let edge = self.heads[v][self.next[v]..].iter().position(|&e| {
                let w = self.to[e as usize] as usize;
                self.capacity[e as usize] > EPSILON && self.level[w] == self.level[v] + 1
            });
            match edge {
                Some(skip) => {
                    self.next[v] += skip;
                    let e = self.heads[v][self.next[v]];
                    path.push(e);
                    v = self.to[e as usize] as usize;
                }
                None => {
                    // A dead end: step back and do not come here again in this phase.
                    self.next[v] = self.heads[v].len();
                    let Some(e) = path.pop() else { return false };
                    v = self.to[(e ^ 1) as usize] as usize;
                    self.next[v] += 1;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cut_goes_through_the_bottleneck() {
        // 0 → {1, 2} → 3 → {4, 5}: the bridge 3 → 4 and 3 → 5 is narrower than what feeds it.
        let mut flow = Flow::new(6);
        for (a, b, c) in
            [(0, 1, 3.0), (0, 2, 3.0), (1, 3, 3.0), (2, 3, 3.0), (3, 4, 1.0), (4, 5, 9.0)]
        {
            flow.edge(a, b, c, 0.0);
        }
        flow.edge(3, 5, 0.5, 0.0);
        assert_eq!(flow.source_side(0, 5), [true, true, true, true, false, false]);
    }
}
