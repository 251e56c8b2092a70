//! `double_sided = share`: of two sheets, which lie on each other, only one is unwrapped; the other carries
//! the same UVs.

use crate::mesh::{NONE, Surface};

/// For each face the face whose UVs it carries: itself, or its mate on the sheet that is unwrapped.
/// A sheet is a connected component; of two that lie on each other the one with the lower first
/// face is unwrapped. Faces that are their own component's mates are unwrapped both.
pub fn sources(surface: &Surface) -> Vec<u32> {
    let sheet = surface.components(|_| true);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::Run;
    use crate::mesh::condition;
    use crate::pipeline::scenes;

    fn surface(text: &str) -> Surface {
        condition(&scenes::scene(text), &Run::quiet()).unwrap()
    }

    #[test]
    fn of_two_sheets_the_first_is_unwrapped() {
        let s = surface(&format!("{}{}", scenes::CUBE, scenes::INSIDE));
        let sources = sources(&s);
        assert_eq!(sources[..12], (0..12).collect::<Vec<u32>>()[..]);
        for f in 12..24 {
            let mate = sources[f] as usize;
            assert!(mate < 12, "face {f} carries its own");
            for k in 0..3 {
                let there = s.triangles[mate][mate_corner(&s, f, mate, k)];
                assert_eq!(there, s.triangles[f][k], "corner {k} of face {f} lies elsewhere");
            }
        }
    }

    #[test]
    fn who_has_no_mate_carries_its_own() {
        let text = scenes::squares(2);
        assert_eq!(sources(&surface(&text)), [0, 1, 2, 3]);
        // Behind the second square a face stands twice.
        let s = surface(&(text + "f 7 6 5\n"));
        let twice: Vec<u32> = sources(&s);
        assert_eq!(twice[..4], [0, 1, 2, 3]);
        assert_eq!(s.triangles[twice[4] as usize].iter().max(), s.triangles[4].iter().max());
    }

    #[test]
    fn a_component_that_is_its_own_mate_is_unwrapped_as_a_whole() {
        // Two faces back to back whose edges hang together are one component.
        let mut s = surface("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1\n");
        assert_eq!(s.sheet_mate, [1, 0]);
        s.twin = [0u32, 1, 2]
            .map(|k| {
                let (from, to) = (s.from(k), s.to(k));
                (3..6).find(|&t| (s.from(t), s.to(t)) == (to, from)).unwrap()
            })
            .into_iter()
            .chain([3u32, 4, 5].map(|k| {
                let (from, to) = (s.from(k), s.to(k));
                (0..3).find(|&t| (s.from(t), s.to(t)) == (to, from)).unwrap()
            }))
            .collect();
        assert_eq!(sources(&s), [0, 1]);
    }
}
