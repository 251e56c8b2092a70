//! The map of each chart: the network's and the baseline (the start map), each polished; the better one
//! ships, and the metrics say what each reached (docs/method.md, sections 5 and 6).

use std::collections::{BTreeMap, BTreeSet};

use super::engine::Engine;
use super::error::Cause;
use super::membership::Membership;
use super::neural;
use super::parts::{Found, Solvers};
use crate::charts::{self, Chart, StartKind};
use crate::contract::{
    Canceled, ChartForm, GaveUp, NeuralGain, Progress, Run, Stage, UnwrapOptions,
};
use crate::flatten::{self, Disk, SlimOptions, UvMap};
use crate::parameterization::{self, TrainOptions, TrainedChart};
use crate::tasks;

/// Descent steps of the polish. A chart of many triangles gets fewer, by counted work.
const STEPS: u32 = 20;

/// Triangles beyond which the polish takes fewer steps.
const STEPS_FACES: usize = 20_000;

/// A chart as good as the baseline ships the baseline: the network must win by this much.
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
    /// What each way to the map reached.
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

/// Train what is to be trained, polish all.
pub fn trained(
    found: &Found,
    solvers: &Solvers,
    charts: Vec<Chart>,
    options: &UnwrapOptions,
    engine: &Engine,
    run: &Run,
) -> Result<Vec<Mapped>, Cause> {
    run.stage(Stage::Train)?;
    // Most charts are of one part: that of their first face.
    let part = |chart: &Chart| chart.faces.first().map_or(0, |&f| found.parts.labels[f as usize]);
    let chosen = neural::choose(&charts, options, run);
    let inputs = neural::inputs(found, solvers, &charts, &chosen);
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
    run.count(results.iter().map(|net| net.steps as usize * how.points).sum());
    drop(inputs);
    let mut trained: BTreeMap<usize, TrainedChart> = chosen.into_iter().zip(results).collect();
    run.parts(parts, parts);
    run.stage(Stage::Polish)?;
    let work: Vec<(Chart, Option<TrainedChart>)> =
        charts.into_iter().enumerate().map(|(i, c)| (c, trained.remove(&i))).collect();
    let clearance = charts::clearance(&found.surface);
    let faces = work.iter().map(|(chart, _)| chart.faces.len()).sum();
    let steps = run.steps(faces, 0.0, 1.0);
    let polish = |(chart, net)| {
        let mapped = polish(chart, net, clearance, run)?;
        steps.add(mapped.chart.faces.len());
        Ok(mapped)
    };
    tasks::map_by_size("map", work, |w| w.0.faces.len(), polish).into_iter().collect()
}

/// Tell that each part has its charts, and how distorted they are.
pub fn tell_parts(found: &Found, mapped: &[Mapped], run: &Run) {
    let mut sums: BTreeMap<u32, (u32, f64, f64)> = BTreeMap::new();
    let energy = |m: &Mapped| flatten::quality(&m.chart.disk, &m.uv).mean;
    let energies: Vec<f64> = mapped.iter().map(energy).collect();
    for (chart, part, area) in Membership::new(found, mapped).areas() {
        let entry = sums.entry(part).or_default();
        // A sheet that carries the coordinates of the other side is as distorted as that one.
        let weight = area.max(f64::MIN_POSITIVE);
        entry.0 += 1;
        entry.1 += weight * energies[chart as usize];
        entry.2 += weight;
    }
    for (part, (charts, energy, area)) in sums {
        let name = found.parts.parts[part as usize].name.clone();
        let symmetric_dirichlet = energy / area;
        run.tell(Progress::PartCompleted { part, name, charts, symmetric_dirichlet });
    }
}

