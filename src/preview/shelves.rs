//! Charts side by side at one scale, before they are packed: upright, the tallest first, in rows from the
//! top.

use glam::Vec2;

use crate::metrics::Measured;

/// Halvings by which the scale is found.
const HALVINGS: usize = 32;

/// Where each chart stands in a picture.
#[derive(Debug, Clone)]
pub(super) struct Shelves {
    scale: f32,
    charts: Vec<Stand>,
}

/// A chart's place.
#[derive(Debug, Clone, Copy)]
struct Stand {
    /// Lowest corner of its box in UV, after the turn; its size.
    low: Vec2,
    size: Vec2,
    /// Whether it is turned by a quarter, so that it stands upright.
    turned: bool,
    /// Top left corner in the picture, pixels.
    at: Vec2,
}

impl Shelves {
    /// Places the charts as large as a room of `room` pixels with its top left corner at `corner` holds,
    /// `gap` pixels apart.
    pub(super) fn new(input: &Measured, corner: Vec2, room: Vec2, gap: f32) -> Self {
        let mut boxes = vec![[Vec2::INFINITY, Vec2::NEG_INFINITY]; input.charts];
        for f in (0..input.uvs.len()).filter(|&f| input.face_map(f).is_some()) {
            let [low, high] = &mut boxes[input.chart_of[f] as usize];
            for uv in input.uvs[f].map(Vec2::from) {
                (*low, *high) = (low.min(uv), high.max(uv));
            }
        }
        let stand = |&[low, high]: &[Vec2; 2]| {
            let size = (high - low).max(Vec2::ZERO);
            if size.x > size.y {
                let (low, size) = (turn(Vec2::new(low.x, high.y)), Vec2::new(size.y, size.x));
                return Stand { low, size, turned: true, at: corner };
            }
            Stand { low, size, turned: false, at: corner }
        };
        let mut shelves = Self { scale: 0.0, charts: boxes.iter().map(stand).collect() };
        let mut order: Vec<usize> = (0..input.charts).collect();
        let height = |i: usize| shelves.charts[i].size.y;
        order.sort_by(|&a, &b| height(b).total_cmp(&height(a)).then(a.cmp(&b)));
        let longest = order.first().map_or(1.0, |&i| height(i)).max(f32::MIN_POSITIVE);
        let (mut fits, mut too_large) = (0.0, room.y / longest);
        for _ in 0..HALVINGS {
            let scale = 0.5 * (fits + too_large);
            if shelves.fill(&order, scale, corner, room, gap) {
                fits = scale;
            } else {
                too_large = scale;
            }
        }
        shelves.fill(&order, fits, corner, room, gap);
        shelves
    }

    /// Fills the rows at a scale; whether all charts find room.
    fn fill(&mut self, order: &[usize], scale: f32, corner: Vec2, room: Vec2, gap: f32) -> bool {
        self.scale = scale;
        let (mut at, mut row) = (Vec2::ZERO, 0.0f32);
        for &i in order {
            let size = self.charts[i].size * scale;
            if at.x > 0.0 && at.x + size.x > room.x {
                at = Vec2::new(0.0, at.y + row + gap);
                row = 0.0;
            }
            if at.x + size.x > room.x || at.y + size.y > room.y {
                return false;
            }
            self.charts[i].at = corner + at;
            (at.x, row) = (at.x + size.x + gap, row.max(size.y));
        }
        true
    }

    /// A place on a chart, v up, as a place in the picture, y down.
    pub(super) fn place(&self, chart: u32, uv: [f32; 2]) -> Vec2 {
        let stand = self.charts[chart as usize];
        let uv = if stand.turned { turn(uv.into()) } else { uv.into() };
        let inside = uv - stand.low;
        stand.at + Vec2::new(inside.x, stand.size.y - inside.y) * self.scale
    }
}

/// By a quarter, against the clock.
fn turn(p: Vec2) -> Vec2 {
    Vec2::new(-p.y, p.x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::fixtures::grid;

    #[test]
    fn charts_stand_upright_and_apart_at_one_scale() {
        let (surface, _) = grid(3, 1, |x, y| glam::DVec3::new(x, y, 0.0));
        // Each of the three cells is a chart: a wide one, a tall one and a square.
        let sizes = [[0.6, 0.2], [0.1, 0.4], [0.3, 0.3]];
        let uvs: Vec<[[f32; 2]; 3]> = (0..6)
            .map(|f| {
                let [w, h]: [f32; 2] = sizes[f / 2];
                let corner = |x: f32, y: f32| [0.1 + x * w, 0.2 + y * h];
                match f % 2 {
                    0 => [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0)],
                    _ => [corner(0.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)],
                }
            })
            .collect();
        let chart_of = [0, 0, 1, 1, 2, 2];
        let input = Measured {
            surface: &surface,
            uvs: &uvs,
            chart_of: &chart_of,
            part_of: &[0; 6],
            charts: 3,
            parts: 1,
            boundary_labels: None,
            page_size: 64,
            pages: 1,
            page_of: &[],
            chamfer: &[],
        };
        let (corner, room) = (Vec2::splat(10.0), Vec2::splat(200.0));
        let shelves = Shelves::new(&input, corner, room, 5.0);
        let boxes: Vec<[Vec2; 2]> = (0..3u32)
            .map(|c| {
                let own = (0..6).filter(|&f| chart_of[f] == c);
                let points = own.flat_map(|f| uvs[f].map(|uv| shelves.place(c, uv)));
                points.fold([Vec2::INFINITY, Vec2::NEG_INFINITY], |[l, h], p| [l.min(p), h.max(p)])
            })
            .collect();
        for (i, [low, high]) in boxes.iter().enumerate() {
            let (size, [w, h]) = (high - low, sizes[i]);
            assert!(size.y >= size.x - 1e-3, "{size}");
            assert!((size.y - shelves.scale * w.max(h)).abs() < 0.01);
            assert!((size.x - shelves.scale * w.min(h)).abs() < 0.01);
            assert!(low.min_element() >= 9.99 && high.max_element() <= 210.01, "{low} {high}");
            for [l, h] in &boxes[..i] {
                let apart = (low - h).max(l - high).max_element();
                assert!(apart >= 4.99, "{apart}");
            }
        }
        // Nothing is mirrored: both triangles keep their sense, with y down.
        let [a, b, c] = uvs[0].map(|uv| shelves.place(0, uv));
        assert!((b - a).perp_dot(c - a) < 0.0);
        assert!(shelves.scale > 150.0);
    }
}
