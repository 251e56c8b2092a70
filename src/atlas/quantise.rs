//! Final coordinates in single precision, without losing a triangle. They are put on the lattice of
//! multiples of 2⁻²⁴: every such number in [0, 1] is a single-precision number, and so is 1 minus
//! it, so that export may turn v over without rounding again. A triangle that the lattice flips or
//! flattens is repaired by moving its corners by a few lattice steps.

use glam::{DVec2, I64Vec2};

use crate::flatten::{Disk, UvMap};
use crate::tasks;

/// The lattice that coordinates are put on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Grid {
    /// Multiples of 2⁻²⁴: exact in single precision within [0, 1].
    Page,
    /// Multiples of 2⁻²⁰: exact in single precision up to 16, for pages on tiles of their own.
    Tiles,
}

impl Grid {
    /// Steps across the page.
    fn steps(self) -> i64 {
        match self {
            Self::Page => 1 << 24,
            Self::Tiles => 1 << 20,
        }
    }

    /// The lattice step, page widths.
    pub fn step(self) -> f64 {
        1.0 / self.steps() as f64
    }
}

/// Least height of a triangle, lattice steps. A height of 1.2e-7 (2.01 steps) counts as none.
const HEIGHT: f64 = 2.2;

/// Where a corner may be moved to from where it was rounded to, in lattice steps: every place up to
/// this far …
const NEAR: i64 = 3;

/// … and places on rings of these radii, in so many directions.
const RINGS: [f64; 6] = [4.5, 6.0, 9.0, 12.0, 17.0, 24.0];
const DIRECTIONS: u32 = 24;

/// No corner ends up further than this from where it was, lattice steps, rounding included.
pub(super) const REACH: f64 = 26.0;

/// A face that falls short by more than the way all its corners could make up is beyond repair.
const BEYOND: f64 = 96.0;

/// Times that the faces of a chart are gone through.
const PASSES: usize = 12;

/// A triangle whose height in 3D is at most this share of the object's diagonal has no area there.
pub(super) const FLAT_3D: f64 = 1e-7;

/// Charts on the lattice.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Quantised {
    /// Coordinates in [0, 1], on the lattice.
    pub uvs: Vec<UvMap>,
    /// Vertices that were moved for the sake of a triangle.
    pub moved: u64,
    /// Triangles that are still flipped or without area: chart and face of its disk.
    pub lost: Vec<(u32, u32)>,
}

/// Whether a face of a disk has no area in 3D, at an object of the given diagonal.
pub(super) fn is_flat_3d(disk: &Disk, face: usize, diagonal: f64) -> bool {
    let [a, b, c] = disk.triangles[face].map(|v| disk.positions[v as usize]);
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    2.0 * disk.areas[face] <= FLAT_3D * diagonal * longest
}

/// Put charts (disk and coordinates in [0, 1]²) on the lattice. `diagonal` is the object's, world
/// units: faces without area in 3D need none in UV, but must not be flipped.
pub fn quantise(charts: &[(&Disk, &UvMap)], diagonal: f64, grid: Grid) -> Quantised {
    let one = |(disk, uv): (&Disk, &UvMap)| {
        let mut lattice = Lattice::new(disk, uv, diagonal, grid);
        let lost = lattice.repair();
        let uv: UvMap = lattice.points.iter().map(|p| p.as_dvec2() * grid.step()).collect();
        (lost, lattice.moved(), uv)
    };
    let size = |(disk, _): &(&Disk, &UvMap)| disk.triangles.len();
    let mut result = Quantised::default();
    let done = tasks::map_by_size("lattice", charts.to_vec(), size, one);
    for (chart, (lost, moved, uv)) in (0u32..).zip(done) {
        result.lost.extend(lost.into_iter().map(|f| (chart, f)));
        result.moved += moved;
        result.uvs.push(uv);
    }
    result
}

/// One chart in lattice steps.
struct Lattice<'a> {
    disk: &'a Disk,
    /// Steps across the page.
    steps: i64,
    points: Vec<I64Vec2>,
    snapped: Vec<I64Vec2>,
    /// Height that each face needs.
    needs: Vec<f64>,
}

