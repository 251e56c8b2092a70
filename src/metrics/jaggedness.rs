//! How jagged the seams are: the length of each seam curve over that of the same curve after a moving average.
//! A curve runs between two junctions, or is closed. A zigzag along the edges of the mesh costs length that a
//! straight seam at the same place would not; a bend that is wide against the window costs nothing.

use glam::DVec3;

use super::edges::same;
use super::statistics::{CAP, weighted_mean};
use super::{Measured, places};
use crate::mesh::NONE;

/// Width of the moving average, mean edges of the mesh.
const WINDOW: f64 = 7.0;
/// The same, for steps that are longer than a few edges.
const WIDE_WINDOW: f64 = 15.0;
/// Points of the resampled curve a mean edge.
const DENSITY: f64 = 2.0;
/// Fewest segments of a resampled curve: an open one has a point between its ends, and a closed one is still a
/// hexagon after an average over a third of it.
const LEAST: [usize; 2] = [2, 6];

/// How jagged the seams are: means over seam curves, weighted by length. 1 is straight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jaggedness {
    /// Against a moving average over 7 mean edges.
    pub near: f64,
    /// Against one over 15.
    pub wide: f64,
}

/// Takes both figures; `None` where there is no seam. A seam is between two twins, so that the border of the
/// mesh is none. Linear in the faces, but for sorting the seams.
pub fn seam_jaggedness(input: &Measured) -> Option<Jaggedness> {
    let surface = input.surface;
    let counted: Vec<bool> =
        (0..surface.face_count()).map(|f| input.face_map(f).is_some()).collect();
    let place = places(surface);
    let (mut edges, mut whole, mut seams) = (0u64, 0.0, vec![]);
    for (h, &t) in (0u32..).zip(&surface.twin).filter(|(h, _)| counted[*h as usize / 3]) {
        let joined = t != NONE && counted[t as usize / 3];
        if joined && t < h {
            continue;
        }
        edges += 1;
        whole += surface.length(h);
        let (a, b) = (place[surface.from(h) as usize], place[surface.to(h) as usize]);
        if joined && a != b && is_seam(input, h, t) {
            seams.push([a.min(b), a.max(b)]);
        }
    }
    // The two sheets of a double-sided object may be cut at one place: that is one curve.
    seams.sort_unstable();
    seams.dedup();
    let mean_edge = whole / edges as f64;
    let position = |&v: &u32| surface.positions[v as usize];
    let lines: Vec<Line> = curves(&seams)
        .iter()
        .map(|curve| Line::new(curve.places.iter().map(position).collect(), curve.closed))
        .filter(|line| line.length > 0.0)
        .collect();
    let mean = |window: f64| {
        weighted_mean(lines.iter().map(|l| (l.jaggedness(mean_edge, window), l.length)))
    };
    Some(Jaggedness { near: mean(WINDOW)?, wide: mean(WIDE_WINDOW)? })
}

/// Whether two twins are in different charts or have different coordinates.
fn is_seam(input: &Measured, h: u32, t: u32) -> bool {
    let ends = |h: u32| {
        let (uv, k) = (&input.uvs[h as usize / 3], h as usize % 3);
        [uv[k], uv[(k + 1) % 3]]
    };
    let [to, from] = ends(t);
    input.chart_of[h as usize / 3] != input.chart_of[t as usize / 3] || !same(&ends(h), &[from, to])
}

/// Seam edges in a row. A closed one has its first place at both ends.
struct Curve {
    places: Vec<u32>,
    closed: bool,
}

/// Takes the graph of the seam edges apart at every place that has not two of them; what is left is closed.
fn curves(seams: &[[u32; 2]]) -> Vec<Curve> {
    let mut ends: Vec<(u32, u32)> =
        (0u32..).zip(seams).flat_map(|(e, &[a, b])| [(a, e), (b, e)]).collect();
    ends.sort_unstable();
    let mut used = vec![false; seams.len()];
    let mut curves = vec![];
    for around in ends.chunk_by(|a, b| a.0 == b.0).filter(|around| around.len() != 2) {
        for &(start, edge) in around {
            if !used[edge as usize] {
                let places = walk(seams, &ends, start, edge, &mut used);
                curves.push(Curve { places, closed: false });
            }
        }
    }
    for (edge, &[start, _]) in (0u32..).zip(seams) {
        if !used[edge as usize] {
            let places = walk(seams, &ends, start, edge, &mut used);
            curves.push(Curve { places, closed: true });
        }
    }
    curves
}

/// The places from `start` along `edge` to the next junction, or back to `start`. `ends` are the ends of the
/// edges, each a place and an edge, sorted.
fn walk(
    seams: &[[u32; 2]],
    ends: &[(u32, u32)],
    start: u32,
    mut edge: u32,
    used: &mut [bool],
) -> Vec<u32> {
    let (mut places, mut at) = (vec![start], start);
    while !used[edge as usize] {
        used[edge as usize] = true;
        let [a, b] = seams[edge as usize];
        at = if a == at { b } else { a };
        places.push(at);
        let around = &ends[ends.partition_point(|end| end.0 < at)..];
        // One edge goes on where two meet.
        match around {
            [(_, x), (v, y), rest @ ..] if *v == at && rest.first().is_none_or(|r| r.0 != at) => {
                edge = if *x == edge { *y } else { *x };
            }
            _ => break,
        }
    }
    places
}

