//! Faces near the borders between regions, where the line may be drawn anew.

use crate::mesh::{NONE, Surface};

/// How many steps each face is from a border between two regions that may be moved, 1 at the border, 0
/// beyond `rings` steps. `free` is asked for the border's half-edges.
pub(super) fn near_borders(
    surface: &Surface,
    region: &[i32],
    rings: u8,
    free: impl Fn(u32) -> bool,
) -> Vec<u8> {
    let across = |f: u32| {
        let edges = (3 * f..3 * f + 3).filter(|&h| surface.twin[h as usize] != NONE && free(h));
        edges.map(|h| surface.twin[h as usize] / 3)
    };
    let mut ring = vec![0; region.len()];
    let mut front: Vec<u32> = (0..region.len() as u32)
        .filter(|&f| {
            let own = region[f as usize];
            own >= 0 && across(f).any(|g| region[g as usize] >= 0 && region[g as usize] != own)
        })
        .collect();
    front.iter().for_each(|&f| ring[f as usize] = 1);
    for step in 2..=rings {
        let mut next = Vec::new();
        for g in front.iter().flat_map(|&f| across(f)) {
            if region[g as usize] >= 0 && ring[g as usize] == 0 {
                ring[g as usize] = step;
                next.push(g);
            }
        }
        front = next;
    }
    ring
}
