//! Charts of the proxy as labels and charts of the fine surface. Where some cannot be carried it is tried again
//! about these alone, each time in another way, and each builds on what the ways before it have mended.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use super::band::Band;
use super::pieces::Pieces;
use super::refine::{Refined, Refiner};
use super::{IN_WAY, near, settle};
use crate::charts::{self, Chart, ChartOptions};
use crate::contract::{Canceled, Run};
use crate::mesh::{NONE, Proxy, Surface};
use crate::tasks;

/// Rings of faces around those at which a chart could not be carried that are held where the proxy has them;
/// as many again go along.
const HELD: u32 = 24;

/// What charts are carried between.
#[derive(Clone, Copy)]
pub struct Surfaces<'a> {
    pub fine: &'a Surface,
    pub proxy: &'a Proxy,
    /// Part of each fine face and of each of the proxy's, or [`NONE`].
    pub parts: [&'a [u32]; 2],
}

/// A way to carry what could not be carried.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    /// Borders nearby stay where the proxy's charts have them.
    Held,
    /// Faces in the way go to the chart beside.
    Given,
    /// Faces in the way become charts of their own.
    Peeled,
}

/// Charts on the way to the fine surface.
pub struct Carrier<'a> {
    surfaces: Surfaces<'a>,
    coarse: &'a [Chart],
    pieces: &'a Pieces,
    options: &'a ChartOptions,
    run: &'a Run,
    /// Piece of each fine face, as the proxy has it.
    plain: Vec<u32>,
    /// Piece of each fine face.
    band: Band<'a, Pieces>,
    /// What has become of each chart.
    refined: Vec<Refined>,
}

/// Charts that were carried.
pub struct Carried {
    /// Charts of the fine surface.
    pub done: Vec<Chart>,
    /// Numbers of the charts that could not be carried, ascending, and the fine faces at which each fails.
    pub failed: Vec<(u32, Vec<u32>)>,
    /// Chart of each fine face, or [`NONE`].
    pub chart_of: Vec<u32>,
}

impl<'a> Carrier<'a> {
    /// Charts of the proxy and their pieces.
    pub fn new(
        surfaces: Surfaces<'a>,
        coarse: &'a [Chart],
        pieces: &'a Pieces,
        options: &'a ChartOptions,
        run: &'a Run,
    ) -> Self {
        let Surfaces { fine, proxy, parts: [fine_parts, proxy_parts] } = surfaces;
        let mut of_part: BTreeSet<(u32, u32)> = BTreeSet::new();
        let mut first: BTreeMap<u32, u32> = BTreeMap::new();
        for (&piece, &part) in pieces.of_face.iter().zip(proxy_parts).filter(|(p, _)| **p != NONE) {
            of_part.insert((pieces.chart[piece as usize], part));
            first.entry(part).or_insert(piece);
        }
        let fits = |f: usize, piece: u32| {
            piece != NONE && of_part.contains(&(pieces.chart[piece as usize], fine_parts[f]))
        };
        let carried = |(&on, &part): (&u32, &u32)| match on == NONE || part == NONE {
            true => NONE,
            false => pieces.of_face[on as usize],
        };
        let labels = proxy.face.iter().zip(fine_parts).map(carried).collect();
        let any = |part: u32| first.get(&part).copied().unwrap_or(0);
        let plain = tasks::link("spread", || spread(fine, labels, fine_parts, fits, any));
        let mut band = Band::new(fine, proxy, pieces, plain.clone(), Some(fine_parts));
        tasks::link("band", || settle(&mut band));
        let refined = vec![Err(Vec::new()); coarse.len()];
        Self { surfaces, coarse, pieces, options, run, plain, band, refined }
    }

    /// Carry all charts; the `last` time none is left.
    pub fn carry(&mut self, last: bool) -> Result<(), Canceled> {
        let all = vec![true; self.coarse.len()];
        self.refined =
            self.refine(&all, false, last)?.into_iter().map(|(_, refined)| refined).collect();
        if last {
            return Ok(());
        }
        for way in [Way::Held, Way::Given, Way::Peeled] {
            if self.failed() == 0 {
                break;
            }
            self.try_on(way)?;
        }
        Ok(())
    }

    /// What has become of the charts.
    pub fn finish(self) -> Carried {
        let chart_of = self.chart_of();
        let (mut done, mut failed) = (Vec::new(), Vec::new());
        for (number, refined) in (0u32..).zip(self.refined) {
            match refined {
                Ok(charts) => done.extend(charts),
                Err(at) => failed.push((number, at)),
            }
        }
        Carried { done, failed, chart_of }
    }

    fn failed(&self) -> usize {
        self.refined.iter().filter(|refined| refined.is_err()).count()
    }

    /// Chart of each fine face, or [`NONE`].
    fn chart_of(&self) -> Vec<u32> {
        let chart = |&l: &u32| if l == NONE { NONE } else { self.pieces.chart[l as usize] };
        self.band.labels.iter().map(chart).collect()
    }

