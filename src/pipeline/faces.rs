//! From charts to faces: what each corner of the file gets. Faces at one place carry the same coordinates;
//! faces without area lie along their neighbour's edge, so that they are in its chart and cover nothing.

use std::collections::HashMap;

use super::finish::CertifiedAtlas;
use super::parts::Found;
use crate::atlas::Grid;
use crate::mesh::NONE;

/// Coordinates and chart of each face.
pub struct Faces {
    /// Coordinates of the corners on their page, [0, 1]², in the surface's winding, v up; NaN for
    /// faces in no chart.
    pub uvs: Vec<[[f32; 2]; 3]>,
    /// What each face of the file gets, in its order and winding, finite for every face: the same, or moved to
    /// the page's UDIM tile, which is exact on that lattice.
    pub file: Vec<[[f32; 2]; 3]>,
    /// Chart of each face of the surface, or [`NONE`].
    pub chart_of: Vec<u32>,
}

/// Collect the faces.
pub fn collect(found: &Found, finished: &CertifiedAtlas) -> Faces {
    let surface = &found.surface;
    let count = surface.face_count();
    let mut uvs = vec![[[f32::NAN; 2]; 3]; count];
    let mut chart_of = vec![NONE; count];
    for (c, (mapped, uv)) in finished.charts.iter().zip(&finished.uvs).enumerate() {
        for (&f, triangle) in mapped.chart.faces.iter().zip(&mapped.chart.disk.triangles) {
            chart_of[f as usize] = c as u32;
            uvs[f as usize] = triangle.map(|v| uv[v as usize].as_vec2().to_array());
        }
    }
    let mut shipped = uvs.clone();
    if finished.grid == Grid::Tiles {
        for (f, &chart) in chart_of.iter().enumerate().filter(|(_, c)| **c != NONE) {
            let page = finished.page_of[chart as usize];
            let tile = [(page % 10) as f32, (page / 10) as f32];
            shipped[f] = shipped[f].map(|[u, v]| [u + tile[0], v + tile[1]]);
        }
    }
    let telling = &found.telling;
    let place = |(i, &f): (usize, &u32)| match f {
        NONE => [[f32::NAN; 2]; 3],
        f => [0, 1, 2].map(|k| shipped[f as usize][telling.corner(surface, i, k)]),
    };
    let mut file: Vec<_> = telling.face.iter().enumerate().map(place).collect();
    lay_down_flat_faces(found, finished.grid.step(), &mut file);
    Faces { uvs, file, chart_of }
}

