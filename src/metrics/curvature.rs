//! How much of an object is developable: the share of the area around vertices at which |K|·A is
//! below 0.05, K the Gauss curvature (angle defect over a third of the area around, Meyer et al.
//! 2003, doi:10.1007/978-3-662-05105-4_2) and A the area of the chart. Vertices on a chart's border
//! count as developable: the cut has freed them.

use std::f64::consts::TAU;

use super::Measured;
use crate::mesh::{DisjointSets, NONE};

/// Most |K|·A of a developable place.
const BENT: f64 = 0.05;

/// Share of the area; `None` where no face has a chart.
pub fn developable(input: &Measured) -> Option<f64> {
    let surface = input.surface;
    let counted = |f: usize| (input.chart_of[f] as usize) < input.charts;
    let same = |h: usize| {
        let t = surface.twin[h];
        t != NONE && input.chart_of[t as usize / 3] == input.chart_of[h / 3]
    };
    let next = |h: u32| 3 * (h / 3) + (h + 1) % 3;
    let mut corners = DisjointSets::new(3 * surface.face_count());
    let mut chart_area = vec![0.0; input.charts];
    for f in (0..surface.face_count()).filter(|&f| counted(f)) {
        chart_area[input.chart_of[f] as usize] += surface.areas[f];
        for h in (3 * f..3 * f + 3).filter(|&h| same(h)) {
            let (h, t) = (h as u32, surface.twin[h]);
            corners.join(h, next(t));
            corners.join(next(h), t);
        }
    }
    // Angle, area and whether it is inside, for each vertex of each chart.
    let mut at = vec![(0.0, 0.0, true); 3 * surface.face_count()];
    for f in (0..surface.face_count()).filter(|&f| counted(f)) {
        let p = surface.corners(f);
        for k in 0..3 {
            let (own, after, before) = (p[k], p[(k + 1) % 3], p[(k + 2) % 3]);
            let vertex = &mut at[corners.root((3 * f + k) as u32) as usize];
            vertex.0 += (after - own).angle_between(before - own);
            vertex.1 += surface.areas[f] / 3.0;
            vertex.2 &= same(3 * f + k) && same(3 * f + (k + 2) % 3);
        }
    }
    let (mut total, mut flat) = (0.0, 0.0);
    for (c, &(angle, area, inside)) in at.iter().enumerate().filter(|(_, v)| v.1 > 0.0) {
        let bent = (TAU - angle).abs() / area * chart_area[input.chart_of[c / 3] as usize];
        total += area;
        flat += if inside && bent >= BENT { 0.0 } else { area };
    }
    (total > 0.0).then(|| flat / total)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::fixtures;
    use glam::DVec3;

    /// A 6 × 6 sheet in one chart, bent by `height` over [−1, 1]².
    fn share(height: impl Fn(f64, f64) -> f64) -> f64 {
        let bent = |x: f64, y: f64| {
            let (x, y) = (2.0 * x - 1.0, 2.0 * y - 1.0);
            DVec3::new(x, y, height(x, y))
        };
        let (surface, _) = fixtures::grid(6, 6, bent);
        let faces = surface.face_count();
        developable(&Measured {
            surface: &surface,
            uvs: &[],
            chart_of: &vec![0; faces],
            part_of: &vec![0; faces],
            charts: 1,
            parts: 1,
            boundary_labels: None,
            page_size: 1024,
            pages: 1,
            page_of: &[],
            chamfer: &[],
        })
        .unwrap()
    }

    #[test]
    fn a_bent_sheet_is_developable_and_a_bump_is_not() {
        assert_eq!(share(|_, _| 0.0), 1.0);
        assert!(share(|x, _| 0.4 * x * x) > 0.99);
        // Only the ring of vertices on the border counts as developable there.
        assert!(share(|x, y| 0.4 * (x * x + y * y)) < 0.4);
    }
}
