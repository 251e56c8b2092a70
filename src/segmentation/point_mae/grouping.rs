//! Groups of points: centres by farthest-point sampling, members the nearest neighbours of each
//! (Point-MAE, arXiv 2203.06604, Sec. 3.1), and the weights by which features of the centres are
//! interpolated at a point (PointNet++, arXiv 1706.02413, Eq. 2, three nearest, inverse square).
//!
//! Clouds are small (2,048 points, 128 groups), so a flat search in f32 beats a tree.

use rayon::prelude::*;

use crate::tasks;

/// Centres over which a point's features are interpolated.
pub const NEAREST: usize = 3;

/// Groups of one cloud.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Groups {
    /// Index of each group's centre.
    pub centres: Vec<u32>,
    /// Members of each group, nearest first, the centre itself among them; group after group.
    pub members: Vec<u32>,
}

/// Divide a cloud into `count` groups of `size` points that overlap. A cloud with fewer points
/// repeats some. The first centre is the point farthest from the middle.
pub fn group(points: &[[f32; 3]], count: usize, size: usize) -> Groups {
    let centres = farthest(points, count);
    let members = centres.par_iter().flat_map_iter(|&c| nearest(points, points[c as usize], size));
    let members = tasks::even("groups", centres.len(), || members.collect());
    Groups { members, centres }
}

fn square(a: [f32; 3], b: [f32; 3]) -> f32 {
    let [x, y, z] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    x * x + y * y + z * z
}

/// Indices of `count` points, each the farthest from those before it; of equals the first.
fn farthest(points: &[[f32; 3]], count: usize) -> Vec<u32> {
    if points.is_empty() {
        return Vec::new();
    }
    let n = points.len() as f32;
    let middle = points.iter().fold([0.0; 3], |m, p| std::array::from_fn(|k| m[k] + p[k] / n));
    let mut away: Vec<f32> = points.iter().map(|&p| square(p, middle)).collect();
    let mut chosen = Vec::with_capacity(count);
    for step in 0..count {
        let best = (0..away.len()).fold(0, |b, i| if away[i] > away[b] { i } else { b });
        chosen.push(best as u32);
        let at = points[best];
        for (away, &p) in away.iter_mut().zip(points) {
            let d = square(p, at);
            *away = if step == 0 { d } else { away.min(d) };
        }
    }
    chosen
}

/// The `size` nearest points, nearest first; repeated from the first where there are fewer.
fn nearest(points: &[[f32; 3]], at: [f32; 3], size: usize) -> Vec<u32> {
    let mut order: Vec<(f32, u32)> =
        points.iter().zip(0u32..).map(|(&p, i)| (square(p, at), i)).collect();
    let by = |a: &(f32, u32), b: &(f32, u32)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
    if order.len() > size {
        order.select_nth_unstable_by(size - 1, by);
        order.truncate(size);
    }
    order.sort_unstable_by(by);
    order.iter().map(|o| o.1).cycle().take(size).collect()
}

/// Interpolation of values at `centres` to each of `points`: a dense row-major matrix `[points,
/// centres]` whose rows sum to 1, so that interpolation is one product.
pub fn interpolation(points: &[[f32; 3]], centres: &[[f32; 3]]) -> Vec<f32> {
    let width = centres.len();
    let mut matrix = vec![0.0; points.len() * width];
    matrix.par_chunks_mut(width.max(1)).zip(points).for_each(|(row, &p)| {
        let mut best = [(f32::INFINITY, usize::MAX); NEAREST];
        for (i, &c) in centres.iter().enumerate() {
            let d = square(p, c);
            if d < best[NEAREST - 1].0 {
                best[NEAREST - 1] = (d, i);
                best.sort_by(|a, b| a.0.total_cmp(&b.0));
            }
        }
        let weight = |d: f32| 1.0 / (d + 1e-8);
        let found = best.iter().filter(|b| b.1 != usize::MAX);
        let total: f32 = found.clone().map(|b| weight(b.0)).sum();
        found.for_each(|b| row[b.1] += weight(b.0) / total);
    });
    matrix
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(n: usize) -> Vec<[f32; 3]> {
        let at = |i: usize| i as f32 / n as f32;
        (0..n * n * n).map(|i| [at(i % n), at(i / n % n), at(i / n / n)]).collect()
    }

    #[test]
    fn centres_are_far_apart_and_members_near() {
        let points = grid(9);
        let groups = group(&points, 8, 4);
        let mut corners = groups.centres.clone();
        corners.sort_unstable();
        corners.dedup();
        assert_eq!(corners.len(), 8, "a centre twice");
        for (i, &a) in groups.centres.iter().enumerate() {
            // Eight points of a cube as far apart as can be are about its corners.
            for &b in &groups.centres[..i] {
                assert!(square(points[a as usize], points[b as usize]) > 0.2);
            }
            let members = &groups.members[4 * i..4 * i + 4];
            assert_eq!(members[0], a);
            let far = members.iter().map(|&m| square(points[m as usize], points[a as usize]));
            assert!(far.fold(0.0, f32::max) < 0.03);
        }
    }

    #[test]
    fn few_points_are_repeated() {
        let points = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
        let groups = group(&points, 4, 3);
        assert_eq!(groups.centres.len(), 4);
        assert_eq!(groups.members.len(), 12);
        assert!(group(&[], 4, 3).members.is_empty());
    }

    #[test]
    fn interpolation_keeps_constants_and_values_at_centres() {
        let centres = grid(3);
        let points = grid(7);
        for (row, p) in interpolation(&points, &centres).chunks(27).zip(&points) {
            assert!((row.iter().sum::<f32>() - 1.0).abs() < 1e-5);
            assert_eq!(row.iter().filter(|w| **w > 0.0).count(), NEAREST, "{p:?}");
        }
        let own = interpolation(&centres, &centres);
        assert!((0..27).all(|i| own[27 * i + i] > 0.999));
    }
}
