//! Parts into charts (pipeline 4): the side of a tube with one axial cut, everything else as patches,
//! all joined while the objective falls and the distortion bound holds.

use rayon::prelude::*;

use super::chart::{Chart, ChartShape, StartKind};
use super::cluster::cluster;
use super::compact::compact;
use super::extent::shorten;
use super::fit::{Fit, from_scratch};
use super::limits::Limits;
use super::merge::merge;
use super::open::open;
use super::part_mesh::{PartMesh, Piece};
use super::patchwork::Patchwork;
use super::split::halves;
use super::straighten::straighten;
use super::tube::{self, Tube};
use super::visibility::visibility;
use crate::contract::{Canceled, Run};
use crate::flatten::{self, flatten_triangle};
use crate::mesh::{NONE, Surface};

/// Rounds of joining charts and moving their seams.
const ROUNDS: u32 = 3;

/// What the cut is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChartOptions {
    /// Largest area-weighted mean symmetric Dirichlet energy of a chart, minus 1.
    pub distortion_bound: f64,
}

/// Cut every part into charts. `part_of` has one part a face ([`NONE`] for faces in no chart).
/// Charts come in order of part, and within a part of first face.
pub fn build(
    surface: &Surface,
    part_of: &[u32],
    options: &ChartOptions,
    run: &Run,
) -> Result<Vec<Chart>, Canceled> {
    let count = part_of.iter().filter(|&&p| p != NONE).max().map_or(0, |&p| p as usize + 1);
    let mut faces = vec![Vec::new(); count];
    for (f, &p) in part_of.iter().enumerate() {
        if p != NONE && surface.usable[f] {
            faces[p as usize].push(f as u32);
        }
    }
    let limits = Limits::new(surface, options.distortion_bound);
    let visibility = visibility(surface, run)?;
    let seen = visibility.as_deref();
    let charts: Result<Vec<Vec<Chart>>, Canceled> = faces
        .into_par_iter()
        .enumerate()
        .map(|(part, faces)| build_part(surface, seen, part as u32, faces, &limits, run))
        .collect();
    Ok(charts?.into_iter().flatten().collect())
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
    let limits = Limits::new(surface, options.distortion_bound);
    let mut charts = Vec::new();
    for half in halves(&mesh, &all) {
        let faces = half.iter().map(|&f| mesh.faces[f as usize]).collect();
        let half = PartMesh::new(surface, faces);
        charts.extend(weld(&half, chart.part, None, &[], &limits, run)?);
    }
    Ok(charts)
}

fn build_part(
    surface: &Surface,
    seen: Option<&[f32]>,
    part: u32,
    faces: Vec<u32>,
    limits: &Limits,
    run: &Run,
) -> Result<Vec<Chart>, Canceled> {
    let mesh = PartMesh::new(surface, faces);
    let all: Vec<u32> = (0..mesh.len() as u32).collect();
    let mut charts = Vec::new();
    for piece in mesh.components(&all, |_| true) {
        run.cancel.check()?;
        let faces = piece.iter().map(|&f| mesh.faces[f as usize]).collect();
        let piece = PartMesh::new(surface, faces).seen(seen);
        let tube = tube::fit(&piece);
        let sides = tube.as_ref().map_or_else(Vec::new, |t| sides(&piece, t, limits.bound));
        charts.extend(weld(&piece, part, tube.as_ref(), &sides, limits, run)?);
    }
    charts.sort_by_key(|c| c.faces.first().copied());
    Ok(charts)
}

/// The side of a tube, cut along its axis and unrolled.
struct Side {
    /// Local faces, ascending.
    faces: Vec<u32>,
    /// Local half-edges of the axial cut.
    cut: Vec<u32>,
    fit: Fit,
}

/// The sides of a tube that open to a disk and unroll within the bound.
fn sides(mesh: &PartMesh, tube: &Tube, bound: f64) -> Vec<Side> {
    let mut lateral = vec![false; mesh.len()];
    tube.lateral.iter().for_each(|&f| lateral[f as usize] = true);
    let same = |h: u32| lateral[mesh.twin[h as usize] as usize / 3];
    let pieces = mesh.components(&tube.lateral, same);
    pieces.into_iter().filter_map(|faces| unroll(mesh, faces, tube, bound)).collect()
}

