//! From the proxy of a dense surface back to it (docs/coarse_to_fine.md): labels of parts and charts, which
//! are straightened in a band about their borders, and the charts' maps.

mod band;
mod divide;
mod pieces;
mod prolong;
mod refine;
mod tidy;

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use rayon::prelude::*;

use crate::charts::{self, Chart, ChartOptions};
use crate::contract::{Canceled, GaveUp, Run, Stage};
use crate::mesh::{NONE, Proxy, Surface};
use band::Band;
use pieces::{Pieces, Plain, Seams};
use refine::{Refined, Refiner};

/// Islands of at most this share of the area go to their neighbours: what would be less than some 64 texels
/// of a usual page.
const ISLAND: f64 = 1.5e-4;

/// Rings of faces around those at which a chart could not be carried that are held where the proxy has them.
const HELD: u32 = 24;

/// Share of a chart's faces that may be in its way.
const IN_WAY: f64 = 0.02;

/// Times that charts which fail are divided on the proxy.
const DIVIDED: u32 = 3;

/// Labels of the proxy's faces carried to the fine faces. Where the caller gave labels, they end where those
/// do.
pub fn labels(fine: &Surface, proxy: &Proxy, of_proxy: &[u32]) -> Vec<u32> {
    let carried = proxy.face.iter().map(|&f| if f == NONE { NONE } else { of_proxy[f as usize] });
    let mut band = Band::new(fine, proxy, &Plain, carried.collect(), None);
    settle(&mut band, fine);
    band.labels
}

fn settle<S: Seams>(band: &mut Band<S>, fine: &Surface) {
    let least = ISLAND * fine.area();
    band.absorb_islands(least);
    band.straighten();
    band.absorb_islands(least);
    band.straighten();
    band.smooth();
    band.absorb_islands(least);
}

/// Charts of the proxy carried to the fine surface. `parts`: part of each fine face, [`NONE`] for those that
/// get no chart, and of each of the proxy's. Every other fine face gets one, of its part where there is one. A
/// chart that cannot be carried is divided on the proxy, [`DIVIDED`] times at most, and then on the fine surface.
pub fn charts(
    fine: &Surface,
    proxy: &Proxy,
    coarse: Vec<Chart>,
    parts: [&[u32]; 2],
    options: &ChartOptions,
    run: &Run,
) -> Result<Vec<Chart>, Canceled> {
    let mut parts = parts.map(<[u32]>::to_vec);
    let mut waiting = coarse;
    let mut charts = Vec::new();
    for round in 0..=DIVIDED {
        let late = round > 0 && run.skips(Stage::Charts, GaveUp::Joining);
        let carrier = Carrier { fine, proxy, options, run, last: late || round == DIVIDED };
        let parts_now = [&parts[0][..], &parts[1]];
        let first = carrier.carry(&waiting, parts_now, &Change::default(), None)?;
        let carried = if late { first } else { carrier.tried_on(&waiting, parts_now, first)? };
        let (done, failed) = (carried.refined.into_iter().flatten().flatten(), carried.failed);
        let chart_of = carried.chart_of;
        let mut trouble: Vec<u32> =
            carried.trouble.iter().map(|&f| proxy.face[f as usize]).collect();
        trouble.sort_unstable();
        trouble.dedup();
        charts.extend(done);
        if failed.is_empty() {
            break;
        }
        // What is left stays within the faces of the charts that failed.
        let number = |chart: u32| failed.binary_search(&chart).map_or(NONE, |i| i as u32);
        parts[0] = chart_of.into_iter().map(number).collect();
        parts[1] = vec![NONE; proxy.surface.face_count()];
        let mut halves = Vec::new();
        for (i, &chart) in (0u32..).zip(&failed) {
            let chart = &waiting[chart as usize];
            chart.faces.iter().for_each(|&f| parts[1][f as usize] = i);
            halves.extend(divide::divide(chart, &trouble));
        }
        waiting = halves;
    }
    charts.sort_by_key(|c| (c.part, c.faces.first().copied()));
    Ok(charts)
}

/// What charts are carried with.
struct Carrier<'a> {
    fine: &'a Surface,
    proxy: &'a Proxy,
    options: &'a ChartOptions,
    run: &'a Run,
    last: bool,
}

/// What is to be other than the band has it.
#[derive(Default)]
struct Change {
    /// Whether each fine face stays where the proxy's charts have it; empty for none.
    held: Vec<bool>,
    /// Fine faces that go to the chart beside theirs.
    given: Vec<u32>,
    /// Whether faces that are in the way of a chart become charts of their own.
    peel: bool,
}

impl Change {
    fn held(fine: &Surface, carried: &Carried) -> Self {
        Self { held: near(&fine.twin, carried.trouble.clone(), HELD), ..Self::default() }
    }
    fn given(carried: &Carried) -> Self {
        // Only where little is in the way.
        let mut of: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for &f in &carried.trouble {
            of.entry(carried.chart_of[f as usize]).or_default().push(f);
        }
        of.retain(|&chart, at| {
            at.len() as f64 <= IN_WAY * carried.faces[chart as usize].len() as f64
        });
        Self { given: of.into_values().flatten().collect(), ..Self::default() }
    }
    fn peeled() -> Self {
        Self { peel: true, ..Self::default() }
    }
}

