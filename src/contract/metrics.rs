//! The shape of `metrics.json`: what is told of the job, the atlas, its parts and its charts. The definitions
//! are in docs/metrics.md.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{
    Certificate, ChartForm, Figures, Repairs, SegmentationSource, ShapeKind, StartKind, Warning,
};

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
    /// How many where only a common edge joins faces: a chart that hangs together by a vertex on an edge (a
    /// T-junction) counts more than once.
    #[serde(default)]
    #[schema(required)]
    pub edge_charts: u32,
    /// Proof of validity.
    pub certificate: Certificate,
    /// Share of the page that is used.
    pub packing_efficiency: PackingEfficiency,
    /// Share of the area that is developable: |K|·A < 0.05, with K the Gauss curvature at an inner
    /// vertex of a chart of area A.
    #[schema(required)]
    pub developable: Option<f64>,
    /// Length of the seam curves over that of the same curves after a moving average over 7 mean edges of the
    /// mesh: 1 is straight, a zigzag of single edges about √2; null without seams.
    #[schema(required)]
    pub seam_jaggedness: Option<f64>,
    /// The same against a moving average over 15 mean edges.
    #[schema(required)]
    pub seam_jaggedness_15: Option<f64>,
    /// Charts below 64 texels that could be larger.
    #[serde(default)]
    #[schema(required)]
    pub small_charts: u32,
    /// Charts below 64 texels whose connected component, given label, authored part or material (where each
    /// has an atlas) is as small itself.
    #[serde(default)]
    #[schema(required)]
    pub small_charts_exempt: u32,
    /// How components of many faces were cut; null where there are none.
    #[serde(default)]
    #[schema(required)]
    pub coarse_to_fine: Option<CoarseToFine>,
    /// The objective of the charts: distortion, seams and their number in one figure (docs/metrics.md). What
    /// charts are cut to make small.
    pub objective: f64,
    /// What training the seams was worth; null where it was not tried (`quality` below `best`).
    #[schema(required)]
    pub joint_seams: Option<JointSeams>,
    /// Meshes that the scene shows several times; null where there are none.
    #[schema(required)]
    pub instances: Option<InstanceMetrics>,
    /// The figures of all faces together.
    #[serde(flatten)]
    pub figures: Figures,
}

/// Meshes that a scene shows several times. Every figure is of each mesh where its largest instance (by
/// volume; the first of them) stands.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct InstanceMetrics {
    /// Instances in all.
    pub count: u32,
    /// Those that are scaled unevenly against the one that is measured: the same coordinates are more
    /// distorted there.
    pub uneven: u32,
    /// Of those, the one with the most distortion.
    #[schema(required)]
    pub worst: Option<WorstInstance>,
}

/// The instance that is distorted most.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct WorstInstance {
    /// Its node, by its number in the file.
    pub node: u32,
    /// Symmetric Dirichlet energy of its mesh there, each chart at its own best scale: 1 is isometric.
    pub symmetric_dirichlet: f64,
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
    /// How sure that source was that this is a part, 0 to 1.
    pub confidence: f64,
    /// How likely the network's name is right, 0 to 1; null where the name is not the network's.
    #[schema(required)]
    pub name_confidence: Option<f64>,
    /// How many faces.
    pub faces: u64,
    /// The charts that its faces lie in, by number.
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
    /// The map carried over from the chart's proxy, relaxed, where there is one.
    #[serde(default)]
    #[schema(required)]
    pub prolonged: Option<f64>,
    /// The same, polished: the baseline where there is one.
    #[serde(default)]
    #[schema(required)]
    pub prolonged_polish: Option<f64>,
    /// The classical start map.
    #[schema(required)]
    pub start: Option<f64>,
    /// The start map, polished: the baseline where no map was carried over.
    #[schema(required)]
    pub start_polish: Option<f64>,
    /// The network's map.
    #[schema(required)]
    pub net: Option<f64>,
    /// The network's map, polished.
    #[schema(required)]
    pub net_polish: Option<f64>,
    /// (baseline − net_polish)/baseline: above 0 where the network earns its place.
    #[schema(required)]
    pub gain: Option<f64>,
}

/// One chart.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct ChartMetrics {
    /// Its number.
    pub id: u32,
    /// The parts that its faces are of, by number, that of most area first. Few charts have several: those
    /// with specks, and those whose border gave way to `max_charts`.
    pub parts: Vec<u32>,
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

/// How dense components, those of more than 12,000 faces, were cut (docs/coarse_to_fine.md).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct CoarseToFine {
    /// Those that were cut on a coarse proxy, from which charts were carried back.
    pub components: u32,
    /// Those that were cut as they are: they cannot be collapsed, or have too many holes for it.
    pub as_they_are: u32,
    /// Charts of the former that were carried back.
    pub carried: u32,
    /// Charts of the former that were made on the mesh itself, where carrying them back failed.
    pub otherwise: u32,
    /// Share of their area in charts that were carried back; null where there is none.
    #[schema(required)]
    pub carried_area: Option<f64>,
}

/// Time of one stage.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct StageCost {
    /// The stage.
    pub name: String,
    /// Wall-clock seconds.
    pub wall_s: f64,
    /// CPU seconds over all threads of the process.
    pub cpu_s: f64,
    /// Work that was counted, begun ahead of its turn or not: in `unit`.
    pub work: u64,
    /// What the work is counted in.
    pub unit: String,
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
    /// Threads that the job could use.
    #[serde(default)]
    pub threads: u32,
}

/// Units of the figures that have one.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Units {
    /// Unit of lengths: the file's world unit.
    pub length: String,
}

impl Metrics {
    /// The same without what differs from run to run: what the job cost.
    pub fn without_cost(&self) -> Self {
        let summary = Summary { seconds: 0.0, ..self.summary.clone() };
        Self { summary, cost: Cost::default(), ..self.clone() }
    }
}

impl Default for Units {
    fn default() -> Self {
        Self { length: "world".into() }
    }
}

/// The result at a glance.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct Summary {
    /// Whether the atlas is valid: `atlas.certificate.valid`; null where the job ends with its parts.
    #[schema(required)]
    pub valid: Option<bool>,
    /// How many parts.
    pub parts: u32,
    /// How many charts.
    pub charts: u32,
    /// On how many pages.
    pub pages: u32,
    /// Seam length over √(3D area): `atlas.seam_length.per_sqrt_area`.
    #[schema(required)]
    pub seam_length: Option<f64>,
    /// `atlas.symmetric_dirichlet_chart`: 1 is isometric. Each chart is taken at its own scale, so that texel
    /// densities that were asked for do not count as distortion.
    #[schema(required)]
    pub symmetric_dirichlet: Option<f64>,
    /// Coefficient of variation of the texel density, where it was asked to differ (`density`, or an atlas for
    /// each material); else null.
    #[schema(required)]
    pub density_variation: Option<f64>,
    /// Share of the pages that is covered: `atlas.packing_efficiency.covered`.
    pub packing: f64,
    /// Charts whose map is the network's: it was better there than the start map after the same descent.
    pub charts_of_network: u32,
    /// Wall-clock seconds: `cost.wall_s`.
    pub seconds: f64,
    /// What the user should know, as it was told while the job ran.
    pub warnings: Vec<Warning>,
}

/// `metrics.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Metrics {
    /// Version of this shape.
    pub schema: u32,
    /// The result at a glance.
    pub summary: Summary,
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
