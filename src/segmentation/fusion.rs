//! From regions to parts, with all evidence that is to be heard: regions are agglomerated while the
//! probability that a part ends between them is at most a cut (0.55 by default), and the faces near the
//! borders are left to the graph cut. For each part it is told which kind of evidence decided: the one
//! without which its borders would be doubted most.

use super::naming::Naming;
use super::near_borders::near_borders;
use super::regions::{Evidence, Heard, Opinion, Prepared, RegionGraph, agglomerate, features};
use super::{Candidate, PartScores, Seen};
use crate::contract::{Canceled, Run, SegmentationSource};
use crate::mesh::{NONE, Surface};
use crate::tasks;

/// Regions are joined up to this probability that a part ends between them, unless another cut is asked
/// for. It lies between 0.5, which of 0.3, 0.4, 0.5 and 0.6 gave the best overlap on half of the labelled
/// objects, and 0.6, which gave the best Rand index of articulated ones.
pub const CUT: f64 = 0.55;

/// Widths of an initial region within which a border may move.
const REACH: f64 = 1.2;

/// Parts of a surface in the opinion of the boundary classifier or the rule, told only of the evidence that
/// is to be heard: regions are joined as long as the probability that a part ends between them is at most
/// `cut`.
pub fn fuse(
    seen: Seen,
    evidence: &Evidence,
    opinion: &dyn Opinion,
    heard: Heard,
    cut: f64,
    run: &Run,
) -> Result<PartScores, Canceled> {
    let Seen { surface, cloud } = seen;
    let Prepared { patch, mut graph, contacts } =
        tasks::link("regions", || super::regions::prepare(surface, cloud, evidence, None, run))?;
    let boundary = |x: &_| opinion.boundary(x, heard);
    let mut tree = tasks::link("agglomerate", || {
        agglomerate(&mut graph, &boundary, cut, run, |_, _, _, _| true)
    })?;
    // Probabilities change as regions get fewer: until none is left that would be joined.
    loop {
        let more = agglomerate(&mut graph, &boundary, cut, run, |_, _, _, _| true)?;
        if more.joins.is_empty() {
            break;
        }
        tree.joins.extend(more.joins);
    }
    let of_patch = tree.cut(cut);
    let label: Vec<i32> =
        patch.iter().map(|&p| if p == NONE { -1 } else { of_patch[p as usize] as i32 }).collect();
    // The region that is left of each part stands at one of its initial regions.
    let count = of_patch.iter().max().map_or(0, |m| *m as usize + 1);
    let mut stands = vec![0u32; count];
    for (p, &part) in (0u32..).zip(&of_patch).filter(|(p, _)| graph.region(*p).is_some()) {
        stands[part as usize] = p;
    }
    // Initial regions have ragged rims: about as far as one reaches, the line may be drawn anew, the more
    // freely the nearer. Between shells the file has drawn it already.
    let faces_of_patch = surface.face_count() as f64 / of_patch.len().max(1) as f64;
    let rings = (REACH * faces_of_patch.sqrt()).round().clamp(2.0, 8.0) as u8;
    let shell = |h: u32| surface.origins[h as usize / 3].shell;
    let same = |h: u32| shell(h) == shell(surface.twin[h as usize]);
    let ring = near_borders(surface, &label, rings, same);
    let fixed = label.iter().zip(&ring).map(|(&l, &r)| if r > 0 { -1 } else { l }).collect();
    let vote = |&f: &u32| if ring[f as usize] > 0 { label[f as usize] } else { -1 };
    let votes = cloud.faces.iter().map(vote).collect();
    let weight = |&f: &u32| f32::from(ring[f as usize]) / f32::from(rings);
    let weights = cloud.faces.iter().map(weight).collect();
    let candidate = |&p: &u32| {
        let found = candidate(&graph, p, opinion, heard);
        match given_name(surface, &graph, p) {
            Some(name) => Candidate { name, name_confidence: None, ..found },
            None => found,
        }
    };
    let candidates = stands.iter().map(candidate).collect();
    // What would be joined next, up to one part for each group of welded components that touch.
    let above = agglomerate(&mut graph, &boundary, f64::INFINITY, run, |_, _, _, _| true)?;
    let part = |patch: u32| of_patch[patch as usize];
    let joins = above.joins.iter().map(|j| (part(j.keep), part(j.gone), j.boundary)).collect();
    let joined = |c: &&super::regions::contact::Contact| {
        label[c.faces.0 as usize] == label[c.faces.1 as usize]
    };
    let bridges = contacts.iter().filter(joined).map(|c| c.faces).collect();
    Ok(PartScores { candidates, fixed, votes, weights, bridges, joins })
}

/// The name of the node that a part lies in, where the file has several.
fn given_name(surface: &Surface, graph: &RegionGraph, p: u32) -> Option<String> {
    let several = surface.origins.iter().any(|o| o.primitive != surface.origins[0].primitive);
    let primitive = graph.region(p)?.primitive.filter(|_| several)?;
    surface.names.get(primitive as usize).filter(|n| !n.is_empty()).cloned()
}

/// Name, source and confidence of the part whose region stands at `p`.
fn candidate(graph: &RegionGraph, p: u32, opinion: &dyn Opinion, heard: Heard) -> Candidate {
    let part = match heard {
        Heard { authored: true, .. } => SegmentationSource::Authored,
        Heard { learned: true, .. } => SegmentationSource::Learned,
        _ => SegmentationSource::Geometric,
    };
    let Some(region) = graph.region(p) else {
        return Candidate {
            name: "part".into(),
            source: part,
            confidence: 0.0,
            name_confidence: None,
        };
    };
    let naming = Naming::of(&region.names).filter(|_| heard.learned);
    let name = naming.and_then(Naming::word);
    let name_confidence = naming.filter(|_| name.is_some()).map(Naming::confidence);
    let name = name.unwrap_or("part");
    let mut without = vec![
        (SegmentationSource::Learned, heard.learned, Heard { learned: false, ..heard }),
        (SegmentationSource::Authored, heard.authored, Heard { authored: false, ..heard }),
        (SegmentationSource::Geometric, heard.shape, Heard { shape: false, ..heard }),
    ];
    without.retain(|w| w.1);
    let (mut sure, mut length, mut missed) = (0.0, 0.0, vec![0.0; without.len()]);
    for (&n, border) in &graph.borders[p as usize] {
        let Some(other) = graph.region(n) else { continue };
        let x = features::features(graph, region, other, border);
        let all = opinion.boundary(&x, heard);
        sure += border.length * all;
        length += border.length;
        for (missed, (_, _, deaf)) in missed.iter_mut().zip(&without) {
            *missed += border.length * (all - opinion.boundary(&x, *deaf));
        }
    }
    // A part that touches nothing is what the file says it is.
    let most = (0..without.len()).max_by(|&a, &b| missed[a].total_cmp(&missed[b]));
    let most = most.filter(|_| length > 0.0);
    let source = most.map_or(part, |k| without[k].0);
    let confidence = if length > 0.0 { sure / length } else { 1.0 };
    Candidate { name: name.into(), source, confidence, name_confidence }
}
