//! The shape of `metrics.json`. A figure that cannot be had is null: never 0, never absent.
//! The definitions are in docs/metrics.md and beside the code that takes each figure.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{Certificate, ChartForm, SegmentationSource, ShapeKind, StartKind};

/// An area-weighted per-face figure.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct FaceStats {
    /// Area-weighted mean.
    pub mean: f64,
    /// Area-weighted 95th percentile.
    pub p95: f64,
    /// Largest.
    pub max: f64,
}

/// Texels per world unit, √(σ1σ2) over the faces, at the stated page size.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct TexelDensity {
    /// Smallest.
    pub min: f64,
    /// Area-weighted mean.
    pub mean: f64,
    /// Largest.
    pub max: f64,
    /// Coefficient of variation: 0 when the density is even.
    pub cv: f64,
}

/// A length in 3D, made free of the object's size.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct SeamLength {
    /// Over √(3D area).
    pub per_sqrt_area: f64,
    /// Over the diagonal of the bounding box.
    pub per_diagonal: f64,
}

/// PartUV's area figure: max(r, 1/r) clipped at 10, unweighted over faces.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct PartUvArea {
    /// The worst chart's mean.
    pub worst_chart: f64,
    /// The mean over all faces at one scale.
    pub overall: f64,
}

/// How well seams and part boundaries agree, within 1 % of the diagonal.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct BoundaryAlignment {
    /// Seam length near a part boundary / seam length.
    pub precision: f64,
    /// Part-boundary length that is seam / part-boundary length.
    pub recall: f64,
    /// Harmonic mean of both.
    pub f1: f64,
    /// The best precision possible: part-boundary length / seam length, at most 1.
    pub ceiling: f64,
    /// Length of contact curves between components (within 0.5 % of the diagonal) / diagonal.
    pub contact_length: f64,
}

/// The paper's conformality, on the shipped atlas and at its worst rotation.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct PaperConformality {
    /// mean |cos(∂p/∂u, ∂p/∂v)|.
    pub shipped: f64,
    /// mean (σ1² − σ2²)/(σ1² + σ2²).
    pub worst_rotation: f64,
}

/// The paper's internal consistency, by distance over the chart and by straight distance.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct PaperInternalConsistency {
    /// Over the 8 nearest by chart-graph distance.
    pub geodesic: f64,
    /// Over the 8 nearest by straight distance, each term clipped at 1.
    pub euclidean: f64,
}

/// The paper's boundary compactness (reconstructed) and the usual one.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct PaperBoundaryCompactness {
    /// |S∩B| / |S∪B| of seam and part-boundary length; null without parts that share edges.
    #[schema(required)]
    pub seam_boundary_overlap: Option<f64>,
    /// Area-weighted mean over charts of 4πA/P².
    pub isoperimetric: f64,
}

