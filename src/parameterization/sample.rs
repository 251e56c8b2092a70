//! The vertices that a chart is trained on. A chart within the bound is trained whole; a larger one
//! on whole triangles drawn by area, each with its neighbours, so that every loss on triangles and on
//! pairs of triangles can be measured exactly.

use crate::device::Seeded;
use crate::flatten::Disk;

/// "No triangle on the other side".
const NONE: u32 = u32::MAX;

/// What a chart is trained on.
#[derive(Debug)]
pub(super) struct Sample {
    /// The triangles, as a mesh of their own; `None` for the whole chart.
    pub part: Option<Disk>,
    /// Vertex of the chart that each vertex of the sample stands for.
    pub vertices: Vec<u32>,
}

impl Sample {
    /// Every vertex of the chart.
    pub fn whole(disk: &Disk) -> Self {
        Self { part: None, vertices: (0..disk.positions.len() as u32).collect() }
    }

    /// At most `points` vertices of the chart: triangles drawn in proportion to their area at even
    /// steps from a random offset, and the triangles around them. `neighbours` is [`neighbours`].
    pub fn draw(disk: &Disk, neighbours: &[[u32; 3]], points: usize, rng: &mut Seeded) -> Self {
        let seeds = (points / 6).max(1);
        let step = disk.area() / seeds as f64;
        let mut next = rng.unit_f64() * step;
        let mut number = vec![NONE; disk.positions.len()];
        let mut taken = vec![false; disk.triangles.len()];
        let mut vertices = Vec::new();
        let mut triangles = Vec::new();
        let mut sum = 0.0;
        for (f, area) in disk.areas.iter().enumerate() {
            sum += area;
            if sum <= next {
                continue;
            }
            // A large triangle may be due more than once; it is taken once.
            while next < sum && step > 0.0 {
                next += step;
            }
            let around = neighbours[f].into_iter().filter(|&n| n != NONE).map(|n| n as usize);
            for f in std::iter::once(f).chain(around) {
                let corners = disk.triangles[f].map(|v| v as usize);
                let new = corners.iter().filter(|&&v| number[v] == NONE).count();
                if taken[f] || vertices.len() + new > points.max(3) {
                    continue;
                }
                taken[f] = true;
                triangles.push(corners.map(|v| {
                    if number[v] == NONE {
                        number[v] = vertices.len() as u32;
                        vertices.push(v as u32);
                    }
                    number[v]
                }));
            }
        }
        let positions = vertices.iter().map(|&v| disk.positions[v as usize]).collect();
        Self { part: Some(Disk::new(positions, triangles)), vertices }
    }

    /// The mesh that is measured.
    pub fn disk<'a>(&'a self, whole: &'a Disk) -> &'a Disk {
        self.part.as_ref().unwrap_or(whole)
    }

    /// The entries of `all` for the vertices of the sample.
    pub fn pick<T: Copy>(&self, all: &[T]) -> Vec<T> {
        self.vertices.iter().map(|&v| all[v as usize]).collect()
    }
}

/// The triangle across each edge of each triangle, or [`NONE`]. Edge `k` runs from corner `k` to the
/// next.
pub(super) fn neighbours(disk: &Disk) -> Vec<[u32; 3]> {
    let mut edges: Vec<([u32; 2], u32, u8)> = Vec::with_capacity(3 * disk.triangles.len());
    for (f, t) in disk.triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            edges.push(([a.min(b), a.max(b)], f as u32, k as u8));
        }
    }
    edges.sort_unstable();
    let mut across = vec![[NONE; 3]; disk.triangles.len()];
    for pair in edges.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, f, i), (_, g, k)] = *pair {
            across[f as usize][i as usize] = g;
            across[g as usize][k as usize] = f;
        }
    }
    across
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameterization::scenes;

    #[test]
    fn a_draw_keeps_to_its_bound_and_to_whole_triangles() {
        let (disk, _) = scenes::bumpy(60, 60);
        let across = neighbours(&disk);
        let draw = |seed| Sample::draw(&disk, &across, 200, &mut Seeded::new(seed, 0));
        let sample = draw(1);
        let part = sample.part.as_ref().unwrap();
        assert!((150..=200).contains(&sample.vertices.len()), "{}", sample.vertices.len());
        assert!(part.triangles.len() > 60);
        for (v, &original) in sample.vertices.iter().enumerate() {
            assert_eq!(part.positions[v], disk.positions[original as usize]);
        }
        assert_eq!(sample.vertices, draw(1).vertices);
        assert_ne!(sample.vertices, draw(2).vertices);
        // Spread over the whole chart, not bunched at its first triangles.
        let x = sample.vertices.iter().map(|&v| disk.positions[v as usize].x);
        let y = sample.vertices.iter().map(|&v| disk.positions[v as usize].y);
        let spread = |v: Vec<f64>| {
            v.iter().fold(f64::MIN, |a, b| a.max(*b)) - v.iter().fold(f64::MAX, |a, b| a.min(*b))
        };
        assert!(spread(x.collect()) > 0.9 && spread(y.collect()) > 0.9);
    }

    #[test]
    fn neighbours_agree_with_each_other() {
        let (disk, _) = scenes::bumpy(5, 4);
        let across = neighbours(&disk);
        let mut inner = 0;
        for (f, edges) in across.iter().enumerate() {
            for &g in edges.iter().filter(|&&g| g != NONE) {
                assert!(across[g as usize].contains(&(f as u32)));
                inner += 1;
            }
        }
        // 40 triangles have 120 sides, of which 18 are on the border.
        assert_eq!(inner, 120 - 18);
    }
}
