//! Smoothness loss (paper 2.3.5). Sound form: Σ_e w_e ‖J_f − J_g‖² / (s² Σ_e w_e) over pairs of adjacent
//! triangles, their tangent planes unfolded about the edge e between them, w_e = ℓ_e² / (A_f + A_g), not
//! across creases or cuts. Along e the two Jacobians agree, so their difference is
//! (Σ_k a_k u_k) ⊗ normal of e over the four corners, with a_k fixed by the unfolded shape: 0 at every
//! isometry. Paper's form: (1/N) Σ ‖u_i − u_j‖² over nearest neighbours, which shrinks the map.

use glam::{DVec2, DVec3};

use super::edges::{Link, length, mask};
use super::{Loss, Map};
use crate::flatten::Disk;
use crate::mesh::CREASE;

/// Two adjacent triangles.
#[derive(Debug, Clone, Copy)]
struct Hinge {
    /// The ends of the edge, then the two apexes.
    corners: [u32; 4],
    /// The a_k times √w_e.
    coefficients: [f64; 4],
}

/// The sound form.
#[derive(Debug)]
pub(super) struct Bending {
    hinges: Vec<Hinge>,
}

impl Bending {
    pub fn prepare(disk: &Disk, links: &[Link], selected: &[u32]) -> Option<Box<dyn Loss>> {
        let mask = mask(disk, selected);
        let (mut hinges, mut total) = (Vec::new(), 0.0);
        for link in links {
            let Some((hinge, weight)) = hinge(disk, link) else { continue };
            if mask[link.left.face as usize] && link.right.is_some_and(|r| mask[r.face as usize]) {
                total += weight;
                hinges.push(hinge);
            }
        }
        for hinge in &mut hinges {
            hinge.coefficients = hinge.coefficients.map(|a| a / f64::sqrt(total));
        }
        (!hinges.is_empty()).then(|| Box::new(Self { hinges }) as Box<dyn Loss>)
    }
}

/// The pair of triangles at an edge and its w_e, unless the edge is a border or a crease or a
/// triangle has no area.
fn hinge(disk: &Disk, link: &Link) -> Option<(Hinge, f64)> {
    let right = link.right?;
    let [i, j] = link.ends.map(|v| disk.positions[v as usize]);
    let [k, l] = [link.left.apex, right.apex].map(|v| disk.positions[v as usize]);
    let areas = disk.areas[link.left.face as usize] + disk.areas[right.face as usize];
    let (e, long) = (j - i, length(disk, link));
    let height = |apex: DVec3| e.cross(apex - i).length() / long;
    let (height_k, height_l) = (height(k), height(l));
    if !(height_k > 0.0 && height_l > 0.0) {
        return None;
    }
    if e.cross(k - i).angle_between((l - i).cross(e)) > CREASE {
        return None;
    }
    // The derivative across e is (apex − its foot on e) / height on either side, towards the apex.
    let foot = |apex: DVec3| e.dot(apex - i) / (long * long);
    let (foot_k, foot_l) = (foot(k), foot(l));
    let a = [
        (foot_k - 1.0) / height_k + (foot_l - 1.0) / height_l,
        -foot_k / height_k - foot_l / height_l,
        1.0 / height_k,
        1.0 / height_l,
    ];
    let weight = long * long / areas;
    let corners = [link.ends[0], link.ends[1], link.left.apex, right.apex];
    Some((Hinge { corners, coefficients: a.map(|a| a * weight.sqrt()) }, weight))
}

impl Loss for Bending {
    fn evaluate(&self, map: Map, weight: f64, gradient: &mut [DVec2]) -> f64 {
        let per_square = 1.0 / (map.scale * map.scale);
        let mut sum = 0.0;
        for Hinge { corners, coefficients } in &self.hinges {
            let mut jump = DVec2::ZERO;
            for (v, a) in corners.iter().zip(coefficients) {
                jump += *a * map.uv[*v as usize];
            }
            sum += jump.length_squared();
            let slope = jump * (2.0 * weight * per_square);
            for (v, a) in corners.iter().zip(coefficients) {
                gradient[*v as usize] += *a * slope;
            }
        }
        sum * per_square
    }
}

/// The paper's form.
#[derive(Debug)]
pub(super) struct Closeness {
    pairs: Vec<[u32; 2]>,
    points: f64,
}

impl Closeness {
    /// `pairs` of neighbours among so many `points`.
    pub fn prepare(pairs: &[[u32; 2]], points: usize) -> Option<Box<dyn Loss>> {
        let loss = || Box::new(Self { pairs: pairs.to_vec(), points: points as f64 });
        (!pairs.is_empty()).then(|| loss() as Box<dyn Loss>)
    }
}

impl Loss for Closeness {
    fn evaluate(&self, map: Map, weight: f64, gradient: &mut [DVec2]) -> f64 {
        let mut sum = 0.0;
        for [i, j] in self.pairs.iter().map(|pair| pair.map(|v| v as usize)) {
            let delta = map.uv[i] - map.uv[j];
            sum += delta.length_squared();
            let force = delta * (2.0 * weight / self.points);
            gradient[i] += force;
            gradient[j] -= force;
        }
        sum / self.points
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::scenes::plane;
    use super::super::{Annealing, ChartTerms, LossContext, Term};
    use super::*;
    use crate::contract::LossForm;

    /// Two unit right triangles on the edge (0, 0)–(0, 1), the right one turned down by `fold`.
    fn fold(fold: f64) -> Disk {
        let (sin, cos) = fold.sin_cos();
        let right = DVec3::new(cos, 0.0, -sin);
        Disk::new(vec![DVec3::ZERO, DVec3::Y, -DVec3::X, right], vec![[0, 1, 2], [1, 0, 3]])
    }

    /// With the right triangle stretched by 3 across the edge, the Jacobians differ by 2 in one entry,
    /// whatever the fold; w = ℓ² / (½ + ½) = 1. A fold sharper than 30° is a crease.
    #[test]
    fn measures_the_jump_of_the_jacobian_over_soft_folds() {
        let uv = [DVec2::ZERO, DVec2::Y, -DVec2::X, 3.0 * DVec2::X];
        for (angle, expected) in [(0.0, 4.0), (0.3, 4.0), (0.6, 0.0)] {
            let terms = ChartTerms::new(&fold(angle), LossContext::default());
            let mut gradient = [DVec2::ZERO; 4];
            let value = terms.evaluate(Term::Smooth, &uv, 1.0, Annealing::at(0.0), &mut gradient);
            assert!((value - expected).abs() < 1e-12, "{angle} {value}");
        }
    }

    /// A shear of the whole plane is no isometry but has one Jacobian everywhere.
    #[test]
    fn linear_maps_are_smooth_and_the_papers_form_wants_a_point() {
        let scene = plane();
        let value = |form: LossForm, size: f64| {
            let sheared = |p: &DVec2| DVec2::new(p.x + 0.7 * p.y, 2.0 * p.y) * size;
            let uv: Vec<DVec2> = scene.uv.iter().map(sheared).collect();
            let mut gradient = uv.clone();
            scene.terms(form, None).evaluate(
                Term::Smooth,
                &uv,
                1.0,
                Annealing::at(0.0),
                &mut gradient,
            )
        };
        assert!(value(LossForm::Sound, 1.0) < 1e-20);
        assert!(value(LossForm::Paper, 1.0) > 0.1 && value(LossForm::Paper, 0.0) == 0.0);
    }
}
