//! Part embeddings → parts: flat mean shift (Comaniciu and Meer 2002, doi:10.1109/34.1000236). The densest
//! point that no part has starts the next; its mean moves until it stays; what lies within the
//! bandwidth is its part.

/// Radius within which points are one part: between the pull (0.5) and the push (2 × 1.5) of the
/// loss that shaped the embedding.
const BANDWIDTH: f32 = 1.0;

/// A part with a smaller share of the points is none; they go to the nearest other.
const LEAST: f64 = 0.004;

/// Points that may start a part.
const STARTS: usize = 512;

/// Most moves of a mean.
const MOVES: usize = 10;

/// Parts of an object at most.
const MOST: usize = 128;

/// The parts of a cloud's points.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Clusters {
    /// Part of each point.
    pub label: Vec<u32>,
    /// Mean embedding of each part, one after the other.
    pub means: Vec<f32>,
    /// How sure each point's part is: 0 where two are equally near, 1 where the next is far.
    pub confidence: Vec<f32>,
}

fn square(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

fn mean(rows: &[f32], width: usize, members: impl Iterator<Item = usize>) -> Option<Vec<f32>> {
    let mut sum = vec![0.0; width];
    let mut count = 0;
    for i in members {
        sum.iter_mut().zip(&rows[i * width..(i + 1) * width]).for_each(|(s, x)| *s += x);
        count += 1;
    }
    (count > 0).then(|| sum.iter().map(|s| s / count as f32).collect())
}

/// Cluster `rows` (one of `width` values a point).
pub fn cluster(rows: &[f32], width: usize) -> Clusters {
    let points = rows.len() / width.max(1);
    let row = |i: usize| &rows[i * width..(i + 1) * width];
    let near = |centre: &[f32], i: usize| square(row(i), centre) < BANDWIDTH * BANDWIDTH;
    let starts: Vec<usize> =
        (0..points.min(STARTS)).map(|k| k * points / points.min(STARTS)).collect();
    let density: Vec<usize> =
        starts.iter().map(|&i| starts.iter().filter(|&&j| near(row(i), j)).count()).collect();
    let mut taken = vec![false; points];
    let mut means: Vec<Vec<f32>> = Vec::new();
    while means.len() < MOST {
        let free = (0..starts.len()).filter(|&k| !taken[starts[k]]);
        let Some(k) = free.max_by(|&a, &b| density[a].cmp(&density[b]).then(b.cmp(&a))) else {
            break;
        };
        let mut centre = row(starts[k]).to_vec();
        for _ in 0..MOVES {
            let members = (0..points).filter(|&i| !taken[i] && near(&centre, i));
            match mean(rows, width, members) {
                Some(moved) if square(&moved, &centre) > 1e-6 => centre = moved,
                _ => break,
            }
        }
        let members: Vec<usize> = (0..points).filter(|&i| !taken[i] && near(&centre, i)).collect();
        taken[starts[k]] = true;
        members.iter().for_each(|&i| taken[i] = true);
        if members.len() as f64 >= LEAST * points as f64 {
            means.push(centre);
        }
    }
    if means.is_empty() {
        means.extend(mean(rows, width, 0..points));
    }
    assign(rows, width, means)
}

fn assign(rows: &[f32], width: usize, means: Vec<Vec<f32>>) -> Clusters {
    let mut clusters = Clusters::default();
    for row in rows.chunks(width.max(1)) {
        let (mut best, mut next) = ((f32::INFINITY, 0), f32::INFINITY);
        for (k, mean) in (0u32..).zip(&means) {
            let d = square(row, mean);
            if d < best.0 {
                next = best.0;
                best = (d, k);
            } else {
                next = next.min(d);
            }
        }
        clusters.label.push(best.1);
        let apart = if next.is_finite() { 1.0 - (best.0 / next.max(1e-12)).sqrt() } else { 1.0 };
        clusters.confidence.push(apart);
    }
    clusters.means = means.concat();
    clusters
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separate_heaps_are_found_and_stragglers_join_the_nearest() {
        let mut rows = Vec::new();
        for (heap, x) in [-3.0_f32, 0.0, 3.0].into_iter().enumerate() {
            for i in 0..200 {
                let at = (i * 37 % 101) as f32 / 101.0 - 0.5;
                rows.extend([x + 0.4 * at, at * at, heap as f32 * 0.0]);
            }
        }
        rows.extend([2.0, 0.9, 0.0]);
        let got = cluster(&rows, 3);
        assert_eq!(got.means.len(), 9);
        for heap in 0..3 {
            assert!(
                got.label[200 * heap..200 * (heap + 1)].iter().all(|&l| l == got.label[200 * heap])
            );
        }
        assert_eq!(got.label[600], got.label[400]);
        assert!(got.confidence[600] < got.confidence[500]);
        assert_eq!(cluster(&[], 3), Clusters::default());
    }
}
