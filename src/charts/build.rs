//! Parts into charts (docs/method.md, section 4): the side of a tube with one axial cut, everything else as
//! patches, all merged while the objective falls and the distortion bound holds.

use rayon::prelude::*;

use super::chart::{Chart, ChartShape};
use super::joins::merge::merge;
use super::limits::ChartLimits;
use super::limits::cost::edge_cost;
use super::limits::extent::shorten;
use super::limits::visibility::visibility;
use super::moves::compact::compact;
use super::moves::straighten::straighten;
use super::part_mesh::PartMesh;
use super::patches::patches;
use super::patches::sides::{Side, sides};
use super::patches::split::halves;
use super::patches::tube::{self, Tube};
use super::patchwork::Patchwork;
use crate::contract::{Canceled, GaveUp, Run, Stage, Steps, UnwrapOptions};
use crate::device::Seeded;
use crate::flatten;
use crate::mesh::{NONE, Surface};

/// Orders drawn at random in which a part is joined besides the first …
const RESTARTS: usize = 4;

/// … of a surface of so many faces or fewer; one of more gets the fewer of them.
const RESTARTED_FACES: usize = 4_000;

/// Patches below which there is nothing to choose.
pub const LEAST_PATCHES: usize = 3;

/// Rounds of joining charts and moving their seams …
const ROUNDS: usize = 3;

/// … of a component of so many faces or fewer; one of more gets the fewer of them, but one.
const ROUND_FACES: usize = 60_000;

/// Steps of a component that progress is counted by: patches, the first merging, the others, the last moves.
const STEPS: usize = 4;

/// What the cut is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChartOptions {
    /// Largest area-weighted mean symmetric Dirichlet energy of a chart, minus 1.
    pub distortion_bound: f64,
}

impl From<&UnwrapOptions> for ChartOptions {
    fn from(options: &UnwrapOptions) -> Self {
        Self { distortion_bound: options.distortion_bound }
    }
}

/// Cut every part into charts. `part_of` has one part a face ([`NONE`] for faces in no chart).
/// Charts come in order of part, and within a part of first face.
pub fn build(
    surface: &Surface,
    part_of: &[u32],
    options: &ChartOptions,
    run: &Run,
) -> Result<Vec<Chart>, Canceled> {
    Ok(build_jointly(surface, part_of, options, None, run)?.charts)
}

/// Charts, and what the joint seams were worth.
#[derive(Debug, Default)]
pub struct Built {
    /// In order of part, and within a part of first face.
    pub charts: Vec<Chart>,
    /// Both results for each component that was merged both ways.
    pub orders: Vec<Orders>,
}

/// Objective Φ·ΣA of one connected component of a part, merged two ways; the lower one is kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orders {
    /// The baseline: by what is saved for the work it takes, or in the best of the orders drawn at random.
    pub baseline: f64,
    /// In the order that the soft map says.
    pub joint: f64,
}

/// Like [`build`]. `openness` says of each half-edge of the surface how far a soft map has left it open, 0
/// to 1, and NaN where it knows nothing: a component of which it knows something is merged by it too, and
/// the better of both is kept.
pub fn build_jointly(
    surface: &Surface,
    part_of: &[u32],
    options: &ChartOptions,
    openness: Option<&[f32]>,
    run: &Run,
) -> Result<Built, Canceled> {
    let count = part_of.iter().filter(|&&p| p != NONE).max().map_or(0, |&p| p as usize + 1);
    let mut faces = vec![Vec::new(); count];
    for (f, &p) in part_of.iter().enumerate() {
        if p != NONE {
            faces[p as usize].push(f as u32);
        }
    }
    let limits = ChartLimits::new(surface, options.distortion_bound);
    let visibility = visibility(surface, run)?;
    let seen = visibility.as_deref();
    let all = surface.face_count();
    let restarts = (RESTARTS * RESTARTED_FACES / all.max(1)).min(RESTARTS) as u64;
    // Training the seams was the first half.
    let from = if openness.is_some() { 0.5 } else { 0.0 };
    let steps = Some(run.steps(STEPS * all, from, 1.0));
    let cutter = Cutter { surface, seen, openness, restarts, limits: &limits, run, steps };
    let parts: Result<Vec<Built>, Canceled> = faces
        .into_par_iter()
        .enumerate()
        .map(|(part, faces)| cutter.build(part as u32, faces))
        .collect();
    let mut built = Built::default();
    for part in parts? {
        built.charts.extend(part.charts);
        built.orders.extend(part.orders);
    }
    Ok(built)
}

