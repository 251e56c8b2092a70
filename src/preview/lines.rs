//! Lines, drawn into a mask of coverage, so that where lines meet nothing is drawn twice.

use glam::Vec2;

/// Length of all lines of a mask, pixels. A picture of one object has a thousandth of it; beyond, lines
/// are left out, so that no input takes minutes.
const MOST_LENGTH: f64 = 5e7;

/// A mask over a canvas.
#[derive(Debug, Clone)]
pub(super) struct LineMask {
    left: f64,
    width: usize,
    height: usize,
    pub coverage: Vec<f32>,
}

impl LineMask {
    pub(super) fn new(width: usize, height: usize) -> Self {
        Self { left: MOST_LENGTH, width, height, coverage: vec![0.0; width * height] }
    }

    /// Draws a line `thick` pixels wide. `visible(pixel, t)` says whether the pixel may show the
    /// point at share `t` of the line.
    pub(super) fn draw(
        &mut self,
        a: Vec2,
        b: Vec2,
        thick: f32,
        visible: impl Fn(usize, f32) -> bool,
    ) {
        let reach = 0.5 * thick + 0.5;
        let along = b - a;
        let length_squared = along.length_squared();
        self.left -= f64::from(a.distance(b).min((self.width + self.height) as f32));
        if !(a.is_finite() && b.is_finite()) || self.left < 0.0 {
            return;
        }
        // Walk the longer axis; at each step cover the pixels of the other within reach.
        let steep = along.y.abs() > along.x.abs();
        let turn = |p: Vec2| if steep { Vec2::new(p.y, p.x) } else { p };
        let (mut p, mut q) = (turn(a), turn(b));
        if q.x < p.x {
            (p, q) = (q, p);
        }
        let (limit, across) =
            if steep { (self.height, self.width) } else { (self.width, self.height) };
        let slope = if q.x > p.x { (q.y - p.y) / (q.x - p.x) } else { 0.0 };
        let half = reach * (1.0 + slope * slope).sqrt();
        let start = (p.x - reach).floor().max(0.0) as usize;
        let end = ((q.x + reach).ceil().max(0.0) as usize).min(limit);
        for i in start..end {
            let x = i as f32 + 0.5;
            let middle = p.y + slope * (x.clamp(p.x, q.x) - p.x);
            let low = (middle - half).floor().max(0.0) as usize;
            let high = ((middle + half).ceil().max(0.0) as usize).min(across);
            for j in low..high {
                let center = turn(Vec2::new(x, j as f32 + 0.5));
                let t = if length_squared > 0.0 {
                    ((center - a).dot(along) / length_squared).clamp(0.0, 1.0)
                } else {
                    0.0
                };
                let covered = (reach - center.distance(a + along * t)).clamp(0.0, 1.0);
                let pixel = if steep { i * self.width + j } else { j * self.width + i };
                if covered > self.coverage[pixel] && visible(pixel, t) {
                    self.coverage[pixel] = covered;
                }
            }
        }
    }

    /// The mask, `strength` at most.
    pub(super) fn scaled(mut self, strength: f32) -> Vec<f32> {
        for c in &mut self.coverage {
            *c *= strength;
        }
        self.coverage
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_covers_its_length_times_its_width() {
        for (a, b) in
            [((4.0, 5.5), (24.0, 5.5)), ((5.5, 24.0), (5.5, 4.0)), ((4.0, 4.0), (18.1, 18.1))]
        {
            let (a, b) = (Vec2::from(a), Vec2::from(b));
            let mut mask = LineMask::new(32, 32);
            mask.draw(a, b, 2.0, |_, _| true);
            let covered: f32 = mask.coverage.iter().sum();
            let wanted = 2.0 * a.distance(b);
            assert!((covered - wanted).abs() < 0.25 * wanted, "{covered} is not {wanted}");
        }
    }

    #[test]
    fn lines_beyond_the_canvas_and_points_do_no_harm() {
        let mut mask = LineMask::new(8, 8);
        mask.draw(Vec2::splat(-1e9), Vec2::splat(1e9), 1.0, |_, _| true);
        mask.draw(Vec2::splat(3.5), Vec2::splat(3.5), 1.0, |_, _| true);
        mask.draw(Vec2::NAN, Vec2::ONE, 1.0, |_, _| true);
        assert!(mask.coverage.iter().all(|c| (0.0..=1.0).contains(c)));
    }
}
