//! Parts into charts (pipeline 4): the side of a tube with one axial cut and its caps apart; every
//! other part as patches that are joined while the distortion bound holds.

use rayon::prelude::*;

use super::chart::{Chart, ChartShape, StartKind};
use super::cluster::cluster;
use super::fit::from_scratch;
use super::merge::merge;
use super::open::open;
use super::part_mesh::{PartMesh, Piece};
use super::patchwork::Patchwork;
use super::split::halves;
use super::tube::{self, Tube};
use crate::contract::{Canceled, Run};
use crate::flatten::{self, StartMap, UvMap, flatten_triangle};
use crate::mesh::{NONE, Surface};

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
    let charts: Result<Vec<Vec<Chart>>, Canceled> = faces
        .into_par_iter()
        .enumerate()
        .map(|(part, faces)| build_part(surface, part as u32, faces, options, run))
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
    let mut charts = Vec::new();
    for half in halves(&mesh, &all) {
        let faces = half.iter().map(|&f| mesh.faces[f as usize]).collect();
        charts.extend(patches(&PartMesh::new(surface, faces), chart.part, options, run)?);
    }
    Ok(charts)
}

fn build_part(
    surface: &Surface,
    part: u32,
    faces: Vec<u32>,
    options: &ChartOptions,
    run: &Run,
) -> Result<Vec<Chart>, Canceled> {
    let mesh = PartMesh::new(surface, faces);
    let all: Vec<u32> = (0..mesh.len() as u32).collect();
    let mut charts = Vec::new();
    for piece in mesh.components(&all, |_| true) {
        run.cancel.check()?;
        let faces = piece.iter().map(|&f| mesh.faces[f as usize]).collect();
        let piece = PartMesh::new(surface, faces);
        match tube::fit(&piece) {
            Some(tube) => charts.extend(tube_and_caps(&piece, part, &tube, options, run)?),
            None => charts.extend(patches(&piece, part, options, run)?),
        }
    }
    charts.sort_by_key(|c| c.faces.first().copied());
    Ok(charts)
}

/// The side of a tube, cut along its axis, and whatever else there is as patches.
fn tube_and_caps(
    mesh: &PartMesh,
    part: u32,
    tube: &Tube,
    options: &ChartOptions,
    run: &Run,
) -> Result<Vec<Chart>, Canceled> {
    let mut is_side = vec![false; mesh.len()];
    tube.lateral.iter().for_each(|&f| is_side[f as usize] = true);
    let all: Vec<u32> = (0..mesh.len() as u32).collect();
    let same = |h: u32| is_side[h as usize / 3] == is_side[mesh.twin[h as usize] as usize / 3];
    let mut charts = Vec::new();
    for piece in mesh.components(&all, same) {
        let faces = piece.iter().map(|&f| mesh.faces[f as usize]).collect();
        let sub = PartMesh::new(mesh.surface, faces);
        let side = is_side[piece[0] as usize];
        match side.then(|| unroll(&sub, part, tube, options)).flatten() {
            Some(chart) => charts.push(chart),
            None => charts.extend(patches(&sub, part, options, run)?),
        }
    }
    Ok(charts)
}

/// One side of a tube as one chart, if it opens to a disk and unrolls within the bound.
fn unroll(mesh: &PartMesh, part: u32, tube: &Tube, options: &ChartOptions) -> Option<Chart> {
    let all: Vec<u32> = (0..mesh.len() as u32).collect();
    let cut = tube::axial_cut(mesh, &all, tube.axis)?;
    let mut glued: Vec<bool> = mesh.twin.iter().map(|&t| t != NONE).collect();
    for h in cut {
        glued[h as usize] = false;
        glued[mesh.twin[h as usize] as usize] = false;
    }
    let piece = mesh.cut_open(all, &glued);
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
    if energy > options.distortion_bound {
        return None;
    }
    let shape = ChartShape::Tubular {
        origin: tube.origin,
        axis: tube.axis,
        radius: tube.radius,
        taper: tube.taper,
    };
    Some(chart(mesh, part, piece, shape, uv.clone(), uv, kind))
}

