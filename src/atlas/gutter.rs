//! The least distance between charts, exactly (in double precision): each border segment is
//! compared with the segments of other charts in the cells of a grid, ring by ring outwards until
//! no nearer one can be left.

use glam::DVec2;

use crate::tasks;

/// A border segment of a chart.
type Segment = [DVec2; 2];

/// Cells along each side of the grid, at most.
const CELLS: f64 = 1024.0;

/// For each chart the least distance from its border to the border of any other chart on the same
/// page; `None` where it is alone on its page. Charts are given by their page and their border
/// segments in [0, 1]²; distances are in page widths. Charts that cross have distance 0.
pub fn gutters(charts: &[(u32, Vec<Segment>)]) -> Vec<Option<f64>> {
    let mut result = vec![None; charts.len()];
    let pages = charts.iter().map(|c| c.0 + 1).max().unwrap_or(0);
    for page in 0..pages {
        let here: Vec<usize> = (0..charts.len()).filter(|&c| charts[c].0 == page).collect();
        if here.len() < 2 {
            continue;
        }
        let finite = |s: &Segment| s[0].is_finite() && s[1].is_finite();
        let segments: Vec<(u32, Segment)> = here
            .iter()
            .flat_map(|&c| charts[c].1.iter().filter(|s| finite(s)).map(move |&s| (c as u32, s)))
            .collect();
        let grid = SegmentGrid::new(&segments);
        // Those of a chart in a row: what it has found bounds what is looked at for the next.
        let own: Vec<&[(u32, Segment)]> = segments.chunk_by(|a, b| a.0 == b.0).collect();
        let nearest = |own: &[(u32, Segment)]| {
            let start = f64::INFINITY;
            let next = |bound, (chart, s): &(u32, Segment)| grid.nearest(*chart, s, bound);
            (own[0].0 as usize, own.iter().fold(start, next))
        };
        for (c, distance) in tasks::map_by_size("gutter", own, |own| own.len(), nearest) {
            result[c] = distance.is_finite().then_some(distance);
        }
    }
    result
}

/// Segments by the square cells that they pass through.
struct SegmentGrid<'a> {
    segments: &'a [(u32, Segment)],
    low: DVec2,
    cell: f64,
    columns: usize,
    rows: usize,
    starts: Vec<usize>,
    items: Vec<u32>,
}

impl<'a> SegmentGrid<'a> {
    fn new(segments: &'a [(u32, Segment)]) -> Self {
        let ends = || segments.iter().flat_map(|(_, s)| s);
        let low = ends().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = ends().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        let extent = (high - low).max_element();
        let across = (segments.len() as f64).sqrt().clamp(1.0, CELLS);
        let cell = if extent > 0.0 { extent / across } else { 1.0 };
        let count = |length: f64| if length > 0.0 { (length / cell) as usize + 1 } else { 1 };
        let (columns, rows) = (count(high.x - low.x), count(high.y - low.y));
        let mut grid =
            Self { segments, low, cell, columns, rows, starts: Vec::new(), items: Vec::new() };
        let mut entries = Vec::new();
        for (i, (_, segment)) in segments.iter().enumerate() {
            grid.pieces(segment).for_each(|[a, b]| {
                for row in a.1..=b.1 {
                    for column in a.0..=b.0 {
                        entries.push((row * columns + column, i as u32));
                    }
                }
            });
        }
        entries.sort_unstable();
        entries.dedup();
        let mut starts = vec![0; columns * rows + 1];
        entries.iter().for_each(|&(cell, _)| starts[cell + 1] += 1);
        for cell in 0..columns * rows {
            starts[cell + 1] += starts[cell];
        }
        grid.starts = starts;
        grid.items = entries.into_iter().map(|(_, i)| i).collect();
        grid
    }

    fn at(&self, p: DVec2) -> (usize, usize) {
        let p = (p - self.low) / self.cell;
        ((p.x as usize).min(self.columns - 1), (p.y as usize).min(self.rows - 1))
    }

    /// A segment in pieces no longer than a cell, each as the cells of its box: lower left and
    /// upper right.
    fn pieces(&self, &[a, b]: &Segment) -> impl Iterator<Item = [(usize, usize); 2]> {
        let count = (a.distance(b) / self.cell).ceil().max(1.0) as usize;
        (0..count).map(move |k| {
            let p = a.lerp(b, k as f64 / count as f64);
            let q = a.lerp(b, (k + 1) as f64 / count as f64);
            [self.at(p.min(q)), self.at(p.max(q))]
        })
    }

    /// Distance from a segment of `chart` to the nearest segment of another chart, or `bound` where
    /// none is nearer.
    fn nearest(&self, chart: u32, segment: &Segment, bound: f64) -> f64 {
        let mut best = bound;
        for [low, high] in self.pieces(segment) {
            for ring in 0..self.columns.max(self.rows) {
                // What stands `ring` cells away is farther than the cells between (with a cell to
                // spare for rounding).
                if (ring as f64 - 2.0) * self.cell > best {
                    break;
                }
                let left = low.0.checked_sub(ring);
                let down = low.1.checked_sub(ring);
                let (right, up) = (high.0 + ring, high.1 + ring);
                for row in down.unwrap_or(0)..=up.min(self.rows - 1) {
                    let whole = ring == 0 || Some(row) == down || row == up;
                    let span = left.unwrap_or(0)..=right.min(self.columns - 1);
                    let edges = [left, Some(right).filter(|&r| r < self.columns)];
                    let inner = if whole { None } else { Some(edges.into_iter().flatten()) };
                    let cells: &mut dyn Iterator<Item = usize> = match inner {
                        None => &mut span.into_iter(),
                        Some(edges) => &mut edges.into_iter(),
                    };
                    for column in cells {
                        best = self.nearest_in(row * self.columns + column, chart, segment, best);
                    }
                }
            }
        }
        best
    }

