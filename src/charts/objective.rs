//! What an atlas costs: distortion, seams and charts in one number, by which two ways to cut an object are
//! compared (docs/method.md, 4; without what hidden places and earlier seams save, so that it is a function of
//! surface and charts alone).

use super::chart::Chart;
use super::limits::ChartLimits;
use super::limits::cost::seam_cost;
use crate::mesh::{NONE, Surface};

/// Φ = ΣA(E − 1)/ΣA + λ(Σℓc/√ΣA + 0.05 · charts) of charts with mean symmetric Dirichlet energies E (1 is
/// isometric).
pub fn objective(surface: &Surface, charts: &[(&Chart, f64)], distortion_bound: f64) -> f64 {
    let limits = ChartLimits::new(surface, distortion_bound);
    // Chart of each face, and its place in it.
    let mut place = vec![(NONE, 0); surface.face_count()];
    for (c, (chart, _)) in (0u32..).zip(charts) {
        for (i, &f) in chart.faces.iter().enumerate() {
            place[f as usize] = (c, i);
        }
    }
    // Vertex of its disk at which a half-edge begins, or, one corner on, ends.
    let vertex = |h: u32, on: u32| {
        let (chart, i) = place[h as usize / 3];
        charts[chart as usize].0.disk.triangles[i][((h % 3 + on) % 3) as usize]
    };
    let is_seam = |h: u32, t: u32| {
        let (here, there) = (place[h as usize / 3].0, place[t as usize / 3].0);
        let is_open = || vertex(h, 0) != vertex(t, 1) || vertex(h, 1) != vertex(t, 0);
        here != NONE && there != NONE && (here != there || is_open())
    };
    let edges = (0u32..).zip(&surface.twin).filter(|(h, t)| **t != NONE && *h < **t);
    let seam: f64 = edges
        .filter(|&(h, &t)| is_seam(h, t))
        .map(|(h, _)| surface.length(h) * seam_cost(surface.dihedral(h)))
        .sum();
    let area: f64 = charts.iter().map(|(chart, _)| chart.disk.area()).sum();
    let energy: f64 = charts.iter().map(|(chart, e)| chart.disk.area() * (e - 1.0)).sum();
    let worth = limits.worth * (seam + limits.chart * charts.len() as f64);
    (energy + worth) / area.max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::super::scenes::solid_box;
    use super::super::{ChartOptions, build};
    use super::*;
    use crate::contract::Run;

    #[test]
    fn a_box_costs_its_open_edges_and_its_charts() {
        let surface = solid_box(1.0, 1.0, 1.0);
        let parts = vec![0; surface.face_count()];
        let options = ChartOptions { distortion_bound: 0.01, pinches: true };
        let charts = build(&surface, &parts, &options, &Run::quiet()).unwrap();
        let cost = |energy| {
            let charts: Vec<_> = charts.iter().map(|chart| (chart, energy)).collect();
            objective(&surface, &charts, 0.01)
        };
        // Each chart of k sides is closed along k - 1 edges; all others of the twelve are open.
        let count = charts.len() as f64;
        let open = 12.0 - (6.0 - count);
        let edge = seam_cost(std::f64::consts::FRAC_PI_2);
        let want = 0.2 * 0.01 * (open * edge / 6f64.sqrt() + 0.05 * count);
        assert!((cost(1.0) - want).abs() < 1e-12, "{} {want}", cost(1.0));
        assert!((cost(1.5) - want - 0.5).abs() < 1e-12);
    }
}
