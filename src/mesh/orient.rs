//! Consistent winding. Faces that share an edge of exactly two faces should run along it in
//! opposite directions; where they do not, the smaller side (by area) of each component is turned
//! over. A component that has no consistent winding (a Möbius strip) keeps some edges that disagree;
//! pairing leaves those open.

use std::collections::VecDeque;

use super::pairing::EdgeGroups;

/// Which faces must be turned over. Length: faces.
pub fn disagreeing(triangles: &[[u32; 3]], areas: &[f64], groups: &EdgeGroups) -> Vec<bool> {
    let faces = triangles.len();
    let direction = |h: u32| {
        let (f, k) = (h as usize / 3, h as usize % 3);
        triangles[f][k] < triangles[f][(k + 1) % 3]
    };
    let mut links: Vec<(u32, u32, bool)> = Vec::new();
    for group in groups.iter() {
        if let &[a, b] = group {
            let same = direction(a) == direction(b);
            links.push((a / 3, b / 3, same));
            links.push((b / 3, a / 3, same));
        }
    }
    let mut turned = vec![false; faces];
    if links.iter().all(|l| !l.2) {
        return turned;
    }
    links.sort_unstable();
    let mut starts = vec![0u32; faces + 1];
    for l in &links {
        starts[l.0 as usize + 1] += 1;
    }
    for f in 0..faces {
        starts[f + 1] += starts[f];
    }
    let mut seen = vec![false; faces];
    let mut queue = VecDeque::new();
    for seed in 0..faces {
        if seen[seed] {
            continue;
        }
        seen[seed] = true;
        queue.push_back(seed);
        let mut component = vec![seed];
        while let Some(f) = queue.pop_front() {
            for &(_, g, same) in &links[starts[f] as usize..starts[f + 1] as usize] {
                let g = g as usize;
                if !seen[g] {
                    seen[g] = true;
                    turned[g] = turned[f] ^ same;
                    component.push(g);
                    queue.push_back(g);
                }
            }
        }
        let area = |want: bool| -> f64 {
            component.iter().filter(|&&f| turned[f] == want).map(|&f| areas[f]).sum()
        };
        if area(true) > area(false) {
            component.iter().for_each(|&f| turned[f] = !turned[f]);
        }
    }
    turned
}
