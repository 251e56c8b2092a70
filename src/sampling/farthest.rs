//! Farthest-point sampling (Gonzalez, "Clustering to minimize the maximum intercluster distance",
//! 1985, doi:10.1016/0304-3975(85)90224-5): the cloud that a network sees, drawn from the dense one.
//!
//! Points lie in buckets, and a bucket is passed over where each of its points has a choice nearer to it than its
//! box is to the newest one: the same points as by looking at all, for a few of the distances.

use glam::DVec3;

use super::PointCloud;
use crate::contract::{Canceled, Run};

/// Points that the segmentation network takes.
pub const NETWORK_POINTS: usize = 2048;

/// Candidates for each wanted point. The work grows with both, so a larger cloud is first thinned
/// evenly.
const CANDIDATES: usize = 8;

/// Candidates of one bucket, at most.
const BUCKET: usize = 64;

/// Share by which a distance to a box must be too large before its bucket is passed over: rounding.
const ROUNDING: f64 = 1e-12;

/// Indices of `count` points (all of them if there are fewer), each the farthest from those before
/// it. The first is the one farthest from the centre of the cloud.
pub fn farthest_points(cloud: &PointCloud, count: usize, run: &Run) -> Result<Vec<u32>, Canceled> {
    let total = cloud.len();
    if count >= total || count == 0 {
        return Ok((0..count.min(total) as u32).collect());
    }
    let kept = total.min(CANDIDATES * count);
    let candidates = (0..kept).map(|i| (i * total / kept) as u32);
    let mut candidates: Vec<Candidate> = candidates.map(|i| Candidate::new(cloud, i)).collect();
    let centre = candidates.iter().map(|c| c.position).sum::<DVec3>() / kept.max(1) as f64;
    let mut chosen = Vec::with_capacity(count);
    // The first choice: its distance to the centre counts for no other.
    let from_centre = |c: &Candidate| c.position.distance_squared(centre);
    let mut next = candidates[0];
    for candidate in &candidates {
        if from_centre(candidate) > from_centre(&next) {
            next = *candidate;
        }
    }
    let mut buckets = buckets(&mut candidates);
    for step in 0..count {
        if step % 64 == 0 {
            run.cancel.check()?;
        }
        chosen.push(next.index);
        buckets.iter_mut().for_each(|b| b.choose(&next));
        let farthest = buckets.iter().map(|b| b.farthest).reduce(Candidate::farther);
        next = farthest.unwrap_or(next);
    }
    Ok(chosen)
}

/// A point that may be chosen.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    position: DVec3,
    index: u32,
    /// Square of the distance to the nearest chosen point; negative if it is chosen itself, so that no
    /// point is chosen twice even where all that is left coincides with a chosen one.
    nearest: f64,
}

impl Candidate {
    fn new(cloud: &PointCloud, index: u32) -> Self {
        Self { position: cloud.positions[index as usize], index, nearest: f64::INFINITY }
    }

    /// The farther of two, of equals the first in the cloud.
    fn farther(self, other: Self) -> Self {
        let ahead = self.nearest > other.nearest
            || (self.nearest == other.nearest && self.index < other.index);
        if ahead { self } else { other }
    }
}

/// Candidates that lie together, and their box.
struct Bucket<'a> {
    least: DVec3,
    most: DVec3,
    farthest: Candidate,
    candidates: &'a mut [Candidate],
}

impl Bucket<'_> {
    /// Take note of the newest choice.
    fn choose(&mut self, chosen: &Candidate) {
        let at = chosen.position;
        let away = at.distance_squared(at.clamp(self.least, self.most));
        if away * (1.0 - ROUNDING) > self.farthest.nearest {
            return;
        }
        let mut farthest: Option<Candidate> = None;
        for candidate in self.candidates.iter_mut() {
            let away = candidate.position.distance_squared(at);
            candidate.nearest = candidate.nearest.min(away);
            if candidate.index == chosen.index {
                candidate.nearest = -1.0;
            }
            farthest = Some(farthest.map_or(*candidate, |f| f.farther(*candidate)));
        }
        self.farthest = farthest.unwrap_or(self.farthest);
    }
}

/// Buckets of at most [`BUCKET`] candidates: halves of halves along the longest side.
fn buckets(candidates: &mut [Candidate]) -> Vec<Bucket<'_>> {
    let (mut buckets, mut open) = (Vec::new(), vec![candidates]);
    while let Some(candidates) = open.pop() {
        let Some(&farthest) = candidates.first() else { continue };
        let start = (farthest.position, farthest.position);
        let (least, most) = candidates
            .iter()
            .fold(start, |(least, most), c| (least.min(c.position), most.max(c.position)));
        if candidates.len() <= BUCKET {
            buckets.push(Bucket { least, most, farthest, candidates });
            continue;
        }
        let axis = (most - least).max_position();
        let middle = candidates.len() / 2;
        candidates.select_nth_unstable_by(middle, |a, b| {
            a.position[axis].total_cmp(&b.position[axis]).then(a.index.cmp(&b.index))
        });
        let (low, high) = candidates.split_at_mut(middle);
        open.extend([low, high]);
    }
    buckets
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// By looking at each point.
    fn plain(positions: &[DVec3], count: usize) -> Vec<u32> {
        let centre = positions.iter().sum::<DVec3>() / positions.len() as f64;
        let mut nearest: Vec<f64> = positions.iter().map(|p| p.distance_squared(centre)).collect();
        (0..count)
            .map(|step| {
                let best =
                    (0..nearest.len()).fold(0, |b, i| if nearest[i] > nearest[b] { i } else { b });
                for (d, p) in nearest.iter_mut().zip(positions) {
                    let away = p.distance_squared(positions[best]);
                    *d = if step == 0 { away } else { d.min(away) };
                }
                nearest[best] = -1.0;
                best as u32
            })
            .collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        /// Coarse coordinates have many equal distances, and points that coincide.
        #[test]
        fn buckets_change_nothing(
            points in prop::collection::vec(prop::array::uniform3(-20..20i32), 2..600),
            step in 0.01..1.0f64,
            share in 0.2..0.9f64,
        ) {
            let positions: Vec<DVec3> =
                points.iter().map(|p| DVec3::from_array(p.map(|x| f64::from(x) * step))).collect();
            // All are candidates.
            let count = ((share * positions.len() as f64) as usize).max(1);
            let cloud = PointCloud { positions: positions.clone(), ..Default::default() };
            let found = farthest_points(&cloud, count, &Run::quiet()).unwrap();
            prop_assert_eq!(found, plain(&positions, count));
        }
    }
}
