//! Packing: every chart on a page, at one texel density (times its weight), turned and moved but
//! neither mirrored nor bent.

use glam::DVec2;

use super::arrangement::free_turns;
use super::effort::Effort;
use super::mask::Outline;
use super::options::PackOptions;
use super::page::CELLS;
use super::piece::Piece;
use super::placement::Placement;
use super::quantise::REACH;
use super::search::{Sheet, Spot, search};
use crate::contract::{Canceled, Rotation, Run};
use crate::flatten::{Disk, UvMap};
use crate::tasks;

/// Why charts could not be packed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PackError {
    /// The page has no room between its margins.
    #[error("a padding of {padding} texels leaves no room on a page of {page_size}")]
    PaddingTooLarge {
        /// Texels asked for between charts.
        padding: u32,
        /// Texels across the page.
        page_size: u32,
    },
    /// The page is not made of whole blocks.
    #[error("a page of {0} texels is not made of whole blocks of 4 x 4: take a multiple of 4")]
    Blocks(u32),
    /// Not one weight a chart, or one that is not positive.
    #[error("weights must be positive and one for each chart, or none at all")]
    Weights,
    /// A chart whose map is not finite or has no extent.
    #[error("chart {0} has no extent or a coordinate that is not finite")]
    Degenerate(usize),
    /// Asked to stop.
    #[error(transparent)]
    Canceled(#[from] Canceled),
}

/// Charts on pages.
#[derive(Debug, Clone, PartialEq)]
pub struct Atlas {
    /// How many pages.
    pub pages: u32,
    /// Side of the square page, texels.
    pub page_size: u32,
    /// Where each chart is.
    pub placements: Vec<Placement>,
    /// Coordinates of each chart's vertices on its page: [0, 1]², v up.
    pub uvs: Vec<UvMap>,
}

/// Where the pages asked for cannot hold the charts at any density, more are used, up to this many.
const MOST_PAGES: u32 = 256;

/// Such pages are packed more coarsely, as there may be many of them.
const COARSE: u32 = CELLS / 4;

/// Texels across a block.
const BLOCK: u32 = 4;

/// Pack charts, each a disk and its map in world units, at one texel density (times its weight),
/// the highest that is found.
pub fn pack(
    charts: &[(&Disk, &UvMap)],
    options: &PackOptions,
    run: &Run,
) -> Result<Atlas, PackError> {
    let page_size = options.page_size;
    let weights = weights(charts.len(), options)?;
    if charts.is_empty() {
        return Ok(Atlas { pages: 0, page_size, placements: Vec::new(), uvs: Vec::new() });
    }
    if options.block_align && !page_size.is_multiple_of(BLOCK) {
        return Err(PackError::Blocks(page_size));
    }
    let turns = |uv: &[DVec2]| match options.rotation {
        Rotation::Free => free_turns(uv),
        Rotation::Quarter | Rotation::None => vec![DVec2::X],
    };
    let quarters = if options.rotation == Rotation::None { 1 } else { 4 };
    let piece = |(i, ((disk, uv), &weight)): (usize, (&(&Disk, &UvMap), &f64))| {
        let low = uv.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = uv.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        let extent = (high - low).max_element();
        if !(extent.is_finite() && extent > 0.0) {
            return Err(PackError::Degenerate(i));
        }
        Ok(Piece::new(Outline::of(disk, uv), weight, turns(uv)))
    };
    let all = charts.iter().zip(&weights).enumerate().collect();
    let size = |(_, ((disk, _), _)): &(usize, (&(&Disk, &UvMap), &f64))| disk.triangles.len();
    let pieces = tasks::map_by_size("piece", all, size, piece).into_iter();
    let pieces = pieces.collect::<Result<Vec<_>, _>>()?;
    let (mut pages, mut finest) = (options.pages.max(1), CELLS);
    let (layout, cell) = loop {
        // Half of the gutter, and room for the repair of needles.
        let half =
            0.5 * f64::from(options.padding) / f64::from(page_size) + REACH * options.grid.step();
        let (side, cell) = cells(options, finest);
        let sheet = Sheet { pages, side, grow: half / cell, quarters };
        if let Some(layout) = search(&pieces, &sheet, Effort::of(options.quality), run)? {
            break (layout, cell);
        }
        (pages, finest) = (2 * pages, COARSE);
        if pages > MOST_PAGES {
            let padding = options.padding;
            return Err(PackError::PaddingTooLarge { padding, page_size });
        }
    };
    let place = |(spot, weight): (&Spot, &f64)| Placement {
        page: spot.page,
        scale: layout.density * weight * cell,
        rotation: spot.turn,
        offset: spot.origin * cell,
    };
    let placements: Vec<Placement> = layout.spots.iter().zip(&weights).map(place).collect();
    let on_page = |(placement, (_, uv)): (&Placement, &(&Disk, &UvMap))| {
        // Vertices that are in no triangle may lie anywhere.
        uv.iter().map(|&p| placement.apply(p).clamp(DVec2::ZERO, DVec2::ONE)).collect()
    };
    let uvs = placements.iter().zip(charts).map(on_page).collect();
    let pages = placements.iter().map(|p| p.page + 1).max().unwrap_or(0);
    Ok(Atlas { pages, page_size, placements, uvs })
}

