//! The names of the losses, their weights (paper 2.3.8) and what is tightened while training runs.

/// λ of the reconstruction loss (paper 2.3.8), which the trainer measures.
pub const RECONSTRUCTION: f64 = 0.3;

/// A loss on the UVs of a chart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Term {
    /// Angles (paper 2.3.3).
    Conformal,
    /// Lengths and areas (paper 2.3.4).
    Stretch,
    /// Change of the Jacobian from face to face (paper 2.3.5).
    Smooth,
    /// Openness of the candidate seams (in the paper's sum, 2.3.8, but not defined there).
    Boundary,
    /// Compactness of the chart (paper 2.3.6).
    Cluster,
    /// Edges must not be torn (paper 2.3.7).
    Connectivity,
    /// Cylinders and cones unroll straight (paper 2.3.1).
    Cylindrical,
    /// Nothing may fold: the symmetric Dirichlet energy (not in the paper).
    Barrier,
}

/// One number for each of [`Term::ALL`], indexed by `term as usize`.
pub type TermValues = [f64; Term::ALL.len()];

impl Term {
    /// Every term, in the order of [`TermValues`].
    pub const ALL: [Self; 8] = [
        Self::Conformal,
        Self::Stretch,
        Self::Smooth,
        Self::Boundary,
        Self::Cluster,
        Self::Connectivity,
        Self::Cylindrical,
        Self::Barrier,
    ];

    /// Weight of the term before balancing (paper 2.3.8; the barrier's is ours).
    pub fn lambda(self) -> f64 {
        match self {
            Self::Conformal | Self::Cluster => 0.8,
            Self::Stretch | Self::Smooth => 0.5,
            Self::Boundary | Self::Connectivity | Self::Barrier => 1.0,
            Self::Cylindrical => 1.2,
        }
    }
}

/// What is tightened while training runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Annealing {
    /// Below this, inverse powers of det J̃ are continued by their Taylor polynomial.
    pub epsilon: f64,
    /// Gap, in part radii, at which a candidate seam counts as half open.
    pub delta: f64,
}

/// Where δ starts: above the widest gap that a closed part can have, the circumference of a tube, 2π
/// radii. On 100 rings of 8 strips cut open in a wrong place, the cheapest seam is open at the end in 25
/// where δ starts at 2, in 92 where it starts at 4, and in 99 (one tie) from 8 on.
const DELTA_AT_FIRST: f64 = 8.0;

/// Where δ ends.
const DELTA_AT_LAST: f64 = 0.01;

impl Annealing {
    /// Geometric: ε from 0.1 at `progress` 0 to 0.01 at 1, δ from 8 to 0.01.
    pub fn at(progress: f64) -> Self {
        let t = progress.clamp(0.0, 1.0);
        let between = |first: f64, last: f64| first * (last / first).powf(t);
        Self { epsilon: between(0.1, 0.01), delta: between(DELTA_AT_FIRST, DELTA_AT_LAST) }
    }
}
