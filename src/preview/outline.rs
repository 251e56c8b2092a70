//! Outlines of charts in UV: the rims of their faces, joined to loops.

use crate::mesh::NONE;
use crate::metrics::{EdgeTable, Measured};

/// A closed line in UV, v up.
pub(super) type Loop = Vec<[f32; 2]>;

/// The loops of every chart. Length: charts.
pub(super) fn outlines(input: &Measured, edges: &EdgeTable) -> Vec<Vec<Loop>> {
    let surface = input.surface;
    let mut rim = vec![false; 3 * surface.face_count()];
    for e in 0..edges.len() {
        for h in edges.rim(e) {
            rim[h as usize] = true;
        }
    }
    let mut loops = vec![vec![]; input.charts];
    let mut walked = vec![false; rim.len()];
    for start in 0..rim.len() as u32 {
        if !rim[start as usize] || walked[start as usize] {
            continue;
        }
        let mut line = vec![];
        let mut h = start;
        while !walked[h as usize] {
            walked[h as usize] = true;
            line.push(input.uvs[h as usize / 3][h as usize % 3]);
            match next_on_rim(input, &rim, h) {
                Some(next) => h = next,
                None => break,
            }
        }
        if let Some(of_chart) = loops.get_mut(input.chart_of[start as usize / 3] as usize) {
            of_chart.push(line);
        }
    }
    loops
}

/// The half-edge of the rim that follows `h`: turn about its end until the rim is met again. `None`
/// where faces are joined in UV but not in 3D.
fn next_on_rim(input: &Measured, rim: &[bool], h: u32) -> Option<u32> {
    let around = |h: u32| h - h % 3 + (h % 3 + 1) % 3;
    let corner = |h: u32| input.uvs[h as usize / 3][h as usize % 3];
    let mut next = around(h);
    let end = corner(next);
    // A vertex has fewer faces than the object.
    for _ in 0..rim.len() {
        if rim[next as usize] {
            return Some(next);
        }
        let twin = input.surface.twin[next as usize];
        if twin == NONE || input.chart_of[twin as usize / 3] != input.chart_of[h as usize / 3] {
            return None;
        }
        next = around(twin);
        if corner(next) != end {
            return None;
        }
    }
    None
}
