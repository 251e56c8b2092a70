//! The map of each chart: the network's and the control's, each polished; the better one ships, and
//! the metrics say what each reached (pipeline 5 and 6).

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use super::engine::Engine;
use super::error::Cause;
use super::neural;
use super::parts::{Found, Solvers};
use crate::charts::{self, Chart};
use crate::contract::{
    Canceled, ChartForm, GaveUp, NeuralGain, Progress, Run, Stage, UnwrapOptions,
};
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
    /// Whether it is larger than its density asks for, so that single precision holds it.
    pub enlarged: bool,
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
            enlarged: false,
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
    solvers: &Solvers,
    charts: Vec<Chart>,
    options: &UnwrapOptions,
    engine: &Engine,
    run: &Run,
) -> Result<Vec<Mapped>, Cause> {
    run.stage(Stage::Train)?;
    let part = |chart: &Chart| solvers.regions.part[chart.part as usize];
    let chosen = neural::choose(&charts, options, run);
    let inputs = neural::inputs(solvers, &charts, &chosen);
    let parts = found.parts.parts.len() as u32;
    let of_chosen: Vec<u32> = chosen.iter().map(|&i| part(&charts[i])).collect();
    let mut told = |step: u32, steps: u32, finished: &[usize]| {
        run.advance(f64::from(step) / f64::from(steps.max(1)));
        // A part waits while one of its charts does.
        let waiting: BTreeSet<u32> =
            (0..of_chosen.len()).filter(|i| !finished.contains(i)).map(|i| of_chosen[i]).collect();
        run.parts(parts - waiting.len() as u32, parts);
    };
    let how = TrainOptions::from(options);
    let results = if inputs.is_empty() {
        Vec::new()
    } else {
        parameterization::train(&inputs, &how, &engine.device, run, &mut told)?
    };
    drop(inputs);
    let mut trained: BTreeMap<usize, TrainedChart> = chosen.into_iter().zip(results).collect();
    run.parts(parts, parts);
    run.stage(Stage::Polish)?;
    let work: Vec<(Chart, Option<TrainedChart>)> =
        charts.into_iter().enumerate().map(|(i, c)| (c, trained.remove(&i))).collect();
    let clearance = charts::clearance(&solvers.surface);
    let faces = work.iter().map(|(chart, _)| chart.faces.len()).sum();
    let steps = run.steps(faces, 0.0, 1.0);
    let mapped: Result<Vec<Mapped>, Canceled> = work
        .into_par_iter()
        .map(|(chart, net)| {
            let mapped = polish(chart, net, clearance, run)?;
            steps.add(mapped.chart.faces.len());
            Ok(mapped)
        })
        .collect();
    let mapped = mapped?;
    tell_parts(found, solvers, &mapped, run);
    Ok(mapped)
}

/// Tell that each part has its charts, and how distorted they are.
fn tell_parts(found: &Found, solvers: &Solvers, mapped: &[Mapped], run: &Run) {
    let mut sums: BTreeMap<u32, (u32, f64, f64)> = BTreeMap::new();
    for m in mapped {
        let area = m.chart.disk.area();
        let entry = sums.entry(solvers.regions.part[m.chart.part as usize]).or_default();
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
    if run.skips(Stage::Polish, GaveUp::Descent) {
        return Ok(Mapped::from_cut(chart));
    }
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
