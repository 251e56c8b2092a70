//! Charts that are too small to be of use: below 64 texels. Where what a chart may not leave is as small itself
//! (its connected component, its given label, its authored part, its material's pages), no cut could have made
//! it larger, and it is exempt.

use std::collections::HashMap;

use super::Measured;
use crate::contract::AtlasGrouping;
use crate::mesh::NONE;

/// A chart, or what holds it, is small below so many texels.
const SMALL: f64 = 64.0;

/// How many charts are small.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SmallCharts {
    /// Those that could be larger.
    pub avoidable: u32,
    /// Those that lie in something as small.
    pub exempt: u32,
}

/// Counts small charts. `authored` says whether a part is the author's; material pages hold a chart where each
/// material has an atlas (`atlas`). A chart over several labels, parts or materials is exempt where all of them
/// together are small.
pub fn small_charts(
    input: &Measured,
    authored: impl Fn(u32) -> bool,
    atlas: AtlasGrouping,
) -> SmallCharts {
    let surface = input.surface;
    let page = f64::from(input.page_size).powi(2);
    let texels: Vec<f64> = (0..surface.face_count())
        .map(|f| input.face_map(f).map_or(0.0, |m| m.uv_area.abs() * page))
        .collect();
    let mut of_chart = vec![0.0; input.charts];
    for (f, &chart) in input.chart_of.iter().enumerate() {
        if let Some(sum) = of_chart.get_mut(chart as usize) {
            *sum += texels[f];
        }
    }
    let small: Vec<bool> = of_chart.iter().map(|&sum| sum < SMALL).collect();
    if !small.contains(&true) {
        return SmallCharts::default();
    }
    let component = surface.components(|_| true);
    let labels = surface.labels.as_deref().unwrap_or(&[]);
    let label = |f: usize| labels.get(f).copied().filter(|&l| l >= 0).map(i64::from);
    let part = |f: usize| {
        let part = input.part_of[f];
        (part != NONE && authored(part)).then_some(i64::from(part))
    };
    // Faces without a material share pages, too.
    let material = |f: usize| match atlas {
        AtlasGrouping::Scene => None,
        AtlasGrouping::Material => surface.origins.get(f).map(|origin| i64::from(origin.material)),
    };
    let mut exempt = vec![false; input.charts];
    let mut count = Count { input, texels: &texels, small: &small, exempt: &mut exempt };
    count.hold(|f| Some(i64::from(component[f])));
    count.hold(label);
    count.hold(part);
    count.hold(material);
    let number = |is: bool| small.iter().zip(&exempt).filter(|(s, e)| **s && **e == is).count();
    SmallCharts { avoidable: number(false) as u32, exempt: number(true) as u32 }
}

/// What is known of the charts.
struct Count<'a> {
    input: &'a Measured<'a>,
    /// Texels of each face.
    texels: &'a [f64],
    /// Which charts are small.
    small: &'a [bool],
    /// Which of them are known to be exempt.
    exempt: &'a mut [bool],
}