impl<'a> Lattice<'a> {
    fn new(disk: &'a Disk, uv: &[DVec2], diagonal: f64, grid: Grid) -> Self {
        let snap =
            |p: &DVec2| (p.clamp(DVec2::ZERO, DVec2::ONE) / grid.step()).round().as_i64vec2();
        let points: Vec<I64Vec2> = uv.iter().map(snap).collect();
        let need = |f| if is_flat_3d(disk, f, diagonal) { 0.0 } else { HEIGHT };
        let needs = (0..disk.triangles.len()).map(need).collect();
        Self { disk, steps: grid.steps(), snapped: points.clone(), points, needs }
    }

    fn moved(&self) -> u64 {
        self.points.iter().zip(&self.snapped).filter(|(p, q)| p != q).count() as u64
    }

    /// By how many steps face `f` falls short of the height it needs; 0 when it is sound.
    fn shortfall(&self, f: u32) -> f64 {
        let [a, b, c] = self.disk.triangles[f as usize].map(|v| self.points[v as usize]);
        let (e, g) = (b - a, c - a);
        let double_area = e.x * g.y - e.y * g.x;
        let squared = |p: I64Vec2| (p.x * p.x + p.y * p.y) as f64;
        let longest = squared(e).max(squared(g)).max(squared(c - b)).sqrt();
        let need = self.needs[f as usize];
        if longest == 0.0 {
            return 2.0 * need;
        }
        // A face that has shrunk in both directions must grow in one before the other can count.
        (need - double_area as f64 / longest).max(0.0) + (need - longest).max(0.0)
    }

    /// Move corners until every face is sound; returns the faces that are not.
    fn repair(&mut self) -> Vec<u32> {
        let all = 0..self.disk.triangles.len() as u32;
        let mut bad: Vec<u32> = all.filter(|&f| self.shortfall(f) > 0.0).collect();
        if bad.is_empty() {
            return bad;
        }
        let (faces_at, stencil) = (self.faces_at(), stencil());
        for _ in 0..PASSES {
            let mut improved = false;
            for f in bad.clone() {
                if (f64::MIN_POSITIVE..BEYOND).contains(&self.shortfall(f)) {
                    improved |= self.mend(f, &faces_at, &stencil);
                }
            }
            // A move may trade one shortfall for a smaller one next door.
            let around = bad.iter().flat_map(|&f| self.disk.triangles[f as usize]);
            let mut near: Vec<u32> =
                around.flat_map(|v| faces_at[v as usize].iter().copied()).collect();
            near.sort_unstable();
            near.dedup();
            near.retain(|&f| self.shortfall(f) > 0.0);
            bad = near;
            if bad.is_empty() || !improved {
                break;
            }
        }
        bad
    }

    /// The best move of one corner of `face`: least shortfall of all faces around it, then least
    /// way. Returns whether one was made.
    fn mend(&mut self, face: u32, faces_at: &[Vec<u32>], stencil: &[I64Vec2]) -> bool {
        let mut best: Option<(f64, i64, usize, I64Vec2)> = None;
        for corner in self.disk.triangles[face as usize] {
            let v = corner as usize;
            let home = self.points[v];
            let sum =
                |lattice: &Self| faces_at[v].iter().map(|&f| lattice.shortfall(f)).sum::<f64>();
            let now = sum(self);
            for &step in stencil {
                let to = self.snapped[v] + step;
                if to.min_element() < 0 || to.max_element() > self.steps {
                    continue;
                }
                self.points[v] = to;
                let (left, way) = (sum(self) - now, step.length_squared());
                let better = best.is_none_or(|(l, w, ..)| (left, way) < (l, w));
                if left < 0.0 && better {
                    best = Some((left, way, v, to));
                }
            }
            self.points[v] = home;
        }
        let Some((_, _, v, to)) = best else { return false };
        self.points[v] = to;
        true
    }

    fn faces_at(&self) -> Vec<Vec<u32>> {
        let mut faces = vec![Vec::new(); self.points.len()];
        for (f, t) in self.disk.triangles.iter().enumerate() {
            t.iter().for_each(|&v| faces[v as usize].push(f as u32));
        }
        faces
    }
}