/// A curve in space. A closed one has its first point at both ends.
struct Line {
    points: Vec<DVec3>,
    closed: bool,
    length: f64,
}

impl Line {
    fn new(points: Vec<DVec3>, closed: bool) -> Self {
        let length = length(&points);
        Self { points, closed, length }
    }

    /// Its length over that of its moving average, capped. `edge` is the mean edge of the mesh, and `window` so
    /// many of them: of a closed curve at most a third, since an average over all of it is a point. The ends of
    /// an open curve stay, and next to them the window is as wide as it can be about its middle.
    fn jaggedness(&self, edge: f64, window: f64) -> f64 {
        let least = LEAST[usize::from(self.closed)];
        let count = ((DENSITY * self.length / edge).round() as usize).max(least);
        let samples = self.resampled(count);
        let width = window * edge;
        let width = if self.closed { width.min(self.length / 3.0) } else { width };
        let reach = (0.5 * width * count as f64 / self.length).round() as usize;
        // The last sample has the number `count`: that of a closed curve is its first.
        let sample = |i: usize| samples[if self.closed { i % count } else { i }];
        let average = |i: usize| {
            if self.closed {
                // Once around, so that no number is below 0.
                return mean_about(i + count, reach, sample);
            }
            mean_about(i, reach.min(i).min(count - i), sample)
        };
        let smooth: Vec<DVec3> = (0..=count).map(average).collect();
        (self.length / length(&smooth)).min(CAP)
    }

    /// `count` + 1 points at equal distances along it, both ends among them.
    fn resampled(&self, count: usize) -> Vec<DVec3> {
        let (mut segment, mut before) = (0, 0.0);
        let step = self.length / count as f64;
        (0..=count)
            .map(|i| {
                let at = step * i as f64;
                loop {
                    let (a, b) = (self.points[segment], self.points[segment + 1]);
                    let own = a.distance(b);
                    // Rounding must not lead beyond the last segment.
                    if before + own >= at || segment + 2 == self.points.len() {
                        let share = if own > 0.0 { (at - before) / own } else { 0.0 };
                        return a.lerp(b, share.clamp(0.0, 1.0));
                    }
                    before += own;
                    segment += 1;
                }
            })
            .collect()
    }
}

/// Mean of a curve from `reach` samples before sample `i` to as many behind it (trapezoidal rule).
fn mean_about(i: usize, reach: usize, sample: impl Fn(usize) -> DVec3) -> DVec3 {
    if reach == 0 {
        return sample(i);
    }
    let ends = 0.5 * (sample(i - reach) + sample(i + reach));
    let inner = (i - reach + 1..i + reach).fold(ends, |sum, j| sum + sample(j));
    inner / (2 * reach) as f64
}

