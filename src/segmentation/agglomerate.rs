//! Regions of a body by agglomeration over the dual graph: the two regions whose common border is
//! least a valley are joined, again and again, until every border that is left is one (the minima
//! rule: Hoffman & Richards 1984, doi:10.1016/0010-0277(84)90022-2). A border is judged over its
//! whole length, so that one shallow edge in it lets nothing through, and small regions are joined
//! first, so that borders grow long before they are judged.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};

use crate::contract::{Canceled, Run};
use crate::mesh::{DisjointSets, NONE, Surface};

/// An edge that is this concave (radians) is a valley in full; a flat one is none.
const FULL: f64 = 0.8;

/// Borders that are more of a valley than this, in the mean over their length, stay.
const VALLEY: f64 = 0.6;

/// How much the size of the smaller region counts beside the valley (for a region that is the whole
/// body).
const BALANCE: f64 = 0.5;

/// How much counts what share of the smaller perimeter the border is (for none): the six
/// sides of a box find each other before one of them finds a neighbour in its plane.
const ENCLOSED: f64 = 0.3;

/// A ridge says little about whether its two sides are one part: its weight in a border's mean.
const RIDGE: f64 = 0.25;

/// A region below this share of the body's area is joined to a neighbour whatever its border.
const SMALL: f64 = 0.002;

/// Faces that meet at less than this (radians) are first joined to patches of at most this share of
/// the body's area.
const FLAT: f64 = 0.2;
const PATCH: f64 = 1.0 / 1500.0;

/// A body of more patches than this is too rough to be read: it stays one region.
const MOST: usize = 100_000;

/// A region of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// Its faces, in ascending order.
    pub faces: Vec<u32>,
    /// How much of a valley its border is, 0 to 1; 0 without a border.
    pub valley: f64,
}

/// A border between two regions: its length, its weight in the mean, how much of it is valley.
#[derive(Debug, Clone, Copy, Default)]
struct Border {
    length: f64,
    weight: f64,
    valley: f64,
}

impl Border {
    fn new(length: f64, angle: f64) -> Self {
        let weight = if angle > FLAT { RIDGE * length } else { length };
        Self { length, weight, valley: length * (-angle / FULL).clamp(0.0, 1.0) }
    }

    /// How much of a valley it is, 0 to 1.
    fn mean(self) -> f64 {
        if self.weight > 0.0 { self.valley / self.weight } else { 0.0 }
    }

    fn add(&mut self, other: Border) {
        self.length += other.length;
        self.weight += other.weight;
        self.valley += other.valley;
    }
}

/// Two regions that may be joined; the cheapest comes first out of the heap.
#[derive(PartialEq)]
struct Join {
    cost: f64,
    pair: (u32, u32),
}

impl Eq for Join {}

impl Ord for Join {
    fn cmp(&self, other: &Self) -> Ordering {
        other.cost.total_cmp(&self.cost).then_with(|| other.pair.cmp(&self.pair))
    }
}

impl PartialOrd for Join {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The regions of a body, in order of first face. `faces` ascend; `local` is scratch, [`NONE`] for
/// every face before and after.
pub fn regions(
    surface: &Surface,
    faces: &[u32],
    local: &mut [u32],
    run: &Run,
) -> Result<Vec<Region>, Canceled> {
    (0u32..).zip(faces).for_each(|(i, &f)| local[f as usize] = i);
    let mut links = Vec::new();
    for (i, &f) in (0u32..).zip(faces) {
        for h in 3 * f..3 * f + 3 {
            let t = surface.twin[h as usize];
            if t != NONE && h < t && local[t as usize / 3] != NONE {
                links.push((i, local[t as usize / 3], surface.length(h), surface.dihedral(h)));
            }
        }
    }
    faces.iter().for_each(|&f| local[f as usize] = NONE);
    run.cancel.check()?;

    let mut areas: Vec<f64> = faces.iter().map(|&f| surface.areas[f as usize]).collect();
    let total: f64 = areas.iter().sum();
    let mut sets = DisjointSets::new(faces.len());
    for &(i, j, _, _) in links.iter().filter(|l| l.3.abs() < FLAT) {
        let (a, b) = (sets.root(i), sets.root(j));
        if a != b && areas[a as usize] + areas[b as usize] <= PATCH * total {
            let (keep, gone) = (a.min(b), a.max(b));
            sets.hang(gone, keep);
            areas[keep as usize] += areas[gone as usize];
        }
    }
    let patches = (0..faces.len() as u32).filter(|&i| sets.root(i) == i).count();
    if patches > MOST {
        return Ok(vec![Region { faces: faces.to_vec(), valley: 0.0 }]);
    }
    let mut borders: Vec<BTreeMap<u32, Border>> = vec![BTreeMap::new(); faces.len()];
    for &(i, j, length, angle) in &links {
        let (a, b) = (sets.root(i), sets.root(j));
        if a != b {
            let border = Border::new(length, angle);
            borders[a as usize].entry(b).or_default().add(border);
            borders[b as usize].entry(a).or_default().add(border);
        }
    }
    let around = |b: &BTreeMap<u32, Border>| b.values().map(|b| b.length).sum();
    let perimeters = borders.iter().map(around).collect();
    let mut growth = Growth { sets, areas, perimeters, borders, total };
    growth.join_flattest(run)?;
    growth.join_small();
    Ok(growth.collect(faces))
}

/// Regions as they grow. Of joined regions only the root's entries count.
struct Growth {
    sets: DisjointSets,
    areas: Vec<f64>,
    perimeters: Vec<f64>,
    borders: Vec<BTreeMap<u32, Border>>,
    total: f64,
}

impl Growth {
    fn candidate(&self, a: u32, b: u32, border: Border) -> Option<Join> {
        let smaller = self.areas[a as usize].min(self.areas[b as usize]);
        let around = self.perimeters[a as usize].min(self.perimeters[b as usize]);
        let enclosed = border.length / around.max(f64::MIN_POSITIVE);
        let size = BALANCE * (smaller / self.total).sqrt();
        let cost = border.mean() + size + ENCLOSED * (1.0 - enclosed);
        (border.mean() <= VALLEY).then_some(Join { cost, pair: (a.min(b), a.max(b)) })
    }

