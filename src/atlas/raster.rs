//! Which chart owns which texel: an independent look at the packed atlas. A texel belongs to a
//! triangle that covers its centre; on a shared edge the half-open rule gives it to one side only,
//! so that a chart covers each of its texels once.

use glam::DVec2;

/// What the raster of an atlas shows.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Coverage {
    /// Texels that some chart owns, over all pages.
    pub covered: u64,
    /// Texels that more than one chart owns, over all pages.
    pub overlapped: u64,
    /// Texels of each chart that another chart owns too.
    pub overlapped_by_chart: Vec<u64>,
    /// Texels of all pages.
    pub texels: u64,
}

impl Coverage {
    /// Owned texels / texels.
    pub fn efficiency(&self) -> f64 {
        if self.texels == 0 { 0.0 } else { self.covered as f64 / self.texels as f64 }
    }
}

/// One chart's triangles on its page: corners in [0, 1]².
pub(super) type PageTriangles<'a> = (u32, &'a [[DVec2; 3]]);

/// Texels held in memory at a time.
const BAND: usize = 1 << 24;

/// No chart.
const NOBODY: u32 = u32::MAX;

/// Bytes that rasterising pages of this many texels across takes.
pub fn raster_bytes(page_size: u32) -> u64 {
    let texels = u64::from(page_size).pow(2).min((BAND as u64).max(u64::from(page_size)));
    texels * (size_of::<u32>() + size_of::<bool>()) as u64
}

/// Rasterise charts, each given by its page and its triangles' corners in [0, 1]², at `page_size`
/// texels across.
pub fn rasterise(charts: &[PageTriangles], pages: u32, page_size: u32) -> Coverage {
    let size = page_size as usize;
    let mut coverage = Coverage {
        overlapped_by_chart: vec![0; charts.len()],
        texels: u64::from(pages) * u64::from(page_size) * u64::from(page_size),
        ..Default::default()
    };
    let rows = (BAND / size.max(1)).clamp(1, size.max(1));
    let mut owners = vec![NOBODY; rows * size];
    let mut shared = vec![false; rows * size];
    for page in 0..pages {
        for first in (0..size).step_by(rows) {
            owners.fill(NOBODY);
            shared.fill(false);
            let band = first..(first + rows).min(size);
            for (chart, (_, triangles)) in
                charts.iter().enumerate().filter(|(_, (on, _))| *on == page)
            {
                let chart = chart as u32;
                for corners in triangles.iter() {
                    scan(corners, size, band.clone(), |row, columns| {
                        let start = (row - first) * size;
                        for texel in start + columns.start..start + columns.end {
                            let owner = owners[texel];
                            if owner == NOBODY {
                                owners[texel] = chart;
                            } else if owner != chart {
                                let first = !std::mem::replace(&mut shared[texel], true);
                                coverage.overlapped_by_chart[chart as usize] += 1;
                                coverage.overlapped_by_chart[owner as usize] += u64::from(first);
                            }
                        }
                    });
                }
            }
            coverage.covered += owners.iter().filter(|&&o| o != NOBODY).count() as u64;
            coverage.overlapped += shared.iter().filter(|&&s| s).count() as u64;
        }
    }
    coverage
}

