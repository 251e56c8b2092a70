//! The topology of a disk: boundary loops, Euler characteristic, and whether it is a disk at all.

use super::Disk;

/// What bounds a set of triangles.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Border {
    /// Boundary loops as ordered vertices, triangles on the left, the last vertex joined to the
    /// first. Each starts at its least half-edge; loops come in the order of their starts.
    pub loops: Vec<Vec<u32>>,
    /// Vertices in use − edges + triangles.
    pub euler: i64,
    /// Whether every edge has at most two triangles, wound consistently, and no vertex joins two
    /// fans.
    pub manifold: bool,
    /// Connected components.
    pub pieces: usize,
}

impl Border {
    /// The border of a disk's triangles.
    pub fn of(disk: &Disk) -> Self {
        Self::of_triangles(&disk.triangles, disk.positions.len())
    }

    /// The border of triangles over `vertices` vertices.
    pub fn of_triangles(triangles: &[[u32; 3]], vertices: usize) -> Self {
        let (twins, edges, mut manifold) = twins(triangles, vertices);
        let mut used = vec![false; vertices];
        triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
        let count = used.iter().filter(|&&u| u).count();
        let euler = count as i64 - edges as i64 + triangles.len() as i64;

        // From a border half-edge, the next one starts where it ends: turn about that vertex.
        let next = |h: u32| h - h % 3 + (h % 3 + 1) % 3;
        let from = |h: u32| triangles[h as usize / 3][h as usize % 3];
        let mut loops = Vec::new();
        let mut done = vec![false; twins.len()];
        let mut passes = vec![0u8; vertices];
        for start in 0..twins.len() as u32 {
            if twins[start as usize].is_some() || done[start as usize] {
                continue;
            }
            let (mut ring, mut h) = (Vec::new(), start);
            while !done[h as usize] {
                done[h as usize] = true;
                ring.push(from(h));
                let pass = &mut passes[from(h) as usize];
                *pass = pass.saturating_add(1);
                h = next(h);
                while let Some(twin) = twins[h as usize] {
                    h = next(twin);
                }
            }
            loops.push(ring);
        }
        manifold &= passes.iter().all(|&p| p <= 1) && one_fan_each(triangles, &twins, vertices);
        Self { loops, euler, manifold, pieces: pieces(&twins) }
    }

    /// One component, one boundary loop, Euler characteristic 1, no pinch.
    pub fn is_disk(&self) -> bool {
        self.manifold && self.pieces == 1 && self.euler == 1 && self.loops.len() == 1
    }
}

/// Whether the triangles of a disk really form one.
pub fn is_disk(disk: &Disk) -> bool {
    Border::of(disk).is_disk()
}

/// The half-edge on the other side of each half-edge, how many edges there are, and whether all
/// are manifold and consistently wound.
fn twins(triangles: &[[u32; 3]], vertices: usize) -> (Vec<Option<u32>>, usize, bool) {
    let ends = |h: u32| {
        let (t, k) = (&triangles[h as usize / 3], h as usize % 3);
        (t[k], t[(k + 1) % 3])
    };
    let half_edges = 0..3 * triangles.len() as u32;
    // Edges by their lower vertex: those of v are `edges[starts[v]..starts[v + 1]]`, with the higher one.
    let mut starts = vec![0u32; vertices + 1];
    let lower = |h: u32| ends(h).0.min(ends(h).1) as usize;
    half_edges.clone().for_each(|h| starts[lower(h) + 1] += 1);
    (0..vertices).for_each(|v| starts[v + 1] += starts[v]);
    let (mut fill, mut edges) = (starts.clone(), vec![(0, 0); half_edges.len()]);
    for h in half_edges {
        let at = &mut fill[lower(h)];
        edges[*at as usize] = (ends(h).0.max(ends(h).1), h);
        *at += 1;
    }
    let mut twins = vec![None; edges.len()];
    let (mut count, mut manifold) = (0, true);
    for v in 0..vertices {
        let of_vertex = &mut edges[starts[v] as usize..starts[v + 1] as usize];
        of_vertex.sort_unstable();
        for run in of_vertex.chunk_by(|x, y| x.0 == y.0) {
            count += 1;
            match run {
                [one] => manifold &= one.0 as usize != v,
                [one, two] if ends(one.1).0 != ends(two.1).0 => {
                    twins[one.1 as usize] = Some(two.1);
                    twins[two.1 as usize] = Some(one.1);
                }
                _ => manifold = false,
            }
        }
    }
    (twins, count, manifold)
}

