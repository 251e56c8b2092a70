//! Welding: vertices at the same place become one. A hash grid whose cells are wide against the
//! tolerance, so that a vertex looks into a neighbouring cell only when it lies close to its wall.

use std::collections::HashMap;

use glam::DVec3;

/// Vertices closer than this share of the diagonal are one.
pub const TOLERANCE: f64 = 1e-6;

/// Cell width in tolerances.
const CELL: f64 = 32.0;

/// For each position the index of the vertex it became, and the vertices, each at the place of its
/// first position. Positions within `tolerance` of an earlier vertex join that vertex.
pub fn weld(positions: &[DVec3], origin: DVec3, tolerance: f64) -> (Vec<u32>, Vec<DVec3>) {
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::with_capacity(positions.len());
    let mut vertices: Vec<DVec3> = Vec::with_capacity(positions.len());
    let width = CELL * tolerance;
    let ids = positions
        .iter()
        .map(|&p| {
            let q = (p - origin) / width;
            let home = q.floor();
            let reach = 1.0 / CELL;
            // Per axis: the home cell, and the one beyond a wall that is within reach.
            let near = |x: f64, floor: f64| -> (i64, i64) {
                let cell = floor as i64;
                let lo = if x - floor < reach { cell - 1 } else { cell };
                let hi = if floor + 1.0 - x < reach { cell + 1 } else { cell };
                (lo, hi)
            };
            let (x, y, z) = (near(q.x, home.x), near(q.y, home.y), near(q.z, home.z));
            let mut found: Option<u32> = None;
            for i in x.0..=x.1 {
                for j in y.0..=y.1 {
                    for k in z.0..=z.1 {
                        for &v in cells.get(&[i, j, k]).map_or(&[][..], Vec::as_slice) {
                            let close =
                                vertices[v as usize].distance_squared(p) <= tolerance * tolerance;
                            if close && found.is_none_or(|f| v < f) {
                                found = Some(v);
                            }
                        }
                    }
                }
            }
            found.unwrap_or_else(|| {
                let id = vertices.len() as u32;
                vertices.push(p);
                cells.entry([home.x as i64, home.y as i64, home.z as i64]).or_default().push(id);
                id
            })
        })
        .collect();
    (ids, vertices)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn welds_what_is_close_and_nothing_else(points in prop::collection::vec((0..6i32, 0..6i32, 0..6i32), 1..80)) {
            let tolerance = 0.01;
            let positions: Vec<DVec3> = points
                .iter()
                .enumerate()
                .map(|(i, &(x, y, z))| {
                    // Clusters 1 apart, jittered by less than half the tolerance.
                    let j = (i % 3) as f64 * 0.002;
                    DVec3::new(f64::from(x) + j, f64::from(y) - j, f64::from(z))
                })
                .collect();
            let (ids, vertices) = weld(&positions, DVec3::ZERO, tolerance);
            for (i, a) in points.iter().enumerate() {
                for (j, b) in points.iter().enumerate() {
                    prop_assert_eq!(ids[i] == ids[j], a == b);
                }
            }
            prop_assert!(ids.iter().all(|&v| (v as usize) < vertices.len()));
        }
    }
}