/// Visit the runs of texels whose centres a triangle covers, row by row within `band`. Columns and
/// rows are half-open, and an edge is cut at the same place from both of its sides, so that
/// triangles that share it share no texel and leave none out.
fn scan(
    corners: &[DVec2; 3],
    size: usize,
    band: std::ops::Range<usize>,
    mut visit: impl FnMut(usize, std::ops::Range<usize>),
) {
    if corners.iter().any(|p| !p.is_finite()) {
        return;
    }
    let points = corners.map(|p| p * size as f64);
    // First texel whose centre is at or beyond x.
    let beyond =
        |x: f64, low: usize, high: usize| ((x - 0.5).ceil().max(0.0) as usize).clamp(low, high);
    let bottom = points.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    let top = points.iter().map(|p| p.y).fold(f64::NEG_INFINITY, f64::max);
    for row in beyond(bottom, band.start, band.end)..beyond(top, band.start, band.end) {
        let y = row as f64 + 0.5;
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..3 {
            let (p, q) = (points[k], points[(k + 1) % 3]);
            let (low, high) = if (p.y, p.x) <= (q.y, q.x) { (p, q) } else { (q, p) };
            if low.y <= y && y < high.y {
                let x = low.x + (y - low.y) * (high.x - low.x) / (high.y - low.y);
                (left, right) = (left.min(x), right.max(x));
            }
        }
        if left < right {
            let columns = beyond(left, 0, size)..beyond(right, 0, size);
            if !columns.is_empty() {
                visit(row, columns);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn square(x: f64, y: f64, side: f64) -> Vec<[DVec2; 3]> {
        let at = |a: f64, b: f64| DVec2::new(x + a * side, y + b * side);
        vec![[at(0., 0.), at(1., 0.), at(1., 1.)], [at(0., 0.), at(1., 1.), at(0., 1.)]]
    }

    #[test]
    fn squares_cover_their_texels_and_overlap_where_they_do() {
        let (a, b) = (square(0.0, 0.0, 0.5), square(0.25, 0.25, 0.5));
        let coverage = rasterise(&[(0, &a), (0, &b)], 1, 64);
        assert_eq!((coverage.covered, coverage.overlapped), (2 * 32 * 32 - 16 * 16, 16 * 16));
        assert_eq!(coverage.overlapped_by_chart, [256, 256]);
        // On pages of their own they do not meet.
        let coverage = rasterise(&[(0, &a), (1, &b)], 2, 64);
        assert_eq!((coverage.covered, coverage.overlapped), (2 * 32 * 32, 0));
        assert_eq!(coverage.efficiency(), 0.25);
    }

    #[test]
    fn charts_that_touch_share_no_texel() {
        // The border runs exactly through texel centres.
        let (a, b) = (square(0.0, 0.0, 10.5 / 64.0), square(10.5 / 64.0, 0.0, 0.5));
        assert_eq!(rasterise(&[(0, &a), (0, &b)], 1, 64).overlapped, 0);
    }

    #[test]
    fn a_whole_page_is_whole_and_outside_is_cut_off() {
        assert_eq!(rasterise(&[(0, &square(0.0, 0.0, 1.0))], 1, 100).efficiency(), 1.0);
        assert_eq!(rasterise(&[(0, &square(-1.0, -1.0, 3.0))], 1, 100).efficiency(), 1.0);
        assert_eq!(rasterise(&[(0, &square(5.0, 5.0, 1.0))], 1, 100).covered, 0);
        assert_eq!(rasterise(&[(0, &[[DVec2::NAN; 3]])], 1, 100).covered, 0);
    }

    #[test]
    fn large_pages_are_drawn_in_bands() {
        let triangles = square(0.1, 0.1, 0.8);
        let coverage = rasterise(&[(0, &triangles), (0, &triangles)], 1, 5000);
        assert_eq!((coverage.covered, coverage.overlapped), (4000 * 4000, 4000 * 4000));
    }

    proptest! {
        #[test]
        fn a_fan_covers_each_texel_once(
            center in prop::array::uniform2(0.3..0.7f64), n in 5usize..12, turn in 0.0..6.3f64,
        ) {
            // As many charts as triangles: any texel given to two sides of an edge would show.
            let center = DVec2::from(center);
            let rim = |k: usize| {
                DVec2::splat(0.5) + DVec2::from_angle(turn + std::f64::consts::TAU * k as f64 / n as f64) * 0.45
            };
            let fans: Vec<Vec<[DVec2; 3]>> = (0..n).map(|k| vec![[center, rim(k), rim((k + 1) % n)]]).collect();
            let charts: Vec<PageTriangles> = fans.iter().map(|t| (0, &t[..])).collect();
            let apart = rasterise(&charts, 1, 128);
            prop_assert_eq!(apart.overlapped, 0);
            let together: Vec<[DVec2; 3]> = fans.concat();
            prop_assert_eq!(rasterise(&[(0, &together)], 1, 128).covered, apart.covered);
            // The area of the polygon, to within its rim.
            let area = 0.5 * n as f64 * 0.45f64.powi(2) * (std::f64::consts::TAU / n as f64).sin();
            prop_assert!((apart.efficiency() - area).abs() < 0.02);
        }
    }
}
