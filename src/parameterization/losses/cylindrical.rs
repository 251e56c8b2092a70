//! Cylindrical loss (paper 2.3.1), on charts taken for a cylinder or cone. Sound form: the area-weighted
//! mean of ‖R u/s − t‖² divided by the variance of t, both centred, t the unrolled shape, least over
//! rotations R (closed form, no reflection; Kabsch in the plane). Paper's form: the mean squared difference
//! of height and v, each brought to mean 0 and variance 1.

use glam::{DVec2, DVec3};

use super::triangles::Triangles;
use super::{Loss, Map};
use crate::flatten::{Disk, UvMap, unroll};

/// What the cylindrical loss compares a map to: one entry a vertex of the disk in either list.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CylinderTarget {
    /// The unrolled shape, world units, not mirrored; turned and moved at will.
    pub developed: UvMap,
    /// Position along the axis.
    pub heights: Vec<f64>,
}

impl CylinderTarget {
    /// The unrolled shape of `disk` as a tube about the line through `origin` along the unit vector
    /// `axis`, whose radius is `radius` at the origin and changes by `taper` along the axis.
    pub fn new(disk: &Disk, origin: DVec3, axis: DVec3, radius: f64, taper: f64) -> Self {
        let developed = unroll(disk, origin, axis, radius, taper);
        let heights = disk.positions.iter().map(|p| (p - origin).dot(axis)).collect();
        Self { developed, heights }
    }

    /// Whether there is one finite entry a vertex.
    pub(super) fn fits(&self, vertices: usize) -> bool {
        self.developed.len() == vertices
            && self.heights.len() == vertices
            && self.developed.iter().all(|p| p.is_finite())
            && self.heights.iter().all(|z| z.is_finite())
    }
}

/// The sound form.
#[derive(Debug)]
pub(super) struct Unrolled {
    points: Vec<Point>,
    /// Weighted mean of ‖target‖². Above 0.
    variance: f64,
}

#[derive(Debug)]
struct Point {
    vertex: u32,
    /// Share of the measured area.
    share: f64,
    /// Centred.
    target: DVec2,
}

impl Unrolled {
    pub fn prepare(triangles: &Triangles, target: CylinderTarget) -> Option<Box<dyn Loss>> {
        let mut shares = vec![0.0; target.developed.len()];
        for t in &triangles.list {
            for v in t.corners {
                shares[v as usize] += t.share / 3.0;
            }
        }
        let weighted = shares.iter().zip(&target.developed);
        let mean: DVec2 = weighted.map(|(share, t)| *share * *t).sum();
        let point = |(v, (share, t)): (usize, (&f64, &DVec2))| {
            (*share > 0.0).then(|| Point { vertex: v as u32, share: *share, target: t - mean })
        };
        let points: Vec<Point> =
            shares.iter().zip(&target.developed).enumerate().filter_map(point).collect();
        let variance: f64 = points.iter().map(|p| p.share * p.target.length_squared()).sum();
        (variance > 0.0).then(|| Box::new(Self { points, variance }) as Box<dyn Loss>)
    }
}

impl Loss for Unrolled {
    fn evaluate(&self, map: Map, weight: f64, gradient: &mut [DVec2]) -> f64 {
        let at = |p: &Point| map.uv[p.vertex as usize] / map.scale;
        let mean: DVec2 = self.points.iter().map(|p| p.share * at(p)).sum();
        // Read as complex numbers, Σ conj(u) t turns the map onto the target.
        let (mut spread, mut turn) = (0.0, DVec2::ZERO);
        for p in &self.points {
            let u = at(p) - mean;
            spread += p.share * u.length_squared();
            turn += p.share * DVec2::new(u.dot(p.target), u.perp_dot(p.target));
        }
        let back = DVec2::new(turn.x, -turn.y).try_normalize().unwrap_or(DVec2::X);
        let slope = 2.0 * weight / (self.variance * map.scale);
        for p in &self.points {
            let residual = at(p) - mean - back.rotate(p.target);
            gradient[p.vertex as usize] += residual * (slope * p.share);
        }
        // Rounding must not take an exact fit below 0.
        ((spread + self.variance - 2.0 * turn.length()) / self.variance).max(0.0)
    }
}

/// Kept away from 0 when dividing by a standard deviation (paper 2.3.1).
const EPSILON: f64 = 1e-6;

/// The paper's form.
#[derive(Debug)]
pub(super) struct Aligned {
    /// Vertices and their heights, mean 0, variance 1.
    points: Vec<(u32, f64)>,
}