/// Charts that were carried.
struct Carried {
    /// Each on the fine surface, `None` where it could not be carried.
    refined: Vec<Option<Vec<Chart>>>,
    /// Numbers of those that could not be carried.
    failed: Vec<u32>,
    /// Fine faces at which they failed.
    trouble: Vec<u32>,
    /// Piece of each fine face, or [`NONE`].
    labels: Vec<u32>,
    /// Fine faces of each.
    faces: Vec<Vec<u32>>,
    /// Chart of each fine face, or [`NONE`].
    chart_of: Vec<u32>,
}

impl Carrier<'_> {
    /// Where charts failed: once more with borders as the proxy has them, or that give way, or without what is in
    /// the way.
    fn tried_on(
        &self,
        coarse: &[Chart],
        parts: [&[u32]; 2],
        first: Carried,
    ) -> Result<Carried, Canceled> {
        if first.failed.is_empty() {
            return Ok(first);
        }
        let changes = [Change::held(self.fine, &first), Change::given(&first), Change::peeled()];
        let mut carried = first;
        for change in changes {
            let again = self.carry(coarse, parts, &change, Some(&carried))?;
            if again.failed.len() < carried.failed.len() {
                carried = again;
            }
            if carried.failed.is_empty() {
                break;
            }
        }
        Ok(carried)
    }

    /// What is as it was `before` is not carried again.
    fn carry(
        &self,
        coarse: &[Chart],
        [fine_parts, proxy_parts]: [&[u32]; 2],
        change: &Change,
        before: Option<&Carried>,
    ) -> Result<Carried, Canceled> {
        let &Self { fine, proxy, options, run, last } = self;
        let pieces = Pieces::new(&proxy.surface, coarse);
        let mut of_part: BTreeSet<(u32, u32)> = BTreeSet::new();
        for (&piece, &part) in pieces.of_face.iter().zip(proxy_parts).filter(|(p, _)| **p != NONE) {
            of_part.insert((pieces.chart[piece as usize], part));
        }
        let fits = |f: usize, piece: u32| {
            piece != NONE && of_part.contains(&(pieces.chart[piece as usize], fine_parts[f]))
        };
        let carried = |(&on, &part): (&u32, &u32)| match on == NONE || part == NONE {
            true => NONE,
            false => pieces.of_face[on as usize],
        };
        let labels = proxy.face.iter().zip(fine_parts).map(carried).collect();
        let any = |part: u32| {
            let of_part = pieces.of_face.iter().zip(proxy_parts).filter(|(p, _)| **p != NONE);
            let mut of_part = of_part.filter(|(_, own)| **own == part);
            of_part.next().map_or(0, |(&piece, _)| piece)
        };
        let labels = spread(fine, labels, fine_parts, fits, any);
        let mut band = Band::new(fine, proxy, &pieces, labels, Some(fine_parts));
        if !change.held.is_empty() {
            band.held.clone_from(&change.held);
        }
        settle(&mut band, fine);
        if !change.given.is_empty() {
            band.give(&change.given);
            band.smooth();
        }
        run.cancel.check()?;
        let labels = band.labels;
        let chart = |&l: &u32| if l == NONE { NONE } else { pieces.chart[l as usize] };
        let chart_of: Vec<u32> = labels.iter().map(chart).collect();
        let mut faces = vec![Vec::new(); coarse.len()];
        for (f, &chart) in (0u32..).zip(&chart_of).filter(|(_, c)| **c != NONE) {
            faces[chart as usize].push(f);
        }
        let clearance = charts::clearance(fine);
        let refiner =
            Refiner { fine, proxy, pieces: &pieces, labels: &labels, options, clearance, run };
        let as_before = |number: usize| {
            let before = before?;
            let same = before.faces[number] == faces[number]
                && faces[number].iter().all(|&f| before.labels[f as usize] == labels[f as usize]);
            before.refined[number].clone().filter(|_| same)
        };
        let refined: Result<Vec<Refined>, Canceled> = coarse
            .par_iter()
            .enumerate()
            .map(|(number, chart)| match as_before(number) {
                Some(charts) => Ok(Ok(charts)),
                None => refiner.refine(chart, faces[number].clone(), change.peel, last),
            })
            .collect();
        let mut trouble = Vec::new();
        let refined: Vec<Option<Vec<Chart>>> = refined?
            .into_iter()
            .map(|charts| charts.map_err(|at| trouble.extend(at)).ok())
            .collect();
        let failed = (0u32..).zip(&refined).filter(|(_, charts)| charts.is_none());
        let failed = failed.map(|(number, _)| number).collect();
        Ok(Carried { refined, failed, trouble, labels, faces, chart_of })
    }
}

/// Which faces lie within so many rings of others. `twin`: the half-edge across each, or [`NONE`].
fn near(twin: &[u32], of: Vec<u32>, rings: u32) -> Vec<bool> {
    let mut near = vec![false; twin.len() / 3];
    of.iter().for_each(|&f| near[f as usize] = true);
    let mut ring = of;
    for _ in 0..rings {
        for f in std::mem::take(&mut ring) {
            for t in (3 * f..3 * f + 3).map(|h| twin[h as usize]).filter(|&t| t != NONE) {
                if !std::mem::replace(&mut near[t as usize / 3], true) {
                    ring.push(t / 3);
                }
            }
        }
    }
    near
}

/// Labels that do not fit are replaced by the nearest over faces that does. Where there is none, they stay; a
/// face without a label gets `any` of its part.
fn spread(
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

#[cfg(test)]
mod tests;
