//! Sparse marching cubes: W. E. Lorensen and H. E. Cline, "Marching cubes: a high resolution 3D
//! surface construction algorithm", SIGGRAPH 1987, doi:10.1145/37401.37422. Their case table is not
//! used: it is made here from one rule a cube face, which leaves no cracks and no ambiguous edge. Only
//! blocks of cells near the surface are sampled.

use glam::{DVec3, I64Vec3, USizeVec3};
use rayon::prelude::*;

use super::field::Field;

/// Cells along a block.
const BLOCK: usize = 8;
/// Cells along a part of a block, which is passed over by itself.
const PART: usize = 2;
/// Samples along a block.
const SIDE: usize = BLOCK + 1;
/// What rounding may add to a distance, in spacings.
const MARGIN: f64 = 0.01;
/// A vertex keeps this share of its edge from both ends: no triangle collapses.
const CLEAR: f64 = 0.03;

/// The triangles of each case of signs. Bit `c` of a case: corner `c` is inside; bit `a` of a corner:
/// it is the upper one along axis `a`. Edge `4 a + n` is the `n`-th along axis `a`.
pub(super) struct Table {
    pub(super) cases: Vec<Vec<[u8; 3]>>,
    /// Lower corner and axis of each edge.
    pub(super) edges: [(usize, usize); 12],
}

impl Table {
    pub(super) fn new() -> Self {
        let corner = |a: usize, n: usize| (n & 1) << ((a + 1) % 3) | (n >> 1) << ((a + 2) % 3);
        let edges = std::array::from_fn(|e| (corner(e / 4, e % 4), e / 4));
        let between = |p: usize, q: usize| {
            let found = edges.iter().position(|&(c, a)| c == p & q && 1 << a == p ^ q);
            found.unwrap_or(0)
        };
        // Corners of the six faces, counter-clockwise from outside.
        let faces: [[usize; 4]; 6] = std::array::from_fn(|f| {
            let round = [0, 1, 3, 2].map(|n| corner(f / 2, n) | (f % 2) << (f / 2));
            if f % 2 == 1 { round } else { [round[3], round[2], round[1], round[0]] }
        });
        let on_one_face = |d: usize, e: usize| {
            let has = |f: &[usize; 4], (c, a): (usize, usize)| {
                f.contains(&c) && f.contains(&(c | 1 << a))
            };
            faces.iter().any(|f| has(f, edges[d]) && has(f, edges[e]))
        };
        let case = |signs: usize| {
            let inside = |c: usize| signs >> c & 1 == 1;
            // Each run of inside corners of a face is cut off by a segment of its own, from the edge
            // before the run to the one after it: the surface is then on the left, seen from outside.
            let mut next = [None; 12];
            for face in &faces {
                for first in (0..4).filter(|&k| inside(face[k]) && !inside(face[(k + 3) % 4])) {
                    let last = (first..).find(|&k| !inside(face[(k + 1) % 4])).unwrap_or(first);
                    let before = between(face[(first + 3) % 4], face[first]);
                    next[before] = Some(between(face[last % 4], face[(last + 1) % 4]));
                }
            }
            let mut triangles = vec![];
            for start in 0..12 {
                let mut round = vec![];
                let mut at = start;
                while let Some(to) = next[at].take() {
                    round.push(at as u8);
                    at = to;
                }
                let n = round.len();
                // A diagonal in a cube face could be the neighbour's too: an edge of four triangles.
                let fits = |apex: &usize| {
                    (2..n.saturating_sub(1)).all(|k| {
                        let other = round[(apex + k) % n];
                        !on_one_face(round[*apex].into(), other.into())
                    })
                };
                let apex = (0..n).find(fits).unwrap_or(0);
                let corner = |k: usize| round[(apex + k) % n];
                triangles.extend((2..n).map(|k| [corner(0), corner(k - 1), corner(k)]));
            }
            triangles
        };
        Self { cases: (0..256).map(case).collect(), edges }
    }
}

/// A grid over a body.
pub(super) struct Grid<'a> {
    field: &'a Field,
    table: &'a Table,
    spacing: f64,
    low: DVec3,
    /// Lower corners of the blocks near the surface, in blocks.
    blocks: Vec<I64Vec3>,
}

/// What a block gives: its vertices, each with the key of its edge, and triangles of them.
type Piece = (Vec<(u64, DVec3)>, Vec<[u32; 3]>);

impl<'a> Grid<'a> {
    pub(super) fn new(field: &'a Field, table: &'a Table, spacing: f64) -> Self {
        // Off the planes of symmetry, where samples would be exactly nought.
        let low = field.low - spacing * DVec3::new(1.414, 1.618, 1.732);
        let extent = (field.high - low).max_element() / spacing + 2.0;
        let mut size = (extent / BLOCK as f64).ceil().max(1.0) as i64;
        size = (size as u64).next_power_of_two() as i64;
        let mut blocks = vec![I64Vec3::ZERO];
        // Eight times as many, eight times as small, as long as the surface may pass.
        while size > 1 {
            size /= 2;
            let cells = size as usize * BLOCK;
            let near = |at: &I64Vec3| {
                let middle = (*at * BLOCK as i64).as_dvec3() + DVec3::splat(0.5 * cells as f64);
                field.distance(low + middle * spacing).abs() <= reach(cells, spacing)
            };
            let children = |at: &I64Vec3| {
                let at = *at;
                (0..8).map(move |c| at + size * I64Vec3::new(c & 1, c >> 1 & 1, c >> 2))
            };
            blocks = blocks.par_iter().flat_map_iter(|at| children(at).filter(near)).collect();
        }
        Self { field, table, spacing, low, blocks }
    }

