//! Scene → surface: weld, set faces without area aside, orient, pair. For the solvers only; the
//! file's geometry stays as it is.

use std::collections::HashMap;

use glam::DVec3;

use super::existing_seams::existing_seams;
use super::pairing::{EdgeGroups, FaceTraits, pair};
use super::scene::Renumbering;
use super::{DisjointSets, FaceOrigin, NONE, Scene, Surface, orient, weld};
use crate::contract::{Canceled, Repairs, Run};

/// A face whose height is below this share of the diagonal has no area.
const FLAT: f64 = 1e-7;

/// An object that lies farther from the origin than so many diagonals is moved there, for the solvers.
const FAR: f64 = 64.0;

/// Condition a scene.
pub fn condition(scene: &Scene, run: &Run) -> Result<Surface, Canceled> {
    run.cancel.check()?;
    let mut soup = Vec::new();
    let mut raw: Vec<[u32; 3]> = Vec::with_capacity(scene.face_count());
    let mut origins = Vec::with_capacity(scene.face_count());
    let mut numbers = Renumbering::default();
    for (p, primitive) in scene.primitives.iter().enumerate() {
        let (base, first) = (soup.len() as u32, raw.len());
        raw.extend_from_slice(&primitive.triangles);
        let used = numbers.apply(&mut raw[first..], primitive.positions.count());
        soup.extend(used.iter().map(|&vertex| primitive.position(vertex)));
        raw[first..].as_flattened_mut().iter_mut().for_each(|vertex| *vertex += base);
        for i in 0..primitive.triangles.len() {
            origins.push(FaceOrigin {
                primitive: p as u32,
                index: i as u32,
                node: primitive.node,
                material: primitive.material.unwrap_or(NONE),
                component: 0,
                file_component: 0,
            });
        }
    }
    number_file_components(&mut origins, &raw, soup.len());
    let (mut low, diagonal) = extent(&soup, &raw);
    if low.length() > FAR * diagonal {
        // What is far from the origin loses its shape where numbers are kept in single precision.
        soup.iter_mut().for_each(|p| *p -= low);
        low = DVec3::ZERO;
    }
    let (ids, mut positions) = weld::weld(&soup, low, weld::TOLERANCE * diagonal);
    run.cancel.check()?;
    let mut triangles: Vec<[u32; 3]> = raw.iter().map(|t| t.map(|v| ids[v as usize])).collect();

    keep_slivers(&soup, &raw, &mut triangles, &mut positions, diagonal);
    let measured = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        (has_area([a, b, c], diagonal), (b - a).cross(c - a))
    };
    let usable: Vec<bool> = triangles.iter().map(|t| measured(t).0).collect();
    let area = |t: &[u32; 3]| {
        let (usable, cross) = measured(t);
        if usable { 0.5 * cross.length() } else { 0.0 }
    };
    let areas: Vec<f64> = triangles.iter().map(area).collect();
    let groups = EdgeGroups::new(&triangles, &usable);
    run.cancel.check()?;
    let reversed = orient::disagreeing(&triangles, &areas, &groups);
    for (t, _) in triangles.iter_mut().zip(&reversed).filter(|(_, r)| **r) {
        t.swap(1, 2);
    }
    let normals: Vec<DVec3> = triangles
        .iter()
        .map(|t| {
            let (usable, cross) = measured(t);
            if usable { cross.normalize_or_zero() } else { DVec3::ZERO }
        })
        .collect();
    // Turning a face over renumbers its half-edges.
    let groups = EdgeGroups::new(&triangles, &usable);
    number_components(&mut origins, &groups);
    let components: Vec<u32> = origins.iter().map(|o| o.component).collect();
    let faces = FaceTraits { normals: &normals, components: &components, turned: &reversed };
    let twin = pair(&triangles, &faces, &groups);
    run.cancel.check()?;
    let by_place = by_place(&triangles, &usable);
    let sheet_mate = sheet_mates(&by_place, triangles.len());
    let existing_seams = existing_seams(scene, &reversed, &twin);

    let used = ids.iter().copied().max().map_or(0, |m| m as u64 + 1);
    let repairs = Repairs {
        welded: soup.len() as u64 - used,
        zero_area_faces: usable.iter().filter(|u| !**u).count() as u64,
        nonmanifold_edges: groups.iter().filter(|g| g.len() > 2).count() as u64,
        split_vertices: split_vertices(&triangles, &usable, &twin),
        reoriented_faces: reversed.iter().filter(|r| **r).count() as u64,
        double_sided_faces: sheet_mate.iter().filter(|&&m| m != NONE).count() as u64,
        duplicate_faces: duplicates(&by_place, &reversed),
        ..Default::default()
    };
    Ok(Surface {
        positions,
        triangles,
        reversed,
        twin,
        usable,
        normals,
        areas,
        sheet_mate,
        existing_seams,
        origins,
        labels: scene.labels.clone(),
        names: scene.primitives.iter().map(|p| scene.name(p).to_owned()).collect(),
        diagonal,
        repairs,
    })
}

