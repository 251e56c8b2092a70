//! Where one chart stands: a similarity from its own map to the unit square of a page.

use glam::DVec2;

/// Page, scale, rotation and translation of one chart. Never mirrors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Page, counted from 0.
    pub page: u32,
    /// Page widths per unit of the chart's map.
    pub scale: f64,
    /// The rotation, as the unit vector that the chart's u axis turns to.
    pub rotation: DVec2,
    /// Where the origin of the chart's map comes to lie, page widths.
    pub offset: DVec2,
}

impl Placement {
    /// The chart's point on the page: [0, 1]², v up.
    pub fn apply(&self, p: DVec2) -> DVec2 {
        self.rotation.rotate(p) * self.scale + self.offset
    }

    /// The similarity of known scale that takes `from` nearest to `to`, in the least-squares sense,
    /// and how far off the worst point is. The rotation follows from the cross-covariance (Kabsch
    /// 1976, in the plane). `None` without points.
    pub fn fit(page: u32, scale: f64, from: &[DVec2], to: &[DVec2]) -> Option<(Self, f64)> {
        let count = from.len().min(to.len());
        if count == 0 {
            return None;
        }
        let mean = |points: &[DVec2]| points.iter().sum::<DVec2>() / count as f64;
        let (a, b) = (mean(from), mean(to));
        let turned = from.iter().zip(to).map(|(p, q)| {
            let (p, q) = (*p - a, *q - b);
            DVec2::new(p.dot(q), p.perp_dot(q))
        });
        let rotation = turned.sum::<DVec2>().normalize_or(DVec2::X);
        let offset = b - rotation.rotate(a) * scale;
        let placement = Self { page, scale, rotation, offset };
        let errors = from.iter().zip(to).map(|(p, q)| placement.apply(*p).distance(*q));
        Some((placement, errors.fold(0.0, f64::max)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_similarity_is_found_again_and_anything_else_is_told() {
        let points: Vec<DVec2> =
            (0..9).map(|i| DVec2::new((i % 3) as f64, (i / 3) as f64)).collect();
        let want = Placement {
            page: 2,
            scale: 0.25,
            rotation: DVec2::from_angle(1.1),
            offset: DVec2::new(0.3, -0.2),
        };
        let moved: Vec<DVec2> = points.iter().map(|&p| want.apply(p)).collect();
        let (found, error) = Placement::fit(2, 0.25, &points, &moved).unwrap();
        assert!(error < 1e-15 && found.rotation.distance(want.rotation) < 1e-15);
        let mirrored: Vec<DVec2> = moved.iter().map(|p| DVec2::new(-p.x, p.y)).collect();
        assert!(Placement::fit(2, 0.25, &points, &mirrored).unwrap().1 > 0.1);
        assert!(Placement::fit(2, 0.5, &points, &moved).unwrap().1 > 0.1);
        assert!(Placement::fit(0, 1.0, &[], &[]).is_none());
    }
}
