//! How well each face is seen from outside: a seam where nobody looks costs less.

use glam::DVec3;
use rayon::prelude::*;

use crate::contract::{Canceled, Run};
use crate::mesh::rays::Rays;
use crate::mesh::{NONE, Surface};
use crate::tasks;

/// Most rays a face.
const RAYS: usize = 8;

/// Rays in all, of usual cost. A surface that would get less than two a face is taken to be seen
/// everywhere.
const MOST_RAYS: f64 = 250_000.0;

/// Expected visits of the ray caster a ray for which that many are affordable.
const USUAL_VISITS: f64 = 300.0;

/// Passes over the neighbours that take the noise away.
const PASSES: usize = 2;

/// Ambient visibility of each face, 0 (sealed) to 1 (open), or nothing where that would take too long.
pub fn visibility(surface: &Surface, run: &Run) -> Result<Option<Vec<f32>>, Canceled> {
    let rays = tasks::link("rays", || Rays::new(surface));
    let dearer = (rays.expected_visits() / USUAL_VISITS).max(1.0);
    let each = (MOST_RAYS / dearer / surface.face_count().max(1) as f64) as usize;
    if each < 2 {
        return Ok(None);
    }
    let each = each.min(RAYS) as u32;
    let open = on_open_sheets(surface);
    let mut seen: Vec<f32> = tasks::even("visibility", surface.face_count(), || {
        (0..surface.face_count())
            .into_par_iter()
            .map(|f| {
                if run.cancel.is_canceled() {
                    return 1.0;
                }
                let center = surface.corners(f).into_iter().sum::<DVec3>() / 3.0;
                let looks = |normal| {
                    rays.ambient_visibility(center, normal, each, f as u64, f as u32) as f32
                };
                let front = looks(surface.normals[f]);
                // What is open shows its back as well.
                if open[f] { front.max(looks(-surface.normals[f])) } else { front }
            })
            .collect()
    });
    run.cancel.check()?;
    for _ in 0..PASSES {
        seen = tasks::even("visibility", seen.len(), || {
            (0..seen.len())
                .into_par_iter()
                .map(|f| {
                    let near = surface.twin[3 * f..3 * f + 3].iter().filter(|&&t| t != NONE);
                    let (sum, count) =
                        near.fold((seen[f], 1.0), |(s, n), &t| (s + seen[t as usize / 3], n + 1.0));
                    sum / count
                })
                .collect()
        });
    }
    Ok(Some(seen))
}

/// Whether each face belongs to a connected component that has a border where no mate lies behind it.
fn on_open_sheets(surface: &Surface) -> Vec<bool> {
    let sheet = surface.components(|_| true);
    let mut open = vec![false; surface.face_count()];
    for (h, &t) in surface.twin.iter().enumerate() {
        open[sheet[h / 3] as usize] |= t == NONE && surface.sheet_mate[h / 3] == NONE;
    }
    sheet.iter().map(|&sheet| open[sheet as usize]).collect()
}