/// One chart by each way to its map, and the best of them.
fn polish(
    chart: Chart,
    net: Option<TrainedChart>,
    clearance: f64,
    run: &Run,
) -> Result<Mapped, Canceled> {
    if run.skips(Stage::Polish, GaveUp::Descent) {
        return Ok(Mapped::from_cut(chart));
    }
    // What was carried over is polished already.
    let prolonged = chart.start_kind == StartKind::Prolonged;
    if prolonged && net.is_none() {
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
    // The baseline starts from the better of the start and the map of the cut.
    let from = match energy(&chart.start) <= energy(&chart.cut_map) {
        true => &chart.start,
        false => &chart.cut_map,
    };
    let baseline = descend(disk, from, run)?;
    let mut ways = vec![(energy(&baseline), ChartForm::Start, baseline)];
    let mut gain = NeuralGain::default();
    let own = (Some(start.mean), Some(ways[0].0));
    if prolonged {
        // The classical start is the third way.
        (gain.prolonged, gain.prolonged_polish) = own;
        let classical = flatten::rescale(disk, flatten::start_map(disk, Some(clearance)).0);
        let polished = descend(disk, &classical, run)?;
        (gain.start, gain.start_polish) = (Some(energy(&classical)), Some(energy(&polished)));
        ways.push((energy(&polished) + MARGIN, ChartForm::Start, polished));
    } else {
        (gain.start, gain.start_polish) = own;
    }
    let (mut steps, mut chamfer) = (0, None);
    if let Some(net) = net {
        (steps, chamfer) = (net.steps, net.chamfer);
        gain.net = Some(energy(&net.uv));
        // A network that found nothing better than its start offers no map of its own.
        if net.improved {
            let polished = descend(disk, &net.uv, run)?;
            let reached = energy(&polished);
            gain.net_polish = Some(reached);
            gain.gain = Some((ways[0].0 - reached) / ways[0].0);
            ways.push((reached + MARGIN, ChartForm::Trained, polished));
        }
    }
    ways.push((f64::INFINITY, ChartForm::Start, chart.cut_map.clone()));
    ways.sort_by(|a, b| a.0.total_cmp(&b.0));
    let best = ways.into_iter().find(|way| proved(&way.2));
    let gain = (steps > 0).then_some(gain);
    let mapped = Mapped::from_cut(chart);
    Ok(match best {
        Some((_, form, uv)) => Mapped { uv, form, steps, gain, chamfer, ..mapped },
        None => Mapped { steps, gain, chamfer, ..mapped },
    })
}

fn descend(disk: &Disk, from: &UvMap, run: &Run) -> Result<UvMap, Canceled> {
    run.count(disk.triangles.len());
    let excess = disk.triangles.len().div_ceil(STEPS_FACES).max(1) as u32;
    let options = SlimOptions { iterations: (STEPS / excess).max(2), ..Default::default() };
    flatten::slim(disk, from, &options, &run.cancel)
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::contract::{Degradation, Scarce};
    use crate::flatten::samples;
    use crate::pipeline::scenes;

    /// A chart that starts at one map and was cut by another.
    fn chart(disk: Disk, start: UvMap, cut_map: UvMap) -> Chart {
        Chart {
            faces: (0..disk.triangles.len() as u32).collect(),
            vertices: (0..disk.positions.len() as u32).collect(),
            start: flatten::rescale(&disk, start),
            cut_map: flatten::rescale(&disk, cut_map),
            start_kind: StartKind::Planar,
            disk,
            ..Chart::default()
        }
    }

    /// A bump seen from above.
    fn bump() -> Chart {
        let lift = |x: f64, y: f64| 0.1 * (5.0 * x).sin() * (4.0 * y).sin();
        let disk = samples::bent(12, 12, |x, y| DVec3::new(x, y, lift(x, y)));
        let seen: UvMap = disk.positions.iter().map(|p| p.truncate()).collect();
        chart(disk, seen.clone(), seen)
    }

    /// What a network made of a chart.
    fn net(chart: &Chart, uv: UvMap, improved: bool) -> TrainedChart {
        let energy = flatten::quality(&chart.disk, &uv).mean;
        let (history, chamfer) = (Vec::new(), Some(0.125));
        TrainedChart { uv, improved, steps: 9, history, energy, chamfer, converged: false }
    }

    fn polished(chart: &Chart, net: Option<TrainedChart>) -> Mapped {
        polish(chart.clone(), net, 0.0, &Run::quiet()).unwrap()
    }

    fn energy(m: &Mapped) -> f64 {
        flatten::quality(&m.chart.disk, &m.uv).mean
    }

    #[test]
    fn untrained_charts_ship_the_map_by_which_they_were_cut() {
        let (disk, flat) = samples::plane(3, 3, 1.0, 1.0);
        let sheared = flat.iter().map(|p| DVec2::new(p.x + 0.3 * p.y, p.y)).collect();
        let charts = vec![bump(), chart(disk, flat, sheared)];
        let mapped = untrained(charts.clone());
        for (m, chart) in mapped.iter().zip(&charts) {
            assert_eq!((&m.chart, &m.uv), (chart, &chart.cut_map));
            assert_eq!((m.form, m.steps, m.gain, m.chamfer), (ChartForm::Start, 0, None, None));
        }
        assert_eq!([0, 1].map(|i| mapped[i].isometric_start), [false, true]);
    }

    #[test]
    fn a_start_without_distortion_to_speak_of_ships_as_it_is() {
        let (disk, flat) = samples::plane(3, 3, 1.0, 1.0);
        let bent = |by: f64| flat.iter().map(|p| DVec2::new(p.x + by * p.y * p.y, p.y)).collect();
        let chart = chart(disk.clone(), bent(1e-3), bent(0.3));
        let m = polished(&chart, None);
        assert!(m.isometric_start && m.uv == chart.start);
        // A descent would have found more.
        assert!(energy(&m) > 1.0 + 1e-9);
    }

    /// A map from which the descent does not arrive.
    fn far_off(chart: &Chart) -> UvMap {
        chart.start.iter().map(|p| DVec2::new(p.x.powi(9), 1e-3 * p.y)).collect()
    }

    #[test]
    fn the_polish_starts_from_the_better_map() {
        let good = bump();
        let alone = polished(&good, None);
        assert!(energy(&alone) < flatten::quality(&good.disk, &good.start).mean - 1e-3);
        for [start, cut_map] in
            [[good.start.clone(), far_off(&good)], [far_off(&good), good.start.clone()]]
        {
            let m = polished(&chart(good.disk.clone(), start, cut_map), None);
            assert!((energy(&m) - energy(&alone)).abs() < 1e-12);
            assert_eq!((m.form, m.gain), (ChartForm::Start, None), "nothing was trained");
        }
    }

    #[test]
    fn a_network_ships_where_it_wins_and_the_metrics_say_by_how_much() {
        let good = bump();
        let far = chart(good.disk.clone(), far_off(&good), far_off(&good));
        let m = polished(&far, Some(net(&far, good.start.clone(), true)));
        assert_eq!((m.form, m.steps, m.chamfer), (ChartForm::Trained, 9, Some(0.125)));
        let gain = m.gain.unwrap();
        let [start, baseline, raw, best] =
            [gain.start, gain.start_polish, gain.net, gain.net_polish].map(Option::unwrap);
        assert_eq!(start, flatten::quality(&far.disk, &far.start).mean);
        assert_eq!(raw, flatten::quality(&far.disk, &good.start).mean);
        assert_eq!(best, energy(&m));
        assert!(start > baseline && baseline > best + MARGIN && raw > best, "{gain:?}");
        assert_eq!(gain.gain, Some((baseline - best) / baseline));
    }

    #[test]
    fn a_network_that_is_as_good_as_the_baseline_does_not_ship() {
        let chart = bump();
        let baseline = polished(&chart, None);
        // As good, and better by next to nothing.
        for (uv, most) in [(&chart.start, 0.0), (&baseline.uv, MARGIN)] {
            let m = polished(&chart, Some(net(&chart, uv.clone(), true)));
            assert_eq!((m.form, &m.uv), (ChartForm::Start, &baseline.uv));
            let gain = m.gain.unwrap().gain.unwrap();
            assert!((0.0..=most).contains(&gain) && (gain > 0.0) == (most > 0.0), "{gain}");
        }
        // One that found nothing offers no map: what it reached is told, and no more.
        let m = polished(&chart, Some(net(&chart, chart.start.clone(), false)));
        let gain = m.gain.unwrap();
        assert!(gain.net.is_some() && gain.net_polish.is_none() && gain.gain.is_none());
        assert_eq!((m.form, m.steps), (ChartForm::Start, 9));
    }

    #[test]
    fn a_map_that_lies_on_itself_never_ships() {
        // A ramp of one and a half turns lies on itself seen from above, where it has next to no distortion.
        let turns = |x: f64| 3.0 * std::f64::consts::PI * x;
        let disk = samples::bent(48, 2, |x, y| {
            (DVec2::from_angle(turns(x)) * (3.0 - y)).extend(0.01 * turns(x))
        });
        let seen: UvMap = disk.positions.iter().map(|p| p.truncate()).collect();
        let at = |v: usize| DVec2::new(2.5 * turns((v % 49) as f64 / 48.0), (v / 49) as f64 / 2.0);
        let straight: UvMap = (0..seen.len()).map(at).collect();
        let chart = chart(disk, seen, straight);
        assert!(flatten::quality(&chart.disk, &chart.start).is_isometric());
        assert!(charts::is_sound(&chart.disk, &chart.cut_map, 0.0));
        for net in [None, Some(net(&chart, chart.start.clone(), true))] {
            let m = polished(&chart, net);
            assert_eq!((m.form, &m.uv), (ChartForm::Start, &chart.cut_map));
        }
    }

    #[test]
    fn a_late_polish_ships_the_map_of_the_cut_and_says_so() {
        let run = scenes::late(66);
        let chart = bump();
        let net = net(&chart, chart.start.clone(), true);
        let m = polish(chart.clone(), Some(net), 0.0, &run).unwrap();
        assert_eq!((m.form, m.steps, &m.uv), (ChartForm::Start, 0, &chart.cut_map));
        let (stage, scarce) = (Stage::Polish, Scarce::Time);
        let given_up = Degradation { stage, gave_up: GaveUp::Descent, scarce };
        assert_eq!(run.budget.degraded(), [given_up]);
    }

    #[test]
    fn each_part_is_told_once_with_its_charts() {
        let (run, told) = scenes::watched();
        let options = scenes::options();
        let text =
            scenes::squares(2) + "v 9 0 0\nv 10 0 0\nv 10 1 1\nv 9 1 0\nf 9 10 11\nf 9 11 12\n";
        let (found, solvers, cut) = scenes::cut(&text, &options, &run);
        let charts = cut.charts;
        let mapped = trained(&found, &solvers, charts, &options, &scenes::engine(), &run).unwrap();
        tell_parts(&found, &mapped, &run);
        let told = told.lock().unwrap();
        let parts = told.iter().filter_map(|p| match p {
            Progress::PartCompleted { part, name, charts, symmetric_dirichlet } => {
                assert_eq!(*name, found.parts.parts[*part as usize].name);
                assert!((symmetric_dirichlet - 1.0).abs() < 1e-6);
                Some((*part, *charts))
            }
            _ => None,
        });
        let of = |part| mapped.iter().filter(|m| m.chart.part == part).count() as u32;
        assert_eq!(parts.collect::<Vec<_>>(), [0, 1, 2].map(|part| (part, of(part))));
    }
}