impl Count<'_> {
    /// Exempts the charts that lie wholly in groups of faces that are small; no group holds nothing.
    fn hold(&mut self, group: impl Fn(usize) -> Option<i64>) {
        let mut of_group: HashMap<i64, f64> = HashMap::new();
        let mut members: Vec<(u32, Option<i64>)> = vec![];
        for (f, &chart) in self.input.chart_of.iter().enumerate() {
            let Some(&small) = self.small.get(chart as usize) else { continue };
            let group = group(f);
            if let Some(group) = group {
                *of_group.entry(group).or_default() += self.texels[f];
            }
            // Faces of a chart often follow each other.
            if small && members.last() != Some(&(chart, group)) {
                members.push((chart, group));
            }
        }
        members.sort_unstable();
        members.dedup();
        for chart in members.chunk_by(|a, b| a.0 == b.0) {
            let texels = chart.iter().map(|(_, group)| of_group.get(group.as_ref()?).copied());
            if texels.sum::<Option<f64>>().is_some_and(|sum| sum < SMALL) {
                self.exempt[chart[0].0 as usize] = true;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::mesh::Surface;
    use crate::metrics::fixtures::{self, grid, uvs};

    /// A strip of 16 cells in a row, each 8 texels wide: of 32 texels where `height` is 4. On the page of 1024
    /// texels. `apart` are cells at which the strip is torn from the one before.
    fn strip(height: f64, apart: &[u32]) -> (Surface, Vec<[[f32; 2]; 3]>) {
        let (mut surface, parameters) = grid(16, 1, |x, y| DVec3::new(x, y, 0.0));
        for h in 0..surface.twin.len() {
            let t = surface.twin[h];
            let cells = [h as u32 / 6, t / 6];
            if t != NONE && cells[0] != cells[1] && apart.contains(&cells[0].max(cells[1])) {
                surface.twin[h] = NONE;
            }
        }
        let uv = uvs(&parameters, |[u, v]| [128.0 / 1024.0 * u, height / 1024.0 * v]);
        (surface, uv)
    }

    /// Charts of cells: the first cell is one, the others another.
    fn first_alone() -> Vec<u32> {
        (0..32).map(|f| u32::from(f >= 2)).collect()
    }

    fn counted(
        (surface, uv): &(Surface, Vec<[[f32; 2]; 3]>),
        charts: &[u32],
        parts: &[u32],
        authored: bool,
        atlas: AtlasGrouping,
    ) -> (u32, u32) {
        let input = fixtures::measured(surface, uv, charts, parts);
        let counted = small_charts(&input, |_| authored, atlas);
        (counted.avoidable, counted.exempt)
    }

    const SCENE: AtlasGrouping = AtlasGrouping::Scene;

    #[test]
    fn a_chart_below_64_texels_is_small() {
        for (height, small) in [(4.0, 1), (7.9, 1), (8.1, 0)] {
            let strip = strip(height, &[]);
            assert_eq!(counted(&strip, &first_alone(), &[0; 32], false, SCENE), (small, 0));
        }
        let each: Vec<u32> = (0..32).map(|f| f / 2).collect();
        assert_eq!(counted(&strip(4.0, &[]), &each, &[0; 32], false, SCENE), (16, 0));
        // Faces in no chart are in no small one.
        assert_eq!(counted(&strip(4.0, &[]), &[NONE; 32], &[0; 32], false, SCENE), (0, 0));
    }

    #[test]
    fn a_component_that_is_small_itself_exempts() {
        let charts = first_alone();
        assert_eq!(counted(&strip(4.0, &[1]), &charts, &[0; 32], false, SCENE), (0, 1));
        // Of a component of two cells, 64 texels, each cell could be more; of one of 62 not.
        let three: Vec<u32> = (0..32).map(|f| (f / 2).min(2)).collect();
        assert_eq!(counted(&strip(4.01, &[2]), &three, &[0; 32], false, SCENE), (2, 0));
        assert_eq!(counted(&strip(3.9, &[2]), &three, &[0; 32], false, SCENE), (0, 2));
    }

    #[test]
    fn a_label_that_is_small_itself_exempts() {
        let charts = first_alone();
        let mut strip = strip(4.0, &[]);
        let labelled = |cells: u32| Some((0..32).map(|f| i32::from(f / 2 >= cells)).collect());
        for (cells, told) in [(1, (0, 1)), (3, (1, 0))] {
            strip.0.labels = labelled(cells);
            assert_eq!(counted(&strip, &charts, &[0; 32], false, SCENE), told);
        }
        // An unknown label holds nothing.
        strip.0.labels = Some((0..32).map(|f| if f < 2 { -1 } else { 0 }).collect());
        assert_eq!(counted(&strip, &charts, &[0; 32], false, SCENE), (1, 0));
    }

    #[test]
    fn a_part_that_is_small_itself_exempts_where_it_is_the_authors() {
        let (strip, charts) = (strip(4.0, &[]), first_alone());
        assert_eq!(counted(&strip, &charts, &charts, true, SCENE), (0, 1));
        assert_eq!(counted(&strip, &charts, &charts, false, SCENE), (1, 0));
        // A chart that reaches into a larger part could be larger.
        let parts: Vec<u32> = (0..32).map(|f| u32::from(f >= 1)).collect();
        assert_eq!(counted(&strip, &charts, &parts, true, SCENE), (1, 0));
    }

    #[test]
    fn a_material_that_is_small_itself_exempts_where_it_has_an_atlas() {
        let (mut strip, charts) = (strip(4.0, &[]), first_alone());
        for origin in &mut strip.0.origins[..2] {
            origin.material = 3;
        }
        let told = [SCENE, AtlasGrouping::Material]
            .map(|atlas| counted(&strip, &charts, &[0; 32], false, atlas));
        assert_eq!(told, [(1, 0), (0, 1)]);
    }
}
