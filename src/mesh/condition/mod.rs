//! Scene → surface: the canonical surface of an object, in whatever way a file tells it (docs/method.md, 1).
//! Weld; set slivers aside; one face a place; pair without windings; orient; find the front of each component;
//! say which face of the file is which. Edges that the file divides on one side alone are closed. For the solvers only; the file's geometry stays as it is.

mod complex;
mod existing_seams;
mod file;
mod junctions;
mod normals;
mod orient;
mod oriented_sets;
mod pairing;
mod places;
mod shells;
mod sign;
mod tell;
mod walls;
mod weld;

use glam::DVec3;
use rayon::prelude::*;

use super::{NONE, Scene, Surface, Telling};
use crate::contract::{Canceled, FirstFaces, Repairs, Run, Winding};
use complex::Complex;
use existing_seams::existing_seams;
use file::FileFaces;
use pairing::EdgeGroups;
use places::Places;
use shells::Shells;
use sign::Said;
use weld::Weld;

use crate::tasks;

/// A face whose height is below this share of the diagonal has no area.
const FLAT: f64 = 1e-7;

/// A surface, and how the file tells it.
#[derive(Debug, Clone, Default)]
pub struct Conditioned {
    /// The canonical surface: one face a place, in the order of places.
    pub surface: Surface,
    /// Where each face of the file is on it.
    pub telling: Telling,
}

/// Condition a scene.
pub fn condition(scene: &Scene, winding: Winding, run: &Run) -> Result<Conditioned, Canceled> {
    run.cancel.check()?;
    let mut file = tasks::link("file faces", || FileFaces::of(scene));
    let FileFaces { low, diagonal, .. } = file;
    let (vertex, positions, wide) = tasks::link("weld", || {
        let mut weld = Weld::new(&file.positions, low, weld::TOLERANCE * diagonal);
        keep_slivers(&file, &mut weld);
        let (vertex, positions) = weld.vertices();
        (vertex, positions, weld.wide)
    });
    file.welded = file.triangles.iter().map(|t| t.map(|v| vertex[v as usize])).collect();
    run.cancel.check()?;
    let at = |t: &[u32; 3]| t.map(|v| positions[v as usize]);
    let usable =
        tasks::fill("usable", file.welded.len(), |f| has_area(at(&file.welded[f]), diagonal));
    let labels = scene.labels.as_deref();
    let places = tasks::link("places", || Places::of(&file, &usable, labels, winding));
    run.cancel.check()?;
    let directed = winding == Winding::File;
    let groups = tasks::link("edges", || {
        EdgeGroups::new(&places.iter().map(|i| i[0].vertices).collect::<Vec<_>>())
    });
    let nonmanifold = groups.iter().filter(|g| g.len() > 2).count();
    let Shells { shell, solid } =
        tasks::link("shells", || Shells::of(scene, &file, &places, &groups));
    file.origins.iter_mut().zip(&shell).for_each(|(origin, &shell)| origin.shell = shell);
    let before = places.len();
    let places = places.by_solid(&solid);

    // Where solids part no place, the edges are still the same.
    let groups = (places.len() == before && !directed).then_some(groups);
    let Complex { positions, triangles, places: faces, closes, walls, mut twin } =
        tasks::link("pairs", || Complex::of(&places, groups, positions, diagonal, directed));
    run.cancel.check()?;
    // Where windings count, twins agree.
    let orientation = tasks::link("orient", || orient::orient(&triangles, &mut twin));
    let origin = |&place: &u32| file.origins[places.instances(place as usize)[0].face as usize];
    let cross = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        (b - a).cross(c - a)
    };
    let mut surface = Surface {
        normals: tasks::fill("normals", triangles.len(), |f| {
            cross(&triangles[f]).normalize_or_zero()
        }),
        areas: tasks::fill("areas", triangles.len(), |f| 0.5 * cross(&triangles[f]).length()),
        sheet_mate: mates(&triangles),
        closes,
        origins: faces.iter().map(origin).collect(),
        names: scene.primitives.iter().map(|p| scene.name(p).to_owned()).collect(),
        existing_seams: Vec::new(),
        labels: None,
        repairs: Repairs::default(),
        diagonal,
        positions,
        triangles,
        twin,
    };
    let normals = normals::of_faces(scene);
    if !directed {
        surface = surface.turned(&orientation.turned);
        let said = Said::of(&normals, &surface, &places, &faces);
        let turned = tasks::link("sign", || sign::turned(&surface, &said, run))?;
        surface = surface.turned(&turned);
    }
    run.cancel.check()?;
    let (telling, told) = tasks::link("tell", || tell::tell(&mut surface, &file, &places, &walls));
    surface.labels = scene.labels.as_ref().map(|labels| surface.from_file_order(labels));
    surface.existing_seams =
        tasks::link("existing seams", || existing_seams(scene, &file, &surface));

    let closed = surface.closed_faces();
    let first = |has: &dyn Fn(usize) -> bool| (0..usable.len()).find(|&f| has(f)).map(|f| f as u64);
    let without = orientation.without.first();
    let against = normals::against(&normals, &file, &usable);
    surface.repairs = Repairs {
        welded: (file.positions.len() - surface.positions.len()) as u64,
        wide_welds: wide,
        t_junctions: closed.len() as u64,
        zero_area_faces: usable.iter().filter(|u| !**u).count() as u64,
        nonmanifold_edges: nonmanifold as u64,
        split_vertices: split_vertices(&surface),
        against_normals: against.count,
        components_without_winding: orientation.without.len() as u64,
        first_faces: FirstFaces {
            zero_area_faces: first(&|f| !usable[f]),
            t_junctions: closed.into_iter().min(),
            against_normals: against.first,
            components_without_winding: without
                .map(|&f| u64::from(surface.origins[f as usize].face)),
            ..told.first_faces
        },
        ..told
    };
    Ok(Conditioned { surface, telling })
}

