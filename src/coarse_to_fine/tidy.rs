//! Labels tidied beside the cut that straightens them: islands absorbed, single faces that jut out, and faces
//! handed to the neighbour.

use std::collections::{BTreeMap, VecDeque};

use super::band::Band;
use super::pieces::Seams;
use crate::mesh::NONE;

/// Most passes in which single faces change hands.
const PASSES: u32 = 6;

impl<S: Seams> Band<'_, S> {
    /// Hand faces to the next labels of other groups, where there are any within their class.
    pub fn give(&mut self, faces: &[u32]) {
        let mut given = vec![false; self.labels.len()];
        faces.iter().for_each(|&f| given[f as usize] = self.dense[f as usize]);
        let own: BTreeMap<u32, u32> =
            faces.iter().map(|&f| (f, self.labels[f as usize])).filter(|p| p.1 != NONE).collect();
        let mut queue: VecDeque<(u32, u32)> = VecDeque::new();
        let take = |f: u32, label: u32, queue: &mut VecDeque<(u32, u32)>, given: &[bool]| {
            for t in (3 * f..3 * f + 3).map(|h| self.fine.twin[h as usize]).filter(|&t| t != NONE) {
                let g = t / 3;
                let fits = given[g as usize]
                    && self.class[g as usize] == self.class[f as usize]
                    && own.get(&g).is_some_and(|&l| self.seams.group(l) != self.seams.group(label));
                if fits {
                    queue.push_back((g, label));
                }
            }
        };
        for (f, &label) in (0u32..).zip(&self.labels) {
            if label != NONE && !given[f as usize] {
                take(f, label, &mut queue, &given);
            }
        }
        let mut new = Vec::new();
        while let Some((f, label)) = queue.pop_front() {
            if std::mem::take(&mut given[f as usize]) {
                new.push((f, label));
                take(f, label, &mut queue, &given);
            }
        }
        new.into_iter().for_each(|(f, label)| self.labels[f as usize] = label);
    }

    /// Faces with two of their three neighbours under one other label take that: what juts out by a face is no
    /// border that a cut wanted, but was held where three labels meet.
    pub fn smooth(&mut self) {
        for _ in 0..PASSES {
            let mut changed = false;
            for f in 0..self.labels.len() {
                let own = self.labels[f];
                if own == NONE || !self.dense[f] || self.held[f] {
                    continue;
                }
                let beside = |k: usize| {
                    let t = self.fine.twin[3 * f + k];
                    let g = (t != NONE).then_some(t as usize / 3)?;
                    let label = self.labels[g];
                    let may = self.class[g] == self.class[f] && label != NONE;
                    (may && self.seams.parts(own, label)).then_some(label)
                };
                let [a, b, c] = [0, 1, 2].map(beside);
                let twice = if a == b || a == c { a } else { b.filter(|_| b == c) };
                if let Some(label) = twice {
                    self.labels[f] = label;
                    changed = true;
                }
            }
            if !changed {
                break;
            }
        }
    }

    /// Give islands, connected sets of faces of at most so much area, to the neighbour of the longest border
    /// within their class; so holes are filled, too.
    pub fn absorb_islands(&mut self, least: f64) {
        let fine = self.fine;
        let roots = fine.components(|h| {
            let (a, b) = (self.label(h), self.label(fine.twin[h as usize]));
            a != NONE && b != NONE && !self.seams.parts(a, b)
        });
        let mut area = vec![0.0; roots.len()];
        roots.iter().zip(&fine.areas).for_each(|(&r, a)| area[r as usize] += a);
        let dense = |f: usize| self.dense[f] && self.labels[f] != NONE;
        let free = |f: usize| dense(f) && !self.held[f];
        let mut borders: BTreeMap<u32, BTreeMap<u32, f64>> = BTreeMap::new();
        for (h, &t) in (0u32..).zip(&fine.twin).filter(|(_, t)| **t != NONE) {
            let (f, g) = (h as usize / 3, t as usize / 3);
            let island = free(f) && area[roots[f] as usize] <= least;
            if island && roots[f] != roots[g] && self.class[f] == self.class[g] && dense(g) {
                let length = fine.length(h);
                *borders.entry(roots[f]).or_default().entry(self.labels[g]).or_default() += length;
            }
        }
        let longest = |around: &BTreeMap<u32, f64>| {
            around.iter().max_by(|a, b| a.1.total_cmp(b.1)).map(|(&label, _)| label)
        };
        let new: BTreeMap<u32, u32> =
            borders.iter().filter_map(|(&root, around)| Some((root, longest(around)?))).collect();
        for (f, root) in roots.iter().enumerate() {
            if let Some(&label) = new.get(root) {
                self.labels[f] = label;
            }
        }
    }
}
