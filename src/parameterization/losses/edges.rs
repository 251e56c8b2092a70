//! The edges of a disk, and which triangles and edges a loss measures. The two sides of a cut are
//! different vertices of a disk, so a cut is a border here without being told.

use crate::flatten::Disk;

/// An edge of a disk, once.
#[derive(Debug, Clone, Copy)]
pub(super) struct Link {
    /// Its ends, in the order in which `left` runs through them.
    pub ends: [u32; 2],
    /// A triangle at the edge.
    pub left: Side,
    /// The triangle across, which runs through the ends the other way; none at a border.
    pub right: Option<Side>,
}

/// A triangle at an edge.
#[derive(Debug, Clone, Copy)]
pub(super) struct Side {
    pub face: u32,
    /// The corner that is not on the edge.
    pub apex: u32,
}

/// An edge with its length in 3D.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edge {
    pub ends: [u32; 2],
    /// Above 0.
    pub length: f64,
}

/// The triangles to measure, in ascending order, once each: those of `faces`, or all, that exist
/// and have area.
pub(super) fn select(disk: &Disk, faces: Option<&[u32]>) -> Vec<u32> {
    let mut selected = match faces {
        Some(faces) => faces.to_vec(),
        None => (0..disk.triangles.len() as u32).collect(),
    };
    selected.retain(|f| disk.areas.get(*f as usize).is_some_and(|area| *area > 0.0));
    selected.sort_unstable();
    selected.dedup();
    selected
}

/// Whether each triangle of the disk is among `selected`.
pub(super) fn mask(disk: &Disk, selected: &[u32]) -> Vec<bool> {
    let mut mask = vec![false; disk.triangles.len()];
    for f in selected {
        mask[*f as usize] = true;
    }
    mask
}

/// Every edge of the disk, once, in ascending order of its ends.
pub(super) fn links(disk: &Disk) -> Vec<Link> {
    let mut half_edges = Vec::with_capacity(3 * disk.triangles.len());
    for (f, t) in disk.triangles.iter().enumerate() {
        for k in 0..3 {
            let ends = [t[k], t[(k + 1) % 3]];
            let side = Side { face: f as u32, apex: t[(k + 2) % 3] };
            half_edges.push((ends[0].min(ends[1]), ends[0].max(ends[1]), ends, side));
        }
    }
    half_edges.sort_by_key(|(low, high, _, side)| (*low, *high, side.face));
    let mut links: Vec<Link> = Vec::with_capacity(half_edges.len() / 2 + 1);
    for (_, _, ends, side) in half_edges {
        match links.last_mut() {
            Some(last) if last.right.is_none() && last.ends == [ends[1], ends[0]] => {
                last.right = Some(side);
            }
            _ => links.push(Link { ends, left: side, right: None }),
        }
    }
    links
}

/// The edges of the selected triangles that have length.
pub(super) fn edges(disk: &Disk, links: &[Link], selected: &[u32]) -> Vec<Edge> {
    let mask = mask(disk, selected);
    let measured = |side: &Side| mask[side.face as usize];
    links
        .iter()
        .filter(|link| measured(&link.left) || link.right.as_ref().is_some_and(measured))
        .map(|link| Edge { ends: link.ends, length: length(disk, link) })
        .filter(|edge| edge.length > 0.0)
        .collect()
}

/// Length of an edge in 3D.
pub(super) fn length(disk: &Disk, link: &Link) -> f64 {
    let [a, b] = link.ends.map(|v| disk.positions[v as usize]);
    a.distance(b)
}
