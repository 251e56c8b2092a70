//! A chart as the packer sees it: the cells of the page that it would take up, at one density and
//! turn, with half of the gutter around it. Where two masks share no cell, their charts are at least
//! the gutter apart. Cells along the border are taken wherever it touches them, those inside by the
//! winding number at their centre.

use glam::DVec2;

use crate::flatten::{Border, Disk};

/// The border of a chart.
#[derive(Debug, Clone)]
pub(super) struct Outline {
    /// Directed segments, the chart on their left, in the chart's units.
    segments: Vec<[DVec2; 2]>,
}

impl Outline {
    /// The outline of a chart.
    pub fn of(disk: &Disk, uv: &[DVec2]) -> Self {
        let rings = Border::of(disk).loops;
        let ring = |ring: &Vec<u32>| -> Vec<[DVec2; 2]> {
            let at = |k: usize| uv[ring[k % ring.len()] as usize];
            (0..ring.len()).map(|k| [at(k), at(k + 1)]).collect()
        };
        Self { segments: rings.iter().flat_map(ring).collect() }
    }

    /// The ends of its segments.
    pub fn points(&self) -> impl Iterator<Item = DVec2> {
        self.segments.iter().map(|s| s[0])
    }

    /// The area that it encloses, at least 0 (the shoelace formula).
    pub fn area(&self) -> f64 {
        let origin = self.points().next().unwrap_or_default();
        let double = self.segments.iter().map(|[a, b]| (a - origin).perp_dot(b - origin));
        0.5 * double.sum::<f64>().max(0.0)
    }

    /// Lower left and upper right corner of its box, after the turn.
    pub fn extent(&self, turn: DVec2) -> [DVec2; 2] {
        self.points()
            .map(|p| turn.rotate(p))
            .fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], p| {
                [low.min(p), high.max(p)]
            })
    }
}

/// The cells that a chart takes up.
#[derive(Debug, Clone, Default)]
pub(super) struct Mask {
    /// Columns and rows.
    pub width: u32,
    pub height: u32,
    /// Where the origin of the turned and scaled chart lies, from the lower left cell's corner.
    pub origin: DVec2,
    /// Cells of the longest span of each row.
    pub longest: Vec<u32>,
    /// The least of these.
    pub least: u32,
    /// Rows from coarse to fine, so that a collision is met early.
    pub order: Vec<u32>,
    /// Half-open spans of columns; those of row r are `spans[starts[r]..starts[r + 1]]`.
    spans: Vec<[u32; 2]>,
    starts: Vec<usize>,
}

impl Mask {
    /// The mask of an outline turned by the unit vector `turn`, at `scale` cells a unit, grown by
    /// `grow` cells on all sides. A `solid` mask is the whole box.
    pub fn new(outline: &Outline, turn: DVec2, scale: f64, grow: f64, solid: bool) -> Self {
        let [low, high] = outline.extent(turn);
        let size = ((high - low) * scale + 2.0 * grow).ceil().max(DVec2::ONE);
        let (width, height) = (size.x as u32, size.y as u32);
        let origin = DVec2::splat(grow) - low * scale;
        let spans = if solid {
            (0..height).map(|row| (row, 0, width)).collect()
        } else {
            let place = |p: DVec2| turn.rotate(p) * scale + origin;
            let segments: Vec<[DVec2; 2]> = outline.segments.iter().map(|s| s.map(place)).collect();
            let mut spans = Spans::of(height);
            touched(&segments, grow, (width, height), &mut spans);
            inside(&segments, (width, height), &mut spans);
            spans.all.sort_unstable();
            spans.all
        };
        Self { width, height, origin, ..Self::joined(height, &spans) }
    }

    /// Spans of one row.
    pub fn row(&self, row: u32) -> &[[u32; 2]] {
        &self.spans[self.starts[row as usize]..self.starts[row as usize + 1]]
    }

    /// Rows of sorted spans (row, first, end), those that meet joined.
    fn joined(height: u32, sorted: &[(u32, u32, u32)]) -> Self {
        let mut mask = Self { starts: vec![0], ..Default::default() };
        let mut next = 0;
        for row in 0..height {
            let start = mask.spans.len();
            while let Some(&(_, first, end)) = sorted.get(next).filter(|s| s.0 == row) {
                match mask.spans[start..].last_mut() {
                    Some(last) if first <= last[1] => last[1] = last[1].max(end),
                    _ => mask.spans.push([first, end]),
                }
                next += 1;
            }
            mask.longest.push(mask.spans[start..].iter().map(|s| s[1] - s[0]).max().unwrap_or(0));
            mask.starts.push(mask.spans.len());
        }
        mask.least = mask.longest.iter().copied().min().unwrap_or(0);
        let mut step = height.next_power_of_two();
        mask.order.push(0);
        while step > 1 {
            mask.order.extend((step / 2..height).step_by(step as usize));
            step /= 2;
        }
        mask
    }
}

/// Spans of cells (row, first, end), as they are found.
struct Spans {
    all: Vec<(u32, u32, u32)>,
    /// The last one of each row: that of the next segment of a border mostly meets it.
    last: Vec<usize>,
}

impl Spans {
    fn of(height: u32) -> Self {
        Self { all: Vec::new(), last: vec![usize::MAX; height as usize] }
    }

