//! `double_sided = share`: of two sheets of faces at the same place only one is unwrapped; the
//! other carries the same UVs.

use crate::mesh::{NONE, Surface};

/// For each face the face whose UVs it carries: itself, or its mate on the sheet that is unwrapped.
/// A sheet is a connected component; of two that lie on each other the one with the lower first
/// face is unwrapped. Faces that are their own component's mates are unwrapped both.
pub fn sources(surface: &Surface) -> Vec<u32> {
    let sheet = sheets(surface);
    let source = |(f, &mate): (usize, &u32)| {
        if mate != NONE && sheet[mate as usize] < sheet[f] { mate } else { f as u32 }
    };
    surface.sheet_mate.iter().enumerate().map(source).collect()
}

/// Which corner of its mate lies where corner `k` of face `f` lies.
pub fn mate_corner(surface: &Surface, f: usize, mate: usize, k: usize) -> usize {
    let vertex = surface.triangles[f][k];
    surface.triangles[mate].iter().position(|&v| v == vertex).unwrap_or(k)
}

/// Connected component of each face over twins, numbered by first face.
fn sheets(surface: &Surface) -> Vec<u32> {
    let mut sheet = vec![NONE; surface.face_count()];
    let mut stack = Vec::new();
    let mut count = 0;
    for seed in 0..surface.face_count() {
        if sheet[seed] != NONE {
            continue;
        }
        sheet[seed] = count;
        stack.push(seed);
        while let Some(f) = stack.pop() {
            for &t in &surface.twin[3 * f..3 * f + 3] {
                if t != NONE && sheet[t as usize / 3] == NONE {
                    sheet[t as usize / 3] = count;
                    stack.push(t as usize / 3);
                }
            }
        }
        count += 1;
    }
    sheet
}