/// Undo the welding at the corners of slivers that it alone would flatten: there, vertices are one
/// only where their positions are the same to the last bit. A sliver so keeps its neighbours.
fn keep_slivers(
    soup: &[DVec3],
    raw: &[[u32; 3]],
    triangles: &mut [[u32; 3]],
    positions: &mut Vec<DVec3>,
    diagonal: f64,
) {
    let mut parted = vec![false; positions.len()];
    for (t, corners) in triangles.iter().zip(raw) {
        if has_area(corners.map(|v| soup[v as usize]), diagonal)
            && !has_area(t.map(|v| positions[v as usize]), diagonal)
        {
            t.iter().for_each(|&v| parted[v as usize] = true);
        }
    }
    let mut exact: HashMap<(u32, [u64; 3]), u32> = HashMap::new();
    for (t, corners) in triangles.iter_mut().zip(raw) {
        for (v, &corner) in t.iter_mut().zip(corners) {
            if !parted.get(*v as usize).copied().unwrap_or(false) {
                continue;
            }
            let p = soup[corner as usize];
            // Adding 0 makes one of the two zeros.
            let key = (*v, (p + 0.0).to_array().map(f64::to_bits));
            *v = *exact.entry(key).or_insert_with(|| {
                positions.push(p);
                positions.len() as u32 - 1
            });
        }
    }
}

/// Whether a triangle is higher than the least height that counts.
fn has_area([a, b, c]: [DVec3; 3], diagonal: f64) -> bool {
    let twice = (b - a).cross(c - a).length();
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    twice > FLAT * diagonal * longest && twice > 0.0
}

/// Lowest corner and diagonal of the box around all vertices that a face uses.
fn extent(positions: &[DVec3], triangles: &[[u32; 3]]) -> (DVec3, f64) {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for v in triangles.iter().flatten() {
        low = low.min(positions[*v as usize]);
        high = high.max(positions[*v as usize]);
    }
    let diagonal = (high - low).length();
    if diagonal.is_finite() && diagonal > 0.0 { (low, diagonal) } else { (DVec3::ZERO, 1.0) }
}

/// Faces that share a vertex of the file.
fn number_file_components(origins: &mut [FaceOrigin], raw: &[[u32; 3]], vertices: usize) {
    let mut sets = DisjointSets::new(vertices);
    for t in raw {
        sets.join(t[0], t[1]);
        sets.join(t[1], t[2]);
    }
    let mut number = HashMap::new();
    for (origin, t) in origins.iter_mut().zip(raw) {
        let next = number.len() as u32;
        origin.file_component = *number.entry(sets.root(t[0])).or_insert(next);
    }
}

/// Connected components within each primitive: faces that share an edge there.
fn number_components(origins: &mut [FaceOrigin], groups: &EdgeGroups) {
    let mut sets = DisjointSets::new(origins.len());
    for group in groups.iter() {
        for (i, &a) in group.iter().enumerate() {
            for &b in &group[..i] {
                let (f, g) = (a / 3, b / 3);
                if origins[f as usize].primitive == origins[g as usize].primitive {
                    sets.join(f, g);
                    break;
                }
            }
        }
    }
    let mut number = HashMap::new();
    for (f, origin) in origins.iter_mut().enumerate() {
        let next = number.len() as u32;
        origin.component = *number.entry(sets.root(f as u32)).or_insert(next);
    }
}

