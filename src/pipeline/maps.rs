//! The map of each chart: the network's and the control's, each polished; the better one ships, and
//! the metrics say what each reached (pipeline 5 and 6).

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::clock::Clock;
use super::error::UnwrapError;
use super::neural;
use super::parts::Found;
use crate::charts::{self, Chart};
use crate::contract::{Canceled, ChartForm, NeuralGain, Progress, Run, Stage, UnwrapOptions};
use crate::device::Device;
use crate::flatten::{self, Disk, SlimOptions, UvMap};
use crate::parameterization::{self, TrainOptions, TrainedChart};

/// Descent steps of the polish. A chart of many triangles gets fewer, by counted work.
const STEPS: u32 = 20;

/// Triangles beyond which the polish takes fewer steps.
const STEPS_FACES: usize = 20_000;

/// A chart as good as the control ships the control: the network must win by this much.
const MARGIN: f64 = 1e-6;

/// A chart with its final map.
#[derive(Debug, Clone)]
pub struct Mapped {
    /// The chart.
    pub chart: Chart,
    /// Its map, scale 1, injective.
    pub uv: UvMap,
    /// How the map was made.
    pub form: ChartForm,
    /// Whether there was nothing to train.
    pub isometric_start: bool,
    /// Training steps.
    pub steps: u32,
    /// What each arm reached.
    pub gain: Option<NeuralGain>,
    /// Round-trip distance of the two networks.
    pub chamfer: Option<f64>,
}

impl Mapped {
    /// A chart that ships the map by which it was cut.
    pub fn from_cut(chart: Chart) -> Self {
        let isometric_start = flatten::quality(&chart.disk, &chart.start).is_isometric();
        Self {
            uv: chart.cut_map.clone(),
            chart,
            form: ChartForm::Start,
            isometric_start,
            steps: 0,
            gain: None,
            chamfer: None,
        }
    }
}

/// Charts that ship as they were cut (`stop_after = charts`).
pub fn untrained(charts: Vec<Chart>) -> Vec<Mapped> {
    charts.into_iter().map(Mapped::from_cut).collect()
}

/// Train the charts that pay best, polish all.
pub fn trained(
    found: &Found,
    charts: Vec<Chart>,
    options: &UnwrapOptions,
    device: &Device,
    run: &Run,
    clock: &mut Clock,
) -> Result<Vec<Mapped>, UnwrapError> {
    clock.stage(Stage::Train, run)?;
    let chosen = neural::choose(&charts, options);
    let inputs = neural::inputs(found, &charts, &chosen);
    let total = chosen.len() as u32;
    let mut told = |step: u32, steps: u32, finished: &[usize]| {
        let fraction = f64::from(step) / f64::from(steps.max(1));
        let parts_done = finished.len() as u32;
        let parts_total = total;
        run.tell(Progress::Progress { stage: Stage::Train, fraction, parts_done, parts_total });
    };
    let results = if inputs.is_empty() {
        Vec::new()
    } else {
        parameterization::train(&inputs, &TrainOptions::from(options), device, run, &mut told)?
    };
    drop(inputs);
    let mut trained: BTreeMap<usize, TrainedChart> = chosen.into_iter().zip(results).collect();
    clock.stage(Stage::Polish, run)?;
    let work: Vec<(Chart, Option<TrainedChart>)> =
        charts.into_iter().enumerate().map(|(i, c)| (c, trained.remove(&i))).collect();
    let clearance = charts::clearance(&found.surface);
    let mapped: Result<Vec<Mapped>, Canceled> =
        work.into_par_iter().map(|(chart, net)| polish(chart, net, clearance, run)).collect();
    let mapped = mapped?;
    tell_parts(found, &mapped, run);
    Ok(mapped)
}

/// Tell that each part has its charts, and how distorted they are.
fn tell_parts(found: &Found, mapped: &[Mapped], run: &Run) {
    let mut sums: BTreeMap<u32, (u32, f64, f64)> = BTreeMap::new();
    for m in mapped {
        let area = m.chart.disk.area();
        let entry = sums.entry(found.part_of_region[m.chart.part as usize]).or_default();
        entry.0 += 1;
        entry.1 += area * flatten::quality(&m.chart.disk, &m.uv).mean;
        entry.2 += area;
    }
    for (part, (charts, energy, area)) in sums {
        let name = found.parts.parts[part as usize].name.clone();
        let symmetric_dirichlet = energy / area;
        run.tell(Progress::PartCompleted { part, name, charts, symmetric_dirichlet });
    }
}

/// One chart's arms, and the best of them.
fn polish(
    chart: Chart,
    net: Option<TrainedChart>,
    clearance: f64,
    run: &Run,
) -> Result<Mapped, Canceled> {
    let disk = &chart.disk;
    let start = flatten::quality(disk, &chart.start);
    let proved = |uv: &UvMap| charts::is_sound(disk, uv, clearance);
    if start.is_isometric() && net.is_none() && proved(&chart.start) {
        let uv = chart.start.clone();
        let isometric_start = true;
        return Ok(Mapped { uv, isometric_start, ..Mapped::from_cut(chart) });
    }
    let energy = |uv: &UvMap| flatten::quality(disk, uv).mean;
    // The control starts from the better of the start and the map of the cut.
    let from = match energy(&chart.start) <= energy(&chart.cut_map) {
        true => &chart.start,
        false => &chart.cut_map,
    };
    let control = descend(disk, from, run)?;
    let mut arms = vec![(energy(&control), ChartForm::Start, control)];
    let mut gain =
        NeuralGain { start: Some(start.mean), start_polish: Some(arms[0].0), ..Default::default() };
    let (mut steps, mut chamfer) = (0, None);
    if let Some(net) = net {
        (steps, chamfer) = (net.steps, net.chamfer);
        gain.net = Some(energy(&net.uv));
        // A network that found nothing better than its start has no arm of its own.
        if net.improved {
            let polished = descend(disk, &net.uv, run)?;
            let reached = energy(&polished);
            gain.net_polish = Some(reached);
            gain.gain = Some((arms[0].0 - reached) / arms[0].0);
            arms.push((reached + MARGIN, ChartForm::Trained, polished));
        }
    }
    arms.push((f64::INFINITY, ChartForm::Start, chart.cut_map.clone()));
    arms.sort_by(|a, b| a.0.total_cmp(&b.0));
    let best = arms.into_iter().find(|arm| proved(&arm.2));
    let gain = (steps > 0).then_some(gain);
    let mapped = Mapped::from_cut(chart);
    Ok(match best {
        Some((_, form, uv)) => Mapped { uv, form, steps, gain, chamfer, ..mapped },
        None => Mapped { steps, gain, chamfer, ..mapped },
    })
}

fn descend(disk: &Disk, from: &UvMap, run: &Run) -> Result<UvMap, Canceled> {
    let excess = disk.triangles.len().div_ceil(STEPS_FACES).max(1) as u32;
    let options = SlimOptions { iterations: (STEPS / excess).max(2), ..Default::default() };
    flatten::slim(disk, from, &options, &run.cancel)
}
