//! Nearest neighbours in 3D, for the paper's smoothness and connectivity losses (2.3.5, 2.3.7).

use std::num::NonZero;

use kiddo::{ImmutableKdTree, SquaredEuclidean};

use crate::flatten::Disk;

/// Neighbours of a point. The paper does not give k.
const NEIGHBOURS: usize = 8;

/// Each of `vertices` with each of its nearest others among them.
pub(super) fn pairs(disk: &Disk, vertices: &[u32]) -> Vec<[u32; 2]> {
    let points: Vec<[f64; 3]> =
        vertices.iter().map(|v| disk.positions[*v as usize].to_array()).collect();
    let Ok(tree) = ImmutableKdTree::<f64, 3>::new_from_slice(&points) else {
        return Vec::new(); // of no points
    };
    let mut pairs = Vec::with_capacity(points.len() * NEIGHBOURS);
    // One more than wanted, since a point finds itself. The two copies of a point on a cut stand at
    // the same place, so it need not find itself first, or at all.
    let most = NonZero::<usize>::MIN.saturating_add(NEIGHBOURS);
    for (i, point) in points.iter().enumerate() {
        let found = tree.query(point).nearest_n::<SquaredEuclidean<f64>>(most).execute();
        let others = found.iter().map(|near| near.item as usize).filter(|j| *j != i);
        pairs.extend(others.take(NEIGHBOURS).map(|j| [vertices[i], vertices[j]]));
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::super::scenes::{cylinder, hills};
    use super::*;

    #[test]
    fn each_point_has_its_nearest_others() {
        for scene in [hills(6, 3), cylinder()] {
            let vertices: Vec<u32> = (0..scene.uv.len() as u32).filter(|v| v % 3 != 1).collect();
            let found = pairs(&scene.disk, &vertices);
            assert_eq!(found.len(), vertices.len() * NEIGHBOURS);
            let at = |v: u32| scene.disk.positions[v as usize];
            for (i, near) in vertices.iter().zip(found.chunks(NEIGHBOURS)) {
                let mut all: Vec<f64> =
                    vertices.iter().filter(|j| *j != i).map(|j| at(*i).distance(at(*j))).collect();
                all.sort_by(f64::total_cmp);
                for ([from, to], distance) in near.iter().zip(all) {
                    assert_eq!(from, i);
                    assert!((at(*i).distance(at(*to)) - distance).abs() < 1e-12);
                }
            }
        }
    }
}