fn unroll(mesh: &PartMesh, faces: Vec<u32>, tube: &Tube, bound: f64) -> Option<Side> {
    let cut = tube::axial_cut(mesh, &faces, tube.axis)?;
    let mut glued = vec![false; mesh.twin.len()];
    glue_side(mesh, &faces, &cut, &mut glued);
    let piece = mesh.cut_open(faces, &glued);
    if !flatten::is_disk(&piece.disk) {
        return None;
    }
    let rolled = flatten::unroll(&piece.disk, tube.origin, tube.axis, tube.radius, tube.taper);
    // A faceted tube is developable: unfolding it is exact, where the round one is only near.
    let unfolded = flatten::unfold(&piece.disk);
    let candidates = [(Some(rolled), StartKind::Unroll), (unfolded, StartKind::Unfold)];
    let (energy, uv, kind) = candidates
        .into_iter()
        .filter_map(|(uv, kind)| {
            let uv = flatten::rescale(&piece.disk, uv?);
            let quality = flatten::quality(&piece.disk, &uv);
            let proved = quality.flips == 0 && flatten::certify(&piece.disk, &uv).is_injective();
            proved.then_some((quality.mean - 1.0, uv, kind))
        })
        .min_by(|a, b| a.0.total_cmp(&b.0))?;
    let fits = energy <= bound;
    fits.then_some(Side { faces: piece.faces, cut, fit: Fit { uv, energy, kind } })
}

/// Close every edge within a side but those of its cut.
fn glue_side(mesh: &PartMesh, faces: &[u32], cut: &[u32], glued: &mut [bool]) {
    let mut own = vec![false; mesh.len()];
    faces.iter().for_each(|&f| own[f as usize] = true);
    for h in faces.iter().flat_map(|&f| 3 * f..3 * f + 3) {
        let t = mesh.twin[h as usize];
        glued[h as usize] = t != NONE && own[t as usize / 3];
    }
    for &h in cut {
        glued[h as usize] = false;
        glued[mesh.twin[h as usize] as usize] = false;
    }
}

/// A piece as charts: the sides of its tube and, of the rest, patches that lie flat within the bound;
/// joined while the objective falls.
fn weld(
    mesh: &PartMesh,
    part: u32,
    tube: Option<&Tube>,
    sides: &[Side],
    limits: &Limits,
    run: &Run,
) -> Result<Vec<Chart>, Canceled> {
    let (patch_of, glued, fits) = patches(mesh, sides, limits, run)?;
    let mut work = Patchwork::new(mesh, patch_of, glued);
    for (chart, (piece, fit)) in (0u32..).zip(&fits) {
        work.place(chart, piece, fit);
    }
    drop(fits);
    let all: Vec<u32> = (0..work.faces.len() as u32).collect();
    let mut changed = all.clone();
    for _ in 0..ROUNDS {
        merge(&mut work, &changed, limits, run)?;
        changed = straighten(&mut work, &all, limits, run)?;
        if changed.is_empty() {
            break;
        }
    }
    shorten(&mut work, limits);
    let divided = compact(&mut work, limits, run)?;
    straighten(&mut work, &divided, limits, run)?;
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
        // What was divided for its length is a piece of a weld.
        let start_kind = work.kind.get(number).copied().unwrap_or(StartKind::Weld);
        charts.push(Chart {
            part,
            faces: piece.faces.iter().map(|&f| mesh.faces[f as usize]).collect(),
            disk: piece.disk,
            vertices: piece.vertices,
            shape,
            start: cut_map.clone(),
            cut_map,
            start_kind,
        });
    }
    Ok(charts)
}

/// Patch of each local face, which edges are closed, and the map of each patch. The sides come
/// first.
type Patches = (Vec<u32>, Vec<bool>, Vec<(Piece, Fit)>);