/// A piece as patches, each a disk within the bound, joined while the bound holds.
fn patches(
    mesh: &PartMesh,
    part: u32,
    options: &ChartOptions,
    run: &Run,
) -> Result<Vec<Chart>, Canceled> {
    let bound = options.distortion_bound;
    let mut patch_of = cluster(mesh, run)?;
    let mut count = patch_of.iter().max().map_or(0, |&m| m + 1);
    let mut pending: Vec<u32> = (0..count).collect();
    let mut maps = vec![None; count as usize];
    // Each round opens all patches and fits the new ones; what does not fit is divided. A single
    // triangle always fits, so that this ends.
    let glued = loop {
        run.cancel.check()?;
        let glued = open(mesh, &patch_of);
        let mut faces = vec![Vec::new(); count as usize];
        for (f, &p) in patch_of.iter().enumerate() {
            faces[p as usize].push(f as u32);
        }
        let mut divided = Vec::new();
        for patch in std::mem::take(&mut pending) {
            let piece = mesh.cut_open(faces[patch as usize].clone(), &glued);
            if let &[triangle] = &piece.disk.triangles[..] {
                let [a, b, c] = triangle.map(|v| piece.disk.positions[v as usize]);
                maps[patch as usize] = Some((piece, flatten_triangle(a, b, c).to_vec()));
                continue;
            }
            if let Some(uv) = from_scratch(&piece.disk, bound, run)? {
                maps[patch as usize] = Some((piece, uv));
                continue;
            }
            let pieces = halves(mesh, &faces[patch as usize]);
            pending.push(patch);
            for piece in &pieces[1..] {
                piece.iter().for_each(|&f| divided.push((f, count)));
                pending.push(count);
                maps.push(None);
                count += 1;
            }
        }
        if pending.is_empty() {
            break glued;
        }
        divided.into_iter().for_each(|(f, p)| patch_of[f as usize] = p);
    };
    let mut work = Patchwork::new(mesh, patch_of, glued);
    for (piece, uv) in maps.into_iter().flatten() {
        for (&f, triangle) in piece.faces.iter().zip(&piece.disk.triangles) {
            for (k, &v) in triangle.iter().enumerate() {
                work.uv[3 * f as usize + k] = uv[v as usize];
            }
        }
    }
    merge(&mut work, bound, run)?;
    let mut charts = Vec::new();
    for faces in work.faces.iter().filter(|f| !f.is_empty()) {
        let piece = mesh.cut_open(faces.clone(), &work.glued);
        let mut cut_map = vec![Default::default(); piece.disk.positions.len()];
        for (&f, triangle) in piece.faces.iter().zip(&piece.disk.triangles) {
            for (k, &v) in triangle.iter().enumerate() {
                cut_map[v as usize] = work.uv[3 * f as usize + k];
            }
        }
        let (start, kind) = match flatten::start_map(&piece.disk) {
            // Tutte's circle is far from every good map; the joined patches are near one.
            (_, StartMap::Tutte) => (cut_map.clone(), StartKind::Weld),
            (start, kind) => (start, kind.into()),
        };
        charts.push(chart(mesh, part, piece, ChartShape::General, start, cut_map, kind));
    }
    Ok(charts)
}

fn chart(
    mesh: &PartMesh,
    part: u32,
    piece: Piece,
    shape: ChartShape,
    start: UvMap,
    cut_map: UvMap,
    start_kind: StartKind,
) -> Chart {
    Chart {
        part,
        faces: piece.faces.iter().map(|&f| mesh.faces[f as usize]).collect(),
        disk: piece.disk,
        vertices: piece.vertices,
        shape,
        start,
        cut_map,
        start_kind,
    }
}
