//! Charts joined anew (docs/method.md, 4.6): which seams are closed first decides where the joining ends, and
//! near-ties decide that. So a few neighbouring charts are taken apart to the patches that they were made of
//! and joined in another order, again and again; what costs less stays (large neighbourhood search: Shaw 1998,
//! doi:10.1007/3-540-49481-2_30). Tries end when the last ones gained nothing, or the work that is allowed them,
//! counted in faces of the charts taken apart, is done.

use std::collections::BTreeSet;

use super::merge::merge;
use crate::charts::limits::ChartLimits;
use crate::charts::moves::straighten::straighten;
use crate::charts::patchwork::Patchwork;
use crate::contract::{Canceled, GaveUp, Run, Stage};
use crate::device::Seeded;
use crate::mesh::NONE;

/// Charts that are taken apart together.
const CHARTS: usize = 3;

/// Tries in a row that gain nothing before it is enough.
const IDLE: usize = 12;

/// Join charts of `work` anew while its objective falls. `patch_of`: the patch of each face; `objective`: what
/// a patchwork costs; `allowance`: faces that all tries together may take apart.
pub fn rejoin<'a>(
    mut work: Patchwork<'a>,
    patch_of: &[u32],
    objective: impl Fn(&Patchwork) -> f64,
    mut allowance: usize,
    limits: &ChartLimits,
    run: &Run,
) -> Result<Patchwork<'a>, Canceled> {
    let mut reached = objective(&work);
    let (mut idle, mut round) = (0, 0);
    let mut tried: BTreeSet<Vec<u32>> = BTreeSet::new();
    while idle < IDLE && !run.skips(Stage::Charts, GaveUp::Joining) {
        run.cancel.check()?;
        let Some(one) = Try::draw(&work, round) else { break };
        let faces: usize = one.charts.iter().map(|&c| work.faces[c as usize].len()).sum();
        let Some(left) = allowance.checked_sub(faces) else { break };
        (allowance, round) = (left, round + 1);
        let other = one.make(work.clone(), patch_of, limits, run)?;
        let cost = objective(&other);
        if cost < reached * (1.0 - 1e-9) {
            (work, reached, idle) = (other, cost, 0);
            tried.clear();
        } else {
            // What was tried twice in vain counts double: there is little else to try.
            idle += 1 + usize::from(!tried.insert(one.charts));
        }
    }
    Ok(work)
}

/// Charts that are to be joined anew, and in which order.
struct Try {
    /// Ascending.
    charts: Vec<u32>,
    random: Seeded,
}

impl Try {
    /// `None` where no two charts meet.
    fn draw(work: &Patchwork, round: u64) -> Option<Self> {
        let mut random = Seeded::new(1, round);
        neighbours(work, &mut random).map(|charts| Self { charts, random })
    }

    /// Take the charts of `work` apart and join them.
    fn make<'a>(
        &self,
        mut work: Patchwork<'a>,
        patch_of: &[u32],
        limits: &ChartLimits,
        run: &Run,
    ) -> Result<Patchwork<'a>, Canceled> {
        let mut random = self.random.clone();
        let mut apart = Vec::new();
        for &chart in &self.charts {
            let own = work.faces[chart as usize].clone();
            let inside = |h: u32| {
                let t = work.mesh.twin[h as usize];
                work.glued[h as usize] && patch_of[h as usize / 3] == patch_of[t as usize / 3]
            };
            let pieces = work.mesh.components(&own, inside);
            apart.extend(work.divide(chart, pieces));
        }
        apart.sort_unstable();
        let order: Vec<f32> = work.mesh.twin.iter().map(|_| random.unit_f64() as f32).collect();
        merge(&mut work, &apart, Some(&order), limits, run)?;
        apart.retain(|&c| !work.faces[c as usize].is_empty());
        let changed = straighten(&mut work, &apart, limits, run)?;
        if !changed.is_empty() {
            merge(&mut work, &changed, None, limits, run)?;
        }
        Ok(work)
    }
}

/// Two charts that meet, drawn by the length of their seams, and one beside them; ascending. `None` where no two
/// meet.
fn neighbours(work: &Patchwork, random: &mut Seeded) -> Option<Vec<u32>> {
    let seams: Vec<(u32, f64)> = (0u32..)
        .zip(&work.mesh.twin)
        .filter(|&(h, &t)| t != NONE && h < t && !work.glued[h as usize])
        .filter(|&(h, &t)| work.chart_of[h as usize / 3] != work.chart_of[t as usize / 3])
        .map(|(h, _)| (h, work.mesh.length(h)))
        .collect();
    let mut at = random.unit_f64() * seams.iter().map(|s| s.1).sum::<f64>();
    let drawn = seams.iter().find(|s| {
        at -= s.1;
        at <= 0.0
    });
    let (h, _) = *drawn.or(seams.last())?;
    let of = |h: u32| work.chart_of[h as usize / 3];
    let mut charts = BTreeSet::from([of(h), of(work.mesh.twin[h as usize])]);
    // A third that meets one of the two.
    let beside: Vec<u32> = seams
        .iter()
        .map(|&(h, _)| [of(h), of(work.mesh.twin[h as usize])])
        .filter(|pair| pair.iter().filter(|c| charts.contains(c)).count() == 1)
        .flatten()
        .filter(|c| !charts.contains(c))
        .collect();
    if charts.len() < CHARTS && !beside.is_empty() {
        let at = (random.unit_f64() * beside.len() as f64) as usize;
        charts.insert(beside[at.min(beside.len() - 1)]);
    }
    Some(charts.into_iter().collect())
}
