//! Which pairs of boxes meet: the broad phase of every overlap test. The plane is cut into
//! horizontal bands; within a band, boxes are swept by their left sides (sweep and prune, Baraff
//! 1992). A pair that meets in several bands is visited only in the band of its intersection's
//! lower side.

use glam::DVec2;
use rayon::prelude::*;

use crate::tasks;

/// Boxes sorted into bands. Boxes with a coordinate that is not finite meet nothing.
pub struct Sweep {
    boxes: Vec<[DVec2; 2]>,
    bottom: f64,
    height: f64,
    /// Boxes of band `b`, by left side: `items[starts[b]..starts[b + 1]]`.
    starts: Vec<usize>,
    items: Vec<u32>,
}

impl Sweep {
    /// Sort boxes, each given by its lower left and upper right corner.
    pub fn new(boxes: Vec<[DVec2; 2]>) -> Self {
        let finite = |b: &[DVec2; 2]| b[0].is_finite() && b[1].is_finite();
        let mut order: Vec<u32> =
            (0..boxes.len() as u32).filter(|&i| finite(&boxes[i as usize])).collect();
        let of = |i: u32| &boxes[i as usize];
        order.sort_by(|&i, &j| of(i)[0].x.total_cmp(&of(j)[0].x).then(i.cmp(&j)));

        let bottom = order.iter().map(|&i| of(i)[0].y).fold(f64::INFINITY, f64::min);
        let top = order.iter().map(|&i| of(i)[1].y).fold(f64::NEG_INFINITY, f64::max);
        let mean = order.iter().map(|&i| of(i)[1].y - of(i)[0].y).sum::<f64>();
        let count = order.len().max(1) as f64;
        // As many bands as a square arrangement has rows, but none lower than two boxes: a box then
        // stands in 1.5 bands on average, whatever the boxes are.
        let height = (2.0 * mean / count).max((top - bottom) / count.sqrt());
        let mut sweep = Self { boxes, bottom, height, starts: Vec::new(), items: Vec::new() };
        let bands = if order.is_empty() { 0 } else { sweep.band(top) + 1 };
        let span = |i: u32| {
            let [lower, upper] = sweep.boxes[i as usize];
            sweep.band(lower.y)..=sweep.band(upper.y)
        };
        let mut starts = vec![0; bands + 1];
        order.iter().flat_map(|&i| span(i)).for_each(|band| starts[band + 1] += 1);
        for band in 0..bands {
            starts[band + 1] += starts[band];
        }
        let (mut fill, mut items) = (starts.clone(), vec![0; starts[bands]]);
        for &i in &order {
            for band in span(i) {
                items[fill[band]] = i;
                fill[band] += 1;
            }
        }
        (sweep.starts, sweep.items) = (starts, items);
        sweep
    }

    fn band(&self, y: f64) -> usize {
        if self.height > 0.0 { ((y - self.bottom) / self.height) as usize } else { 0 }
    }

    /// Visit every pair i < j of boxes of one band that meet (closed boxes), until `visit` says
    /// stop by returning true. Returns whether it did.
    fn visit_band(&self, band: usize, mut visit: impl FnMut(u32, u32) -> bool) -> bool {
        let items = &self.items[self.starts[band]..self.starts[band + 1]];
        for (k, &i) in items.iter().enumerate() {
            let a = self.boxes[i as usize];
            for &j in &items[k + 1..] {
                let b = self.boxes[j as usize];
                if b[0].x > a[1].x {
                    break;
                }
                let meets = b[0].y <= a[1].y && a[0].y <= b[1].y;
                if meets && self.band(a[0].y.max(b[0].y)) == band && visit(i.min(j), i.max(j)) {
                    return true;
                }
            }
        }
        false
    }

    fn bands(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Whether `test` holds for any pair of boxes that meet.
    pub fn any(&self, test: impl Fn(u32, u32) -> bool) -> bool {
        (0..self.bands()).any(|band| self.visit_band(band, &test))
    }

    /// For how many pairs of boxes that meet `test` holds.
    pub fn count(&self, test: impl Fn(u32, u32) -> bool + Sync) -> u64 {
        let band = |band| {
            let mut count = 0;
            self.visit_band(band, |i, j| {
                count += u64::from(test(i, j));
                false
            });
            count
        };
        tasks::even("overlaps", self.bands(), || (0..self.bands()).into_par_iter().map(band).sum())
    }

    /// Every pair i < j of boxes that meet and for which `test` holds, in ascending order.
    pub fn pairs(&self, test: impl Fn(u32, u32) -> bool + Sync) -> Vec<(u32, u32)> {
        let band = |band| {
            let mut pairs = Vec::new();
            self.visit_band(band, |i, j| {
                if test(i, j) {
                    pairs.push((i, j));
                }
                false
            });
            pairs
        };
        let bands = 0..self.bands();
        let mut pairs: Vec<_> = tasks::even("overlaps", bands.len(), || {
            bands.into_par_iter().flat_map_iter(band).collect()
        });
        pairs.sort_unstable();
        pairs
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn finds_what_brute_force_finds(
            raw in prop::collection::vec((0.0..1.0f64, 0.0..1.0f64, 0.0..0.4f64, -6.0..-0.5f64), 0..60),
        ) {
            let boxes: Vec<[DVec2; 2]> = raw
                .iter()
                .map(|&(x, y, w, h)| [DVec2::new(x, y), DVec2::new(x + w, y + 10f64.powf(h))])
                .collect();
            let mut want = Vec::new();
            for i in 0..boxes.len() {
                for j in i + 1..boxes.len() {
                    let (a, b) = (boxes[i], boxes[j]);
                    if a[0].cmple(b[1]).all() && b[0].cmple(a[1]).all() {
                        want.push((i as u32, j as u32));
                    }
                }
            }
            let sweep = Sweep::new(boxes);
            prop_assert_eq!(sweep.count(|_, _| true), want.len() as u64);
            prop_assert_eq!(sweep.any(|_, _| true), !want.is_empty());
            prop_assert_eq!(sweep.pairs(|_, _| true), want);
        }
    }

    #[test]
    fn boxes_that_are_points_or_not_finite_do_no_harm() {
        let point = [DVec2::ONE; 2];
        let bad = [DVec2::new(f64::NAN, 0.0), DVec2::ONE];
        assert_eq!(Sweep::new(vec![point, bad, point]).pairs(|_, _| true), [(0, 2)]);
        assert_eq!(Sweep::new(vec![bad]).count(|_, _| true), 0);
        assert_eq!(Sweep::new(Vec::new()).count(|_, _| true), 0);
    }
}