    fn push(&mut self, row: u32, start: u32, end: u32) {
        let last = &mut self.last[row as usize];
        match self.all.get_mut(*last) {
            Some(span) if start <= span.2 && end >= span.1 => {
                (span.1, span.2) = (span.1.min(start), span.2.max(end));
            }
            _ => {
                *last = self.all.len();
                self.all.push((row, start, end));
            }
        }
    }
}

/// Cells that come within `grow` (in either direction) of a segment, as spans of rows.
fn touched(segments: &[[DVec2; 2]], grow: f64, (width, height): (u32, u32), spans: &mut Spans) {
    for &[a, b] in segments {
        let (low, high) = if a.y <= b.y { (a, b) } else { (b, a) };
        let first = (low.y - grow).floor().max(0.0) as u32;
        let last = ((high.y + grow).floor().max(0.0) as u32).min(height - 1);
        let slope = (high.x - low.x) / (high.y - low.y);
        // The segment's x at a height, which stays within its ends (also where it is level).
        let at = |y: f64| {
            if y <= low.y {
                low.x
            } else if y >= high.y {
                high.x
            } else {
                low.x + (y - low.y) * slope
            }
        };
        for row in first..=last {
            let (x, z) = if high.y > low.y {
                (at(f64::from(row) - grow), at(f64::from(row) + 1.0 + grow))
            } else {
                (low.x, high.x)
            };
            let start = (x.min(z) - grow).floor().max(0.0) as u32;
            let end = ((x.max(z) + grow).floor().max(0.0) as u32 + 1).min(width);
            if start < end {
                spans.push(row, start, end);
            }
        }
    }
}

/// Cells whose centres the segments wind around, as spans of rows.
fn inside(segments: &[[DVec2; 2]], (width, height): (u32, u32), spans: &mut Spans) {
    let beyond = |x: f64, most: u32| ((x - 0.5).ceil().max(0.0) as u32).min(most);
    let rows = |&[a, b]: &[DVec2; 2]| {
        beyond(a.y.min(b.y), height) as usize..beyond(a.y.max(b.y), height) as usize
    };
    // Crossings by row: room for each, filled from the front.
    let mut starts = vec![0; height as usize + 1];
    segments.iter().flat_map(rows).for_each(|row| starts[row + 1] += 1);
    for row in 0..height as usize {
        starts[row + 1] += starts[row];
    }
    let mut filled = starts.clone();
    let mut crossings = vec![(0.0, 0); starts[height as usize]];
    for segment in segments {
        let [a, b] = *segment;
        let (low, high, way) = if a.y <= b.y { (a, b, 1) } else { (b, a, -1) };
        for row in rows(segment) {
            let y = row as f64 + 0.5;
            let x = low.x + (y - low.y) * (high.x - low.x) / (high.y - low.y);
            crossings[filled[row]] = (x, way);
            filled[row] += 1;
        }
    }
    for row in 0..height {
        let crossings = &mut crossings[starts[row as usize]..starts[row as usize + 1]];
        crossings.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut winding = 0;
        for pair in crossings.windows(2) {
            let [(x, way), (z, _)] = [pair[0], pair[1]];
            winding += way;
            let (start, end) = (beyond(x, width), beyond(z, width));
            if winding != 0 && start < end {
                spans.push(row, start, end);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::samples;

    #[test]
    fn a_mask_holds_the_chart_and_its_gutter() {
        let (disk, uv) = samples::plane(5, 3, 5.0, 2.0);
        let outline = Outline::of(&disk, &uv);
        assert!((outline.area() - 10.0).abs() < 1e-12);
        for k in 0..24 {
            let (turn, scale, grow) = (DVec2::from_angle(0.3 * f64::from(k)), 7.3, 1.25);
            let mask = Mask::new(&outline, turn, scale, grow, false);
            let holds = |p: DVec2| {
                let (column, row) = (p.x.floor() as u32, p.y.floor() as u32);
                p.min_element() >= 0.0
                    && row < mask.height
                    && mask.row(row).iter().any(|s| s[0] <= column && column < s[1])
            };
            for i in 0..=50 {
                for j in 0..=20 {
                    let at = turn.rotate(DVec2::new(0.1 * f64::from(i), 0.1 * f64::from(j)));
                    for way in [(1, 1), (1, -1), (-1, 1), (-1, -1)]
                        .map(|(x, y)| (0.999 * x as f64, 0.999 * y as f64))
                    {
                        assert!(holds(at * scale + mask.origin + grow * DVec2::from(way)));
                    }
                }
            }
            // No more than the cells that the grown border crosses are lost.
            let cells: u32 = (0..mask.height).flat_map(|r| mask.row(r)).map(|s| s[1] - s[0]).sum();
            let (length, reach) = (14.0 * scale, 2.0 * grow + 3.0);
            assert!(f64::from(cells) < 10.0 * scale * scale + length * reach, "{cells}");
        }
    }

    #[test]
    fn what_lies_in_a_ring_is_free() {
        let corners = |r: f64| [(-r, -r), (r, -r), (r, r), (-r, r)].map(DVec2::from);
        let sides = |c: [DVec2; 4], back: bool| {
            (0..4).map(move |k| {
                let (a, b) = (c[k], c[(k + 1) % 4]);
                if back { [b, a] } else { [a, b] }
            })
        };
        let segments = sides(corners(10.0), false).chain(sides(corners(8.0), true)).collect();
        let mask = Mask::new(&Outline { segments }, DVec2::X, 1.0, 0.01, false);
        assert_eq!(mask.row(mask.height / 2).len(), 2);
    }
}