/// Divide a chart that failed its certificate into smaller ones.
pub fn split_chart(
    surface: &Surface,
    chart: &Chart,
    options: &ChartOptions,
    run: &Run,
) -> Result<Vec<Chart>, Canceled> {
    let mesh = PartMesh::new(surface, chart.faces.clone());
    let all: Vec<u32> = (0..mesh.len() as u32).collect();
    let limits = ChartLimits::new(surface, options.distortion_bound);
    let (restarts, steps) = (0, None);
    let cutter =
        Cutter { surface, seen: None, openness: None, restarts, limits: &limits, run, steps };
    let mut built = Built::default();
    for half in halves(&mesh, &all) {
        let faces = half.iter().map(|&f| mesh.faces[f as usize]).collect();
        let half = PartMesh::new(surface, faces);
        cutter.weld(&half, chart.part, None, &[], &mut built)?;
    }
    Ok(built.charts)
}

/// What every part is cut with.
struct Cutter<'a> {
    surface: &'a Surface,
    seen: Option<&'a [f32]>,
    openness: Option<&'a [f32]>,
    /// Orders to be tried besides the first.
    restarts: u64,
    limits: &'a ChartLimits,
    run: &'a Run,
    /// Where progress is counted.
    steps: Option<Steps<'a>>,
}

impl Cutter<'_> {
    /// One of the [`STEPS`] of a component is done.
    fn step(&self, mesh: &PartMesh) {
        if let Some(steps) = &self.steps {
            steps.add(mesh.len());
        }
    }

    fn build(&self, part: u32, faces: Vec<u32>) -> Result<Built, Canceled> {
        let mesh = PartMesh::new(self.surface, faces);
        let mut built = Built::default();
        for faces in pieces(&mesh) {
            self.run.cancel.check()?;
            let piece = PartMesh::new(self.surface, faces).seen(self.seen);
            let tube = tube::fit(&piece);
            let sides = sides(&piece, tube.as_ref(), self.limits.bound);
            self.weld(&piece, part, tube.as_ref(), &sides, &mut built)?;
        }
        built.charts.sort_by_key(|c| c.faces.first().copied());
        Ok(built)
    }

    /// A component as charts: the sides of its tube and, of the rest, patches that lie flat within the bound;
    /// merged while the objective falls.
    fn weld(
        &self,
        mesh: &PartMesh,
        part: u32,
        tube: Option<&Tube>,
        sides: &[Side],
        built: &mut Built,
    ) -> Result<(), Canceled> {
        let (limits, run) = (self.limits, self.run);
        let work = patchwork(mesh, sides, limits, run)?;
        self.step(mesh);
        let mut best = join(work.clone(), None, limits, run)?;
        self.step(mesh);
        let mut baseline = objective(&best, limits);
        let restarts = if work.faces.len() >= LEAST_PATCHES { self.restarts } else { 0 };
        for k in 0..restarts {
            if run.skips(Stage::Charts, GaveUp::Joining) {
                break;
            }
            let mut random = Seeded::new(0, k);
            let order: Vec<f32> = mesh.twin.iter().map(|_| random.unit_f64() as f32).collect();
            let other = join(work.clone(), Some(&order), limits, run)?;
            let reached = objective(&other, limits);
            if reached < baseline {
                (best, baseline) = (other, reached);
            }
        }
        let told = |o: &[f32]| -> Vec<f32> {
            (0..mesh.twin.len() as u32).map(|h| o[mesh.surface_half_edge(h) as usize]).collect()
        };
        let openness = self.openness.map(told);
        if let Some(openness) = openness.filter(|o| o.iter().any(|o| !o.is_nan())) {
            let other = join(work, Some(&openness), limits, run)?;
            let joint = objective(&other, limits);
            built.orders.push(Orders { baseline, joint });
            if joint < baseline {
                best = other;
            }
        }
        self.step(mesh);
        shorten(&mut best, limits);
        let divided = compact(&mut best, limits, run)?;
        straighten(&mut best, &divided, limits, run)?;
        built.charts.extend(charts(&best, part, tube, sides));
        self.step(mesh);
        Ok(())
    }
}