/// The figures that are taken at every level: atlas, part, chart. σ1 ≥ σ2 are the singular values
/// of the map from a face's tangent plane to UV; s is the scale that makes total UV area equal
/// total 3D area, global except where the name ends in `_chart`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct Figures {
    /// σ1/σ2.
    #[schema(required)]
    pub quasi_conformal: Option<FaceStats>,
    /// ½√(Σw(σ1²+σ2²)·Σw(σ1⁻²+σ2⁻²))/Σw at the best common scale: 1 is isometric.
    #[schema(required)]
    pub symmetric_dirichlet: Option<f64>,
    /// The same with each chart at its own best scale.
    #[schema(required)]
    pub symmetric_dirichlet_chart: Option<f64>,
    /// max(r, 1/r), r = σ1σ2/s².
    #[schema(required)]
    pub area_distortion: Option<FaceStats>,
    /// The same with each chart at its own scale.
    #[schema(required)]
    pub area_distortion_chart: Option<FaceStats>,
    /// Root of the area-weighted mean of (σ1⁻²+σ2⁻²)/2, scaled (Sander et al. 2001).
    #[schema(required)]
    pub stretch_l2: Option<f64>,
    /// Largest 1/σ2, scaled.
    #[schema(required)]
    pub stretch_linf: Option<f64>,
    /// Texels per world unit.
    #[schema(required)]
    pub texel_density: Option<TexelDensity>,
    /// Cuts: an edge of k faces needs ⌈k/2⌉ different UV edges, and each further one is a cut.
    pub seam_edges: u64,
    /// Their length in 3D, counted once.
    #[schema(required)]
    pub seam_length: Option<SeamLength>,
    /// Seam length that is neither near a part boundary, nor at a crease, nor hidden / seam length.
    #[schema(required)]
    pub avoidable_seam: Option<f64>,
    /// Seams against part boundaries; null without parts that share edges.
    #[schema(required)]
    pub boundary_alignment: Option<BoundaryAlignment>,
    /// 1 − mean |cos(∂p/∂u, ∂p/∂v)| (PartUV's table).
    #[schema(required)]
    pub partuv_angular: Option<f64>,
    /// PartUV's area figure.
    #[schema(required)]
    pub partuv_area: Option<PartUvArea>,
    /// Angular distortion as the paper takes it.
    #[schema(required)]
    pub paper_conformality: Option<PaperConformality>,
    /// Whether near points stay near, as the paper takes it (reconstructed).
    #[schema(required)]
    pub paper_internal_consistency: Option<PaperInternalConsistency>,
    /// Seams against part boundaries as the paper takes it (reconstructed).
    #[schema(required)]
    pub paper_boundary_compactness: Option<PaperBoundaryCompactness>,
    /// ΣA·½(|σ1/s − 1| + |σ2/s − 1|)/ΣA (reconstructed).
    #[schema(required)]
    pub paper_texture_distortion: Option<f64>,
    /// √(ΣA·min_R‖J/s − R‖²/ΣA) (reconstructed).
    #[schema(required)]
    pub paper_mean_texture_error: Option<f64>,
    /// Chamfer distance of the round trip 3D → UV → 3D; null where no chart was trained.
    #[schema(required)]
    pub paper_chamfer: Option<f64>,
    /// Seam length over the diagonal, as in the paper's Table 2.
    #[schema(required)]
    pub paper_total_seam_length: Option<f64>,
    /// Connected seam curves, as in the paper's Table 4.
    pub paper_seam_count: u64,
    /// Charts, as in the paper's Table 4.
    pub paper_island_count: u64,
    /// Share of seam length near a part boundary, as in the paper's Table 4.
    #[schema(required)]
    pub paper_boundary_alignment_score: Option<f64>,
}

/// Covered share of the full square page.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct PackingEfficiency {
    /// UV area / page area.
    pub covered: f64,
    /// Texels that some chart owns / texels of the page, at the stated resolution.
    pub delivered: f64,
}

/// The atlas as a whole.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct AtlasMetrics {
    /// Pages.
    pub pages: u32,
    /// Whether page k is written to UDIM tile 1001 + k; otherwise all pages share [0, 1]².
    pub udim: bool,
    /// Texels across a page.
    pub width: u32,
    /// Texels down a page.
    pub height: u32,
    /// How many charts.
    pub charts: u32,
    /// Proof of validity.
    pub certificate: Certificate,
    /// Share of the page that is used.
    pub packing_efficiency: PackingEfficiency,
    /// Share of the area that is developable: |K|·A < 0.05, with K the Gauss curvature at an inner
    /// vertex of a chart of area A.
    #[schema(required)]
    pub developable: Option<f64>,
    /// What training the seams was worth; null where it was not tried (`quality` below `best`).
    #[schema(required)]
    pub joint_seams: Option<JointSeams>,
    /// The figures of all faces together.
    #[serde(flatten)]
    pub figures: Figures,
}

/// One part.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct PartMetrics {
    /// Its number: what face labels refer to.
    pub id: u32,
    /// Its name.
    pub name: String,
    /// Which source decided.
    pub source: SegmentationSource,
    /// How sure that source was, 0 to 1.
    pub confidence: f64,
    /// How many faces.
    pub faces: u64,
    /// Its charts, by number.
    pub charts: Vec<u32>,
    /// The figures of its faces.
    #[serde(flatten)]
    pub figures: Figures,
}

/// Two parts that would be joined next: the hierarchy above the parts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PartJoin {
    /// One of them; it stands for all that it was joined with before.
    pub a: u32,
    /// The other.
    pub b: u32,
    /// How likely a part ends between them, 0 to 1. A later join may be more certain than an earlier one.
    pub boundary: f64,
}

/// Seams found by training them with the maps, against merging alone.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct JointSeams {
    /// Connected components of parts that were merged both ways.
    pub pieces: u32,
    /// Of those, how many keep the trained seams.
    pub kept: u32,
    /// By which share the objective (energy, seam cost and charts) of all of them fell below merging
    /// alone; null where there was none.
    #[schema(required)]
    pub gain: Option<f64>,
}

