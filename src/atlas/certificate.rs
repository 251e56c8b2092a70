//! The certificate of the whole atlas and of each chart, taken on the coordinates as they are
//! exported: single precision, after packing.

use glam::DVec2;

use super::gutter::gutters;
use super::quantise::is_flat_3d;
use super::raster::rasterise;
use crate::contract::Certificate;
use crate::flatten::{Border, Disk, has_simple_boundary, list_overlapping_pairs, orientation};
use crate::tasks;

/// Triangles that enter each other by no more than this (page widths) touch.
const TOUCH: f64 = 1e-6;

/// A UV triangle whose height is at most this has no area in single precision (an ulp at 1).
const FLAT_UV: f64 = 1.2e-7;

/// A chart on its page.
#[derive(Debug, Clone, Copy)]
pub struct Placed<'a> {
    /// The chart.
    pub disk: &'a Disk,
    /// Exported coordinates of its vertices, v up. They are rounded to single precision here.
    pub uv: &'a [DVec2],
    /// Its page.
    pub page: u32,
}

/// The certificates of an atlas.
#[derive(Debug, Clone, PartialEq)]
pub struct AtlasCertificates {
    /// Of all charts together.
    pub atlas: Certificate,
    /// Of each chart, by itself and against all others.
    pub charts: Vec<Certificate>,
    /// Owned texels / texels, over all pages.
    pub delivered: f64,
}

/// What is asked of an atlas.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demands {
    /// Pages.
    pub pages: u32,
    /// Side of a page, texels.
    pub page_size: u32,
    /// Least gutter, texels.
    pub padding: u32,
    /// Diagonal of the object, world units: it says which faces have no area in 3D.
    pub diagonal: f64,
    /// Whether double-sided faces share their coordinates on purpose.
    pub shared_sheets: bool,
}

/// Certify charts on pages.
pub fn certify_atlas(charts: &[Placed], demands: &Demands) -> AtlasCertificates {
    let one = |chart: &Placed| {
        let uv: Vec<DVec2> = chart.uv.iter().map(|p| p.as_vec2().as_dvec2()).collect();
        let border = Border::of(chart.disk);
        let own = by_itself(chart.disk, &uv, &border, demands);
        let corners = |t: &[u32; 3]| t.map(|v| uv[v as usize]);
        let triangles: Vec<[DVec2; 3]> = chart.disk.triangles.iter().map(corners).collect();
        (own, (segments(&border, &uv), triangles))
    };
    let all: Vec<&Placed> = charts.iter().collect();
    let alone = tasks::map_by_size("proof of a chart", all, |c| c.disk.triangles.len(), one);
    let (mut own, rest): (Vec<Certificate>, Vec<_>) = alone.into_iter().unzip();
    let (borders, triangles): (Vec<_>, Vec<_>) = rest.into_iter().unzip();
    let on_pages: Vec<(u32, &[[DVec2; 3]])> =
        charts.iter().zip(&triangles).map(|(c, t)| (c.page, &t[..])).collect();
    let rings: Vec<(u32, Vec<[DVec2; 2]>)> =
        charts.iter().map(|chart| chart.page).zip(borders).collect();
    let raster =
        || tasks::link("raster", || rasterise(&on_pages, demands.pages, demands.page_size));
    let apart = || tasks::join("pages", raster, || tasks::link("gutters", || gutters(&rings)));
    let (overlaps, (coverage, gutters)) =
        tasks::join("pages", || overlaps(charts, &triangles, demands), apart);
    let mut atlas = Certificate { simple_boundary: true, ..Default::default() };
    atlas.overlapping_pairs = overlaps.len() as u64;
    for [a, b] in overlaps {
        own[a].overlapping_pairs += 1;
        own[b].overlapping_pairs += u64::from(a != b);
    }
    atlas.overlap_texels = coverage.overlapped;
    let texels = |distance: f64| distance * f64::from(demands.page_size);
    for ((chart, gutter), &texels_shared) in
        own.iter_mut().zip(gutters).zip(&coverage.overlapped_by_chart)
    {
        chart.overlap_texels = texels_shared;
        chart.min_gutter_texels = gutter.map(texels);
        conclude(chart, demands);
        atlas.flipped += chart.flipped;
        atlas.out_of_range += chart.out_of_range;
        atlas.zero_area_uv += chart.zero_area_uv;
        atlas.zero_area_3d += chart.zero_area_3d;
        atlas.simple_boundary &= chart.simple_boundary;
        atlas.min_gutter_texels = match (atlas.min_gutter_texels, chart.min_gutter_texels) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
    }
    conclude(&mut atlas, demands);
    AtlasCertificates { atlas, charts: own, delivered: coverage.efficiency() }
}

/// What can be said of one chart without the others.
fn by_itself(disk: &Disk, uv: &[DVec2], border: &Border, demands: &Demands) -> Certificate {
    let mut certificate = Certificate::default();
    for (f, t) in disk.triangles.iter().enumerate() {
        let corners = t.map(|v| uv[v as usize]);
        let within = |p: &DVec2| p.cmpge(DVec2::ZERO).all() && p.cmple(DVec2::ONE).all();
        certificate.out_of_range += u64::from(!corners.iter().all(within));
        if is_flat_3d(disk, f, demands.diagonal) {
            certificate.zero_area_3d += 1;
            continue;
        }
        let [a, b, c] = corners;
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let flat = (b - a).perp_dot(c - a).abs() <= FLAT_UV * longest;
        certificate.flipped += u64::from(orientation(corners) < 0);
        certificate.zero_area_uv += u64::from(flat);
    }
    certificate.simple_boundary = has_simple_boundary(border, uv);
    certificate
}

