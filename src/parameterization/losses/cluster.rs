//! Cluster loss (paper 2.3.6). Sound form: max(0, Q_uv / Q_3D − 1)², Q = P² / 4πA the isoperimetric
//! quotient of the chart, P the length of its rim and A its area: a chart may not become less compact
//! than its faces are in 3D, and every isometry scores 0. The UV area is signed, by the rim alone,
//! and its inverse continued below ε, so a chart turned inside out has a way back. Paper's form: the mean
//! distance to the class centroid, and a margin between centroids.

use glam::DVec2;

use super::continuation::inverse;
use super::edges::{Link, length};
use super::{Loss, Map};
use crate::flatten::Disk;

/// The sound form.
#[derive(Debug)]
pub(super) struct Compactness {
    /// Edges with one triangle, running as that triangle does.
    rim: Vec<[u32; 2]>,
    /// Length of the rim in 3D.
    perimeter: f64,
    /// Area of the whole chart in 3D.
    area: f64,
}

impl Compactness {
    /// Adds the vertices of the rim to `vertices`.
    pub fn prepare(disk: &Disk, links: &[Link], vertices: &mut Vec<u32>) -> Option<Box<dyn Loss>> {
        let open = || links.iter().filter(|link| link.right.is_none());
        let rim: Vec<[u32; 2]> = open().map(|link| link.ends).collect();
        let perimeter: f64 = open().map(|link| length(disk, link)).sum();
        let area = disk.area();
        if !(perimeter > 0.0 && area > 0.0) {
            return None;
        }
        vertices.extend(rim.iter().flatten());
        Some(Box::new(Self { rim, perimeter, area }))
    }
}

impl Loss for Compactness {
    fn evaluate(&self, map: Map, weight: f64, gradient: &mut [DVec2]) -> f64 {
        let ends = |[i, j]: [u32; 2]| [map.uv[i as usize], map.uv[j as usize]];
        // Seen from a point of the rim, so that the area does not cancel far from the origin.
        let origin = self.rim.first().map_or(DVec2::ZERO, |edge| ends(*edge)[0]);
        let (mut perimeter, mut area) = (0.0, 0.0);
        for edge in &self.rim {
            let [a, b] = ends(*edge);
            perimeter += a.distance(b);
            area += 0.5 * (a - origin).perp_dot(b - origin);
        }
        let per_square = 1.0 / (map.scale * map.scale);
        let long = perimeter * perimeter * per_square / (self.perimeter * self.perimeter);
        let inverse = inverse(area * per_square / self.area, map.at.epsilon);
        let excess = long * inverse.value - 1.0;
        if excess <= 0.0 {
            return 0.0;
        }
        let slope = 2.0 * weight * excess;
        let by_perimeter = slope * 2.0 * long / perimeter * inverse.value;
        let by_area = slope * long * inverse.derivative * per_square / self.area;
        for edge in &self.rim {
            let [a, b] = ends(*edge);
            let pull = (b - a).normalize_or_zero() * by_perimeter;
            gradient[edge[0] as usize] -= pull + (b - origin).perp() * (0.5 * by_area);
            gradient[edge[1] as usize] += pull + (a - origin).perp() * (0.5 * by_area);
        }
        excess * excess
    }
}

/// The paper's form.
#[derive(Debug)]
pub(super) struct Centroids {
    /// Vertices of each class; none is empty.
    classes: Vec<Vec<u32>>,
    /// Least distance between centroids. The paper does not give it: the radius of the circle that
    /// has the chart's 3D area.
    margin: f64,
}

