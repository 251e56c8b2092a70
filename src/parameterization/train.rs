//! Training, from charts to maps: charts are laid out in groups that fit the caches and the memory,
//! every group takes its steps, and a chart that is done leaves its group at once.

use std::ops::Range;

use rayon::prelude::*;

use super::adam::Adam;
use super::batch::Batch;
use super::chamfer::chamfer;
use super::chart::{RESAMPLE, Trainee};
use super::mapper::{self, Layout};
use super::step::{step, whole_map};
use super::{MapError, TrainChart, TrainOptions, TrainedChart};
use crate::contract::{Cancel, GaveUp, Run, Scarce};
use crate::device::{Device, DeviceKind};
use crate::flatten::{UvMap, rescale};

/// Rows that train at the same time on the processor: more do not make it faster.
const CPU_ROWS: usize = 8_192;
/// Rows that train at the same time on a graphics card.
const GPU_ROWS: usize = 131_072;
/// Bytes that one row needs for each unit of width: activations and slopes of three passes.
const BYTES_PER_ROW: usize = 4 * 40;

/// Train the networks of `charts` and return the best map of each, in the same order.
///
/// `told` hears, after every step, how many of all steps are done, how many there are, and which
/// charts (by index) are finished. Where the stage is late
/// ([`TrainOptions::stage`]) training ends early; the charts then carry the best map so far.
///
/// # Errors
/// When the job is canceled, when an array does not fit its disk, or when the device fails.
pub fn train(
    charts: &[TrainChart],
    options: &TrainOptions,
    device: &Device,
    run: &Run,
    told: &mut dyn FnMut(u32, u32, &[usize]),
) -> Result<Vec<TrainedChart>, MapError> {
    check(charts)?;
    let groups = groups(charts, options, device, run);
    let steps = options.steps.saturating_mul(groups.len() as u32);
    let mut done: Vec<Option<TrainedChart>> = vec![None; charts.len()];
    let mut finished = Vec::new();
    for (number, group) in groups.into_iter().enumerate() {
        let before = options.steps.saturating_mul(number as u32);
        let prepared: Vec<Trainee> =
            group.into_par_iter().map(|i| Trainee::new(i, &charts[i], options)).collect();
        let mut trainees = Vec::new();
        for trainee in prepared {
            if trainee.is_finished() {
                done[trainee.index] = Some(result(&trainee, None));
                finished.push(trainee.index);
            } else {
                trainees.push(trainee);
            }
        }
        if trainees.is_empty() {
            continue;
        }
        let mut group = Group::new(trainees, options, device, &run.cancel);
        let mut taken = 0;
        loop {
            let out_of_time = run.is_late(options.stage);
            if out_of_time && group.is_unfinished() {
                run.give_up(options.stage, GaveUp::Training, Scarce::Time);
            }
            for (index, chart) in group.release(out_of_time)? {
                done[index] = Some(chart);
                finished.push(index);
            }
            told(before.saturating_add(taken), steps, &finished);
            run.cancel.check()?;
            if group.charts.is_empty() {
                break;
            }
            group.step()?;
            taken += 1;
        }
    }
    told(steps, steps, &finished);
    Ok(done.into_iter().flatten().collect())
}

/// Bytes that training a chart of so many vertices takes while it runs.
pub fn bytes(vertices: usize, options: &TrainOptions) -> u64 {
    let rows = vertices.min(options.points) as u64;
    rows.saturating_mul(row_bytes(options))
}

fn row_bytes(options: &TrainOptions) -> u64 {
    (BYTES_PER_ROW * options.width.max(1)) as u64
}

/// Charts that train together.
struct Group<'a> {
    charts: Vec<Trainee<'a>>,
    batch: Batch,
    adam: Adam,
    layout: Layout,
    options: &'a TrainOptions,
    device: &'a Device,
    cancel: &'a Cancel,
}

impl<'a> Group<'a> {
    fn new(
        charts: Vec<Trainee<'a>>,
        options: &'a TrainOptions,
        device: &'a Device,
        cancel: &'a Cancel,
    ) -> Self {
        let layout = Layout::new(options.width);
        let initial = |chart: &Trainee| layout.initial(&mut chart.weights_rng());
        let rows: Vec<Vec<f32>> = charts.iter().map(initial).collect();
        let adam = Adam::new(mapper::stack(&rows, &device.burn()), options.steps);
        let batch = Batch::new(&charts, device);
        Self { charts, batch, adam, layout, options, device, cancel }
    }

    fn is_unfinished(&self) -> bool {
        self.charts.iter().any(|chart| !chart.is_finished())
    }