    fn join_flattest(&mut self, run: &Run) -> Result<(), Canceled> {
        let mut heap = BinaryHeap::new();
        for (a, around) in (0u32..).zip(&self.borders) {
            let above = around.range(a..);
            heap.extend(above.filter_map(|(&b, &border)| self.candidate(a, b, border)));
        }
        let mut steps = 0u32;
        while let Some(Join { cost, pair: (a, b) }) = heap.pop() {
            steps += 1;
            if steps.is_multiple_of(4096) {
                run.cancel.check()?;
            }
            let (a, b) = (self.sets.root(a), self.sets.root(b));
            let Some(&border) = self.borders[a as usize].get(&b) else { continue };
            let Some(now) = self.candidate(a, b, border) else { continue };
            // Regions have grown since: their turn comes later.
            if now.cost > cost + 1e-12 {
                heap.push(now);
                continue;
            }
            let (kept, changed) = self.join(a, b);
            for n in changed {
                if let Some(&border) = self.borders[kept as usize].get(&n) {
                    heap.extend(self.candidate(kept, n, border));
                }
            }
        }
        Ok(())
    }

    /// Join two regions; returns the one that is left and the neighbours that came with the other.
    fn join(&mut self, a: u32, b: u32) -> (u32, Vec<u32>) {
        let more = self.borders[a as usize].len() >= self.borders[b as usize].len();
        let (keep, gone) = if more { (a, b) } else { (b, a) };
        let moved = std::mem::take(&mut self.borders[gone as usize]);
        let between = self.borders[keep as usize].remove(&gone).unwrap_or_default();
        self.perimeters[keep as usize] += self.perimeters[gone as usize] - 2.0 * between.length;
        for (&n, &border) in moved.iter().filter(|(n, _)| **n != keep) {
            self.borders[n as usize].remove(&gone);
            self.borders[n as usize].entry(keep).or_default().add(border);
            self.borders[keep as usize].entry(n).or_default().add(border);
        }
        self.sets.hang(gone, keep);
        self.areas[keep as usize] += self.areas[gone as usize];
        (keep, moved.into_keys().filter(|&n| n != keep).collect())
    }

    /// Smallest first, each to the neighbour across the border that is least a valley.
    fn join_small(&mut self) {
        let mut order: Vec<u32> = (0..self.areas.len() as u32).collect();
        order.retain(|&r| self.sets.root(r) == r && self.areas[r as usize] < SMALL * self.total);
        order.sort_by(|&a, &b| {
            self.areas[a as usize].total_cmp(&self.areas[b as usize]).then(a.cmp(&b))
        });
        for r in order {
            let r = self.sets.root(r);
            if self.areas[r as usize] >= SMALL * self.total {
                continue;
            }
            let around = self.borders[r as usize].iter();
            let best = around.min_by(|x, y| x.1.mean().total_cmp(&y.1.mean()).then(x.0.cmp(y.0)));
            if let Some((&n, _)) = best {
                self.join(r, n);
            }
        }
    }

    fn collect(mut self, faces: &[u32]) -> Vec<Region> {
        let mut number = vec![NONE; faces.len()];
        let mut regions: Vec<Region> = Vec::new();
        for (i, &f) in (0u32..).zip(faces) {
            let root = self.sets.root(i) as usize;
            if number[root] == NONE {
                number[root] = regions.len() as u32;
                let mut whole = Border::default();
                self.borders[root].values().for_each(|&b| whole.add(b));
                regions.push(Region { faces: Vec::new(), valley: whole.mean() });
            }
            regions[number[root] as usize].faces.push(f);
        }
        regions
    }
}