/// Undo the welding of slivers that it alone would flatten: there, vertices are one only where their positions
/// are the same to the last bit. A sliver so keeps its neighbours.
fn keep_slivers(file: &FileFaces, weld: &mut Weld) {
    let flattened = |t: &&[u32; 3]| {
        has_area(t.map(|v| file.positions[v as usize]), file.diagonal)
            && !has_area(t.map(|v| weld.welded(v)), file.diagonal)
    };
    let corners: Vec<u32> = file.triangles.iter().filter(flattened).flatten().copied().collect();
    weld.part_at(corners.into_iter());
}

/// Whether a triangle is higher than the least height that counts.
fn has_area([a, b, c]: [DVec3; 3], diagonal: f64) -> bool {
    let twice = (b - a).cross(c - a).length();
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    twice > FLAT * diagonal * longest && twice > 0.0
}

/// For each face one other on the same vertices, or [`NONE`].
fn mates(triangles: &[[u32; 3]]) -> Vec<u32> {
    let key = |f: usize| {
        let mut key = triangles[f];
        key.sort_unstable();
        (key, f as u32)
    };
    let mut keyed = tasks::fill("mates", triangles.len(), key);
    tasks::even("mates", keyed.len(), || keyed.par_sort_unstable());
    let mut mates = vec![NONE; triangles.len()];
    for group in keyed.chunk_by(|a, b| a.0 == b.0) {
        for pair in group.chunks_exact(2) {
            mates[pair[0].1 as usize] = pair[1].1;
            mates[pair[1].1 as usize] = pair[0].1;
        }
    }
    mates
}

/// How many fans of faces there are beyond one a vertex (bow ties, non-manifold vertices).
fn split_vertices(surface: &Surface) -> u64 {
    let (fans, _) = surface.sheets();
    let mut used = vec![false; surface.positions.len()];
    surface.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
    (fans.len() - used.iter().filter(|used| **used).count()) as u64
}

#[cfg(test)]
mod tests;
