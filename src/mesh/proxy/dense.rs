//! One dense component: collapsed, and its vertices and faces found again on what is left of it.

use glam::DVec3;
use rayon::prelude::*;

use super::collapse::{Collapsed, Sheet, collapse};
use super::place::{Locator, Place};
use crate::contract::{Canceled, Run};
use crate::mesh::{DisjointSets, NONE, Numbers, Surface};
use crate::tasks;

/// A component that was collapsed; its faces and vertices have numbers of their own.
pub struct Dense {
    pub faces: Vec<u32>,
    pub vertices: Vec<u32>,
    pub collapsed: Collapsed,
    /// The face that each of its faces lies on.
    pub face: Vec<u32>,
    /// Where each of its vertices lies.
    pub places: Vec<Place>,
}

impl Dense {
    /// Collapse the component of these faces (ascending) to so many.
    pub fn new(
        surface: &Surface,
        faces: Vec<u32>,
        (positions, corners): (&[DVec3], &[[u32; 3]]),
        features: &[u8],
        coarse: usize,
        run: &Run,
    ) -> Result<Self, Canceled> {
        let mut vertices: Vec<u32> = faces.iter().flat_map(|&f| corners[f as usize]).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let (vertex, face) = (Numbers::of(&vertices), Numbers::of(&faces));
        let local = |v: u32| vertex.get(v);
        let across = |h: u32| match surface.twin[h as usize] {
            NONE => NONE,
            t => match face.get(t / 3) {
                NONE => NONE,
                g => 3 * g + t % 3,
            },
        };
        let half_edges = || faces.iter().flat_map(|&f| 3 * f..3 * f + 3);
        // Quadrics are exact only near the origin, and costs are kept in single precision: a power of two
        // brings any object to about size 1 without rounding.
        let centre = surface.centroid(faces[faces.len() / 2] as usize);
        let unit = surface.diagonal.log2().floor().exp2();
        let sheet = Sheet {
            positions: vertices.iter().map(|&v| (positions[v as usize] - centre) / unit).collect(),
            triangles: faces.iter().map(|&f| corners[f as usize].map(local)).collect(),
            twin: half_edges().map(across).collect(),
            feature: half_edges().map(|h| features[h as usize]).collect(),
        };
        let fine = sheet.clone();
        let mut collapsed = tasks::link("collapse", || collapse(sheet, coarse, &run.cancel))?;
        let (face, places) = tasks::link("locate", || locate(&fine, &collapsed));
        collapsed.sheet.positions.iter_mut().for_each(|p| *p = *p * unit + centre);
        run.cancel.check()?;
        Ok(Self { faces, vertices, collapsed, face, places })
    }
}

/// The place of each face's middle (its face), and of each vertex, on what is left of a sheet.
fn locate(fine: &Sheet, collapsed: &Collapsed) -> (Vec<u32>, Vec<Place>) {
    let sheet = &collapsed.sheet;
    let normal = |t: &[u32; 3], positions: &[DVec3]| {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        (b - a).cross(c - a)
    };
    let normals: Vec<DVec3> =
        sheet.triangles.iter().map(|t| normal(t, &sheet.positions).normalize_or_zero()).collect();
    // Faces within one outline of features stay within it.
    let mut sets = DisjointSets::new(fine.triangles.len());
    for (h, &t) in (0u32..).zip(&fine.twin) {
        if t != NONE && fine.feature[h as usize] == 0 {
            sets.join(h / 3, t / 3);
        }
    }
    let within: Vec<u32> = (0..fine.triangles.len() as u32).map(|f| sets.root(f)).collect();
    let locator = Locator::new(collapsed, &normals, &within);
    let mut outwards = vec![DVec3::ZERO; fine.positions.len()];
    let mut inside = vec![None; fine.positions.len()];
    for (t, &of) in fine.triangles.iter().zip(&within) {
        let normal = normal(t, &fine.positions);
        for &v in t {
            outwards[v as usize] += normal;
            inside[v as usize] = match inside[v as usize] {
                None => Some(of),
                // Several outlines meet at a feature: any of them will do.
                Some(other) => Some(if other == of { of } else { NONE }),
            };
        }
    }
    let face = |(t, &of): (&[u32; 3], &u32)| {
        let middle = t.iter().map(|&v| fine.positions[v as usize]).sum::<DVec3>() / 3.0;
        locator.find(t, middle, normal(t, &fine.positions), of).face
    };
    let faces: Vec<u32> = tasks::even("located", fine.triangles.len(), || {
        fine.triangles.par_iter().zip(&within).map(face).collect()
    });
    let place = |v: usize| {
        let of = inside[v].unwrap_or(NONE);
        locator.find(&[v as u32], fine.positions[v], outwards[v], of)
    };
    let places = tasks::even("located", fine.positions.len(), || {
        (0..fine.positions.len()).into_par_iter().map(place).collect()
    });
    (faces, places)
}
