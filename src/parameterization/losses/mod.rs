//! The losses of one chart (paper 2.3): value and gradient with respect to the UVs, in closed form,
//! in f64, measured on the chart's real triangles and edges, so on the very map that ships. One file
//! a loss. The reconstruction loss is not here: it needs the networks.
//!
//! Every sound form sees the map divided by its scale `s` ([`ChartTerms::scale`]), which is held
//! constant, and is 0 at every isometry. The paper's own forms ([`LossForm::Paper`]) see the map as
//! it is; they are kept so that its ablations can be rerun.

mod barrier;
mod boundary;
mod cluster;
mod conformal;
mod connectivity;
mod continuation;
mod cylindrical;
mod edges;
mod neighbours;
#[cfg(test)]
mod scenes;
mod smooth;
mod stretch;
mod term;
#[cfg(test)]
mod tests;
mod triangles;

use std::fmt::Debug;

use glam::DVec2;

pub use boundary::{CutEdge, OverCut};
pub use cylindrical::CylinderTarget;
#[cfg(test)]
pub(super) use scenes::plane;
pub use term::{Annealing, RECONSTRUCTION, Term, TermValues};

use crate::contract::LossForm;
use crate::flatten::Disk;

/// A map at one step of the training.
#[derive(Clone, Copy)]
struct Map<'a> {
    /// One entry a vertex of the disk.
    uv: &'a [DVec2],
    /// Scale of the map, held constant.
    scale: f64,
    at: Annealing,
}

/// A loss, prepared for one chart.
trait Loss: Debug + Send + Sync {
    /// Its value. `weight` times its gradient with respect to the UVs is added to `gradient`.
    fn evaluate(&self, map: Map, weight: f64, gradient: &mut [DVec2]) -> f64;
}

/// What the losses of a chart need to know besides its mesh.
#[derive(Debug, Clone, Default)]
pub struct LossContext<'a> {
    /// Which formulas.
    pub form: LossForm,
    /// The triangles to measure; all of them if absent. The smoothness loss sees only pairs of
    /// adjacent triangles of the selection, so select triangles together with their neighbours.
    pub faces: Option<&'a [u32]>,
    /// The unrolled shape of a tubular chart.
    pub cylinder: Option<CylinderTarget>,
    /// Candidate seams, where the UVs are those of an over-cut mesh.
    pub over_cut: Option<OverCut>,
    /// Class of each vertex, for the paper's cluster loss; all are of one class if absent.
    pub classes: Option<&'a [u32]>,
}

/// The losses of one chart: everything that depends on the mesh alone is worked out once.
#[derive(Debug)]
pub struct ChartTerms {
    /// Measures the scale in both forms; conformal, stretch and barrier in the sound form.
    triangles: triangles::Triangles,
    form: LossForm,
    /// The terms that have something to measure here, besides those of `triangles`.
    losses: Vec<(Term, Box<dyn Loss>)>,
    vertices: Vec<u32>,
}

impl ChartTerms {
    /// Prepare the losses of a chart. Triangles without area and edges without length are left out,
    /// and so is a term with nothing to measure. Entries of `context` that do not fit the disk
    /// (wrong length, index out of range) are ignored.
    pub fn new(disk: &Disk, context: LossContext) -> Self {
        let n = disk.positions.len();
        let selected = edges::select(disk, context.faces);
        let triangles = triangles::Triangles::new(disk, &selected);
        let links = edges::links(disk);
        let lines = edges::edges(disk, &links, &selected);
        let mut vertices = triangles.vertices();
        let cylinder = context.cylinder.filter(|target| target.fits(n));
        let over_cut = context.over_cut.filter(|cut| cut.fits(n));
        let mut losses: Vec<(Term, Box<dyn Loss>)> = Vec::new();
        let mut keep = |term, loss: Option<Box<dyn Loss>>| losses.extend(loss.map(|l| (term, l)));
        match context.form {
            LossForm::Sound => {
                keep(Term::Smooth, smooth::Bending::prepare(disk, &links, &selected));
                keep(Term::Cluster, cluster::Compactness::prepare(disk, &links, &mut vertices));
                keep(Term::Connectivity, connectivity::Tearing::prepare(lines));
                let unrolled = cylinder.and_then(|c| cylindrical::Unrolled::prepare(&triangles, c));
                keep(Term::Cylindrical, unrolled);
            }
            LossForm::Paper => {
                let pairs = neighbours::pairs(disk, &vertices);
                let classes = context.classes.filter(|classes| classes.len() == n);
                keep(Term::Conformal, conformal::Angles::prepare(disk, &selected));
                keep(Term::Stretch, stretch::EdgeRatios::prepare(lines));
                keep(Term::Cluster, cluster::Centroids::prepare(disk, &vertices, classes));
                keep(Term::Smooth, smooth::Closeness::prepare(&pairs, vertices.len()));
                keep(Term::Connectivity, connectivity::Distances::prepare(pairs));
                let aligned = cylinder.and_then(|c| cylindrical::Aligned::prepare(&vertices, c));
                keep(Term::Cylindrical, aligned);
            }
        }
        keep(
            Term::Boundary,
            over_cut.and_then(|cut| boundary::Openness::prepare(cut, &mut vertices)),
        );
        vertices.sort_unstable();
        vertices.dedup();
        Self { triangles, form: context.form, losses, vertices }
    }

    /// Whether the term has anything to measure on this chart.
    pub fn has(&self, term: Term) -> bool {
        self.by_triangles(term) || self.losses.iter().any(|(t, _)| *t == term)
    }

    /// Vertices that the losses read, in ascending order: only these need UVs when a selection of
    /// faces is measured.
    pub fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// Scale of a map: √(UV area / 3D area) over the measured triangles, areas counted without
    /// sign; at least 1e-12.
    pub fn scale(&self, uv: &[DVec2]) -> f64 {
        self.triangles.scale(uv)
    }

    /// Value of one term at the map `uv` (one entry a vertex of the disk), 0 where the chart does
    /// not have the term; its gradient is added to `gradient`. `scale` is [`Self::scale`] of the
    /// step and is held constant.
    pub fn evaluate(
        &self,
        term: Term,
        uv: &[DVec2],
        scale: f64,
        at: Annealing,
        gradient: &mut [DVec2],
    ) -> f64 {
        let mut weights = TermValues::default();
        weights[term as usize] = 1.0;
        self.evaluate_sum(&weights, uv, scale, at, gradient)[term as usize]
    }

    /// Values of all terms whose weight is not 0, each without its weight (0 for the others). The
    /// gradient of the weighted sum is added to `gradient`. Cheaper than the terms one by one.
    pub fn evaluate_sum(
        &self,
        weights: &TermValues,
        uv: &[DVec2],
        scale: f64,
        at: Annealing,
        gradient: &mut [DVec2],
    ) -> TermValues {
        let map = Map { uv, scale, at };
        let mut values = TermValues::default();
        if Term::ALL.iter().any(|t| self.by_triangles(*t) && weights[*t as usize] != 0.0) {
            self.triangles.evaluate(map, weights, gradient, &mut values);
        }
        for (term, loss) in &self.losses {
            let weight = weights[*term as usize];
            if weight != 0.0 {
                values[*term as usize] = loss.evaluate(map, weight, gradient);
            }
        }
        values
    }

    /// Whether the one pass over the triangles measures the term.
    fn by_triangles(&self, term: Term) -> bool {
        self.form == LossForm::Sound
            && !self.triangles.is_empty()
            && matches!(term, Term::Conformal | Term::Stretch | Term::Barrier)
    }
}