/// Where a corner may be moved to, relative to where it was rounded to.
fn stencil() -> Vec<I64Vec2> {
    let square = (-NEAR..=NEAR).flat_map(|y| (-NEAR..=NEAR).map(move |x| I64Vec2::new(x, y)));
    let turn = std::f64::consts::TAU / f64::from(DIRECTIONS);
    let rings = RINGS.iter().flat_map(|&radius| {
        (0..DIRECTIONS).map(move |k| DVec2::from_angle(turn * f64::from(k)) * radius)
    });
    square.chain(rings.map(|p| p.round().as_i64vec2())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::{orientation, samples};
    use proptest::prelude::*;

    fn sound(disk: &Disk, uv: &[DVec2], face: usize) -> bool {
        let t = disk.triangles[face].map(|v| uv[v as usize].as_vec2().as_dvec2());
        let longest = t[0].distance(t[1]).max(t[1].distance(t[2])).max(t[2].distance(t[0]));
        orientation(t) > 0 && (t[1] - t[0]).perp_dot(t[2] - t[0]) > 1.2e-7 * longest
    }

    proptest! {
        #[test]
        fn the_lattice_survives_export(x in 0.0..1.0f64) {
            let (disk, _) = samples::plane(1, 1, 1.0, 1.0);
            let uv = vec![DVec2::splat(x); 4];
            let p = quantise(&[(&disk, &uv)], 1.0, Grid::Page).uvs[0][0];
            prop_assert_eq!(f64::from(p.x as f32), p.x);
            let turned = 1.0f32 - p.x as f32;
            prop_assert_eq!(1.0 - f64::from(turned), p.x);
        }

        #[test]
        fn thin_grids_keep_all_their_triangles(
            thin in -7.8..-5.0f64, turn in 0.0..6.3f64, at in 0.2..0.8f64,
        ) {
            // Needles of a height around a lattice step, in every direction.
            let (disk, uv) = samples::plane(6, 1, 0.2, 10f64.powf(thin));
            let uv: UvMap = uv.iter().map(|&p| DVec2::from_angle(turn).rotate(p) + at).collect();
            let uv = uv.iter().map(|p| p.clamp(DVec2::splat(0.01), DVec2::splat(0.99))).collect();
            let result = quantise(&[(&disk, &uv)], 1e-3, Grid::Page);
            let lost: Vec<u32> = result.lost.iter().map(|l| l.1).collect();
            for f in 0..disk.triangles.len() {
                prop_assert_eq!(sound(&disk, &result.uvs[0], f), !lost.contains(&(f as u32)));
            }
            prop_assert!(lost.is_empty(), "{} lost", lost.len());
            let far = result.uvs[0].iter().zip(&uv).map(|(p, q): (&DVec2, &DVec2)| p.distance(*q));
            prop_assert!(far.fold(0.0, f64::max) < 40.0 * Grid::Page.step());
        }
    }

    #[test]
    fn tiles_are_exact_wherever_they_lie() {
        let (disk, uv) = samples::plane(20, 20, 0.9, 0.9);
        let result = quantise(&[(&disk, &uv)], 1.0, Grid::Tiles);
        assert!(result.lost.is_empty());
        for x in result.uvs[0].iter().flat_map(|p| p.to_array()) {
            for tile in 0..10 {
                let there = x + f64::from(tile);
                assert_eq!(f64::from(there as f32), there);
                // Export turns v over.
                assert_eq!(f64::from(1.0 - there as f32), 1.0 - there);
            }
        }
    }

    #[test]
    fn sound_charts_are_only_rounded() {
        let (disk, uv) = samples::plane(20, 20, 0.9, 0.9);
        let result = quantise(&[(&disk, &uv)], 1.0, Grid::Page);
        assert_eq!((result.moved, result.lost.len()), (0, 0));
        assert!(result.uvs[0].iter().zip(&uv).all(|(p, q)| p.distance(*q) < Grid::Page.step()));
    }

    #[test]
    fn a_chart_that_has_shrunk_to_a_point_is_grown_or_reported() {
        let (disk, uv) = samples::plane(1, 1, 1.0, 1.0);
        let tiny: UvMap = uv.iter().map(|p| 0.5 + p * 1e-9).collect();
        assert!(quantise(&[(&disk, &tiny)], 1.0, Grid::Page).lost.is_empty());
        let (disk, uv) = samples::plane(40, 40, 1.0, 1.0);
        let tiny: UvMap = uv.iter().map(|p| 0.5 + p * 1e-9).collect();
        assert!(!quantise(&[(&disk, &tiny)], 1.0, Grid::Page).lost.is_empty());
    }
}