impl Aligned {
    pub fn prepare(vertices: &[u32], target: CylinderTarget) -> Option<Box<dyn Loss>> {
        let heights = vertices.iter().map(|v| target.heights[*v as usize]);
        let n = vertices.len() as f64;
        let mean = heights.clone().sum::<f64>() / n;
        let variance = heights.clone().map(|z| (z - mean).powi(2)).sum::<f64>() / n;
        let scored = heights.map(|z| (z - mean) / (variance.sqrt() + EPSILON));
        let points: Vec<_> = vertices.iter().copied().zip(scored).collect();
        (!points.is_empty()).then(|| Box::new(Self { points }) as Box<dyn Loss>)
    }
}

impl Loss for Aligned {
    fn evaluate(&self, map: Map, weight: f64, gradient: &mut [DVec2]) -> f64 {
        let n = self.points.len() as f64;
        let v = |vertex: u32| map.uv[vertex as usize].y;
        let mean = self.points.iter().map(|(p, _)| v(*p)).sum::<f64>() / n;
        let variance = self.points.iter().map(|(p, _)| (v(*p) - mean).powi(2)).sum::<f64>() / n;
        let (deviation, unit) = (variance.sqrt(), variance.sqrt() + EPSILON);
        let (mut sum, mut residuals, mut along) = (0.0, 0.0, 0.0);
        for (p, z) in &self.points {
            let centred = v(*p) - mean;
            let residual = centred / unit - z;
            sum += residual * residual;
            residuals += residual;
            along += residual * centred;
        }
        let slope = 2.0 * weight / (n * unit);
        // How the deviation, which divides, moves with v.
        let by_deviation = if deviation > 0.0 { along / (n * unit * deviation) } else { 0.0 };
        for (p, z) in &self.points {
            let centred = v(*p) - mean;
            let residual = centred / unit - z;
            gradient[*p as usize].y += slope * (residual - residuals / n - by_deviation * centred);
        }
        sum / n
    }
}

#[cfg(test)]
mod tests {
    use super::super::scenes::{cone, cylinder};
    use super::super::{Annealing, ChartTerms, LossContext, Term};
    use super::*;
    use crate::contract::LossForm;

    fn value(form: LossForm, change: impl Fn(DVec2) -> DVec2) -> f64 {
        let scene = cylinder();
        let heights = scene.disk.positions.iter().map(|p| p.z).collect();
        let target = CylinderTarget { developed: scene.uv.clone(), heights };
        let context = LossContext { form, cylinder: Some(target), ..Default::default() };
        let terms = ChartTerms::new(&scene.disk, context);
        let uv: Vec<DVec2> = scene.uv.iter().map(|p| change(*p)).collect();
        let mut gradient = uv.clone();
        terms.evaluate(Term::Cylindrical, &uv, 1.0, Annealing::at(0.0), &mut gradient)
    }

    #[test]
    fn any_rotation_fits_but_no_mirror_and_no_other_shape() {
        let turn = DVec2::from_angle(2.5);
        assert!(value(LossForm::Sound, |p| turn.rotate(p) + DVec2::new(5.0, 1.0)) < 1e-12);
        assert!(value(LossForm::Sound, |p| turn.rotate(p * DVec2::new(-1.0, 1.0))) > 0.1);
        // A point is one variance away.
        assert!((value(LossForm::Sound, |_| DVec2::ONE) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_papers_form_wants_v_along_the_axis_at_any_scale() {
        // Not exactly 0, since ε = 1e-6 is added to the deviation.
        assert!(value(LossForm::Paper, |p| DVec2::new(p.x.sin(), 3.0 * p.y + 1.0)) < 1e-9);
        assert!(value(LossForm::Paper, |p| DVec2::new(p.y, p.x)) > 1.0);
    }

    /// The arc is longer than its chord by θ²/24: 0.3 % at 24 strips, so 10⁻⁵ in the square.
    #[test]
    fn cylinders_and_cones_fit_their_own_target() {
        let cases =
            [(cylinder(), DVec3::Z, 0.0), (cone(), DVec3::Z, -0.4), (cone(), -DVec3::Z, 0.4)];
        for (scene, axis, taper) in cases {
            let target = CylinderTarget::new(&scene.disk, DVec3::ZERO, axis, 2.0, taper);
            let context = LossContext { cylinder: Some(target), ..Default::default() };
            let terms = ChartTerms::new(&scene.disk, context);
            let mut gradient = scene.uv.clone();
            let at = Annealing::at(0.0);
            let value = terms.evaluate(Term::Cylindrical, &scene.uv, 1.0, at, &mut gradient);
            assert!(value < 1e-5, "{} {value}", scene.name);
        }
    }
}