    fn nearest_in(&self, cell: usize, chart: u32, segment: &Segment, mut best: f64) -> f64 {
        for &i in &self.items[self.starts[cell]..self.starts[cell + 1]] {
            let (other, against) = &self.segments[i as usize];
            if *other != chart {
                best = best.min(segment_distance(segment, against));
            }
        }
        best
    }
}

/// Distance between two closed segments; 0 where they cross.
fn segment_distance(&[a, b]: &Segment, &[c, d]: &Segment) -> f64 {
    let side = |p: DVec2, q: DVec2, r: DVec2| (q - p).perp_dot(r - p);
    if side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0 {
        return 0.0;
    }
    let point = |p: DVec2, q: DVec2, r: DVec2| {
        let along = r - q;
        let length = along.length_squared();
        let t = if length > 0.0 { ((p - q).dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
        p.distance(q + along * t)
    };
    point(a, c, d).min(point(b, c, d)).min(point(c, a, b)).min(point(d, a, b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn ring(points: &[DVec2]) -> Vec<Segment> {
        (0..points.len()).map(|k| [points[k], points[(k + 1) % points.len()]]).collect()
    }

    fn square(x: f64, y: f64, side: f64) -> Vec<Segment> {
        ring(
            &[(0., 0.), (1., 0.), (1., 1.), (0., 1.)]
                .map(|(a, b)| DVec2::new(x + a * side, y + b * side)),
        )
    }

    #[test]
    fn distances_between_squares_are_exact() {
        let charts = [
            (0, square(0.0, 0.0, 0.4)),
            (0, square(0.4 + 5.0 / 1024.0, 0.1, 0.3)),
            (1, square(0.0, 0.0, 1.0)),
        ];
        let found = gutters(&charts);
        assert!((found[0].unwrap() * 1024.0 - 5.0).abs() < 1e-9);
        assert_eq!(found[0], found[1]);
        assert_eq!(found[2], None);
        // Corner to corner.
        let diagonal = gutters(&[(0, square(0.0, 0.0, 0.1)), (0, square(0.4, 0.5, 0.1))]);
        assert!((diagonal[0].unwrap() - 0.5).abs() < 1e-12);
    }

    #[test]
    fn charts_that_cross_or_touch_have_no_gutter() {
        assert_eq!(
            gutters(&[(0, square(0.0, 0.0, 0.5)), (0, square(0.3, 0.3, 0.5))])[1],
            Some(0.0)
        );
        assert_eq!(
            gutters(&[(0, square(0.0, 0.0, 0.5)), (0, square(0.5, 0.5, 0.5))])[0],
            Some(0.0)
        );
    }

    #[test]
    fn a_segment_is_cut_into_pieces_of_a_cell() {
        let all: Vec<(u32, Segment)> = (0..64)
            .flat_map(|i| square(0.1 * f64::from(i % 8), 0.0, 1.0))
            .map(|s| (0, s))
            .collect();
        let grid = SegmentGrid::new(&all);
        let segment = [DVec2::new(0.02, 0.9), DVec2::new(1.6, 0.03)];
        let pieces: Vec<_> = grid.pieces(&segment).collect();
        let length = segment[0].distance(segment[1]) / grid.cell;
        assert!(length > 10.0);
        assert_eq!(pieces.len(), length.ceil() as usize);
        // Each box is two cells wide at most, and they lead from one end to the other.
        for [low, high] in &pieces {
            assert!(low.0 <= high.0 && high.0 - low.0 <= 1, "{low:?} {high:?}");
            assert!(low.1 <= high.1 && high.1 - low.1 <= 1, "{low:?} {high:?}");
        }
        let (first, last) = (grid.at(segment[0]), grid.at(segment[1]));
        assert_eq!((pieces[0][0].0, pieces[0][1].1), first);
        let end = pieces[pieces.len() - 1];
        assert_eq!((end[1].0, end[0].1), last);
        for pair in pieces.windows(2) {
            let ([low, high], [next_low, next_high]) = (pair[0], pair[1]);
            assert!(low.0 <= next_high.0 && next_low.0 <= high.0, "they touch");
            assert!(low.1 <= next_high.1 && next_low.1 <= high.1, "they touch");
        }
    }

    proptest! {
        #[test]
        fn the_grid_finds_what_brute_force_finds(
            centers in prop::collection::vec((0.0..1.0f64, 0.0..1.0f64, -5.0..-1.0f64), 2..25),
        ) {
            let charts: Vec<(u32, Vec<Segment>)> = centers
                .iter()
                .map(|&(x, y, e)| (0, square(x, y, 10f64.powf(e))))
                .collect();
            let found = gutters(&charts);
            for (i, (_, a)) in charts.iter().enumerate() {
                let mut want = f64::INFINITY;
                for (_, b) in charts.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, c)| c) {
                    for s in a {
                        for t in b {
                            want = want.min(segment_distance(s, t));
                        }
                    }
                }
                prop_assert_eq!(found[i], Some(want));
            }
        }
    }
}