/// The two charts, or twice the same one, of each pair of triangles that share a page and overlap.
fn overlaps(
    charts: &[Placed],
    triangles: &[Vec<[DVec2; 3]>],
    demands: &Demands,
) -> Vec<[usize; 2]> {
    let mut pairs = Vec::new();
    for page in 0..demands.pages {
        let (mut here, mut owner) = (Vec::new(), Vec::new());
        for (chart, t) in triangles.iter().enumerate().filter(|(c, _)| charts[*c].page == page) {
            here.extend_from_slice(t);
            owner.resize(here.len(), chart);
        }
        let found = list_overlapping_pairs(&here, TOUCH).into_iter();
        pairs.extend(found.map(|(i, j)| [owner[i as usize], owner[j as usize]]));
    }
    pairs
}

/// The border as segments.
fn segments(border: &Border, uv: &[DVec2]) -> Vec<[DVec2; 2]> {
    let ring = |ring: &Vec<u32>| -> Vec<[DVec2; 2]> {
        let at = |k: usize| uv[ring[k % ring.len()] as usize];
        (0..ring.len()).map(|k| [at(k), at(k + 1)]).collect()
    };
    border.loops.iter().flat_map(ring).collect()
}

/// Whether everything holds.
fn conclude(certificate: &mut Certificate, demands: &Demands) {
    let c = &*certificate;
    let faults = [c.flipped, c.overlapping_pairs, c.overlap_texels, c.out_of_range, c.zero_area_uv];
    let padding = f64::from(demands.padding);
    let apart = c.min_gutter_texels.is_none_or(|gutter| gutter >= padding);
    certificate.shared_sheets = demands.shared_sheets;
    certificate.valid = faults == [0; 5] && certificate.simple_boundary && apart;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::samples;

    const DEMANDS: Demands =
        Demands { pages: 1, page_size: 256, padding: 2, diagonal: 2.0, shared_sheets: false };

    fn square(x: f64) -> (Disk, Vec<DVec2>) {
        let (disk, uv) = samples::plane(4, 4, 0.25, 0.25);
        (disk, uv.iter().map(|p| p + DVec2::new(x, 0.125)).collect())
    }

    fn certify(charts: &[(Disk, Vec<DVec2>)]) -> AtlasCertificates {
        let placed: Vec<Placed> =
            charts.iter().map(|(disk, uv)| Placed { disk, uv, page: 0 }).collect();
        certify_atlas(&placed, &DEMANDS)
    }

    #[test]
    fn two_squares_apart_are_valid() {
        let found = certify(&[square(0.125), square(0.5)]);
        assert!(found.atlas.valid && found.charts.iter().all(|c| c.valid), "{found:?}");
        assert_eq!(found.atlas.min_gutter_texels, Some(32.0));
        assert_eq!(found.delivered, 2.0 * 64.0 * 64.0 / 65536.0);
        assert_eq!(certify(&[square(0.125)]).atlas.min_gutter_texels, None);
        assert!(certify(&[]).atlas.valid);
    }

    #[test]
    fn a_gutter_is_measured_between_edges_and_not_between_corners() {
        let (disk, uv) = square(0.5);
        let between = uv.iter().map(|p| p + DVec2::new(0.0, 1.0 / 32.0)).collect();
        let found = certify(&[square(0.125), (disk, between)]);
        assert_eq!(found.atlas.min_gutter_texels, Some(32.0));
    }

    #[test]
    fn overlap_and_narrow_gutters_are_found() {
        let found = certify(&[square(0.125), square(0.25), square(0.5 + 1.0 / 256.0)]);
        assert!(!found.atlas.valid && found.atlas.overlapping_pairs > 0);
        assert_eq!(found.atlas.overlap_texels, 32 * 64);
        assert_eq!(found.charts[0].overlapping_pairs, found.charts[1].overlapping_pairs);
        // The third overlaps nothing, but stands a texel from the second.
        assert_eq!(found.charts[2].overlapping_pairs, 0);
        assert_eq!(found.charts[2].min_gutter_texels, Some(1.0));
        assert!(!found.charts[2].valid);
    }

    #[test]
    fn flips_flat_faces_and_range_are_counted() {
        let mut charts = vec![square(0.125)];
        let middle = charts[0].1[12];
        charts[0].1[12] = middle + DVec2::new(0.09, 0.03);
        let found = certify(&charts);
        assert!(found.atlas.flipped > 0 && found.atlas.overlapping_pairs > 0);
        assert!(found.atlas.simple_boundary && !found.atlas.valid);

        charts[0].1[12] = DVec2::NAN;
        assert!(certify(&charts).atlas.out_of_range > 0);
        charts[0].1[12] = charts[0].1[13];
        let flat = certify(&charts).atlas;
        assert!(flat.zero_area_uv > 0 && flat.flipped == 0, "what is flat is not flipped");
        charts[0].1[12] = middle;
        charts[0].1[0].x = -0.5;
        assert!(certify(&charts).atlas.out_of_range > 0);
    }

    #[test]
    fn faces_without_area_in_3d_need_none_in_uv() {
        let (flat, uv) = samples::plane(4, 4, 1.0, 1e-8);
        let found = certify(&[(flat, uv.iter().map(|p| p * 0.5 + 0.1).collect())]);
        assert_eq!((found.atlas.zero_area_3d, found.atlas.zero_area_uv), (32, 0));
    }
}
