//! Which components are dense, and how those that were cut by their proxies came by their charts
//! (docs/coarse_to_fine.md): what the metrics say of it.

use std::collections::{BTreeMap, BTreeSet};

use super::maps::Mapped;
use crate::charts::StartKind;
use crate::contract::CoarseToFine;
use crate::mesh::{Proxy, ProxySize, Surface};

/// The dense components of a surface.
#[derive(Debug, Clone, Default)]
pub struct DenseComponents {
    /// Whether each face belongs to one that was cut by its proxy; empty where none was.
    by_proxy: Vec<bool>,
    components: u32,
    as_they_are: u32,
}

impl DenseComponents {
    /// Those of a surface, of which some have a proxy.
    pub fn of(surface: &Surface, proxy: Option<&Proxy>, size: ProxySize) -> Self {
        if surface.face_count() <= size.dense {
            return Self::default();
        }
        let roots = surface.components(|_| true);
        let mut faces: BTreeMap<u32, usize> = BTreeMap::new();
        for &root in &roots {
            *faces.entry(root).or_default() += 1;
        }
        faces.retain(|_, faces| *faces > size.dense);
        let by_proxy: Vec<bool> = match proxy {
            Some(proxy) => proxy.face.iter().map(|&face| proxy.collapsed[face as usize]).collect(),
            None => Vec::new(),
        };
        let with_proxy: BTreeSet<u32> =
            roots.iter().zip(&by_proxy).filter(|(_, by)| **by).map(|(&root, _)| root).collect();
        let components = faces.keys().filter(|root| with_proxy.contains(root)).count();
        let as_they_are = (faces.len() - components) as u32;
        Self { by_proxy, components: components as u32, as_they_are }
    }

    /// The same of the sides of those faces.
    pub fn sides(&self, of: &[u32]) -> Self {
        let by_proxy = match self.by_proxy.is_empty() {
            true => Vec::new(),
            false => of.iter().map(|&f| self.by_proxy[f as usize]).collect(),
        };
        Self { by_proxy, ..*self }
    }

    /// How they were cut; `None` where there are none.
    pub fn metrics(&self, surface: &Surface, charts: &[Mapped]) -> Option<CoarseToFine> {
        if self.components + self.as_they_are == 0 {
            return None;
        }
        let by_proxy = |m: &&Mapped| {
            let first = m.chart.faces.first();
            first.is_some_and(|&f| self.by_proxy.get(f as usize) == Some(&true))
        };
        let carried = |m: &&Mapped| m.chart.start_kind == StartKind::Prolonged;
        let (carried, otherwise): (Vec<&Mapped>, Vec<&Mapped>) =
            charts.iter().filter(by_proxy).partition(carried);
        let area = |of: &[&Mapped]| {
            let faces = of.iter().flat_map(|m| &m.chart.faces);
            faces.map(|&f| surface.areas[f as usize]).sum::<f64>()
        };
        let (own, rest) = (area(&carried), area(&otherwise));
        Some(CoarseToFine {
            components: self.components,
            as_they_are: self.as_they_are,
            carried: carried.len() as u32,
            otherwise: otherwise.len() as u32,
            carried_area: (own + rest > 0.0).then(|| own / (own + rest)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::{Run, SegmentationSource, UnwrapOptions};
    use crate::pipeline::{maps, scenes};

    /// What the metrics say of a sphere of `n` rings.
    fn said(n: u32) -> Option<CoarseToFine> {
        let segmentation = SegmentationSource::Authored;
        let options = UnwrapOptions { segmentation, ..scenes::options() };
        let run = Run::quiet();
        let (found, solvers, cut) = scenes::cut(&scenes::sphere(n), &options, &run);
        let charts = solvers.refined(cut.charts, &found, &options, &run).unwrap();
        found.dense.metrics(&found.surface, &maps::untrained(charts))
    }

    #[test]
    fn what_is_dense_is_told_with_the_way_of_its_charts() {
        assert_eq!(said(20), None);
        let said = said(60).unwrap();
        assert_eq!((said.components, said.as_they_are), (1, 0));
        assert!(said.carried > 0 && said.carried_area.unwrap() >= 0.99, "{said:?}");
    }
}
