//! A connected component of a part cut at every seam between patches (docs/method.md, 4.6): its patches as
//! one mesh that falls apart at every candidate seam, laid out along the tree of dearest seams. What a soft map of it leaves open says which
//! seams to keep.

use std::collections::BinaryHeap;

use glam::{DMat2, DVec2};
use rayon::prelude::*;

use super::candidates;
use super::proposal::{Motion, rigid_motion};
use crate::charts::build::{ChartOptions, pieces};
use crate::charts::component::{LEAST_PATCHES, patchwork};
use crate::charts::limits::ChartLimits;
use crate::charts::limits::cost::edge_cost;
use crate::charts::part_mesh::PartMesh;
use crate::charts::patches::sides::sides;
use crate::charts::patches::tube;
use crate::charts::patchwork::{Patchwork, next};
use crate::contract::{Canceled, Run};
use crate::flatten::{Disk, UvMap};
use crate::mesh::{NONE, Surface};

/// A connected component of a part, over-cut.
pub struct OverCutPart {
    /// Its faces, ascending.
    pub faces: Vec<u32>,
    /// The same faces as a mesh in which every patch stands alone.
    pub disk: Disk,
    /// Vertex of the surface that each vertex of the disk stands for.
    pub vertices: Vec<u32>,
    /// The patches' maps, laid next to each other; they may overlap.
    pub start: UvMap,
    /// Every edge between two patches, and every slit.
    pub seams: Vec<Seam>,
}

/// An edge that stands twice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seam {
    /// Half-edges of the surface.
    pub half_edges: [u32; 2],
    /// The edge's ends on the one side and, in the same order, on the other: vertices of the disk.
    pub sides: [[u32; 2]; 2],
    /// Length in 3D.
    pub length: f64,
    /// Cost of a unit of it as a seam.
    pub cost: f64,
}

/// The components of all parts whose patches leave a choice, with at most `most` vertices.
pub fn over_cut(
    surface: &Surface,
    part_of: &[u32],
    options: &ChartOptions,
    most: usize,
    run: &Run,
) -> Result<Vec<OverCutPart>, Canceled> {
    let faces = (0..part_of.len() as u32).filter(|&f| part_of[f as usize] != NONE).collect();
    let mut mesh = PartMesh::new(surface, faces);
    // Parts end where the number changes.
    let differs = |h: usize, t: u32| {
        part_of[mesh.faces[h / 3] as usize] != part_of[mesh.faces[t as usize / 3] as usize]
    };
    let ends: Vec<usize> = (0..mesh.twin.len())
        .filter(|&h| mesh.twin[h] != NONE && differs(h, mesh.twin[h]))
        .collect();
    ends.into_iter().for_each(|h| mesh.twin[h] = NONE);
    let limits = ChartLimits::of(surface, options);
    let found: Result<Vec<Option<OverCutPart>>, Canceled> = pieces(&mesh)
        .into_par_iter()
        .filter(|faces| faces.len() <= 2 * most)
        .map(|faces| over_cut_piece(&PartMesh::new(surface, faces), &limits, run))
        .collect();
    Ok(found?.into_iter().flatten().filter(|part| part.disk.positions.len() <= most).collect())
}

fn over_cut_piece(
    mesh: &PartMesh,
    limits: &ChartLimits,
    run: &Run,
) -> Result<Option<OverCutPart>, Canceled> {
    run.cancel.check()?;
    let tube = tube::fit(mesh);
    let sides = sides(mesh, tube.as_ref(), limits.bound);
    let work = patchwork(mesh, &sides, limits, run)?;
    if work.faces.len() < LEAST_PATCHES {
        return Ok(None);
    }
    let poses = poses(&work);
    let piece = mesh.cut_open((0..mesh.len() as u32).collect(), &work.glued);
    let mut start = vec![DVec2::ZERO; piece.disk.positions.len()];
    for (&f, triangle) in piece.faces.iter().zip(&piece.disk.triangles) {
        let (rotation, shift) = poses[work.chart_of[f as usize] as usize];
        for (k, &v) in triangle.iter().enumerate() {
            start[v as usize] = rotation * work.uv[3 * f as usize + k] + shift;
        }
    }
    let at = |h: u32| piece.disk.triangles[h as usize / 3][h as usize % 3];
    let open = |&(h, t): &(u32, u32)| t != NONE && h < t && !work.glued[h as usize];
    let seam = |(h, t): (u32, u32)| {
        let length = mesh.length(h);
        Seam {
            half_edges: [h, t].map(|h| mesh.surface_half_edge(h)),
            sides: [[at(h), at(next(h))], [at(next(t)), at(t)]],
            length,
            cost: edge_cost(mesh, h) / length.max(f64::MIN_POSITIVE),
        }
    };
    let seams = (0u32..).zip(mesh.twin.iter().copied()).filter(open).map(seam).collect();
    let (faces, vertices) = (mesh.faces.clone(), piece.vertices);
    Ok(Some(OverCutPart { faces, disk: piece.disk, vertices, start, seams }))
}

/// Where each patch is laid: next to a neighbour across its dearest seam, from the largest patch on.
fn poses(work: &Patchwork) -> Vec<Motion> {
    let count = work.faces.len();
    let mut poses: Vec<Option<Motion>> = vec![None; count];
    let mut order: Vec<u32> = (0..count as u32).collect();
    order.sort_by(|&a, &b| work.area[b as usize].total_cmp(&work.area[a as usize]).then(a.cmp(&b)));
    let mut heap: BinaryHeap<(u64, u32, u32, usize)> = BinaryHeap::new();
    let mut steps: Vec<Motion> = Vec::new();
    for root in order {
        if poses[root as usize].is_some() {
            continue;
        }
        let mut settled = Some((root, (DMat2::IDENTITY, DVec2::ZERO)));
        while let Some((chart, pose)) = settled {
            poses[chart as usize] = Some(pose);
            for c in candidates::around(work, chart) {
                if poses[c.b as usize].is_none()
                    && let Some((motion, _)) = rigid_motion(work, &c.path)
                {
                    heap.push((c.cost(work).to_bits(), chart, c.b, steps.len()));
                    steps.push(motion);
                }
            }
            settled = None;
            while let Some((_, from, to, step)) = heap.pop() {
                if poses[to as usize].is_none()
                    && let Some((rotation, shift)) = poses[from as usize]
                {
                    let (turn, move_by) = steps[step];
                    settled = Some((to, (rotation * turn, rotation * move_by + shift)));
                    break;
                }
            }
        }
    }
    poses.into_iter().map(|p| p.unwrap_or((DMat2::IDENTITY, DVec2::ZERO))).collect()
}
