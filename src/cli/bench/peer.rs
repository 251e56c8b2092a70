//! The classical unwrapper as a peer: `uvunwrap` on each connected component of the conditioned surface, so
//! that its shattering of double-sided objects flatters nobody, and on the welded mesh as it came.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

use super::row::PeerFigures;
use crate::flatten::{self, Island, singular_values};
use crate::mesh::{DisjointSets, NONE, Surface};
use crate::metrics::places;

/// What the peer reaches: charts, seam length over √area, symmetric Dirichlet at one scale, seconds;
/// and the charts on the raw mesh. `None` where it refuses the mesh.
pub fn measure(surface: &Surface) -> Option<PeerFigures> {
    let begun = Instant::now();
    let islands = on_components(surface)?;
    let seconds = begun.elapsed().as_secs_f64();
    let total = surface.area();
    if surface.face_count() == 0 {
        return None;
    }
    let raw = match surface.repairs.nonmanifold_edges {
        0 => None,
        _ => flatten::classical_islands(&surface.positions, &surface.triangles).ok(),
    };
    Some(PeerFigures {
        charts: islands.len() as u32,
        raw_charts: raw.map_or(islands.len(), |raw| raw.len()) as u32,
        seam: seam_length(surface, &islands) / total.sqrt(),
        symmetric_dirichlet: symmetric_dirichlet(surface, &islands),
        seconds,
    })
}

/// The peer's islands, each connected component on its own: it welds by position, so that sheets, which
/// lie on each other, would be one to it.
fn on_components(surface: &Surface) -> Option<Vec<Island>> {
    let (positions, triangles) = surface.sheets();
    let mut sets = DisjointSets::new(positions.len());
    for t in &triangles {
        sets.join(t[0], t[1]);
        sets.join(t[0], t[2]);
    }
    let mut members: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (f, t) in (0u32..).zip(&triangles) {
        members.entry(sets.root(t[0])).or_default().push(f);
    }
    let mut number = vec![NONE; positions.len()];
    let mut islands = Vec::new();
    for faces in members.into_values() {
        let mut own = Vec::new();
        let mut local = |v: u32| {
            if number[v as usize] == NONE {
                number[v as usize] = own.len() as u32;
                own.push(positions[v as usize]);
            }
            number[v as usize]
        };
        let component: Vec<[u32; 3]> =
            faces.iter().map(|&f| triangles[f as usize].map(&mut local)).collect();
        for mut island in flatten::classical_islands(&own, &component).ok()? {
            island.faces.iter_mut().for_each(|f| *f = faces[*f as usize]);
            islands.push(island);
        }
    }
    Some(islands)
}

/// 3D length of the cuts, counted as our own are: an edge of k faces needs ⌈k/2⌉ different UV edges, and
/// each further one is a cut. So the rim of a double-sided object, where its two sheets meet, is one for both.
fn seam_length(surface: &Surface, islands: &[Island]) -> f64 {
    let mut corner = vec![(NONE, [0; 2]); 3 * surface.face_count()];
    for (i, island) in (0u32..).zip(islands) {
        for (&f, t) in island.faces.iter().zip(&island.disk.triangles) {
            for k in 0..3 {
                let uv = island.uv[t[k] as usize].to_array().map(f64::to_bits);
                corner[3 * f as usize + k] = (i, uv);
            }
        }
    }
    let next = |h: usize| 3 * (h / 3) + (h + 1) % 3;
    let place = places(surface);
    let mut edges: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
    for h in 0..corner.len() {
        let mut ends = [surface.from(h as u32), surface.to(h as u32)].map(|v| place[v as usize]);
        ends.sort_unstable();
        edges.entry(ends).or_default().push(h);
    }
    let cuts = |(ends, around): (&[u32; 2], &Vec<usize>)| {
        let different: BTreeSet<_> = around
            .iter()
            .map(|&h| {
                let forward = place[surface.from(h as u32) as usize] == ends[0];
                let (a, b) = (corner[h], corner[next(h)]);
                if forward { [a, b] } else { [b, a] }
            })
            .collect();
        let more = different.len().saturating_sub(around.len().div_ceil(2));
        more as f64 * surface.length(around[0] as u32)
    };
    edges.iter().map(cuts).sum()
}

/// ½√(Σw(σ1²+σ2²)·Σw(σ1⁻²+σ2⁻²))/Σw over all faces with area.
fn symmetric_dirichlet(surface: &Surface, islands: &[Island]) -> f64 {
    let (mut direct, mut inverse, mut weight) = (0.0, 0.0, 0.0);
    for island in islands {
        for (i, &f) in island.faces.iter().enumerate() {
            let (s1, s2) = singular_values(island.disk.jacobian(i, &island.uv));
            let area = surface.areas[f as usize];
            direct += area * (s1 * s1 + s2 * s2);
            inverse += area * (1.0 / (s1 * s1) + 1.0 / (s2 * s2));
            weight += area;
        }
    }
    0.5 * (direct * inverse).sqrt() / weight
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::contract::{Run, Winding};
    use crate::mesh::{Conditioned, Scene, Sides, condition};

    /// A quad of two triangles, with both windings or one.
    fn quad(double: bool) -> Surface {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let mut triangles = vec![[0, 1, 2], [0, 2, 3]];
        if double {
            triangles.extend([[0, 2, 1], [0, 3, 2]]);
        }
        let positions = corners.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec();
        let scene = Scene::from_triangles(positions, triangles);
        let Conditioned { surface, telling } =
            condition(&scene, Winding::Surface, &Run::quiet()).unwrap();
        Sides::of(&surface, &telling, true, false).surface
    }

    #[test]
    fn a_sheet_has_no_seam_and_two_upon_each_other_have_their_rim() {
        for (double, rim) in [(false, 0.0), (true, 4.0)] {
            let surface = quad(double);
            let islands = on_components(&surface).unwrap();
            assert_eq!(islands.len(), 1 + usize::from(double));
            assert_eq!(seam_length(&surface, &islands), rim);
        }
    }

    #[test]
    fn triangles_apart_have_their_diagonal_for_a_seam() {
        let surface = quad(false);
        let mut islands = on_components(&surface).unwrap();
        let mut second = islands[0].clone();
        second.disk.triangles = vec![second.disk.triangles[1]];
        second.faces = vec![second.faces[1]];
        islands[0].disk.triangles.truncate(1);
        islands[0].faces.truncate(1);
        islands.push(second);
        assert!((seam_length(&surface, &islands) - 2f64.sqrt()).abs() < 1e-12);
    }
}
