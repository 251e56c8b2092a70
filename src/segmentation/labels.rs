//! The outcome: one part a face. Connected components of one label are separate parts.

use std::collections::BTreeMap;

use super::dual::DualGraph;
use super::regions::hierarchy::groups;
use super::scores::{Candidate, PartScores};
use crate::contract::{PartJoin, SegmentationSource};
use crate::mesh::{DisjointSets, NONE};

/// A set of faces that the segmentation calls one thing.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Its number: what face labels refer to.
    pub id: u32,
    /// Its name, unique within the object.
    pub name: String,
    /// Which source decided.
    pub source: SegmentationSource,
    /// How sure it was, 0 to 1.
    pub confidence: f64,
    /// How sure the network is of the name, 0 to 1; `None` where the name is not the network's.
    pub name_confidence: Option<f64>,
}

/// One part a face.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PartLabels {
    /// Part of each face; Length: faces.
    pub labels: Vec<u32>,
    /// The parts, numbered in order of first face.
    pub parts: Vec<Part>,
    /// The hierarchy above them: which would be joined next, in order; empty where the source has none.
    pub joins: Vec<PartJoin>,
}

impl PartLabels {
    /// Group of each part if the joins up to this boundary were made, numbered in order of first part: a
    /// coarser cut through the hierarchy.
    pub fn coarser(&self, boundary: f64) -> Vec<u32> {
        groups(self.parts.len(), self.joins.iter().map(|j| (j.a, j.b, j.boundary)), boundary)
    }

    /// The labels as text: one integer a line, line i for face i, −1 for a face without area.
    pub fn to_text(&self) -> String {
        let label = |&l: &u32| if l == NONE { -1 } else { i64::from(l) };
        self.labels.iter().map(|l| format!("{}\n", label(l))).collect()
    }
}

/// Number the connected components of each label. Faces are connected over shared edges and the scores'
/// bridges; a face and its mate are one place, and so in one component.
pub fn connected_parts(dual: &DualGraph, scores: &PartScores, label: &[i32]) -> PartLabels {
    let mut labels = vec![NONE; label.len()];
    let mut of_part: Vec<Option<&Candidate>> = Vec::new();
    let mut of_candidate: Vec<i32> = Vec::new();
    let mut bridges: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for &(f, g) in &scores.bridges {
        bridges.entry(f).or_default().push(g);
        bridges.entry(g).or_default().push(f);
    }
    let mut stack = Vec::new();
    for seed in 0..label.len() {
        if labels[seed] != NONE {
            continue;
        }
        let id = of_part.len() as u32;
        of_candidate.push(label[seed]);
        of_part.push(usize::try_from(label[seed]).ok().and_then(|l| scores.candidates.get(l)));
        labels[seed] = id;
        stack.push(seed as u32);
        while let Some(f) = stack.pop() {
            let across = bridges.get(&f).map_or(&[][..], Vec::as_slice);
            for &g in dual.links(f).iter().map(|(g, _)| g).chain(across) {
                if labels[g as usize] == NONE && label[g as usize] == label[seed] {
                    labels[g as usize] = id;
                    stack.push(g);
                }
            }
        }
    }
    // Of these faces no source says anything.
    let source = SegmentationSource::Labels;
    let nobody =
        Candidate { name: "unlabelled".into(), source, confidence: 0.0, name_confidence: None };
    let of_part: Vec<&Candidate> = of_part.into_iter().map(|c| c.unwrap_or(&nobody)).collect();
    let joins = joins(scores, &of_candidate);
    let names = unique_names(&of_part);
    let parts = (0u32..).zip(names).zip(of_part);
    let parts = parts
        .map(|((id, name), c)| Part {
            id,
            name,
            source: c.source,
            confidence: c.confidence,
            name_confidence: c.name_confidence,
        })
        .collect();
    PartLabels { labels, parts, joins }
}

/// The candidates' joins as joins of parts. The first part of a candidate stands for it; one whose faces
/// all went to others hands its joins on to what it is joined with.
fn joins(scores: &PartScores, of_candidate: &[i32]) -> Vec<PartJoin> {
    let mut stands = vec![None; scores.candidates.len()];
    for (part, &candidate) in (0u32..).zip(of_candidate).filter(|(_, c)| **c >= 0) {
        stands[candidate as usize].get_or_insert(part);
    }
    let mut sets = DisjointSets::new(stands.len());
    let mut joins = Vec::new();
    for &(a, b, boundary) in &scores.joins {
        let (a, b) = (sets.root(a), sets.root(b));
        let (of_a, of_b) = (stands[a as usize], stands[b as usize]);
        if a == b {
            continue;
        }
        if let (Some(a), Some(b)) = (of_a, of_b) {
            joins.push(PartJoin { a, b, boundary });
        }
        sets.hang(b, a);
        stands[a as usize] = of_a.or(of_b);
    }
    joins
}

/// A name that several parts have is numbered, past the names that stand there already.
fn unique_names(of_part: &[&Candidate]) -> Vec<String> {
    let mut count: BTreeMap<&str, u32> = BTreeMap::new();
    for candidate in of_part {
        *count.entry(&candidate.name).or_default() += 1;
    }
    let mut next: BTreeMap<&str, u32> = BTreeMap::new();
    let mut names = Vec::with_capacity(of_part.len());
    for candidate in of_part {
        let name = candidate.name.as_str();
        if count[name] == 1 {
            names.push(name.to_owned());
            continue;
        }
        let number = next.entry(name).or_default();
        loop {
            *number += 1;
            let tried = format!("{name}_{number}");
            if !count.contains_key(tried.as_str()) {
                names.push(tried);
                break;
            }
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    fn join(a: u32, b: u32, boundary: f64) -> PartJoin {
        PartJoin { a, b, boundary }
    }

    #[test]
    fn a_coarser_cut_only_joins() {
        let source = SegmentationSource::Learned;
        let part = |id: u32| Part {
            id,
            name: id.to_string(),
            source,
            confidence: 1.0,
            name_confidence: None,
        };
        let parts = PartLabels {
            labels: vec![0, 1, 2, 3],
            parts: (0..4).map(part).collect(),
            joins: vec![join(0, 1, 0.6), join(2, 3, 0.9), join(0, 2, 0.7)],
        };
        assert_eq!(parts.coarser(0.5), [0, 1, 2, 3]);
        assert_eq!(parts.coarser(0.65), [0, 0, 1, 2]);
        // The last join stands on the one before it, which is bolder.
        assert_eq!(parts.coarser(0.8), [0, 0, 1, 2]);
        assert_eq!(parts.coarser(0.95), [0, 0, 0, 0]);
    }

    #[test]
    fn a_candidate_without_faces_hands_its_joins_on() {
        let name = String::new();
        let source = SegmentationSource::Learned;
        let candidate = Candidate { name, source, confidence: 1.0, name_confidence: None };
        let scores = PartScores {
            candidates: vec![candidate; 3],
            joins: vec![(0, 1, 0.6), (0, 2, 0.7)],
            ..Default::default()
        };
        assert_eq!(joins(&scores, &[0, 1, 2]), [join(0, 1, 0.6), join(0, 2, 0.7)]);
        // Candidate 0 has no part; a component of candidate 2 stands twice.
        assert_eq!(joins(&scores, &[1, 2, 2]), [join(0, 1, 0.7)]);
    }
}
