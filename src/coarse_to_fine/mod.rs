//! From the proxy of a dense surface back to it (docs/coarse_to_fine.md): labels of parts and charts, which
//! are straightened in a band about their borders, and the charts' maps.

mod band;
mod carry;
mod divide;
mod pieces;
mod prolong;
mod refine;
mod tidy;

use crate::charts::{Chart, ChartOptions};
use crate::contract::{Canceled, GaveUp, Run, Stage};
use crate::flatten::{self, SlimOptions};
use crate::mesh::{NONE, Proxy, Surface};
use band::Band;
use carry::{Carried, Carrier, Surfaces};
use pieces::{Pieces, Plain, Seams};

use crate::tasks;

/// Islands of at most this share of the area go to their neighbours: what would be less than some 64 texels
/// of a usual page.
const ISLAND: f64 = 1.5e-4;

/// Share of a chart's faces that may be in its way.
const IN_WAY: f64 = 0.02;

/// Descent steps of a proxy's map before it is carried over.
const STEPS: u32 = 20;

/// Times that charts which fail are divided on the proxy.
const DIVIDED: u32 = 3;

/// Labels of the proxy's faces carried to the fine faces. Where the caller gave labels, they end where those
/// do.
pub fn labels(fine: &Surface, proxy: &Proxy, of_proxy: &[u32]) -> Vec<u32> {
    let carried = proxy.face.iter().map(|&f| of_proxy[f as usize]);
    let mut band = Band::new(fine, proxy, &Plain, carried.collect(), None);
    settle(&mut band);
    band.labels
}

/// Labels short of islands, and straight.
fn settle<S: Seams>(band: &mut Band<S>) {
    let least = ISLAND * band.fine.area();
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
    mut coarse: Vec<Chart>,
    parts: [&[u32]; 2],
    options: &ChartOptions,
    run: &Run,
) -> Result<Vec<Chart>, Canceled> {
    let mut parts = parts.map(<[u32]>::to_vec);
    polish(&mut coarse, proxy, run)?;
    let mut charts = Vec::new();
    for round in 0..=DIVIDED {
        let late = round > 0 && run.skips(Stage::Charts, GaveUp::Joining);
        let last = late || round == DIVIDED;
        let surfaces = Surfaces { fine, proxy, parts: [&parts[0], &parts[1]] };
        let pieces = Pieces::new(&proxy.surface, &coarse);
        let mut carrier = Carrier::new(surfaces, &coarse, &pieces, options, run);
        carrier.carry(last)?;
        let Carried { done, failed, chart_of } = carrier.finish();
        charts.extend(done);
        if failed.is_empty() {
            break;
        }
        // What is left stays within the faces of the charts that failed.
        let number =
            |chart: u32| failed.binary_search_by_key(&chart, |f| f.0).map_or(NONE, |i| i as u32);
        parts[0] = chart_of.into_iter().map(number).collect();
        parts[1] = vec![NONE; proxy.surface.face_count()];
        let mut halves = Vec::new();
        for (i, (chart, trouble)) in (0u32..).zip(&failed) {
            let chart = &coarse[*chart as usize];
            chart.faces.iter().for_each(|&f| parts[1][f as usize] = i);
            let mut at: Vec<u32> = trouble.iter().map(|&f| proxy.face[f as usize]).collect();
            at.sort_unstable();
            at.dedup();
            halves.extend(divide::divide(chart, &at));
        }
        polish(&mut halves, proxy, run)?;
        coarse = halves;
    }
    charts.sort_by_key(|c| (c.part, c.faces.first().copied()));
    Ok(charts)
}

/// Descent of the proxy's maps, without letting a border touch itself.
fn polish(coarse: &mut [Chart], proxy: &Proxy, run: &Run) -> Result<(), Canceled> {
    let options = SlimOptions { iterations: STEPS, keep_simple: true, ..Default::default() };
    let collapsed =
        |chart: &&mut Chart| chart.faces.first().is_some_and(|&f| proxy.collapsed[f as usize]);
    let charts = coarse.iter_mut().filter(collapsed).collect();
    let descend = |chart: &mut Chart| {
        chart.cut_map = flatten::slim(&chart.disk, &chart.cut_map, &options, &run.cancel)?;
        Ok(())
    };
    tasks::map_by_size("map of a proxy", charts, |c| c.faces.len(), descend).into_iter().collect()
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

#[cfg(test)]
mod tests;