impl Centroids {
    pub fn prepare(
        disk: &Disk,
        vertices: &[u32],
        classes: Option<&[u32]>,
    ) -> Option<Box<dyn Loss>> {
        let class = |v: u32| classes.map_or(0, |classes| classes[v as usize]);
        let mut ordered = vertices.to_vec();
        ordered.sort_by_key(|v| (class(*v), *v));
        let groups = ordered.chunk_by(|a, b| class(*a) == class(*b));
        let classes: Vec<Vec<u32>> = groups.map(<[u32]>::to_vec).collect();
        let margin = (disk.area() / std::f64::consts::PI).sqrt();
        (!classes.is_empty()).then(|| Box::new(Self { classes, margin }) as Box<dyn Loss>)
    }
}

impl Loss for Centroids {
    fn evaluate(&self, map: Map, weight: f64, gradient: &mut [DVec2]) -> f64 {
        let at = |v: &u32| map.uv[*v as usize];
        let mean = |class: &Vec<u32>| class.iter().map(at).sum::<DVec2>() / class.len() as f64;
        let centroids: Vec<DVec2> = self.classes.iter().map(mean).collect();
        let (mut pull, mut push) = (0.0, 0.0);
        for (c, (class, centroid)) in self.classes.iter().zip(&centroids).enumerate() {
            let share = 1.0 / (self.classes.len() * class.len()) as f64;
            let mut by_centroid = DVec2::ZERO;
            for v in class {
                let away = at(v) - centroid;
                pull += share * away.length();
                let force = away.normalize_or_zero() * (share * weight);
                gradient[*v as usize] += force;
                by_centroid -= force;
            }
            for (_, other) in centroids.iter().enumerate().filter(|(o, _)| *o != c) {
                let away = centroid - other;
                let missing = self.margin - away.length();
                if missing > 0.0 {
                    push += missing;
                    // The sum runs over ordered pairs, so this pair comes twice.
                    by_centroid -= away.normalize_or_zero() * (2.0 * weight);
                }
            }
            for v in class {
                gradient[*v as usize] += by_centroid / class.len() as f64;
            }
        }
        pull + push
    }
}

#[cfg(test)]
mod tests {
    use super::super::scenes::plane;
    use super::super::{Annealing, ChartTerms, LossContext, Term};
    use super::*;
    use crate::contract::LossForm;

    fn value(terms: &ChartTerms, uv: &[DVec2]) -> f64 {
        let mut gradient = uv.to_vec();
        terms.evaluate(Term::Cluster, uv, terms.scale(uv), Annealing::at(0.0), &mut gradient)
    }

    /// A long strip is as compact as it is in 3D, so it is left alone; so is a rounder map. Drawn out
    /// to four times its length, a chart of 7 × 4 is less compact.
    #[test]
    fn only_what_is_less_compact_than_in_3d_counts() {
        let scene = plane();
        let terms = scene.terms(LossForm::Sound, None);
        let drawn = |x: f64| scene.uv.iter().map(|p| *p * DVec2::new(x, 1.0)).collect::<Vec<_>>();
        assert!(value(&terms, &drawn(1.0)) < 1e-20);
        assert_eq!(value(&terms, &drawn(0.6)), 0.0);
        assert!(value(&terms, &drawn(4.0)) > 0.1);
        assert!(value(&terms, &drawn(-1.0)) > 100.0, "inside out");
    }

    #[test]
    fn the_papers_form_pulls_to_centroids_and_keeps_them_apart() {
        let scene = plane();
        let one = LossContext { form: LossForm::Paper, ..Default::default() };
        let point = vec![DVec2::ONE; scene.uv.len()];
        assert_eq!(value(&ChartTerms::new(&scene.disk, one), &point), 0.0);
        // Two classes at one point: each ordered pair misses the whole margin.
        let classes: Vec<u32> = (0..scene.uv.len() as u32).map(|v| 7 * (v % 2)).collect();
        let two =
            LossContext { form: LossForm::Paper, classes: Some(&classes), ..Default::default() };
        let margin = (scene.disk.area() / std::f64::consts::PI).sqrt();
        let found = value(&ChartTerms::new(&scene.disk, two), &point);
        assert!((found - 2.0 * margin).abs() < 1e-12);
    }
}