/// What each way to the map reached (symmetric Dirichlet, 1 is isometric). Ways that did not run
/// are null.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct NeuralGain {
    /// The start map.
    #[schema(required)]
    pub start: Option<f64>,
    /// The start map, polished: the baseline.
    #[schema(required)]
    pub start_polish: Option<f64>,
    /// The network's map.
    #[schema(required)]
    pub net: Option<f64>,
    /// The network's map, polished.
    #[schema(required)]
    pub net_polish: Option<f64>,
    /// (start_polish − net_polish)/start_polish: above 0 where the network earns its place.
    #[schema(required)]
    pub gain: Option<f64>,
}

/// One chart.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct ChartMetrics {
    /// Its number.
    pub id: u32,
    /// The part it belongs to.
    pub part: u32,
    /// The page it is on, counted from 0.
    pub page: u32,
    /// How many faces.
    pub faces: u64,
    /// What shape it was taken for.
    pub shape: ShapeKind,
    /// How its start map was made.
    pub start: StartKind,
    /// How its map was made.
    pub form: ChartForm,
    /// Whether the start was isometric already, so that there was nothing to train.
    pub isometric_start: bool,
    /// Training steps it took part in.
    pub steps: u32,
    /// What the training gained.
    #[schema(required)]
    pub neural_gain: Option<NeuralGain>,
    /// Proof of validity.
    pub certificate: Certificate,
    /// The figures of its faces.
    #[serde(flatten)]
    pub figures: Figures,
}

/// What conditioning repaired, for the solvers only: the file keeps its geometry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
pub struct Repairs {
    /// Vertices merged with another at the same place.
    pub welded: u64,
    /// Faces without area.
    pub zero_area_faces: u64,
    /// Edges with more than two faces.
    pub nonmanifold_edges: u64,
    /// Vertices where several fans met, taken apart.
    pub split_vertices: u64,
    /// Faces whose winding disagreed with their neighbours'.
    pub reoriented_faces: u64,
    /// Faces that stand twice, with both windings.
    pub double_sided_faces: u64,
    /// Faces with more texels than their part's density asks for, since single precision would flatten
    /// them.
    #[serde(default)]
    pub enlarged_faces: u64,
}

/// Time of one stage.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct StageCost {
    /// The stage.
    pub name: String,
    /// Wall-clock seconds.
    pub wall_s: f64,
    /// CPU seconds over all threads.
    pub cpu_s: f64,
}

/// What the job cost. The one part of the metrics that differs from run to run.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct Cost {
    /// Every stage that ran, in order.
    pub stages: Vec<StageCost>,
    /// Wall-clock seconds of the whole pipeline.
    pub wall_s: f64,
    /// CPU seconds of the whole pipeline.
    pub cpu_s: f64,
    /// Most memory the process held, MiB.
    #[schema(required)]
    pub peak_memory_mib: Option<f64>,
    /// Training steps of the job.
    pub steps: u32,
    /// Device that trained.
    pub device: String,
}

/// Units of the figures that have one.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Units {
    /// Unit of lengths: the file's world unit.
    pub length: String,
}

impl Default for Units {
    fn default() -> Self {
        Self { length: "world".into() }
    }
}

/// `metrics.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Metrics {
    /// Version of this shape.
    pub schema: u32,
    /// Whether the result is a function of input, options, version, weights and device alone. False when
    /// the clock made a stage take its cheaper form; `degraded` names the stages.
    pub deterministic: bool,
    /// Stages that took a cheaper form for want of time or memory, with a sentence each.
    pub degraded: Vec<String>,
    /// Units.
    pub units: Units,
    /// The atlas.
    pub atlas: AtlasMetrics,
    /// The parts.
    pub parts: Vec<PartMetrics>,
    /// Which parts would be joined next, in order; empty where the source of the parts has no hierarchy.
    pub part_joins: Vec<PartJoin>,
    /// The charts.
    pub charts: Vec<ChartMetrics>,
    /// What was repaired.
    pub repairs: Repairs,
    /// Version of the program.
    pub engine: String,
    /// `sha256:…` of the segmentation network's weights; null where it was not asked.
    #[schema(required)]
    pub weights: Option<String>,
    /// Device that trained: its name as `uvsegnet doctor` prints it.
    pub device: String,
    /// What it cost.
    pub cost: Cost,
}