    /// Carry the charts that could not be in another way, and those that this changes. It stays as it was where
    /// that leaves no fewer.
    fn try_on(&mut self, way: Way) -> Result<(), Canceled> {
        let failed = self.failed();
        if self.refined.iter().all(|r| r.as_ref().err().is_none_or(Vec::is_empty)) {
            return Ok(());
        }
        let before = self.band.labels.clone();
        self.relabel(way);
        let mut changed: Vec<bool> = self.refined.iter().map(Result::is_err).collect();
        for (&l, &m) in before.iter().zip(&self.band.labels).filter(|(l, m)| l != m) {
            for label in [l, m].into_iter().filter(|l| *l != NONE) {
                changed[self.pieces.chart[label as usize] as usize] = true;
            }
        }
        let refined = self.refine(&changed, way == Way::Peeled, false)?;
        // Every chart that failed is among them.
        let still = refined.iter().filter(|(_, refined)| refined.is_err()).count();
        if still < failed {
            for (chart, refined) in refined {
                self.refined[chart] = refined;
            }
        } else {
            self.band.labels = before;
        }
        Ok(())
    }

    /// Change labels about the faces at which charts fail.
    fn relabel(&mut self, way: Way) {
        let trouble: Vec<u32> =
            self.refined.iter().filter_map(|r| r.as_ref().err()).flatten().copied().collect();
        let twin = &self.surfaces.fine.twin;
        match way {
            Way::Held => {
                let held = near(twin, trouble.clone(), HELD);
                let about = near(twin, trouble, 2 * HELD);
                for (f, _) in held.iter().enumerate().filter(|(_, held)| **held) {
                    self.band.labels[f] = self.plain[f];
                }
                self.band.held =
                    held.iter().zip(&about).map(|(held, near)| *held || !near).collect();
                settle(&mut self.band);
            }
            Way::Given => {
                let about = near(twin, trouble, HELD);
                self.band.held = about.into_iter().map(|near| !near).collect();
                self.band.give(&self.in_way());
                self.band.smooth();
            }
            Way::Peeled => {}
        }
    }

    /// Faces in the way of charts in which few are.
    fn in_way(&self) -> Vec<u32> {
        let mut faces = vec![0usize; self.coarse.len()];
        let labels = self.band.labels.iter().filter(|l| **l != NONE);
        labels.for_each(|&l| faces[self.pieces.chart[l as usize] as usize] += 1);
        let trouble =
            self.refined.iter().zip(faces).filter_map(|(r, n)| Some((r.as_ref().err()?, n)));
        let few = trouble.filter(|(at, faces)| at.len() as f64 <= IN_WAY * *faces as f64);
        few.flat_map(|(at, _)| at.iter().copied()).collect()
    }

    /// What becomes of some charts with the labels as they are, with their numbers.
    fn refine(
        &self,
        which: &[bool],
        peel: bool,
        last: bool,
    ) -> Result<Vec<(usize, Refined)>, Canceled> {
        self.run.cancel.check()?;
        let Surfaces { fine, proxy, .. } = self.surfaces;
        let labels = &self.band.labels;
        let mut faces = vec![Vec::new(); which.len()];
        for (f, &label) in (0u32..).zip(labels).filter(|(_, l)| **l != NONE) {
            let chart = self.pieces.chart[label as usize] as usize;
            if which[chart] {
                faces[chart].push(f);
            }
        }
        let clearance = charts::clearance(fine);
        let (pieces, options, run) = (self.pieces, self.options, self.run);
        let refiner = Refiner { fine, proxy, pieces, labels, options, clearance, run };
        let work: Vec<(usize, Vec<u32>)> =
            faces.into_iter().enumerate().filter(|(chart, _)| which[*chart]).collect();
        let refine = |(chart, faces): (usize, Vec<u32>)| {
            Ok((chart, refiner.refine(&self.coarse[chart], faces, peel, last)?))
        };
        tasks::map_by_size("chart carried", work, |w| w.1.len(), refine).into_iter().collect()
    }
}

/// Labels that do not fit are replaced by the nearest over faces that does. Where there is none, they stay; a
/// face without a label gets `any` of its part.
pub(super) fn spread(
    fine: &Surface,
    labels: Vec<u32>,
    parts: &[u32],
    fits: impl Fn(usize, u32) -> bool,
    any: impl Fn(u32) -> u32,
) -> Vec<u32> {
    let mut done: Vec<bool> = (0..labels.len()).map(|f| fits(f, labels[f])).collect();
    let mut new = labels;
    let mut queue: VecDeque<u32> = (0..new.len() as u32).filter(|&f| done[f as usize]).collect();
    while let Some(f) = queue.pop_front() {
        for t in (3 * f..3 * f + 3).map(|h| fine.twin[h as usize]).filter(|&t| t != NONE) {
            let g = t as usize / 3;
            if !done[g] && parts[g] != NONE && fits(g, new[f as usize]) {
                (new[g], done[g]) = (new[f as usize], true);
                queue.push_back(g as u32);
            }
        }
    }
    for (label, &part) in new.iter_mut().zip(parts) {
        if *label == NONE && part != NONE {
            *label = any(part);
        }
    }
    new
}
