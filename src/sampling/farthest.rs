//! Farthest-point sampling (Gonzalez, "Clustering to minimize the maximum intercluster distance",
//! 1985, doi:10.1016/0304-3975(85)90224-5): the cloud that a network sees, drawn from the dense one.

use super::PointCloud;
use crate::contract::{Canceled, Run};

/// Points that the segmentation network takes.
pub const NETWORK_POINTS: usize = 2048;

/// Candidates for each wanted point. The work is candidates × points, so a larger cloud is first
/// thinned evenly.
const CANDIDATES: usize = 8;

/// Indices of `count` points (all of them if there are fewer), each the farthest from those before
/// it. The first is the one farthest from the centre of the cloud.
pub fn farthest_points(cloud: &PointCloud, count: usize, run: &Run) -> Result<Vec<u32>, Canceled> {
    let total = cloud.len();
    if count >= total {
        return Ok((0..total as u32).collect());
    }
    let kept = total.min(CANDIDATES * count);
    let candidates: Vec<u32> = (0..kept).map(|i| (i * total / kept) as u32).collect();
    let points: Vec<_> = candidates.iter().map(|&i| cloud.positions[i as usize]).collect();
    let centre = points.iter().sum::<glam::DVec3>() / kept.max(1) as f64;
    let mut nearest: Vec<f64> = points.iter().map(|p| p.distance_squared(centre)).collect();
    let mut chosen = Vec::with_capacity(count);
    for step in 0..count {
        if step % 64 == 0 {
            run.cancel.check()?;
        }
        let mut best = 0;
        for i in 1..kept {
            if nearest[i] > nearest[best] {
                best = i;
            }
        }
        chosen.push(candidates[best]);
        let at = points[best];
        for (d, p) in nearest.iter_mut().zip(&points) {
            let away = p.distance_squared(at);
            // The first choice replaces the distances to the centre.
            *d = if step == 0 { away } else { d.min(away) };
        }
        // Never twice, even where all that is left coincides with a chosen point.
        nearest[best] = -1.0;
    }
    Ok(chosen)
}
