//! One chart in training, as the host sees it: its sample, its losses and their balance, the best map
//! so far, and when there is nothing more to gain. Nothing here knows of other charts.

use glam::DVec2;

use super::balance::{Balance, clip, norm};
use super::frame::{Frame, REST};
use super::losses::{Annealing, ChartTerms, CylinderTarget, LossContext, Term, TermValues};
use super::measure::{energy, free_scale};
use super::sample::{Sample, neighbours};
use super::{TrainChart, TrainOptions};
use crate::contract::LossForm;
use crate::device::Seeded;
use crate::flatten::UvMap;

/// Steps after which a chart that is trained on a sample gets a fresh one, and its whole map is
/// looked at.
pub(super) const RESAMPLE: u32 = 50;

/// Jitter of the start UV in the second half of the cycle, in radii: without it F_uv could copy it.
const JITTER: f32 = 0.02;

/// Energy above an isometry's that is not worth a step.
const NOTHING_LEFT: f64 = 1e-6;

/// Least relative gain over an eighth of the steps that is worth going on for, once three fifths of
/// them are done (before that the learning rate is too high to tell).
const LEAST_GAIN: f64 = 2e-3;

/// A chart in training.
#[derive(Debug)]
pub(super) struct Trainee<'a> {
    /// Index among the charts that were given.
    pub index: usize,
    pub chart: &'a TrainChart<'a>,
    pub frame: Frame,
    options: TrainOptions,
    rng: Seeded,
    /// Of the chart's triangles; empty where the chart is trained whole.
    neighbours: Vec<[u32; 3]>,
    pub sample: Sample,
    terms: ChartTerms,
    balance: Balance,
    /// The map on the sample, its scale, and the weighted gradient there, world units.
    uv: UvMap,
    pub scale: f64,
    gradient: Vec<DVec2>,
    scratch: Vec<DVec2>,
    /// What the gradient of the reconstruction was multiplied by, 0 to 1.
    pub clip: f32,
    /// Weighted sum of the losses at this step, the reconstruction left out.
    pub loss: f64,
    /// The best map of the network and its energy.
    best: Option<(f64, UvMap)>,
    start_energy: f64,
    /// Least energy on the sample, and as it was an eighth of the steps ago.
    least: f64,
    marked: f64,
    pub history: Vec<f32>,
    pub steps: u32,
    pub converged: bool,
    /// A gradient was not a number: the chart cannot go on.
    pub broken: bool,
}

impl<'a> Trainee<'a> {
    /// A chart before its first step.
    pub fn new(index: usize, chart: &'a TrainChart<'a>, options: &TrainOptions) -> Self {
        // Stream 2 id + 1; the initial weights have stream 2 id.
        let mut rng = Seeded::new(options.seed, chart.id.wrapping_mul(2).wrapping_add(1));
        let large = chart.disk.positions.len() > options.points;
        let neighbours = if large { neighbours(chart.disk) } else { Vec::new() };
        let sample = if large {
            Sample::draw(chart.disk, &neighbours, options.points, &mut rng)
        } else {
            Sample::whole(chart.disk)
        };
        let terms = terms(chart, &sample, options);
        let start_energy = energy(chart.disk, chart.start);
        let mut trainee = Self {
            index,
            chart,
            frame: Frame::new(chart),
            options: *options,
            rng,
            neighbours,
            sample,
            terms,
            balance: Balance::default(),
            uv: Vec::new(),
            scale: 1.0,
            gradient: Vec::new(),
            scratch: Vec::new(),
            clip: 1.0,
            loss: 0.0,
            best: None,
            start_energy,
            least: f64::INFINITY,
            marked: f64::INFINITY,
            history: Vec::new(),
            steps: 0,
            converged: start_energy - 1.0 <= NOTHING_LEFT && chart.over_cut.is_none(),
            broken: false,
        };
        trainee.resize();
        trainee
    }

    /// Initial weights.
    pub fn weights_rng(&self) -> Seeded {
        Seeded::new(self.options.seed, self.chart.id.wrapping_mul(2))
    }

    /// Vertices it is trained on.
    pub fn rows(&self) -> usize {
        self.sample.vertices.len()
    }

    /// Whether it is trained on a part of its vertices at a time.
    pub fn is_sampled(&self) -> bool {
        self.sample.part.is_some()
    }

    /// Whether it is done.
    pub fn is_finished(&self) -> bool {
        self.converged || self.broken || self.steps >= self.options.steps
    }

    /// Draw a fresh sample.
    pub fn resample(&mut self) {
        let (disk, points) = (self.chart.disk, self.options.points);
        self.sample = Sample::draw(disk, &self.neighbours, points, &mut self.rng);
        self.terms = terms(self.chart, &self.sample, &self.options);
        self.resize();
    }

    fn resize(&mut self) {
        let rows = self.rows();
        for array in [&mut self.uv, &mut self.gradient, &mut self.scratch] {
            array.clear();
            array.resize(rows, DVec2::ZERO);
        }
    }