/// Give faces that have no coordinates yet a place without area.
fn lay_down_flat_faces(found: &Found, step: f64, uvs: &mut [[[f32; 2]; 3]]) {
    let (surface, telling) = (&found.surface, &found.telling);
    let missing: Vec<usize> = (0..uvs.len()).filter(|&f| uvs[f][0][0].is_nan()).collect();
    if missing.is_empty() {
        return;
    }
    let mut edges: HashMap<(u32, u32), ([f32; 2], [f32; 2])> = HashMap::new();
    let mut vertices: HashMap<u32, [f32; 2]> = HashMap::new();
    for (f, t) in telling.triangles.iter().enumerate().filter(|(f, _)| !uvs[*f][0][0].is_nan()) {
        for k in 0..3 {
            let next = (k + 1) % 3;
            edges.entry((t[next], t[k])).or_insert((uvs[f][next], uvs[f][k]));
            vertices.entry(t[k]).or_insert(uvs[f][k]);
        }
    }
    for f in missing {
        let t = telling.triangles[f];
        let position = |k: usize| surface.positions[t[k] as usize];
        let length = |k: usize| position(k).distance(position((k + 1) % 3));
        let longest = (0..3).max_by(|&a, &b| length(a).total_cmp(&length(b))).unwrap_or(0);
        let (b, c) = ((longest + 1) % 3, (longest + 2) % 3);
        let either = edges.get(&(t[longest], t[b])).copied();
        let either = either.or_else(|| edges.get(&(t[b], t[longest])).map(|&(p, q)| (q, p)));
        uvs[f] = match either.filter(|_| length(longest) > 0.0) {
            Some((p, q)) => {
                let along = position(b) - position(longest);
                let share = (position(c) - position(longest)).dot(along) / along.length_squared();
                let share = share.clamp(0.0, 1.0);
                // On the lattice, as every other coordinate.
                let mix = |i: usize| {
                    let x = f64::from(p[i]) + share * (f64::from(q[i]) - f64::from(p[i]));
                    ((x / step).round() * step) as f32
                };
                let mut corners = [[0.0; 2]; 3];
                (corners[longest], corners[b], corners[c]) = (p, q, [mix(0), mix(1)]);
                corners
            }
            None => [t.iter().find_map(|v| vertices.get(v)).copied().unwrap_or([0.0; 2]); 3],
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::{DoubleSided, Run, UnwrapOptions};
    use crate::pipeline::scenes;

    fn collected(text: &str, options: &UnwrapOptions) -> (Found, CertifiedAtlas, Faces) {
        let (found, _, atlas) = scenes::atlas(text, options, &Run::quiet());
        let faces = collect(&found, &atlas);
        assert!(faces.file.iter().flatten().flatten().all(|x| x.is_finite()));
        (found, atlas, faces)
    }

    fn area([a, b, c]: [[f32; 2]; 3]) -> f32 {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    }

    #[test]
    fn corners_are_told_in_the_winding_of_the_file() {
        // Beside a square two smaller faces with the other winding: one chart, positive where most of it is.
        let text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 2 3 0\nv 0 3 0\n\
            f 1 2 3\nf 1 3 4\nf 4 5 3\nf 4 6 5\n";
        let (found, _, faces) = collected(text, &scenes::options());
        assert_eq!(faces.chart_of, [0; 4]);
        assert!(faces.uvs.iter().all(|&t| area(t) > 0.0), "no face of the surface is flipped");
        let positive: Vec<bool> = faces.file.iter().map(|&t| area(t) > 0.0).collect();
        assert_eq!(positive, [true, true, false, false]);
        let at = |f: usize, k: usize| faces.file[f][k];
        assert_eq!((at(1, 2), at(1, 1)), (at(2, 0), at(2, 2)), "they meet in vertices 4 and 3");
        assert_eq!(found.surface.face_count(), 4);
    }

    #[test]
    fn a_face_without_area_lies_along_its_neighbour() {
        // A triangle with one corner more on its long side, a face that has shrunk to one of its corners, and
        // one that touches nothing.
        let text = "v 0 0 0\nv 4 0 0\nv 0 3 0\nv 1 0 0\nv 9 9 9\nv 8 8 8\nv 7 7 7\n\
            f 1 2 3\nf 1 4 2\nf 3 3 3\nf 5 6 7\n";
        let (found, atlas, faces) = collected(text, &scenes::options());
        assert_eq!(found.telling.face, [0, NONE, NONE, NONE]);
        assert_eq!(faces.chart_of, [0]);
        let [one, two, three] = faces.file[0];
        let [a, between, b] = faces.file[1];
        assert_eq!((a, b), (one, two));
        for i in 0..2 {
            let share = a[i] + 0.25 * (b[i] - a[i]);
            assert!((between[i] - share).abs() < 1e-6, "{between:?}");
            let steps = f64::from(between[i]) / atlas.grid.step();
            assert_eq!(steps, steps.round(), "on the lattice");
        }
        assert_eq!(faces.file[2], [three; 3]);
        assert_eq!(faces.file[3], [[0.0; 2]; 3]);
    }

    #[test]
    fn a_shared_sheet_carries_its_mates_coordinates() {
        let text = format!("{}{}", scenes::CUBE, scenes::INSIDE);
        let options = UnwrapOptions { double_sided: DoubleSided::Share, ..scenes::options() };
        let (found, _, faces) = collected(&text, &options);
        let telling = &found.telling;
        assert_eq!((found.surface.face_count(), telling.face.len()), (12, 24));
        for f in 12..24 {
            let mate = (0..12).find(|&g| telling.face[g] == telling.face[f]).unwrap();
            // The same place in space is the same place on the page.
            for (k, v) in telling.triangles[f].iter().enumerate() {
                let there = telling.triangles[mate].iter().position(|w| w == v).unwrap();
                assert_eq!(faces.file[f][k], faces.file[mate][there]);
            }
        }
    }

    #[test]
    fn both_sides_of_a_sheet_are_cut_alike() {
        let text = format!("{}{}", scenes::CUBE, scenes::INSIDE);
        let (found, atlas, faces) = collected(&text, &scenes::options());
        let charts = atlas.charts.len();
        assert_eq!((found.surface.face_count(), charts % 2), (24, 0));
        let chart = |file: usize| faces.chart_of[found.telling.face[file] as usize];
        for (f, g) in (0..12).flat_map(|f| (0..12).map(move |g| (f, g))) {
            let mate = |f: usize| {
                let mut key = found.telling.triangles[f];
                key.sort_unstable();
                let is_mate = |g: &usize| {
                    let mut own = found.telling.triangles[*g];
                    own.sort_unstable();
                    own == key
                };
                (12..24).find(is_mate).unwrap()
            };
            assert_eq!(chart(f) == chart(g), chart(mate(f)) == chart(mate(g)));
            assert_ne!(chart(f), chart(mate(g)));
        }
        assert!(faces.file.iter().all(|&t| area(t) > 0.0), "in the file's winding, too");
    }

    #[test]
    fn the_file_has_each_page_on_its_tile() {
        let options = UnwrapOptions { pages: 12, udim: true, ..scenes::options() };
        let (found, atlas, faces) = collected(&scenes::squares(12), &options);
        assert_eq!(atlas.pages, 12);
        for f in 0..24 {
            let own = found.telling.face[f] as usize;
            let page = atlas.page_of[faces.chart_of[own] as usize];
            let tile = [(page % 10) as f32, (page / 10) as f32];
            for k in 0..3 {
                let [u, v] = faces.uvs[own][found.telling.corner(&found.surface, f, k)];
                assert!((0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v));
                let there = faces.file[f][k];
                assert_eq!(there, [u + tile[0], v + tile[1]]);
            }
        }
    }
}
