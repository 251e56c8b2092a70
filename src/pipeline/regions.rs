//! What charts may not cross (`Regions`; those of `segmentation` are others): the border of a part and,
//! where each material has an atlas, that of a material. A speck that only the network or the geometry
//! calls a part joins its neighbour's charts.

use std::collections::BTreeMap;

use super::parts::Found;
use crate::contract::{AtlasGrouping, PartJoin, SegmentationSource};
use crate::mesh::{DisjointSets, NONE, Surface};

/// Parts below this share of the area are specks.
const SPECK: f64 = 0.005;

/// What charts may not cross.
#[derive(Debug, Clone, PartialEq)]
pub struct Regions {
    /// Region of each face: its part, or part and material where each material has an atlas;
    /// [`NONE`] for faces that get no chart of their own.
    pub of_face: Vec<u32>,
    /// Part of each region.
    pub part: Vec<u32>,
    /// Atlas of each region, from 0.
    pub atlas: Vec<u32>,
}

/// A surface with its parts.
#[derive(Debug, Clone, Copy)]
pub struct Segmented<'a> {
    /// The surface.
    pub surface: &'a Surface,
    /// Part of each face.
    pub labels: &'a [u32],
}

impl Regions {
    /// The same where these joins of parts are made: regions of parts that are joined, in one atlas, are one,
    /// the one with the lowest number.
    pub fn joined(&self, found: &Found, joins: &[PartJoin]) -> Self {
        let mut sets = DisjointSets::new(found.parts.parts.len());
        for join in joins {
            sets.join(join.a, join.b);
        }
        let mut first = BTreeMap::new();
        let of_region: Vec<u32> = (0..)
            .zip(self.part.iter().zip(&self.atlas))
            .map(|(region, (&part, &atlas))| {
                *first.entry((sets.root(part), atlas)).or_insert(region)
            })
            .collect();
        let of = |&region: &u32| of_region.get(region as usize).copied().unwrap_or(NONE);
        Self { of_face: self.of_face.iter().map(of).collect(), ..self.clone() }
    }
}

/// The joins over borders that only the network or the geometry draws, between parts of one density, the
/// least certain border first.
pub fn giving_way(found: &Found) -> Vec<PartJoin> {
    let guessed = |part: u32| is_guessed(found.parts.parts[part as usize].source);
    let alike = |a: u32, b: u32| found.densities[a as usize] == found.densities[b as usize];
    let joins = found.parts.joins.iter().copied();
    joins.filter(|j| guessed(j.a) && guessed(j.b) && alike(j.a, j.b)).collect()
}

/// Whether nothing but the network or the geometry calls this a part.
pub fn is_guessed(source: SegmentationSource) -> bool {
    matches!(source, SegmentationSource::Geometric | SegmentationSource::Learned)
}

/// Number the regions in order of part, then material.
pub fn divide(found: &Found, on: &Segmented, atlas: AtlasGrouping) -> Regions {
    let surface = on.surface;
    let key = |f: usize| {
        let material = match atlas {
            AtlasGrouping::Scene => 0,
            AtlasGrouping::Material => surface.origins[f].material,
        };
        let part = on.labels[f];
        (part != NONE).then_some((part, material))
    };
    let keys: Vec<Option<(u32, u32)>> = (0..surface.face_count()).map(key).collect();
    let mut regions: Vec<(u32, u32)> = keys.iter().flatten().copied().collect();
    regions.sort_unstable();
    regions.dedup();
    let mut materials: Vec<u32> = regions.iter().map(|r| r.1).collect();
    materials.sort_unstable();
    materials.dedup();
    let number = |k: &Option<(u32, u32)>| {
        k.and_then(|k| regions.binary_search(&k).ok()).map_or(NONE, |r| r as u32)
    };
    let atlas_of = |r: &(u32, u32)| materials.binary_search(&r.1).unwrap_or(0) as u32;
    let divided = Regions {
        of_face: keys.iter().map(number).collect(),
        part: regions.iter().map(|r| r.0).collect(),
        atlas: regions.iter().map(atlas_of).collect(),
    };
    let absorbed = absorbed_specks(found, surface, &divided);
    let joined = |region: &u32| absorbed.get(region).copied().unwrap_or(*region);
    Regions { of_face: divided.of_face.iter().map(joined).collect(), ..divided }
}