/// The faces with area, those of the same vertices one after the other, first those of one winding: sorted
/// vertices, winding, face.
fn by_place(triangles: &[[u32; 3]], usable: &[bool]) -> Vec<([u32; 3], bool, u32)> {
    let mut keyed = Vec::with_capacity(triangles.len());
    for (f, t) in triangles.iter().enumerate().filter(|&(f, _)| usable[f]) {
        let least = (0..3).min_by_key(|&k| t[k]).unwrap_or(0);
        let [a, b, c] = [t[least], t[(least + 1) % 3], t[(least + 2) % 3]];
        keyed.push(([a, b.min(c), b.max(c)], b < c, f as u32));
    }
    keyed.sort_unstable();
    keyed
}

/// For each face the one with the same vertices and the opposite winding.
fn sheet_mates(by_place: &[([u32; 3], bool, u32)], faces: usize) -> Vec<u32> {
    let mut mates = vec![NONE; faces];
    for group in by_place.chunk_by(|x, y| x.0 == y.0) {
        let split = group.partition_point(|x| !x.1);
        let (left, right) = group.split_at(split);
        for (l, r) in left.iter().zip(right) {
            mates[l.2 as usize] = r.2;
            mates[r.2 as usize] = l.2;
        }
    }
    mates
}

/// Faces that stand where another of the same winding in the file does, less one each.
fn duplicates(by_place: &[([u32; 3], bool, u32)], reversed: &[bool]) -> u64 {
    let copies = |group: &[([u32; 3], bool, u32)]| {
        let in_file = |x: &&([u32; 3], bool, u32)| x.1 != reversed[x.2 as usize];
        let one_way = group.iter().filter(in_file).count();
        one_way.saturating_sub(1) + (group.len() - one_way).saturating_sub(1)
    };
    by_place.chunk_by(|x, y| x.0 == y.0).map(copies).sum::<usize>() as u64
}

/// How many fans of faces there are beyond one a vertex (bow ties, non-manifold vertices).
fn split_vertices(triangles: &[[u32; 3]], usable: &[bool], twin: &[u32]) -> u64 {
    let mut sets = DisjointSets::new(3 * triangles.len());
    for (h, &t) in twin.iter().enumerate().filter(|(_, t)| **t != NONE) {
        // The half-edge's start meets the twin's end, and the other way round.
        let (f, k) = (h / 3, h % 3);
        let (g, l) = (t as usize / 3, t as usize % 3);
        sets.join((3 * f + k) as u32, (3 * g + (l + 1) % 3) as u32);
        sets.join((3 * f + (k + 1) % 3) as u32, (3 * g + l) as u32);
    }
    let mut fans = 0u64;
    let mut seen = std::collections::HashSet::new();
    for (f, t) in triangles.iter().enumerate().filter(|&(f, _)| usable[f]) {
        for k in 0..3 {
            let corner = (3 * f + k) as u32;
            fans += u64::from(sets.root(corner) == corner);
            seen.insert(t[k]);
        }
    }
    fans - seen.len() as u64
}

#[cfg(test)]
mod tests {
    //! Conditioning on the kinds of mesh that real files hold.

    use super::*;

