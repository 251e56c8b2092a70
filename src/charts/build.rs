//! Parts into charts (docs/method.md, section 4): the side of a tube with one axial cut, everything else as
//! patches, all merged while the objective falls and the distortion bound holds.

use super::chart::{Chart, ChartShape};
use super::component::{Joiner, Orders};
use super::limits::ChartLimits;
use super::limits::extent::shorten;
use super::limits::visibility::visibility;
use super::moves::compact::compact;
use super::moves::straighten::straighten;
use super::part_mesh::PartMesh;
use super::patches::sides::{Side, sides};
use super::patches::split::halves;
use super::patches::tube::{self, Tube};
use super::patchwork::Patchwork;
use crate::contract::{Canceled, Run, Steps, UnwrapOptions};
use crate::flatten;
use crate::mesh::{NONE, Surface};
use crate::tasks;

/// Steps of a component that progress is counted by: patches, the first merging, the others, the last moves.
const STEPS: usize = 4;

/// What the cut is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChartOptions {
    /// Largest area-weighted mean symmetric Dirichlet energy of a chart, minus 1.
    pub distortion_bound: f64,
    /// Whether a border may come twice to a vertex. Where a proxy stands for a finer surface it may not: that has an
    /// edge there.
    pub pinches: bool,
}

impl From<&UnwrapOptions> for ChartOptions {
    fn from(options: &UnwrapOptions) -> Self {
        Self { distortion_bound: options.distortion_bound, pinches: true }
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
    let limits = ChartLimits::of(surface, options);
    let visibility = visibility(surface, run)?;
    let seen = visibility.as_deref();
    let all = surface.face_count();
    // Training the seams was the first half.
    let from = if openness.is_some() { 0.5 } else { 0.0 };
    let steps = Some(run.steps(STEPS * all, from, 1.0));
    let joiner = Joiner::new(all, &limits, run);
    let cutter = Cutter { surface, seen, openness, joiner, limits: &limits, run, steps };
    let parts = (0u32..).zip(faces).collect();
    let whole = |(part, faces): (u32, Vec<u32>)| {
        let pieces = pieces(&PartMesh::new(surface, faces));
        pieces.into_iter().map(|faces| (part, faces)).collect()
    };
    let components: Vec<Vec<_>> = tasks::map_by_size("components", parts, |p| p.1.len(), whole);
    let components = components.into_iter().flatten().collect();
    let weld = |(part, faces)| cutter.build(part, faces);
    let made: Vec<_> = tasks::map_by_size("component", components, |c| c.1.len(), weld);
    let mut built = Built::default();
    for made in made {
        let made = made?;
        built.charts.extend(made.charts);
        built.orders.extend(made.orders);
    }
    built.charts.sort_by_key(|c| (c.part, c.faces.first().copied()));
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
    let limits = ChartLimits::of(surface, options);
    let (seen, openness, steps) = (None, None, None);
    let joiner = Joiner::once(&limits, run);
    let cutter = Cutter { surface, seen, openness, joiner, limits: &limits, run, steps };
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
    joiner: Joiner<'a>,
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

    /// The charts of one component of a part.
    fn build(&self, part: u32, faces: Vec<u32>) -> Result<Built, Canceled> {
        self.run.cancel.check()?;
        let mut built = Built::default();
        let piece = PartMesh::new(self.surface, faces).seen(self.seen);
        let tube = tube::fit(&piece);
        let sides = sides(&piece, tube.as_ref(), self.limits.bound);
        self.weld(&piece, part, tube.as_ref(), &sides, &mut built)?;
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
        let (work, first) = self.joiner.first(mesh, sides)?;
        (0..2).for_each(|_| self.step(mesh));
        let mut best = self.joiner.reordered(&work, first)?;
        let told = |o: &[f32]| -> Vec<f32> {
            (0..mesh.twin.len() as u32).map(|h| o[mesh.surface_half_edge(h) as usize]).collect()
        };
        let openness = self.openness.map(told);
        if let Some(openness) = openness.filter(|o| o.iter().any(|o| !o.is_nan())) {
            let (better, orders) = self.joiner.guided(work, best, &openness)?;
            best = better;
            built.orders.push(orders);
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