    /// One step of every chart; large charts then look at their whole map and draw a fresh sample.
    fn step(&mut self) -> Result<(), MapError> {
        step(&self.batch, &mut self.charts, &self.layout, &mut self.adam, self.options.form)?;
        let mut fresh = false;
        for i in 0..self.charts.len() {
            let chart = &self.charts[i];
            if chart.is_sampled() && !chart.is_finished() && chart.steps.is_multiple_of(RESAMPLE) {
                self.consider_whole(i)?;
                self.charts[i].resample();
                fresh = true;
            }
        }
        if fresh {
            self.batch = Batch::new(&self.charts, self.device);
        }
        Ok(())
    }

    fn consider_whole(&mut self, i: usize) -> Result<(), MapError> {
        let parameters = self.adam.parameters.clone().slice([i..i + 1]);
        let uv = whole_map(&self.charts[i], &self.layout, &parameters, self.device, self.cancel)?;
        self.charts[i].consider(uv);
        Ok(())
    }

    /// Take out the charts that are finished, or all of them, and what became of each.
    fn release(&mut self, all: bool) -> Result<Vec<(usize, TrainedChart)>, MapError> {
        let leaves = |chart: &Trainee| all || chart.is_finished();
        if !self.charts.iter().any(leaves) {
            return Ok(Vec::new());
        }
        let mut released = Vec::new();
        let mut kept = Vec::new();
        for i in 0..self.charts.len() {
            if !leaves(&self.charts[i]) {
                kept.push(i);
                continue;
            }
            self.cancel.check()?;
            // The step that came last moved the weights and has not been looked at.
            if self.charts[i].steps > 0 && !self.charts[i].broken {
                self.consider_whole(i)?;
            }
            let chart = &self.charts[i];
            released.push((chart.index, result(chart, self.chamfer(i)?)));
        }
        let charts = std::mem::take(&mut self.charts).into_iter().enumerate();
        self.charts = charts.filter(|(i, _)| kept.contains(i)).map(|(_, chart)| chart).collect();
        if !self.charts.is_empty() {
            self.adam.keep(&kept);
            self.batch = Batch::new(&self.charts, self.device);
        }
        Ok(released)
    }

    /// Chamfer distance of the round trip by a chart's shipped map, once there was a step.
    fn chamfer(&self, i: usize) -> Result<Option<f64>, MapError> {
        let chart = &self.charts[i];
        if chart.steps == 0 {
            return Ok(None);
        }
        let uv = chart.best().map_or(chart.chart.start, |(_, uv)| uv);
        let parameters = self.adam.parameters.clone().slice([i..i + 1]);
        chamfer(chart, uv, &self.layout, &parameters, self.device)
    }
}

fn result(trainee: &Trainee, chamfer: Option<f64>) -> TrainedChart {
    let best = trainee.best();
    let start = || (trainee.start_energy(), trainee.chart.start.to_vec());
    let scaled = |(energy, uv): (f64, &UvMap)| (energy, rescale(trainee.chart.disk, uv.clone()));
    let (energy, uv) = best.map_or_else(start, scaled);
    TrainedChart {
        uv,
        improved: best.is_some(),
        steps: trainee.steps,
        history: trainee.history.clone(),
        energy,
        chamfer,
        converged: trainee.converged,
    }
}

/// Neighbouring charts in groups of bounded size. What a chart becomes does not depend on it.
fn groups(
    charts: &[TrainChart],
    options: &TrainOptions,
    device: &Device,
    run: &Run,
) -> Vec<Range<usize>> {
    let most = if device.kind() == DeviceKind::Cpu { CPU_ROWS } else { GPU_ROWS };
    let affordable = run.budget.spare_bytes() / row_bytes(options);
    let most = most.min(usize::try_from(affordable).unwrap_or(usize::MAX));
    let mut groups: Vec<Range<usize>> = Vec::new();
    // Padding takes memory as well: a group costs its charts times the longest of them.
    let mut longest = 0;
    for (i, chart) in charts.iter().enumerate() {
        let rows = chart.disk.positions.len().min(options.points);
        match groups.last_mut() {
            Some(group) if (group.len() + 1) * rows.max(longest) <= most => {
                group.end = i + 1;
                longest = longest.max(rows);
            }
            _ => {
                groups.push(i..i + 1);
                longest = rows;
            }
        }
    }
    groups
}

/// Every array of every chart has one entry a vertex, and triangles name vertices that exist.
fn check(charts: &[TrainChart]) -> Result<(), MapError> {
    for (i, chart) in charts.iter().enumerate() {
        let vertices = chart.disk.positions.len();
        let lengths = [
            ("start", chart.start.len()),
            ("normals", chart.normals.len()),
            ("rho", chart.rho.len()),
            ("boundary", chart.boundary.len()),
            ("crease", chart.crease.len()),
            ("cylinder", chart.cylinder.as_ref().map_or(vertices, |c| c.developed.len())),
            ("heights", chart.cylinder.as_ref().map_or(vertices, |c| c.heights.len())),
        ];
        for (array, found) in lengths {
            if found != vertices {
                return Err(MapError::Mismatch { chart: i, array, found, vertices });
            }
        }
    }
    Ok(())
}
