//! The outcome: one part a face. Connected pieces of one label are separate parts.

use std::collections::BTreeMap;

use super::dual::DualGraph;
use super::scores::{Candidate, PartScores};
use crate::contract::SegmentationSource;
use crate::mesh::{NONE, Surface};

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
}

/// One part a face.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PartLabels {
    /// Part of each face; [`NONE`] for faces without area. Length: faces.
    pub labels: Vec<u32>,
    /// The parts, numbered in order of first face.
    pub parts: Vec<Part>,
}

impl PartLabels {
    /// The labels as text: one integer a line, line i for face i, −1 for a face without area.
    pub fn to_text(&self) -> String {
        let label = |&l: &u32| if l == NONE { -1 } else { i64::from(l) };
        self.labels.iter().map(|l| format!("{}\n", label(l))).collect()
    }
}

/// Number the connected pieces of each label. Faces are connected over shared edges and the scores'
/// bridges; the two faces of a double-sided sheet are one place and so one piece.
pub fn connected_parts(
    surface: &Surface,
    dual: &DualGraph,
    scores: &PartScores,
    label: &[i32],
) -> PartLabels {
    let mut labels = vec![NONE; label.len()];
    let mut of_part: Vec<Option<&Candidate>> = Vec::new();
    let mut bridges: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for &(f, g) in &scores.bridges {
        bridges.entry(f).or_default().push(g);
        bridges.entry(g).or_default().push(f);
    }
    let mut stack = Vec::new();
    for seed in 0..label.len() {
        if labels[seed] != NONE || !surface.usable[seed] {
            continue;
        }
        let id = of_part.len() as u32;
        of_part.push(usize::try_from(label[seed]).ok().and_then(|l| scores.candidates.get(l)));
        labels[seed] = id;
        stack.push(seed as u32);
        while let Some(f) = stack.pop() {
            let across = bridges.get(&f).map_or(&[][..], Vec::as_slice);
            for &g in dual.links(f).iter().map(|(g, _)| g).chain(across) {
                let g_is_free = labels[g as usize] == NONE && surface.usable[g as usize];
                if g_is_free && label[g as usize] == label[seed] {
                    labels[g as usize] = id;
                    stack.push(g);
                }
            }
        }
    }
    // Of these faces no source says anything.
    let source = SegmentationSource::Labels;
    let nobody = Candidate { name: "unlabelled".into(), source, confidence: 0.0 };
    let of_part: Vec<&Candidate> = of_part.into_iter().map(|c| c.unwrap_or(&nobody)).collect();
    let names = unique_names(&of_part);
    let parts = (0u32..).zip(names).zip(of_part);
    let parts = parts
        .map(|((id, name), c)| Part { id, name, source: c.source, confidence: c.confidence })
        .collect();
    PartLabels { labels, parts }
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