    /// How many triangles [`Self::surface`] gives.
    pub(super) fn count(&self) -> usize {
        let in_block = |at: &I64Vec3| {
            let values = self.values(*at);
            lattice(BLOCK).map(|c| self.table.cases[case(&values, c)].len()).sum::<usize>()
        };
        self.blocks.par_iter().map(in_block).sum()
    }

    /// The surface, wound outwards. Vertices stand in the order of their edges.
    pub(super) fn surface(&self) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let pieces: Vec<Piece> = self.blocks.par_iter().map(|at| self.piece(*at)).collect();
        let mut vertices: Vec<(u64, DVec3)> =
            pieces.par_iter().flat_map_iter(|p| p.0.iter().copied()).collect();
        // Blocks that share an edge agree on its vertex to the last bit.
        vertices.par_sort_unstable_by_key(|v| v.0);
        vertices.dedup_by_key(|v| v.0);
        let triangles = pieces
            .par_iter()
            .flat_map_iter(|(own, triangles)| {
                let number = |v: &(u64, DVec3)| vertices.partition_point(|w| w.0 < v.0) as u32;
                let numbers: Vec<u32> = own.iter().map(number).collect();
                triangles.iter().map(move |t| t.map(|v| numbers[v as usize]))
            })
            .collect();
        (vertices.into_iter().map(|v| v.1).collect(), triangles)
    }

    fn sample(&self, at: I64Vec3) -> DVec3 {
        self.low + at.as_dvec3() * self.spacing
    }

    /// The samples of a block, x fastest. Where the surface does not pass, only their sign is right.
    fn values(&self, block: I64Vec3) -> Vec<f64> {
        let base = block * BLOCK as i64;
        let middle = |at: I64Vec3, cells: usize| {
            self.sample(base + at) + DVec3::splat(0.5 * cells as f64 * self.spacing)
        };
        let field = self.field.near(middle(I64Vec3::ZERO, BLOCK), reach(BLOCK, self.spacing));
        let mut values = vec![f64::NAN; SIDE * SIDE * SIDE];
        let mut empty = vec![];
        for from in lattice(BLOCK / PART).map(|at| at * PART) {
            let d = field.distance(middle(from.as_i64vec3(), PART));
            if d.abs() > reach(PART, self.spacing) {
                empty.push((from, d));
                continue;
            }
            for at in lattice(PART + 1).map(|at| from + at) {
                let value = &mut values[index(at)];
                if value.is_nan() {
                    *value = field.distance(self.sample(base + at.as_i64vec3()));
                }
            }
        }
        for (from, d) in empty {
            for at in lattice(PART + 1).map(|at| from + at) {
                let value = &mut values[index(at)];
                if value.is_nan() {
                    *value = d;
                }
            }
        }
        values
    }

    fn piece(&self, block: I64Vec3) -> Piece {
        let values = self.values(block);
        let base = block * BLOCK as i64;
        let mut numbers = vec![u32::MAX; 3 * values.len()];
        let (mut vertices, mut triangles) = (vec![], vec![]);
        for cell in lattice(BLOCK) {
            for t in &self.table.cases[case(&values, cell)] {
                triangles.push(t.map(|e| {
                    let (corner, axis) = self.table.edges[e as usize];
                    let from = cell + offset(corner);
                    let (i, j) = (index(from), index(from + offset(1 << axis)));
                    let number = &mut numbers[3 * i + axis];
                    if *number == u32::MAX {
                        *number = vertices.len() as u32;
                        let t = (values[i] / (values[i] - values[j])).clamp(CLEAR, 1.0 - CLEAR);
                        let at = base + from.as_i64vec3();
                        let mut place = self.sample(at);
                        place[axis] += t * self.spacing;
                        // 20 bits a coordinate, two for the axis.
                        let [x, y, z] = at.to_array().map(|c| c as u64);
                        vertices.push((((z << 20 | y) << 20 | x) << 2 | axis as u64, place));
                    }
                    *number
                }));
            }
        }
        (vertices, triangles)
    }
}

/// From the middle of a cube of cells to its corners, and a little more.
fn reach(cells: usize, spacing: f64) -> f64 {
    (0.5 * 3f64.sqrt() * cells as f64 + MARGIN) * spacing
}

/// The points of a cube of `n` a side, x fastest.
fn lattice(n: usize) -> impl Iterator<Item = USizeVec3> {
    (0..n).flat_map(move |z| (0..n).flat_map(move |y| (0..n).map(move |x| USizeVec3::new(x, y, z))))
}

fn offset(corner: usize) -> USizeVec3 {
    USizeVec3::new(corner & 1, corner >> 1 & 1, corner >> 2 & 1)
}

fn index(at: USizeVec3) -> usize {
    (at.z * SIDE + at.y) * SIDE + at.x
}

fn case(values: &[f64], cell: USizeVec3) -> usize {
    let i = index(cell);
    (0..8).filter(|&c| values[i + index(offset(c))] < 0.0).map(|c| 1 << c).sum()
}