/// The specks that only the network or the geometry calls parts, each with the neighbour of the longest
/// common border, in the same atlas and of the same density, whose charts it joins.
fn absorbed_specks(found: &Found, surface: &Surface, regions: &Regions) -> BTreeMap<u32, u32> {
    let mut area = vec![0.0; regions.part.len()];
    for (f, &region) in regions.of_face.iter().enumerate().filter(|(_, r)| **r != NONE) {
        area[region as usize] += surface.areas[f];
    }
    let least = SPECK * area.iter().sum::<f64>();
    let part = |region: u32| &found.parts.parts[regions.part[region as usize] as usize];
    let is_speck = |region: u32| is_guessed(part(region).source) && area[region as usize] < least;
    let like = |region: u32| {
        let part = regions.part[region as usize] as usize;
        (regions.atlas[region as usize], found.densities[part].to_bits())
    };
    let mut borders: BTreeMap<u32, BTreeMap<u32, f64>> = BTreeMap::new();
    for (h, &t) in (0u32..).zip(&surface.twin).filter(|(_, t)| **t != NONE) {
        let [from, to] = [h, t].map(|h| regions.of_face[h as usize / 3]);
        // Towards what is no speck, so that none is absorbed twice.
        if from != NONE && to != NONE && is_speck(from) && !is_speck(to) && like(from) == like(to) {
            *borders.entry(from).or_default().entry(to).or_default() += surface.length(h);
        }
    }
    let longest = |around: &BTreeMap<u32, f64>| {
        around.iter().max_by(|a, b| a.1.total_cmp(b.1)).map(|(&region, _)| region)
    };
    borders.iter().filter_map(|(&speck, around)| Some((speck, longest(around)?))).collect()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::contract::{Run, Winding};
    use crate::mesh::{Conditioned, Scene, condition};
    use crate::pipeline::dense_components::DenseComponents;
    use crate::segmentation::{Part, PartLabels};

    /// A square of 20 × 20 cells in two halves, parts 0 and 2, of which part 1 has a cell of the first.
    fn found(source: SegmentationSource) -> Found {
        let positions = (0..21 * 21).map(|i| DVec3::new(f64::from(i % 21), f64::from(i / 21), 0.0));
        let quads = (0..400u32).map(|i| i / 20 * 21 + i % 20);
        let cells = quads.flat_map(|a| [[a, a + 1, a + 22], [a, a + 22, a + 21]]);
        let scene = Scene::from_triangles(positions.collect(), cells.collect());
        let Conditioned { surface, telling } =
            condition(&scene, Winding::Surface, &Run::quiet()).unwrap();
        let label = |f: u32| if f / 2 == 63 { 1 } else { 2 * u32::from(f / 2 % 20 >= 10) };
        let of_file: Vec<u32> = (0..800).map(label).collect();
        let part =
            |id| Part { id, name: id.to_string(), source, confidence: 1.0, name_confidence: None };
        Found {
            parts: PartLabels {
                labels: surface.from_file_order(&of_file),
                parts: (0..3).map(part).collect(),
                joins: Vec::new(),
            },
            densities: vec![1.0; 3],
            weights: None,
            dense: DenseComponents::default(),
            surface: surface.into(),
            telling,
        }
    }

    /// Region of a face of the file.
    fn region(found: &Found, regions: &Regions, face: usize) -> u32 {
        regions.of_face[found.telling.face[face] as usize]
    }

    #[test]
    fn a_guessed_speck_goes_to_its_neighbour_and_a_named_one_stays() {
        for (source, own) in [(SegmentationSource::Geometric, 0), (SegmentationSource::Labels, 1)] {
            let found = found(source);
            let regions = divide(&found, &found.segmented(), AtlasGrouping::Scene);
            let of = [0, 126, 127, 799].map(|f| region(&found, &regions, f));
            assert_eq!(of, [0, own, own, 2]);
        }
    }

    #[test]
    fn a_speck_of_its_own_density_stays() {
        let mut found = found(SegmentationSource::Geometric);
        found.densities[1] = 4.0;
        let regions = divide(&found, &found.segmented(), AtlasGrouping::Scene);
        assert_eq!(region(&found, &regions, 126), 1);
    }
}
