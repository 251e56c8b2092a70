//! Dividing faces that cannot be flattened together: two normal clusters where the surface bends,
//! two halves along the longest direction where it does not (Cohen-Steiner, Alliez & Desbrun 2004
//! use the same assignment by normals; doi:10.1145/1015706.1015817).

use glam::{DMat3, DVec3};

use crate::charts::part_mesh::PartMesh;

/// Divide connected local faces (at least two) into connected sets, at least two of them, each
/// ascending.
pub fn halves(mesh: &PartMesh, faces: &[u32]) -> Vec<Vec<u32>> {
    let by_normals = sides(mesh, faces);
    let mut in_left = vec![false; mesh.len()];
    for (&f, &left) in faces.iter().zip(&by_normals) {
        in_left[f as usize] = left;
    }
    mesh.components(faces, |h| {
        in_left[h as usize / 3] == in_left[mesh.twin[h as usize] as usize / 3]
    })
}

/// Which side each face goes to; both sides have one.
fn sides(mesh: &PartMesh, faces: &[u32]) -> Vec<bool> {
    let normal = |f: u32| mesh.normal(f as usize);
    let area = |f: u32| mesh.area(f as usize);
    let vector: DVec3 = faces.iter().map(|&f| normal(f) * area(f)).sum();
    let mean = vector.normalize_or_zero();
    let farthest = |from: DVec3| {
        faces.iter().copied().min_by(|&f, &g| normal(f).dot(from).total_cmp(&normal(g).dot(from)))
    };
    let (Some(a), Some(b)) = (farthest(mean), farthest(mean).and_then(|f| farthest(normal(f))))
    else {
        return vec![true; faces.len()];
    };
    // Within 20° all over, normals tell nothing: halve by position.
    if normal(a).dot(normal(b)) > 0.94 {
        return by_position(mesh, faces);
    }
    let mut centers = [normal(a), normal(b)];
    let mut side = vec![true; faces.len()];
    for _ in 0..8 {
        let mut sums = [DVec3::ZERO; 2];
        for (&f, s) in faces.iter().zip(&mut side) {
            *s = normal(f).dot(centers[0]) >= normal(f).dot(centers[1]);
            sums[usize::from(!*s)] += normal(f) * area(f);
        }
        centers = sums.map(DVec3::normalize_or_zero);
    }
    if side.iter().all(|&s| s) || side.iter().all(|&s| !s) {
        return by_position(mesh, faces);
    }
    side
}

/// Halve at the median along the direction of largest extent.
fn by_position(mesh: &PartMesh, faces: &[u32]) -> Vec<bool> {
    let center = |f: u32| mesh.surface.centroid(mesh.faces[f as usize] as usize);
    let mean = faces.iter().map(|&f| center(f)).sum::<DVec3>() / faces.len() as f64;
    let mut spread = DMat3::ZERO;
    for &f in faces {
        let d = center(f) - mean;
        spread += DMat3::from_cols(d * d.x, d * d.y, d * d.z);
    }
    // Power iteration from the diagonal is enough: any long direction will do.
    let mut direction = DVec3::new(1.0, 0.93, 0.87);
    for _ in 0..24 {
        let next = spread * direction;
        direction = if next.length() > 0.0 { next.normalize() } else { DVec3::X };
    }
    let mut order: Vec<(f64, usize)> =
        faces.iter().enumerate().map(|(i, &f)| (center(f).dot(direction), i)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut side = vec![false; faces.len()];
    order[..faces.len() / 2].iter().for_each(|&(_, i)| side[i] = true);
    side
}