/// Length of a polyline.
fn length(points: &[DVec3]) -> f64 {
    points.windows(2).fold(0.0, |sum, p| sum + p[0].distance(p[1]))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{SQRT_2, TAU};

    use super::*;
    use crate::metrics::fixtures::{grid, measured, uvs};

    fn open(points: impl Iterator<Item = (f64, f64)>) -> Line {
        Line::new(points.map(|(x, y)| DVec3::new(x, y, 0.0)).collect(), false)
    }

    #[track_caller]
    fn near(a: f64, b: f64, tolerance: f64) {
        assert!((a - b).abs() <= tolerance, "{a} is not {b}");
    }

    /// A flat square of `n` × `n` cells of length 1, whose cells `(i, j)` are in these charts.
    fn of_cells(n: u32, chart: impl Fn(u32, u32) -> u32) -> Option<Jaggedness> {
        let side = f64::from(n);
        let (surface, parameters) = grid(n, n, |x, y| DVec3::new(side * x, side * y, 0.0));
        let charts: Vec<u32> = (0..2 * n * n).map(|f| chart(f / 2 / n, f / 2 % n)).collect();
        let parts = vec![0; charts.len()];
        // In different charts the same coordinates are a seam, too.
        let uv = uvs(&parameters, |p| p);
        seam_jaggedness(&measured(&surface, &uv, &charts, &parts))
    }

    #[test]
    fn a_straight_line_is_not_jagged_however_short_it_is() {
        for edges in [1, 2, 3, 10, 100] {
            let line = open((0..=edges).map(|i| (f64::from(i), 0.5 * f64::from(i))));
            for edge in [0.1, 1.0, 7.0] {
                near(line.jaggedness(edge, WINDOW), 1.0, 1e-12);
                near(line.jaggedness(edge, WIDE_WINDOW), 1.0, 1e-12);
            }
        }
    }

    #[test]
    fn a_zigzag_of_unit_steps_is_as_long_as_it_is_against_its_chord() {
        // One at 45° to its chord, and one along the edges of a grid.
        for line in [
            open((0..=100).map(|i| (f64::from(i), f64::from(i % 2)))),
            open((0..=100).map(|i| (f64::from((i + 1) / 2), f64::from(i / 2)))),
        ] {
            near(line.jaggedness(1.0, WINDOW), SQRT_2, 0.05);
            near(line.jaggedness(1.0, WIDE_WINDOW), SQRT_2, 0.05);
        }
    }

    #[test]
    fn longer_steps_are_seen_by_the_wider_window() {
        // Steps of 8 edges.
        let step = |i: i32| {
            let (whole, rest) = (8 * (i / 16), i % 16);
            (f64::from(whole + rest.min(8)), f64::from(whole + (rest - 8).max(0)))
        };
        let line = open((0..=320).map(step));
        let [usual, wide] = [WINDOW, WIDE_WINDOW].map(|w| line.jaggedness(1.0, w));
        assert!(usual > 1.1 && wide > usual + 0.05 && wide < SQRT_2 + 0.01, "{usual} {wide}");
    }

    #[test]
    fn a_circle_is_hardly_jagged_and_a_small_one_still_has_a_figure() {
        let circle = |edges: u32| {
            let on = |i: u32| {
                let (sin, cos) = (TAU * f64::from(i) / f64::from(edges)).sin_cos();
                DVec3::new(cos, sin, 0.0)
            };
            Line::new((0..=edges).map(on).collect(), true)
        };
        let edge = |n: u32| 2.0 * (0.5 * TAU / f64::from(n)).sin();
        near(circle(100).jaggedness(edge(100), WINDOW), 1.0, 0.02);
        near(circle(300).jaggedness(edge(300), WIDE_WINDOW), 1.0, 0.02);
        for edges in [3, 4, 12] {
            let small = circle(edges).jaggedness(edge(edges), WINDOW);
            assert!((1.0..1.6).contains(&small), "{small}");
        }
    }

    #[test]
    fn a_seam_along_a_grid_line_is_straight_and_stairs_are_not() {
        let straight = of_cells(24, |i, _| u32::from(i >= 12)).unwrap();
        near(straight.near, 1.0, 1e-9);
        near(straight.wide, 1.0, 1e-9);
        let stairs = of_cells(24, |i, j| u32::from(i > j)).unwrap();
        near(stairs.near, SQRT_2, 0.05);
        // Four straight seams that meet in one junction.
        let cross = of_cells(8, |i, j| 2 * (i / 4) + j / 4).unwrap();
        near(cross.near, 1.0, 1e-9);
        // The border of the mesh is no seam.
        assert_eq!(of_cells(4, |_, _| 0), None);
        assert_eq!(of_cells(4, |_, _| NONE), None);
    }

    /// A cylinder of 128 × 8 cells, laid out by `place`; the first half of its height is chart 0.
    fn of_cylinder(charts: u32, place: impl Fn([f64; 2]) -> [f64; 2]) -> Jaggedness {
        let (around, along) = (128, 8);
        let (surface, parameters) = grid(around, along, |x, y| {
            let (sin, cos) = (TAU * x).sin_cos();
            DVec3::new(cos, sin, TAU / f64::from(around) * f64::from(along) * y)
        });
        let chart = |f: u32| charts * (f / 2 % along) / along;
        let chart_of: Vec<u32> = (0..2 * around * along).map(chart).collect();
        let uv = uvs(&parameters, place);
        let parts = vec![0; uv.len()];
        seam_jaggedness(&measured(&surface, &uv, &chart_of, &parts)).unwrap()
    }

    #[test]
    fn a_cut_within_a_chart_and_a_closed_seam_are_curves() {
        // Unrolled: one straight cut.
        near(of_cylinder(1, |p| p).near, 1.0, 1e-9);
        // Two rings that are laid out as rings meet in a closed circle.
        let ring = |[u, v]: [f64; 2]| {
            let (sin, cos) = (TAU * u).sin_cos();
            [0.5 + 0.2 * (1.0 + v) * cos, 0.5 + 0.2 * (1.0 + v) * sin]
        };
        let circle = of_cylinder(2, ring);
        near(circle.near, 1.0, 0.02);
        assert!(circle.near > 1.001, "an average lies within the circle: {circle:?}");
    }

    #[test]
    fn curves_end_at_junctions_and_loops_are_closed() {
        // A loop of three, a path of two edges, and a loop that hangs from a third edge.
        let seams = [[0, 1], [0, 2], [1, 2], [3, 4], [4, 5], [6, 7], [7, 8], [7, 9], [8, 9]];
        let found = curves(&seams);
        let told: Vec<(Vec<u32>, bool)> = found.into_iter().map(|c| (c.places, c.closed)).collect();
        let open = [vec![3, 4, 5], vec![6, 7], vec![7, 8, 9, 7]].map(|places| (places, false));
        assert_eq!(told[..3], open);
        assert_eq!(told[3..], [(vec![0, 1, 2, 0], true)]);
    }
}
