//! The classical unwrapper as a peer: `uvunwrap` on the conditioned sheets, so that its shattering
//! of double-sided faces flatters nobody, and on the welded mesh as it came.

use std::collections::BTreeMap;
use std::time::Instant;

use glam::DVec2;
use serde_json::{Value, json};

use crate::flatten::{self, Island, singular_values};
use crate::mesh::{DisjointSets, NONE, Surface};

/// What the peer reaches: charts, seam length over √area, symmetric Dirichlet at one scale, seconds;
/// and the charts on the raw mesh. Null where it refuses the mesh.
pub fn measure(surface: &Surface) -> Value {
    let begun = Instant::now();
    let Some(islands) = on_sheets(surface) else { return Value::Null };
    let seconds = begun.elapsed().as_secs_f64();
    let (usable, total) = (surface.usable.iter().filter(|u| **u).count(), surface.area());
    if usable == 0 {
        return Value::Null;
    }
    let raw = match surface.repairs.nonmanifold_edges {
        0 => None,
        _ => flatten::classical_islands(&surface.positions, &surface.triangles).ok(),
    };
    let counted = |islands: &[Island]| {
        islands.iter().filter(|i| i.faces.iter().any(|&f| surface.usable[f as usize])).count()
    };
    json!({
        "charts": counted(&islands),
        "raw_charts": raw.map_or(counted(&islands), |raw| counted(&raw)),
        "seam": seam_length(surface, &islands) / total.sqrt(),
        "symmetric_dirichlet": symmetric_dirichlet(surface, &islands),
        "seconds": seconds,
    })
}

/// The peer's islands, each connected sheet on its own: it welds by position, so that sheets that lie
/// upon each other would be one to it.
fn on_sheets(surface: &Surface) -> Option<Vec<Island>> {
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
        let sheet: Vec<[u32; 3]> =
            faces.iter().map(|&f| triangles[f as usize].map(&mut local)).collect();
        for mut island in flatten::classical_islands(&own, &sheet).ok()? {
            island.faces.iter_mut().for_each(|f| *f = faces[*f as usize]);
            islands.push(island);
        }
    }
    Some(islands)
}

/// 3D length of the sheets' edges whose two sides have different coordinates.
fn seam_length(surface: &Surface, islands: &[Island]) -> f64 {
    let mut corner = vec![(NONE, DVec2::ZERO); 3 * surface.face_count()];
    for (i, island) in islands.iter().enumerate() {
        for (&f, t) in island.faces.iter().zip(&island.disk.triangles) {
            (0..3).for_each(|k| corner[3 * f as usize + k] = (i as u32, island.uv[t[k] as usize]));
        }
    }
    let next = |h: usize| 3 * (h / 3) + (h + 1) % 3;
    let mut length = 0.0;
    for (h, &t) in surface.twin.iter().enumerate().filter(|(h, t)| **t != NONE && *h < **t as usize)
    {
        let t = t as usize;
        if corner[h] != corner[next(t)] || corner[next(h)] != corner[t] {
            length += surface.length(h as u32);
        }
    }
    length
}

/// ½√(Σw(σ1²+σ2²)·Σw(σ1⁻²+σ2⁻²))/Σw over all faces with area.
fn symmetric_dirichlet(surface: &Surface, islands: &[Island]) -> f64 {
    let (mut direct, mut inverse, mut weight) = (0.0, 0.0, 0.0);
    for island in islands {
        for (i, &f) in island.faces.iter().enumerate().filter(|(_, f)| surface.usable[**f as usize])
        {
            let (s1, s2) = singular_values(island.disk.jacobian(i, &island.uv));
            let area = surface.areas[f as usize];
            direct += area * (s1 * s1 + s2 * s2);
            inverse += area * (1.0 / (s1 * s1) + 1.0 / (s2 * s2));
            weight += area;
        }
    }
    0.5 * (direct * inverse).sqrt() / weight
}
