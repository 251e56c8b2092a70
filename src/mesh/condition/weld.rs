//! Welding: vertices at the same place become one, whatever order they come in. Places are numbered in the
//! lexicographic order of their coordinates; the closure of all pairs within the tolerance is one vertex, at
//! the first of its places. Pairs are found in a hash grid whose cells are wide against the tolerance, so
//! that a place looks into a neighbouring cell only when it lies close to its wall.

use std::cmp::Ordering;
use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use crate::mesh::{DisjointSets, NONE};
use crate::tasks;

/// Vertices closer than this share of the diagonal are one.
pub const TOLERANCE: f64 = 1e-6;

/// Cell width in tolerances.
const CELL: f64 = 32.0;

/// A closure wider than so many tolerances is no place: there only what is equal is one.
const WIDE: f64 = 4.0;

/// Positions on their way to becoming vertices.
pub struct Weld {
    /// Place of each position.
    pub place: Vec<u32>,
    /// The distinct places, in lexicographic order.
    places: Vec<DVec3>,
    /// First place of the closure of each.
    closure: Vec<u32>,
    /// Closures that were too wide.
    pub wide: u64,
}

/// Order of places: x, then y, then z.
fn lexicographic(a: DVec3, b: DVec3) -> Ordering {
    a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z))
}

impl Weld {
    /// Find what is together. `origin`: a corner of the box of all positions.
    pub fn new(positions: &[DVec3], origin: DVec3, tolerance: f64) -> Self {
        // Adding 0 makes one of the two zeros.
        let mut order: Vec<(DVec3, u32)> =
            positions.par_iter().enumerate().map(|(i, &p)| (p + 0.0, i as u32)).collect();
        tasks::even("weld", order.len(), || {
            order.par_sort_unstable_by(|a, b| lexicographic(a.0, b.0).then(a.1.cmp(&b.1)))
        });
        let mut place = vec![0; positions.len()];
        let mut places: Vec<DVec3> = Vec::new();
        for (p, i) in order {
            if places.last().is_none_or(|&last| lexicographic(last, p) != Ordering::Equal) {
                places.push(p);
            }
            place[i as usize] = places.len() as u32 - 1;
        }
        let mut sets = close(&places, origin, tolerance);
        let closure: Vec<u32> = (0..places.len() as u32).map(|i| sets.root(i)).collect();
        let mut weld = Self { place, places, closure, wide: 0 };
        let wide = weld.wider_than(WIDE * tolerance);
        weld.wide = wide.len() as u64;
        weld.part(&wide);
        weld
    }

    /// First places of closures of several places whose box has a longer diagonal than this.
    fn wider_than(&self, most: f64) -> Vec<u32> {
        let mut boxes: HashMap<u32, (DVec3, DVec3)> = HashMap::new();
        for (&first, &p) in self.closure.iter().zip(&self.places) {
            let start = self.places[first as usize];
            if start != p {
                let (low, high) = boxes.entry(first).or_insert((start, start));
                (*low, *high) = (low.min(p), high.max(p));
            }
        }
        let wide = boxes.into_iter().filter(|(_, (low, high))| low.distance(*high) > most);
        let mut wide: Vec<u32> = wide.map(|(first, _)| first).collect();
        wide.sort_unstable();
        wide
    }

    /// Undo the closures of these first places, in ascending order: each of their places is a vertex of its own.
    fn part(&mut self, closures: &[u32]) {
        if closures.is_empty() {
            return;
        }
        for (i, first) in self.closure.iter_mut().enumerate() {
            if closures.binary_search(first).is_ok() {
                *first = i as u32;
            }
        }
    }

    /// Undo the closures of these positions.
    pub fn part_at(&mut self, positions: impl Iterator<Item = u32>) {
        let mut closures: Vec<u32> =
            positions.map(|p| self.closure[self.place[p as usize] as usize]).collect();
        closures.sort_unstable();
        closures.dedup();
        self.part(&closures);
    }

    /// Where a position is welded to.
    pub fn welded(&self, position: u32) -> DVec3 {
        self.places[self.closure[self.place[position as usize] as usize] as usize]
    }

