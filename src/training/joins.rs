//! Learning the boundary classifier (`segmentation::regions`): objects whose parts are known are
//! agglomerated with the classifier as it stands; every pair it would join is an example, and where the
//! truth says no, it is not joined (Nunez-Iglesias et al. 2013, doi:10.1371/journal.pone.0071715, "active
//! learning" of agglomeration). After each round one is trained on all rounds' examples (`committee`).

use std::collections::HashMap;

use rayon::prelude::*;

use super::committee::{Pair, fit};
use super::folder::LabelledMesh;
use super::trainer::TrainError;
use crate::contract::{Canceled, Run};
use crate::device::Device;
use crate::sampling::{PointCloud, SampleCounts, sample};
use crate::segmentation::Network;
use crate::segmentation::Seen;
use crate::segmentation::point_mae::PairHead;
use crate::segmentation::regions::{
    BoundaryClassifier, Evidence, FEATURES, Heard, Opinion, Region, RegionGraph, agglomerate,
    features::{at, features},
    gather, prepare,
};

/// Rounds of agglomeration and training.
const ROUNDS: usize = 3;

/// How far the classifier goes astray while it learns: up to this probability that a part ends.
const ASTRAY: f64 = 0.5;

/// A refused pair is an example again when the smaller region has grown so much.
const GROWN: f64 = 1.5;

/// An object with its evidence, and its parts.
pub struct Known {
    mesh: LabelledMesh,
    evidence: Evidence,
    cloud: PointCloud,
}

/// Gather the evidence of objects with a trained network.
pub fn know(
    meshes: Vec<LabelledMesh>,
    network: &Network,
    seed: u64,
    run: &Run,
) -> Result<Vec<Known>, Canceled> {
    let one = |mesh: LabelledMesh| {
        let counts = SampleCounts::dense(mesh.surface.face_count());
        let cloud = sample(&mesh.surface, counts, seed, run)?;
        let evidence = gather(Seen { surface: &mesh.surface, cloud: &cloud }, Some(network), run)?;
        Ok(Known { mesh, evidence, cloud })
    };
    meshes.into_par_iter().map(one).collect()
}

/// Train a boundary classifier on these objects; `watch` is told each round's pairs and loss.
pub fn train_joins(
    known: &[Known],
    seed: u64,
    device: &Device,
    run: &Run,
    mut watch: impl FnMut(usize, usize, f64),
) -> Result<PairHead, TrainError> {
    let mut pairs: Vec<Pair> = Vec::new();
    let mut head = None;
    for round in 0..ROUNDS {
        let classifier = head.as_ref().map(BoundaryClassifier::new);
        for astray in [false, true].into_iter().filter(|a| !a || classifier.is_some()) {
            let of =
                |(i, k): (usize, &Known)| examples(k, i as u32, classifier.as_ref(), astray, run);
            let found: Result<Vec<Vec<Pair>>, Canceled> =
                known.par_iter().enumerate().map(of).collect();
            pairs.extend(found?.into_iter().flatten());
        }
        let (trained, loss) = fit(&pairs, known.len(), seed + round as u64, device, run)?;
        head = Some(trained);
        watch(round, pairs.len(), loss);
    }
    head.ok_or(TrainError::NoExamples)
}

/// The pairs that are met when an object is agglomerated without a wrong join; or, `astray`, with those
/// that the classifier makes, up to where it would stop and once around what is left.
fn examples(
    known: &Known,
    object: u32,
    classifier: Option<&BoundaryClassifier>,
    astray: bool,
    run: &Run,
) -> Result<Vec<Pair>, Canceled> {
    let truth = Some(known.mesh.parts.as_slice());
    let prepared = prepare(&known.mesh.surface, &known.cloud, &known.evidence, truth, run)?;
    let mut graph = prepared.graph;
    let mut pairs = Vec::new();
    let areas = part_areas(&graph);
    // A pair that was refused comes up again whenever one of the two grows; it counts again once the
    // smaller has grown by half.
    let mut refused: HashMap<(u32, u32), f64> = HashMap::new();
    // Before there is a classifier: steps of the embedding, concave regions, authored components, and small
    // regions first.
    let first = |x: &[f32; FEATURES]| {
        let speaks = [at::APART, at::STEP, at::BAY, at::ACROSS_SOLIDS].map(|i| x[i]);
        f64::from(speaks.iter().sum::<f32>()) + 0.1 * f64::from(x[at::SMALL])
    };
    let boundary = |x: &[f32; FEATURES]| match classifier {
        Some(classifier) => classifier.boundary(x, Heard::ALL),
        None => first(x),
    };
    let until = if astray { ASTRAY } else { f64::INFINITY };
    agglomerate(&mut graph, &boundary, until, run, |graph, a, b, x| {
        let (Some(r), Some(s)) = (graph.region(a), graph.region(b)) else { return false };
        let Some((is_boundary, weight)) = lesson(&areas, r, s) else { return true };
        if is_boundary {
            let last = refused.entry((a, b)).or_default();
            let smaller = r.area.min(s.area);
            if smaller < GROWN * *last {
                return false;
            }
            *last = smaller;
        }
        pairs.push(Pair { features: *x, is_boundary, weight, object });
        !is_boundary || astray
    })?;
    if astray {
        let left = (0u32..).zip(&graph.borders);
        for (a, b, border) in left.flat_map(|(a, n)| n.range(a..).map(move |(&b, x)| (a, b, x))) {
            let (Some(r), Some(s)) = (graph.region(a), graph.region(b)) else { continue };
            let Some((is_boundary, weight)) = lesson(&areas, r, s) else { continue };
            let features = features(&graph, r, s, border);
            pairs.push(Pair { features, is_boundary, weight, object });
        }
    }
    Ok(pairs)
}

/// Area of each true part.
fn part_areas(graph: &RegionGraph) -> HashMap<i32, f64> {
    let mut areas = HashMap::new();
    for (&part, area) in graph.regions.iter().flatten().flat_map(|r| &r.truth) {
        *areas.entry(part).or_default() += area;
    }
    areas
}

/// Whether a part ends between two regions, and how much it matters: joining them wrongly, or not,
/// spoils their parts in the share that the smaller has of its own, whatever the size of that part. The
/// root, for much of it lies in few pairs.
fn lesson(areas: &HashMap<i32, f64>, r: &Region, s: &Region) -> Option<(bool, f64)> {
    let (p, q) = (r.majority()?, s.majority()?);
    let (small, part) = if r.area <= s.area { (r.area, p.0) } else { (s.area, q.0) };
    let of_part = small / areas.get(&part).copied().unwrap_or(0.0).max(f64::MIN_POSITIVE);
    // A region of two parts teaches little.
    let clear = (p.1.min(q.1) * 2.0 - 1.0).max(0.0);
    Some((p.0 != q.0, clear * of_part.min(1.0).sqrt()))
}