/// How many components the triangles make when joined at twin half-edges.
fn pieces(twins: &[Option<u32>]) -> usize {
    let mut seen = vec![false; twins.len() / 3];
    let (mut count, mut stack) = (0, Vec::new());
    for f in 0..seen.len() {
        if !seen[f] {
            seen[f] = true;
            count += 1;
            stack.push(f);
        }
        while let Some(f) = stack.pop() {
            for g in twins[3 * f..3 * f + 3].iter().flatten().map(|&h| h as usize / 3) {
                if !seen[g] {
                    seen[g] = true;
                    stack.push(g);
                }
            }
        }
    }
    count
}

/// Whether the triangles around each vertex form one fan.
fn one_fan_each(triangles: &[[u32; 3]], twins: &[Option<u32>], vertices: usize) -> bool {
    let mut corners = vec![0u32; vertices];
    triangles.iter().flatten().for_each(|&v| corners[v as usize] += 1);
    let mut seen = vec![false; vertices];
    let before = |h: u32| h - h % 3 + (h % 3 + 2) % 3;
    for h in 0..twins.len() as u32 {
        let v = triangles[h as usize / 3][h as usize % 3] as usize;
        // Start at the fan's clockwise end where it has one, or anywhere in a closed fan.
        let open = twins[h as usize].is_none();
        if seen[v] || (!open && has_open_end(h, twins)) {
            continue;
        }
        seen[v] = true;
        let (mut count, mut g) = (1, before(h));
        while let Some(twin) = twins[g as usize] {
            if twin == h {
                break;
            }
            count += 1;
            if count > corners[v] {
                return false;
            }
            g = before(twin);
        }
        if count != corners[v] {
            return false;
        }
    }
    true
}

/// Whether turning clockwise about the first vertex of `h` ends at a border.
fn has_open_end(h: u32, twins: &[Option<u32>]) -> bool {
    let next = |h: u32| h - h % 3 + (h % 3 + 1) % 3;
    let mut g = h;
    for _ in 0..twins.len() {
        match twins[g as usize] {
            None => return true,
            Some(twin) => g = next(twin),
        }
        if g == h {
            return false;
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::samples;

    #[test]
    fn a_grid_is_a_disk_with_its_rim_as_loop() {
        let (disk, _) = samples::plane(4, 3, 1.0, 1.0);
        let border = Border::of(&disk);
        assert!(border.is_disk());
        assert_eq!(border.loops[0].len(), 2 * (4 + 3));
    }

    #[test]
    fn an_open_tube_is_an_annulus() {
        // A ring of six quads.
        let ring = |i: u32| (i % 6, i % 6 + 6);
        let mut triangles = Vec::new();
        for i in 0..6 {
            let ((a, d), (b, c)) = (ring(i), ring(i + 1));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        let border = Border::of_triangles(&triangles, 12);
        assert_eq!((border.loops.len(), border.euler, border.manifold), (2, 0, true));
        assert!(!border.is_disk());
    }

    #[test]
    fn pinches_and_bad_edges_are_seen() {
        let pinch = [[0, 1, 2], [0, 3, 4]];
        assert!(!Border::of_triangles(&pinch, 5).manifold);
        let fin = [[0, 1, 2], [1, 0, 3], [1, 0, 4]];
        assert!(!Border::of_triangles(&fin, 5).manifold);
        let twisted = [[0, 1, 2], [0, 1, 3]];
        assert!(!Border::of_triangles(&twisted, 4).manifold);
        // Two closed fans at vertex 0: two tetrahedra that touch.
        let tetra = |b: [u32; 4]| {
            [[b[0], b[1], b[2]], [b[0], b[2], b[3]], [b[0], b[3], b[1]], [b[1], b[3], b[2]]]
        };
        let two = [tetra([0, 1, 2, 3]), tetra([0, 4, 5, 6])].concat();
        assert!(!Border::of_triangles(&two, 7).manifold);
        assert!(Border::of_triangles(&tetra([0, 1, 2, 3]), 4).manifold);
        assert!(Border::of_triangles(&[[0, 1, 2]], 3).is_disk());
    }
}