    /// Vertex of each position, and the vertices, in order of place.
    pub fn vertices(&self) -> (Vec<u32>, Vec<DVec3>) {
        let mut number = vec![NONE; self.places.len()];
        let mut vertices = Vec::new();
        for (i, (&first, &p)) in self.closure.iter().zip(&self.places).enumerate() {
            if first == i as u32 {
                number[i] = vertices.len() as u32;
                vertices.push(p);
            }
        }
        let vertex = |&place: &u32| number[self.closure[place as usize] as usize];
        (self.place.iter().map(vertex).collect(), vertices)
    }
}

/// The closure of all pairs of places within the tolerance.
fn close(places: &[DVec3], origin: DVec3, tolerance: f64) -> DisjointSets {
    let mut sets = DisjointSets::new(places.len());
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::with_capacity(places.len());
    let width = CELL * tolerance;
    for (i, &p) in (0u32..).zip(places) {
        let q = (p - origin) / width;
        let home = q.floor();
        let reach = 1.0 / CELL;
        // Per axis: the home cell, and the one beyond a wall that is within reach.
        let near = |x: f64, floor: f64| -> (i64, i64) {
            let cell = floor as i64;
            let lo = if x - floor < reach { cell - 1 } else { cell };
            let hi = if floor + 1.0 - x < reach { cell + 1 } else { cell };
            (lo, hi)
        };
        let (x, y, z) = (near(q.x, home.x), near(q.y, home.y), near(q.z, home.z));
        for i_x in x.0..=x.1 {
            for i_y in y.0..=y.1 {
                for i_z in z.0..=z.1 {
                    for &v in cells.get(&[i_x, i_y, i_z]).map_or(&[][..], Vec::as_slice) {
                        if places[v as usize].distance_squared(p) <= tolerance * tolerance {
                            sets.join(v, i);
                        }
                    }
                }
            }
        }
        cells.entry([home.x as i64, home.y as i64, home.z as i64]).or_default().push(i);
    }
    sets
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn weld(positions: &[DVec3], tolerance: f64) -> (Vec<u32>, Vec<DVec3>) {
        Weld::new(positions, DVec3::ZERO, tolerance).vertices()
    }

    proptest! {
        #[test]
        fn welds_what_is_close_and_nothing_else(points in prop::collection::vec((0..6i32, 0..6i32, 0..6i32), 1..80)) {
            let positions: Vec<DVec3> = points
                .iter()
                .enumerate()
                .map(|(i, &(x, y, z))| {
                    // Clusters 1 apart, jittered by less than half the tolerance.
                    let j = (i % 3) as f64 * 0.002;
                    DVec3::new(f64::from(x) + j, f64::from(y) - j, f64::from(z))
                })
                .collect();
            let (ids, vertices) = weld(&positions, 0.01);
            for (i, a) in points.iter().enumerate() {
                for (j, b) in points.iter().enumerate() {
                    prop_assert_eq!(ids[i] == ids[j], a == b);
                }
            }
            prop_assert!(ids.iter().all(|&v| (v as usize) < vertices.len()));
            prop_assert!(vertices.windows(2).all(|w| lexicographic(w[0], w[1]) == Ordering::Less));
            // The order they come in does not matter.
            let turned: Vec<DVec3> = positions.iter().rev().copied().collect();
            let (again, same) = weld(&turned, 0.01);
            prop_assert_eq!(same, vertices);
            prop_assert!(again.iter().rev().eq(ids.iter()));
        }
    }

    #[test]
    fn a_row_of_close_places_is_one_vertex_up_to_four_tolerances() {
        let row = |n: u32| (0..n).map(|i| DVec3::X * 0.9 * f64::from(i)).collect::<Vec<_>>();
        let (ids, vertices) = weld(&row(5), 1.0);
        assert_eq!((ids, vertices), (vec![0; 5], vec![DVec3::ZERO]));
        let twice = [row(6), row(6)].concat();
        let wide = Weld::new(&twice, DVec3::ZERO, 1.0);
        assert_eq!(wide.wide, 1);
        assert_eq!(wide.vertices().0, [0, 1, 2, 3, 4, 5, 0, 1, 2, 3, 4, 5], "equals are one");
    }
}
