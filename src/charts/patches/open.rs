//! Opening a patch to a disk by tree and cotree (Eppstein 2003, "Dynamic generators of
//! topologically embedded graphs", arXiv:cs/0207082; Erickson & Whittlesey 2005): faces are joined
//! along a spanning tree of the dual graph, dearest seams first; of the other edges those that hang
//! free are closed again. What is left is the cut graph: nothing for a disk, paths between the
//! loops of a patch with holes, loops along the generators of handles.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::charts::limits::cost::edge_cost;
use crate::charts::part_mesh::PartMesh;
use crate::charts::patchwork::next;
use crate::mesh::NONE;

/// Which local half-edges stay closed when every patch is opened to a disk. A closed patch would
/// come out as one vertex-less sphere: the caller passes patches with a border.
pub fn open(mesh: &PartMesh, patch_of: &[u32]) -> Vec<bool> {
    open_where(mesh, |h| {
        let t = mesh.twin[h as usize];
        t != NONE && patch_of[t as usize / 3] == patch_of[h as usize / 3]
    })
}

/// Like [`open`], where `inside` says of each half-edge that has a twin whether it is closed by now.
pub fn open_where(mesh: &PartMesh, inside: impl Fn(u32) -> bool) -> Vec<bool> {
    let mut glued = vec![false; mesh.twin.len()];
    let mut reached = vec![false; mesh.len()];
    let mut heap = BinaryHeap::new();
    for seed in 0..mesh.len() as u32 {
        if reached[seed as usize] {
            continue;
        }
        // Maximum spanning tree of the dual graph (Prim), on the cost of the seam that it closes.
        reached[seed as usize] = true;
        let mut front = Some(seed);
        while let Some(f) = front {
            for h in (3 * f..3 * f + 3).filter(|&h| inside(h)) {
                heap.push((edge_cost(mesh, h).to_bits(), Reverse(h)));
            }
            front = None;
            while let Some((_, Reverse(h))) = heap.pop() {
                let t = mesh.twin[h as usize];
                if !reached[t as usize / 3] {
                    reached[t as usize / 3] = true;
                    glued[h as usize] = true;
                    glued[t as usize] = true;
                    front = Some(t / 3);
                    break;
                }
            }
        }
    }
    close_free_ends(mesh, inside, &mut glued);
    glued
}

/// Close cut edges that end at an inner vertex where no other cut or border arrives, over and over.
fn close_free_ends(mesh: &PartMesh, inside: impl Fn(u32) -> bool, glued: &mut [bool]) {
    let corners = 3 * mesh.len() as u32;
    // Fans: corners joined across every inner edge, cut or not, are one vertex of the patch.
    let mut fan = vec![NONE; 3 * mesh.len()];
    let mut fans = 0u32;
    let mut stack = Vec::new();
    for seed in 0..corners {
        if fan[seed as usize] != NONE {
            continue;
        }
        fan[seed as usize] = fans;
        stack.push(seed);
        while let Some(c) = stack.pop() {
            // Corner c starts half-edge c and ends the half-edge before it.
            let before = 3 * (c / 3) + (c % 3 + 2) % 3;
            let mut reach = |corner: u32| {
                if fan[corner as usize] == NONE {
                    fan[corner as usize] = fans;
                    stack.push(corner);
                }
            };
            if inside(c) {
                reach(next(mesh.twin[c as usize]));
            }
            if inside(before) {
                reach(mesh.twin[before as usize]);
            }
        }
        fans += 1;
    }
    let end = |h: u32| fan[next(h) as usize];
    let start = |h: u32| fan[h as usize];
    // Cut edges and border edges at each vertex. A border counts twice, so that it never hangs free.
    let mut degree = vec![0u32; fans as usize];
    let mut at = vec![Vec::new(); fans as usize];
    for h in 0..corners {
        let (a, b) = (start(h) as usize, end(h) as usize);
        if !inside(h) {
            degree[a] += 2;
            degree[b] += 2;
        } else if !glued[h as usize] && h < mesh.twin[h as usize] {
            degree[a] += 1;
            degree[b] += 1;
            at[a].push(h);
            at[b].push(h);
        }
    }
    let mut free: Vec<usize> = (0..fans as usize).filter(|&v| degree[v] == 1).collect();
    while let Some(v) = free.pop() {
        if degree[v] != 1 {
            continue;
        }
        let Some(&h) = at[v].iter().find(|&&h| !glued[h as usize]) else { continue };
        glued[h as usize] = true;
        glued[mesh.twin[h as usize] as usize] = true;
        for w in [start(h) as usize, end(h) as usize] {
            degree[w] -= 1;
            if degree[w] == 1 {
                free.push(w);
            }
        }
    }
}
