//! Borders that charts may cross (docs/method.md, 4): what only the network draws between two parts of an open
//! smooth surface, where there is no crease and no fold and nothing that the file says, is no place for a seam.
//! Such parts share their charts; a seam comes to lie there only where the distortion bound wants one.

use std::collections::BTreeMap;

use super::parts::Found;
use super::regions::{Segmented, is_guessed};
use crate::contract::PartJoin;
use crate::mesh::{NONE, Surface};

/// Least border of an open surface over the root of its area: a vessel with a narrow mouth has less.
const OPEN: f64 = 0.5;

/// A border lies on a fold, a valley or its other side, if the surface bends there by more than this signed
/// dihedral angle (radians) in the mean. Bumps to both sides cancel.
const FOLD: f64 = 0.3;

/// Share of a border's length that may be told by more than the network.
const TOLD: f64 = 0.02;

/// The joins over such borders.
pub fn soft_borders(found: &Found, on: &Segmented) -> Vec<PartJoin> {
    let (surface, parts) = (on.surface, &found.parts.parts);
    let open = widely_open(surface);
    // Length of each border, and of what of it is told by more than the network, and how much it bends.
    let mut borders: BTreeMap<(u32, u32), [f64; 3]> = BTreeMap::new();
    for (h, &t) in (0u32..).zip(&surface.twin).filter(|&(h, &t)| t != NONE && h < t) {
        let (f, g) = (h as usize / 3, t as usize / 3);
        let (a, b) = (on.labels[f], on.labels[g]);
        if a == b || a == NONE || b == NONE || !open[f] {
            continue;
        }
        let length = surface.length(h);
        let border = borders.entry((a.min(b), a.max(b))).or_default();
        border[0] += length;
        if is_told(surface, h) {
            border[1] += length;
        }
        border[2] += surface.dihedral(h) * length;
    }
    let guessed = |part: u32| is_guessed(parts[part as usize].source);
    let alike = |a: u32, b: u32| found.densities[a as usize] == found.densities[b as usize];
    borders
        .into_iter()
        .filter(|&((a, b), [all, told, bend])| {
            let soft = told <= TOLD * all && bend.abs() <= FOLD * all;
            soft && guessed(a) && guessed(b) && alike(a, b)
        })
        .map(|((a, b), _)| PartJoin { a, b, boundary: 0.0 })
        .collect()
}

/// Whether a crease or the file say that something ends at an edge.
fn is_told(surface: &Surface, h: u32) -> bool {
    let t = surface.twin[h as usize] as usize;
    let origin = |h: usize| {
        let origin = &surface.origins[h / 3];
        (origin.primitive, origin.material, origin.shell)
    };
    surface.is_crease(h)
        || surface.existing_seams.get(h as usize) == Some(&true)
        || origin(h as usize) != origin(t)
}

/// Whether each face lies in a connected component that has a long border for its area.
fn widely_open(surface: &Surface) -> Vec<bool> {
    let component = surface.components(|_| true);
    let count = component.iter().max().map_or(0, |&m| m as usize + 1);
    let (mut border, mut area) = (vec![0.0; count], vec![0.0; count]);
    for (f, &c) in component.iter().enumerate() {
        area[c as usize] += surface.areas[f];
        for h in 3 * f..3 * f + 3 {
            if surface.twin[h] == NONE {
                border[c as usize] += surface.length(h as u32);
            }
        }
    }
    component.iter().map(|&c| border[c as usize] >= OPEN * f64::sqrt(area[c as usize])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::{Run, SegmentationSource};
    use crate::pipeline::scenes;
    use crate::segmentation::{Part, PartLabels};

    /// Borders that give way on a surface of 8 × 8 cells in two halves.
    fn borders(text: &str, source: SegmentationSource) -> usize {
        let (mut found, mut solvers) = scenes::found(text, &scenes::options(), &Run::quiet());
        let part =
            |id| Part { id, name: id.to_string(), source, confidence: 0.9, name_confidence: None };
        let half = |f: usize| u32::from(solvers.surface.centroid(f).x > 4.0);
        let labels: Vec<u32> = (0..solvers.surface.face_count()).map(half).collect();
        found.parts =
            PartLabels { labels: labels.clone(), parts: (0..2).map(part).collect(), joins: vec![] };
        found.densities = vec![1.0; 2];
        solvers.part_of = labels;
        soft_borders(&found, &solvers.segmented()).len()
    }

    #[test]
    fn what_only_the_network_draws_on_an_open_smooth_surface_gives_way() {
        let flat = scenes::sheet(8, |_, _| 0.0);
        assert_eq!(borders(&flat, SegmentationSource::Learned), 1);
        assert_eq!(borders(&flat, SegmentationSource::Labels), 0, "what is given stays");
        let bent = |height: f64| scenes::sheet(8, move |x, _| height * (x - 4.0).abs());
        assert_eq!(borders(&bent(0.1), SegmentationSource::Learned), 1);
        assert_eq!(borders(&bent(0.2), SegmentationSource::Learned), 0, "a fold stays");
        assert_eq!(borders(&bent(-0.2), SegmentationSource::Learned), 0, "a fold stays");
        assert_eq!(borders(&bent(-0.5), SegmentationSource::Learned), 0, "a crease stays");
        assert_eq!(borders(&scenes::sphere(6), SegmentationSource::Learned), 0, "it is closed");
    }
}