/// Connected components of a part, as faces of the surface.
pub fn pieces(mesh: &PartMesh) -> Vec<Vec<u32>> {
    let all: Vec<u32> = (0..mesh.len() as u32).collect();
    let global = |piece: Vec<u32>| piece.iter().map(|&f| mesh.faces[f as usize]).collect();
    mesh.components(&all, |_| true).into_iter().map(global).collect()
}

/// What merging starts from: the sides of a tube and patches, each with its map.
pub fn patchwork<'a>(
    mesh: &'a PartMesh<'a>,
    sides: &[Side],
    limits: &ChartLimits,
    run: &Run,
) -> Result<Patchwork<'a>, Canceled> {
    let (patch_of, glued, fits) = patches(mesh, sides, limits, run)?;
    let mut work = Patchwork::new(mesh, patch_of, glued);
    for (chart, (piece, fit)) in (0u32..).zip(&fits) {
        work.place(chart, piece, fit);
    }
    Ok(work)
}

/// Rounds of joining charts and moving their seams.
fn join<'a>(
    mut work: Patchwork<'a>,
    openness: Option<&[f32]>,
    limits: &ChartLimits,
    run: &Run,
) -> Result<Patchwork<'a>, Canceled> {
    let all: Vec<u32> = (0..work.faces.len() as u32).collect();
    let mut changed = all.clone();
    let rounds = (ROUNDS * ROUND_FACES / work.mesh.len().max(1)).clamp(1, ROUNDS);
    for _ in 0..rounds {
        merge(&mut work, &changed, openness, limits, run)?;
        changed = straighten(&mut work, &all, limits, run)?;
        if changed.is_empty() {
            break;
        }
    }
    Ok(work)
}

/// Φ·ΣA of a component: energy, and what its seams and its charts are worth.
fn objective(work: &Patchwork, limits: &ChartLimits) -> f64 {
    let open = |h: &u32| {
        let t = work.mesh.twin[*h as usize];
        t != NONE && *h < t && !work.glued[*h as usize]
    };
    let half_edges = 0..work.mesh.twin.len() as u32;
    let seam: f64 = half_edges.filter(open).map(|h| edge_cost(work.mesh, h)).sum();
    let charts = work.faces.iter().filter(|f| !f.is_empty()).count() as f64;
    work.energy.iter().sum::<f64>() + limits.worth * (seam + limits.chart * charts)
}

/// The charts of a patchwork.
fn charts(work: &Patchwork, part: u32, tube: Option<&Tube>, sides: &[Side]) -> Vec<Chart> {
    let mesh = work.mesh;
    let mut charts = Vec::new();
    for (number, faces) in work.faces.iter().enumerate().filter(|(_, f)| !f.is_empty()) {
        let piece = mesh.cut_open(faces.clone(), &work.glued);
        let cut_map = flatten::rescale(&piece.disk, work.map_of(&piece));
        // The sides come first; one that nothing was joined to is still a tube.
        let alone = sides.get(number).filter(|side| side.faces == piece.faces);
        let shape = match alone.and(tube) {
            Some(&Tube { origin, axis, radius, taper, .. }) => {
                ChartShape::Tubular { origin, axis, radius, taper }
            }
            None => ChartShape::General,
        };
        charts.push(Chart {
            part,
            faces: piece.faces.iter().map(|&f| mesh.faces[f as usize]).collect(),
            disk: piece.disk,
            vertices: piece.vertices,
            shape,
            start: cut_map.clone(),
            cut_map,
            start_kind: work.kind[number],
        });
    }
    charts
}