/// Cells across the page, at most `finest`, and the width of one, page widths. Under block alignment
/// a cell is a number of whole blocks, so that charts that share no cell share no block.
fn cells(options: &PackOptions, finest: u32) -> (u32, f64) {
    if !options.block_align {
        return (finest, 1.0 / f64::from(finest));
    }
    let texels = BLOCK * options.page_size.div_ceil(BLOCK * finest);
    (options.page_size / texels, f64::from(texels) / f64::from(options.page_size))
}

fn weights(charts: usize, options: &PackOptions) -> Result<Vec<f64>, PackError> {
    let sound = |&w: &f64| w.is_finite() && w > 0.0;
    match options.weights.len() {
        0 => Ok(vec![1.0; charts]),
        n if n == charts && options.weights.iter().all(sound) => Ok(options.weights.clone()),
        _ => Err(PackError::Weights),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::atlas::Grid;
    use crate::atlas::{gutters, rasterise};
    use crate::contract::Quality;
    use crate::flatten::{Border, quality, samples};
    use rand::{RngExt, SeedableRng};

    fn options(page_size: u32, padding: u32) -> PackOptions {
        PackOptions {
            page_size,
            padding,
            rotation: Rotation::Free,
            block_align: false,
            quality: Quality::Balanced,
            pages: 1,
            grid: Grid::Page,
            weights: Vec::new(),
        }
    }

    /// Pack and check what must hold for any charts; returns the atlas and its efficiency.
    fn check(charts: &[(Disk, UvMap)], options: &PackOptions) -> (Atlas, f64) {
        let borrowed: Vec<(&Disk, &UvMap)> = charts.iter().map(|(d, u)| (d, u)).collect();
        let atlas = pack(&borrowed, options, &Run::quiet()).unwrap();
        let mut triangles = Vec::new();
        let mut borders = Vec::new();
        for (i, (disk, uv)) in charts.iter().enumerate() {
            let (placed, page) = (&atlas.uvs[i], atlas.placements[i].page);
            assert!(placed.iter().all(|p| p.min_element() >= 0.0 && p.max_element() <= 1.0));
            // A similarity: no energy is gained or lost.
            let (before, after) = (quality(disk, uv), quality(disk, placed));
            assert!((before.optimal - after.optimal).abs() < 1e-9 * before.optimal);
            triangles.push(disk.triangles.iter().map(|t| t.map(|v| placed[v as usize])).collect());
            let rings = Border::of(disk).loops;
            let segments = rings.iter().flat_map(|ring| {
                (0..ring.len())
                    .map(|k| [ring[k], ring[(k + 1) % ring.len()]].map(|v| placed[v as usize]))
            });
            borders.push((page, segments.collect()));
        }
        let on_pages: Vec<(u32, &[[DVec2; 3]])> = triangles
            .iter()
            .zip(&atlas.placements)
            .map(|(t, placement): (&Vec<[DVec2; 3]>, _)| (placement.page, &t[..]))
            .collect();
        let coverage = rasterise(&on_pages, atlas.pages, atlas.page_size);
        assert_eq!(coverage.overlapped, 0);
        let least = gutters(&borders).into_iter().flatten().fold(f64::INFINITY, f64::min);
        let least = least * f64::from(atlas.page_size);
        assert!(least >= f64::from(options.padding), "{least}");
        (atlas, coverage.efficiency())
    }

    fn rectangles(count: usize, seed: u64) -> Vec<(Disk, UvMap)> {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        (0..count)
            .map(|_| {
                let side = |random: &mut rand_chacha::ChaCha8Rng| {
                    10f64.powf(random.random_range(-1.5..0.0))
                };
                let (width, height) = (side(&mut random), side(&mut random));
                let (disk, uv) = samples::plane(3, 2, width, height);
                let turn = DVec2::from_angle(random.random_range(0.0..6.0));
                (disk, uv.iter().map(|&p| turn.rotate(p)).collect())
            })
            .collect()
    }

    #[test]
    fn one_square_fills_the_page() {
        let (atlas, efficiency) = check(&[samples::plane(4, 4, 3.0, 3.0)], &options(256, 0));
        assert_eq!(atlas.pages, 1);
        assert!(efficiency > 0.97, "{efficiency}");
    }

    #[test]
    fn turned_rectangles_are_packed_tightly_and_apart() {
        for padding in [0, 1, 2, 5] {
            let (atlas, efficiency) = check(&rectangles(60, 1), &options(512, padding));
            let scales: Vec<f64> = atlas.placements.iter().map(|p| p.scale).collect();
            assert!(scales.iter().all(|s| (s / scales[0] - 1.0).abs() < 1e-9), "one density");
            assert!(efficiency > 0.6, "{padding} {efficiency}");
        }
        check(&rectangles(10, 5), &options(8192, 3));
    }

    #[test]
    fn equal_squares_fill_the_page_but_for_their_gutters() {
        // Nine squares of a side of (256 − 3·4) / 3 texels are the optimum.
        let squares: Vec<_> = (0..9).map(|_| samples::plane(1, 1, 1.0, 1.0)).collect();
        let (_, efficiency) = check(&squares, &options(256, 4));
        let best = (244.0_f64 / 256.0).powi(2);
        assert!(efficiency > 0.97 * best && efficiency < 1.01 * best, "{efficiency}");
    }

    #[test]
    fn weights_scale_the_density() {
        let charts = rectangles(3, 2);
        let weighted = PackOptions { weights: vec![1.0, 2.0, 0.5], ..options(256, 2) };
        let (atlas, _) = check(&charts, &weighted);
        let scale = |i: usize| atlas.placements[i].scale;
        assert!(
            (scale(1) / scale(0) - 2.0).abs() < 1e-9 && (scale(2) / scale(0) - 0.5).abs() < 1e-9
        );
    }

    /// Whether a chart, as it was placed, is turned by a whole number of quarter turns: which one.
    fn quarter_turn(uv: &[DVec2], placed: &[DVec2]) -> Option<usize> {
        let (from, to) = (uv[1] - uv[0], (placed[1] - placed[0]).normalize());
        let axes = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
        axes.iter().position(|a| a.rotate(from.normalize()).distance(to) < 1e-9)
    }

    #[test]
    fn rotation_is_as_free_as_asked_for() {
        let charts = rectangles(30, 6);
        let turns = |rotation| -> Vec<Option<usize>> {
            let (atlas, _) = check(&charts, &PackOptions { rotation, ..options(512, 2) });
            charts.iter().zip(&atlas.uvs).map(|(c, placed)| quarter_turn(&c.1, placed)).collect()
        };
        assert!(turns(Rotation::None).iter().all(|&t| t == Some(0)));
        let quarters = turns(Rotation::Quarter);
        assert!(quarters.iter().all(Option::is_some));
        assert!(quarters.iter().any(|&t| t != Some(0)), "quarter turns are used");
        assert!(turns(Rotation::Free).iter().any(Option::is_none), "free turns are used");
    }

    /// Whether a triangle and a box overlap: no side of either separates them.
    fn meets(t: &[DVec2; 3], low: DVec2, high: DVec2) -> bool {
        let corners = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
        let sides = (0..3).map(|k| (t[(k + 1) % 3] - t[k]).perp());
        sides.chain([DVec2::X, DVec2::Y]).all(|axis| {
            let span = |points: &[DVec2]| {
                let along = points.iter().map(|p| p.dot(axis));
                along.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)))
            };
            let (a, b) = (span(t), span(&corners));
            a.0 < b.1 && b.0 < a.1
        })
    }

    #[test]
    fn aligned_charts_share_no_block() {
        let charts = rectangles(40, 7);
        for (page_size, padding) in [(256, 2), (508, 1), (5000, 3)] {
            let aligned = PackOptions { block_align: true, ..options(page_size, padding) };
            let (atlas, _) = check(&charts, &aligned);
            let blocks = page_size / BLOCK;
            let mut owner = std::collections::HashMap::new();
            for (i, (disk, _)) in charts.iter().enumerate() {
                for t in &disk.triangles {
                    let t = t.map(|v| atlas.uvs[i][v as usize] * f64::from(blocks));
                    let low = t[0].min(t[1]).min(t[2]).floor().as_uvec2();
                    let high = t[0].max(t[1]).max(t[2]).floor().as_uvec2();
                    for y in low.y..=high.y {
                        for x in low.x..=high.x {
                            let block = DVec2::new(f64::from(x), f64::from(y));
                            if meets(&t, block, block + 1.0) {
                                assert_eq!(*owner.entry((x, y)).or_insert(i), i, "{page_size}");
                            }
                        }
                    }
                }
            }
        }
        let odd = PackOptions { block_align: true, ..options(254, 2) };
        let borrowed: Vec<_> = charts.iter().map(|(d, u)| (d, u)).collect();
        assert_eq!(pack(&borrowed, &odd, &Run::quiet()), Err(PackError::Blocks(254)));
    }

    #[test]
    fn the_density_grows_until_the_pages_are_full() {
        let charts = rectangles(40, 8);
        let on = |pages| check(&charts, &PackOptions { pages, ..options(256, 2) }).0;
        let (one, four) = (on(1), on(4));
        assert_eq!((one.pages, four.pages), (1, 4));
        let scale = |atlas: &Atlas| atlas.placements[0].scale;
        assert!(four.placements.iter().all(|p| (p.scale / scale(&four) - 1.0).abs() < 1e-9));
        // Four pages hold four times the area, less what the longest chart forbids.
        let gain = scale(&four) / scale(&one);
        assert!((1.3..2.3).contains(&gain), "{gain}");
    }

    #[test]
    fn thousands_of_tiny_charts_fit() {
        let charts: Vec<(Disk, UvMap)> =
            (0..4000).map(|i| samples::plane(1, 1, 1.0 + 0.001 * f64::from(i % 7), 0.5)).collect();
        let (atlas, _) = check(&charts, &options(1024, 2));
        assert_eq!(atlas.pages, 1);
    }

    #[test]
    fn a_long_strip_and_slivers_are_no_trouble() {
        let mut charts = rectangles(5, 3);
        charts.push(samples::plane(200, 1, 200.0, 0.01));
        // Too thin to survive single precision; a chart with a needle in its middle.
        charts.push(samples::plane(1, 1, 1.0, 1e-9));
        let (flat, _) = samples::plane(2, 1, 1.0, 1.0);
        let mut positions = flat.positions.clone();
        positions[1].x = 1e-9;
        positions[4].x = 1e-9;
        let needle = Disk::new(positions, flat.triangles);
        let uv = needle.positions.iter().map(|p| p.truncate()).collect();
        charts.push((needle, uv));
        check(&charts, &options(1024, 2));
    }

    #[test]
    fn the_same_charts_give_the_same_atlas() {
        let charts = rectangles(40, 4);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| check(&charts, &options(512, 2)).0)
        };
        assert_eq!(on(1), on(5));
    }

    #[test]
    fn what_cannot_be_packed_is_an_error() {
        let square = samples::plane(1, 1, 1.0, 1.0);
        let one = |options: &PackOptions| pack(&[(&square.0, &square.1)], options, &Run::quiet());
        let tight = PackError::PaddingTooLarge { padding: 64, page_size: 64 };
        assert_eq!(one(&options(64, 64)), Err(tight));
        let wrong = PackOptions { weights: vec![1.0, 1.0], ..options(64, 1) };
        assert_eq!(one(&wrong), Err(PackError::Weights));
        let point = vec![DVec2::ONE; 4];
        let degenerate = pack(&[(&square.0, &point)], &options(64, 1), &Run::quiet());
        assert_eq!(degenerate, Err(PackError::Degenerate(0)));
        assert_eq!(pack(&[], &options(64, 1), &Run::quiet()).unwrap().pages, 0);
        let run = Run::quiet();
        run.cancel.cancel();
        let stopped = pack(&[(&square.0, &square.1)], &options(64, 1), &run);
        assert_eq!(stopped, Err(PackError::Canceled(Canceled)));
    }
}