fn patches(
    mesh: &PartMesh,
    sides: &[Side],
    limits: &Limits,
    run: &Run,
) -> Result<Patches, Canceled> {
    let mut patch_of = vec![NONE; mesh.len()];
    for (number, side) in (0u32..).zip(sides) {
        side.faces.iter().for_each(|&f| patch_of[f as usize] = number);
    }
    let mut count = cluster(mesh, &mut patch_of, sides.len() as u32, run)?;
    let mut fits: Vec<Option<(Piece, Fit)>> = vec![None; count as usize];
    let mut pending: Vec<u32> = (sides.len() as u32..count).collect();
    // Patches that are flattened without a cut, whatever holes they have.
    let mut whole = vec![false; count as usize];
    // Each round opens all patches and fits the new ones; what does not fit is divided. A single
    // triangle always fits, so that this ends.
    loop {
        run.cancel.check()?;
        let mut glued = open(mesh, &patch_of);
        let inside: Vec<bool> = (0..mesh.twin.len())
            .map(|h| {
                let t = mesh.twin[h];
                t != NONE && patch_of[t as usize / 3] == patch_of[h / 3]
            })
            .collect();
        let mut faces = vec![Vec::new(); count as usize];
        for (f, &p) in patch_of.iter().enumerate() {
            faces[p as usize].push(f as u32);
        }
        let mut divided = Vec::new();
        let tried: Result<Vec<_>, Canceled> = std::mem::take(&mut pending)
            .into_par_iter()
            .map(|p| Ok((p, lay_flat(mesh, &faces[p as usize], [&inside, &glued], limits, run)?)))
            .collect();
        for (patch, flat) in tried? {
            if let Some((piece, fit, is_whole)) = flat {
                whole[patch as usize] = is_whole;
                fits[patch as usize] = Some((piece, fit));
                continue;
            }
            let pieces = halves(mesh, &faces[patch as usize]);
            pending.push(patch);
            for piece in &pieces[1..] {
                piece.iter().for_each(|&f| divided.push((f, count)));
                pending.push(count);
                fits.push(None);
                whole.push(false);
                count += 1;
            }
        }
        if pending.is_empty() {
            for (h, glued) in glued.iter_mut().enumerate() {
                *glued |= inside[h] && whole[patch_of[h / 3] as usize];
            }
            for side in sides {
                glue_side(mesh, &side.faces, &side.cut, &mut glued);
            }
            for (number, side) in sides.iter().enumerate() {
                let piece = mesh.cut_open(side.faces.clone(), &glued);
                fits[number] = Some((piece, side.fit.clone()));
            }
            return Ok((patch_of, glued, fits.into_iter().flatten().collect()));
        }
        divided.into_iter().for_each(|(f, p)| patch_of[f as usize] = p);
    }
}

/// Flatten a patch, uncut if that can be done (`inside`: every inner edge is closed), or else opened to
/// a disk (`opened`). Also tells whether it is whole.
fn lay_flat(
    mesh: &PartMesh,
    faces: &[u32],
    [inside, opened]: [&[bool]; 2],
    limits: &Limits,
    run: &Run,
) -> Result<Option<(Piece, Fit, bool)>, Canceled> {
    let piece = mesh.cut_open(faces.to_vec(), inside);
    if let Some(fit) = fit_patch(&piece, limits, run)? {
        return Ok(Some((piece, fit, true)));
    }
    if flatten::is_disk(&piece.disk) {
        return Ok(None);
    }
    let piece = mesh.cut_open(faces.to_vec(), opened);
    Ok(fit_patch(&piece, limits, run)?.map(|fit| (piece, fit, false)))
}

fn fit_patch(piece: &Piece, limits: &Limits, run: &Run) -> Result<Option<Fit>, Canceled> {
    if let &[triangle] = &piece.disk.triangles[..] {
        let [a, b, c] = triangle.map(|v| piece.disk.positions[v as usize]);
        return Ok(Some(Fit {
            uv: flatten_triangle(a, b, c).to_vec(),
            energy: 0.0,
            kind: StartKind::Planar,
        }));
    }
    from_scratch(&piece.disk, limits.bound, limits.clearance, run)
}