    /// Measure the map that the network makes (`delta`: two numbers a row, in radii): scale, losses,
    /// gradient, energy. Keeps it if it is the best.
    pub fn measure(&mut self, delta: &[f32]) {
        for ((uv, d), &v) in
            self.uv.iter_mut().zip(delta.chunks_exact(2)).zip(&self.sample.vertices)
        {
            *uv = self.frame.moved(self.chart.start[v as usize], [d[0], d[1]]);
        }
        let progress = f64::from(self.steps) / f64::from(self.options.steps.max(1));
        let at = Annealing::at(progress);
        let sound = self.options.form == LossForm::Sound;
        self.scale = self.terms.scale(&self.uv);
        let (uv, terms) = (&self.uv, &self.terms);
        self.balance.refresh(self.steps as usize, terms, uv, self.scale, at, &mut self.scratch);
        let mut weights = *self.balance.weights();
        if sound {
            // Smoothness guides the map in the first half; after that it would hold a bent chart off its
            // optimum.
            weights[Term::Smooth as usize] *= (1.0 - 2.0 * progress).max(0.0);
            if self.is_sampled() {
                // The rim of a sample is not the chart's.
                weights[Term::Cluster as usize] = 0.0;
            }
        }
        self.gradient.fill(DVec2::ZERO);
        let values = terms.evaluate_sum(&weights, uv, self.scale, at, &mut self.gradient);
        self.loss = dot(&weights, &values);
        if sound {
            free_scale(self.sample.disk(self.chart.disk), &self.uv, &mut self.gradient);
        }
        self.judge();
    }

    /// Note the energy of the map that was measured, and whether there is still something to gain.
    fn judge(&mut self) {
        let energy = energy(self.sample.disk(self.chart.disk), &self.uv);
        if !self.is_sampled() {
            self.offer(energy, |trainee| trainee.uv.clone());
        }
        self.least = self.least.min(energy);
        let window = (self.options.steps / 8).max(1);
        let whole = !self.is_sampled() && !self.closes_seams();
        self.converged = whole && self.least - 1.0 <= NOTHING_LEFT;
        if self.steps.is_multiple_of(window) {
            let settled = self.marked - self.least <= LEAST_GAIN * (self.marked - 1.0);
            let late = 5 * self.steps >= 3 * self.options.steps;
            self.converged |= late && whole && self.marked.is_finite() && settled;
            self.marked = self.least;
        }
    }

    /// Consider a map of the whole chart.
    pub fn consider(&mut self, uv: UvMap) {
        let energy = energy(self.chart.disk, &uv);
        self.offer(energy, |_| uv);
        self.converged |= energy - 1.0 <= NOTHING_LEFT && !self.closes_seams();
    }

    /// Whether its seams are to close: then less energy is not the gain that is looked for.
    fn closes_seams(&self) -> bool {
        self.chart.over_cut.is_some()
    }

    fn offer(&mut self, energy: f64, uv: impl FnOnce(&Self) -> UvMap) {
        let least = self.best.as_ref().map_or(self.start_energy, |(least, _)| *least);
        // Seams close as training goes on, so of those maps the last without flips counts.
        if energy < least || (self.closes_seams() && energy.is_finite()) {
            self.best = Some((energy, uv(self)));
        }
    }

    /// The gradient that drives the forward mapper, written to `total` (two numbers a row, by
    /// radii): that of the mesh losses, and that of the reconstruction, `inverse`, clipped.
    pub fn join(&mut self, inverse: &[f32], total: &mut [f32]) {
        let radius = self.frame.radius;
        let forward = norm(&self.gradient) * radius;
        let inverse_norm = inverse.iter().map(|&g| f64::from(g).powi(2)).sum::<f64>().sqrt();
        let factor = clip(forward, inverse_norm);
        for ((t, i), g) in
            total.chunks_exact_mut(2).zip(inverse.chunks_exact(2)).zip(&self.gradient)
        {
            t[0] = (g.x * radius + factor * f64::from(i[0])) as f32;
            t[1] = (g.y * radius + factor * f64::from(i[1])) as f32;
        }
        if !(factor.is_finite() && total.iter().all(|t| t.is_finite())) {
            self.broken = true;
            total.fill(0.0);
        }
        self.clip = if self.broken { 0.0 } else { factor as f32 };
    }

    /// The channels of every row after its position, the start UV moved a little at random.
    pub fn jittered(&mut self, rest: &[f32], out: &mut [f32]) {
        out.copy_from_slice(rest);
        for row in out.chunks_exact_mut(REST) {
            row[REST - 2] += self.rng.symmetric(JITTER);
            row[REST - 1] += self.rng.symmetric(JITTER);
        }
    }

    /// The best map of the network and its energy, or `None` where the start map is as good.
    pub fn best(&self) -> Option<(f64, &UvMap)> {
        self.best.as_ref().map(|(energy, uv)| (*energy, uv))
    }

    /// Energy of the start map.
    pub fn start_energy(&self) -> f64 {
        self.start_energy
    }
}

fn terms(chart: &TrainChart, sample: &Sample, options: &TrainOptions) -> ChartTerms {
    let cylinder = chart.cylinder.as_ref().map(|target| CylinderTarget {
        developed: sample.pick(&target.developed),
        heights: sample.pick(&target.heights),
    });
    // A part of an over-cut chart has lost the other side of its seams.
    let over_cut = if sample.part.is_none() { chart.over_cut.clone() } else { None };
    let context = LossContext { form: options.form, cylinder, over_cut, ..Default::default() };
    ChartTerms::new(sample.disk(chart.disk), context)
}

fn dot(a: &TermValues, b: &TermValues) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
