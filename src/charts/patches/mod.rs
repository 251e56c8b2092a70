//! What charts are made from: the sides of tubes, and patches of little bend that lie flat within the
//! bound; a patch that does not is divided.

mod cluster;
mod initial;
mod open;
pub mod sides;
pub mod split;
pub mod swept;
pub mod tube;

pub use initial::initial_patches;
pub use open::open_where;

use crate::charts::chart::StartKind;
use crate::charts::limits::ChartLimits;
use crate::charts::limits::fit::{Fit, from_scratch};
use crate::charts::part_mesh::{PartMesh, Piece};
use crate::contract::{Canceled, Run};
use crate::flatten::{self, flatten_triangle};
use crate::mesh::NONE;
use cluster::cluster;
use open::open;
use sides::{Side, glue_side};
use split::halves;

use crate::tasks;

/// Patch of each local face, which edges are closed, and the map of each patch. The sides come
/// first.
pub type Patches = (Vec<u32>, Vec<bool>, Vec<(Piece, Fit)>);

/// Flatten a part patch by patch.
pub fn patches(
    mesh: &PartMesh,
    sides: &[Side],
    limits: &ChartLimits,
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
        let now = std::mem::take(&mut pending);
        let size = |&p: &u32| faces[p as usize].len();
        let tried = tasks::map_by_size("patch", now.clone(), size, |p| {
            lay_flat(mesh, &faces[p as usize], [&inside, &glued], limits, run)
        });
        for (patch, flat) in now.into_iter().zip(tried) {
            if let Some((piece, fit, is_whole)) = flat? {
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
    limits: &ChartLimits,
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

fn fit_patch(piece: &Piece, limits: &ChartLimits, run: &Run) -> Result<Option<Fit>, Canceled> {
    if let &[triangle] = &piece.disk.triangles[..] {
        let [a, b, c] = triangle.map(|v| piece.disk.positions[v as usize]);
        return Ok(Some(Fit {
            uv: flatten_triangle(a, b, c).to_vec(),
            energy: 0.0,
            kind: StartKind::Planar,
        }));
    }
    from_scratch(&piece.disk, limits.bound, limits, run)
}