    fn conditioned(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Surface {
        let positions = positions.iter().map(|p| DVec3::from_array(*p)).collect();
        let scene = Scene::from_triangles(positions, triangles.to_vec());
        condition(&scene, &Run::quiet()).unwrap()
    }

    const QUAD: [[f64; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];

    #[test]
    fn a_soup_is_welded_and_paired() {
        let soup = [QUAD[0], QUAD[1], QUAD[2], QUAD[0], QUAD[2], QUAD[3]];
        let s = conditioned(&soup, &[[0, 1, 2], [3, 4, 5]]);
        assert_eq!(s.repairs.welded, 2);
        assert_eq!(s.twin[2], 3);
        assert_eq!(s.twin.iter().filter(|&&t| t != NONE).count(), 2);
    }

    #[test]
    fn what_is_far_from_the_origin_is_moved_there() {
        let moved = |by: f64| {
            let away = QUAD.map(|p| p.map(|x| x + by));
            conditioned(&away, &[[0, 1, 2], [0, 2, 3]]).positions
        };
        let at = |by: f64| moved(by)[0];
        assert_eq!([at(0.0), at(32.0)], [DVec3::ZERO, DVec3::splat(32.0)]);
        assert_eq!(moved(1024.0), moved(0.0));
    }

    #[test]
    fn a_turned_face_is_turned_back() {
        let strip =
            [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.], [0., 2., 0.], [1., 2., 0.]];
        let s = conditioned(&strip, &[[0, 1, 2], [0, 2, 3], [3, 2, 4], [2, 4, 5]]);
        assert_eq!(s.repairs.reoriented_faces, 1);
        assert!(s.reversed[3]);
        assert!(s.normals.iter().all(|n| n.z > 0.99));
        assert_eq!([s.file_corner(3, 0), s.file_corner(3, 1), s.file_corner(3, 2)], [0, 2, 1]);
    }

    #[test]
    fn a_double_sided_box_corner_becomes_two_sheets() {
        // Two quads that meet at 90°, each face with both windings.
        let p =
            [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.], [1., 0., 1.], [1., 1., 1.]];
        let front = [[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]];
        let mut faces = front.to_vec();
        faces.extend(front.iter().map(|&[a, b, c]| [a, c, b]));
        let s = conditioned(&p, &faces);
        assert_eq!(s.repairs.double_sided_faces, 8);
        for (h, &t) in s.twin.iter().enumerate().filter(|(_, t)| **t != NONE) {
            assert_eq!(h / 3 < 4, t / 3 < 4, "half-edge {h} pairs with the other sheet");
        }
        assert_eq!(s.twin.iter().filter(|&&t| t != NONE).count(), 12);
        assert_eq!(s.sheet_mate[0], 4);
    }

    #[test]
    fn copies_are_counted_and_other_sides_are_not() {
        let copies = [[0, 1, 2], [0, 2, 3], [1, 2, 0], [2, 0, 1], [0, 3, 2]];
        let s = conditioned(&QUAD, &copies);
        assert_eq!(s.repairs.duplicate_faces, 2, "two more of the first");
    }

    #[test]
    fn degenerate_faces_are_set_aside() {
        let s = conditioned(&QUAD, &[[0, 1, 2], [0, 2, 3], [0, 0, 1]]);
        assert_eq!(s.usable, [true, true, false]);
        assert_eq!(s.repairs.zero_area_faces, 1);
    }

    #[test]
    fn a_sliver_that_welding_would_flatten_keeps_its_neighbours() {
        let mut p = QUAD.to_vec();
        p.push([1., 1. + 1e-6, 0.]);
        let s = conditioned(&p, &[[0, 1, 2], [0, 2, 4], [0, 4, 3]]);
        assert_eq!(s.usable, [true, true, true]);
        assert_eq!(s.twin[3..6].iter().filter(|&&t| t != NONE).count(), 2);
        assert!(s.origins.iter().all(|o| o.component == 0));
    }

    #[test]
    fn a_bow_tie_is_two_fans() {
        let p = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [-1., 0., 0.], [0., -1., 0.]];
        let s = conditioned(&p, &[[0, 1, 2], [0, 3, 4]]);
        assert_eq!(s.repairs.split_vertices, 1);
    }

    #[test]
    fn dihedral_angles_have_a_sign() {
        let p =
            [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.], [1., 0., -1.], [1., 1., -1.]];
        let s = conditioned(&p, &[[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]]);
        let right = std::f64::consts::FRAC_PI_2;
        assert!((s.dihedral(1) - right).abs() < 1e-12, "{}", s.dihedral(1));
        let mut valley = p;
        valley[4][2] = 1.0;
        valley[5][2] = 1.0;
        let s = conditioned(&valley, &[[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]]);
        assert!((s.dihedral(1) + right).abs() < 1e-12);
    }
}
