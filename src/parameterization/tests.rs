//! What training promises: it starts at the start map, it lowers the energy, a chart's result depends
//! on nothing but the chart, the options and the seed, and it stops when it is told to.

use std::time::{Duration, Instant};

use glam::DVec2;

use super::measure::energy;
use super::scenes::{barrel, bumpy, half_cylinder, plain};
use super::*;
use crate::contract::{Budget, Cancel, Degradation, GaveUp, Run, Scarce, Stage};
use crate::device::Device;

fn options(steps: u32) -> TrainOptions {
    TrainOptions {
        width: 32,
        steps,
        points: 512,
        seed: 1,
        form: LossForm::Sound,
        stage: Stage::Train,
    }
}

fn trained(charts: &[TrainChart], options: &TrainOptions) -> Vec<TrainedChart> {
    train(charts, options, &Device::cpu(), &Run::quiet(), &mut |_, _, _| {}).unwrap()
}

#[test]
fn without_steps_the_map_is_the_start_map() {
    let (disk, start) = bumpy(8, 8);
    let result = trained(&[plain(&disk, &start, 3)], &options(0));
    assert_eq!(result[0].uv, start);
    assert!(!result[0].improved && result[0].steps == 0 && result[0].chamfer.is_none());
    assert_eq!(result[0].energy, energy(&disk, &start));
}

#[test]
fn step_0_is_the_start_map() {
    let (disk, start) = bumpy(8, 8);
    let chart = plain(&disk, &start, 3);
    let options = options(1);
    let layout = mapper::Layout::new(options.width);
    let trainee = chart::Trainee::new(0, &chart, &options);
    let parameters =
        mapper::stack(&[layout.initial(&mut trainee.weights_rng())], &Device::cpu().burn());
    let map = step::whole_map(&trainee, &layout, &parameters, &Device::cpu(), &Cancel::default())
        .unwrap();
    assert_eq!(map, start);
}

#[test]
fn a_barrel_gets_better() {
    let (disk, start) = barrel(15, 15);
    let before = energy(&disk, &start);
    let result = trained(&[plain(&disk, &start, 0)], &options(150));
    let after = energy(&disk, &result[0].uv);
    assert!(result[0].improved);
    assert!((after - result[0].energy).abs() < 1e-9);
    assert!(after - 1.0 < 0.35 * (before - 1.0), "{before} → {after}");
    let scale = crate::flatten::scale(&disk, &result[0].uv);
    assert!((scale - 1.0).abs() < 1e-9);
    assert!(result[0].chamfer.unwrap() < 0.2, "{:?}", result[0].chamfer);
}

#[test]
fn a_half_cylinder_unrolls_from_its_projection() {
    let (disk, start) = half_cylinder(15, 10);
    let before = energy(&disk, &start);
    let mut chart = plain(&disk, &start, 0);
    let free = trained(std::slice::from_ref(&chart), &options(200))[0].energy;
    let (origin, axis) = (DVec3::ZERO, DVec3::Y);
    chart.cylinder = Some(CylinderTarget::new(&disk, origin, axis, 0.5, 0.0));
    let guided = trained(std::slice::from_ref(&chart), &options(200))[0].energy;
    assert!(free - 1.0 < 0.02 * (before - 1.0), "{before} → {free}");
    assert!(guided - 1.0 < 0.02 * (before - 1.0), "{before} → {guided}");
}

#[test]
fn a_chart_does_not_depend_on_its_batch() {
    let scenes = [bumpy(10, 9), barrel(22, 20), half_cylinder(4, 3)];
    let charts: Vec<TrainChart> =
        scenes.iter().zip(7..).map(|((disk, start), id)| plain(disk, start, id)).collect();
    let together = trained(&charts, &options(25));
    for (chart, together) in charts.iter().zip(&together) {
        assert_eq!(&trained(std::slice::from_ref(chart), &options(25))[0], together);
    }
}

#[test]
fn a_chart_that_leaves_early_does_not_disturb_the_others() {
    let flat = bumpy(6, 6);
    let isometric: UvMap = flat.0.positions.iter().map(|p| DVec2::new(p.x, p.y)).collect();
    let sheet = Disk::new(
        flat.0.positions.iter().map(|p| DVec3::new(p.x, p.y, 0.0)).collect(),
        flat.0.triangles.clone(),
    );
    let (disk, start) = barrel(9, 9);
    let charts = [plain(&sheet, &isometric, 1), plain(&disk, &start, 2)];
    let together = trained(&charts, &options(20));
    assert!(together[0].converged && together[0].steps == 0 && together[0].uv == isometric);
    assert_eq!(trained(&charts[1..], &options(20))[0], together[1]);
}

#[test]
fn threads_do_not_matter_and_seeds_do() {
    let (disk, start) = barrel(12, 12);
    let run = |threads, seed| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let charts = [plain(&disk, &start, 4), plain(&disk, &start, 5)];
        pool.install(|| trained(&charts, &TrainOptions { seed, ..options(21) }))
    };
    let one = run(1, 1);
    assert!(one == run(2, 1));
    assert_ne!(one[0].history, one[1].history, "another id draws other weights");
    assert_ne!(one[0].history, run(1, 2)[0].history);
}

#[test]
fn both_forms_of_the_losses_run() {
    let (disk, start) = barrel(10, 10);
    for form in [LossForm::Sound, LossForm::Paper] {
        let options = TrainOptions { form, ..options(60) };
        let result = &trained(&[plain(&disk, &start, 0)], &options)[0];
        let (first, last) = (result.history[0], *result.history.last().unwrap());
        assert_eq!(result.history.len(), result.steps.div_ceil(10) as usize);
        assert!(result.history.iter().all(|loss| loss.is_finite() && *loss >= 0.0));
        assert!(last < first, "{form}: {:?}", result.history);
    }
}

#[test]
fn what_runs_on_a_graphics_card_is_the_same_training() {
    let scenes = [barrel(10, 10), bumpy(5, 4)];
    let charts: Vec<TrainChart> =
        scenes.iter().zip(0..).map(|((disk, start), id)| plain(disk, start, id)).collect();
    let run =
        |device| train(&charts, &options(11), &device, &Run::quiet(), &mut |_, _, _| {}).unwrap();
    for (fused, composed) in run(Device::cpu()).iter().zip(&run(Device::posing_as_gpu())) {
        for (a, b) in fused.history.iter().zip(&composed.history) {
            assert!((a - b).abs() < 1e-2 * a, "{a} {b}");
        }
    }
}

#[test]
fn a_large_chart_trains_on_samples_and_ships_whole() {
    let (disk, start) = barrel(50, 40);
    let before = energy(&disk, &start);
    let options = TrainOptions { points: 200, ..options(150) };
    let result = &trained(&[plain(&disk, &start, 0)], &options)[0];
    assert_eq!(result.uv.len(), disk.positions.len());
    assert!(result.improved);
    let after = energy(&disk, &result.uv);
    assert!(after - 1.0 < 0.5 * (before - 1.0), "{before} → {after}");
}

#[test]
fn a_start_with_flips_comes_back_marked_or_mended() {
    let (disk, start) = barrel(8, 8);
    let mirrored: UvMap = start.iter().map(|u| DVec2::new(-u.x, u.y)).collect();
    let result = &trained(&[plain(&disk, &mirrored, 0)], &options(5))[0];
    if result.improved {
        assert!(result.energy.is_finite());
    } else {
        assert_eq!(result.uv, mirrored);
        assert_eq!(result.energy, f64::INFINITY);
    }
}

#[test]
fn the_inverse_gradient_never_outweighs_the_forward_one() {
    let (disk, start) = barrel(8, 8);
    let chart = plain(&disk, &start, 0);
    let mut trainee = chart::Trainee::new(0, &chart, &options(10));
    let rows = disk.positions.len();
    trainee.measure(&vec![0.0; 2 * rows]);
    let mut alone = vec![0.0; 2 * rows];
    trainee.join(&vec![0.0; 2 * rows], &mut alone);
    let mut total = vec![0.0; 2 * rows];
    trainee.join(&vec![1e6; 2 * rows], &mut total);
    let norm = |v: &[f32]| v.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
    let added: Vec<f32> = total.iter().zip(&alone).map(|(t, a)| t - a).collect();
    assert!((norm(&added) / norm(&alone) - 1.0).abs() < 1e-3);
    assert!(trainee.clip > 0.0 && trainee.clip < 1e-3);
    // A small one passes as it is.
    trainee.join(&vec![1e-9; 2 * rows], &mut total);
    assert_eq!(trainee.clip, 1.0);
}

#[test]
fn a_gradient_that_is_no_number_ends_the_chart() {
    let (disk, start) = barrel(8, 8);
    let chart = plain(&disk, &start, 0);
    let mut trainee = chart::Trainee::new(0, &chart, &options(10));
    let rows = disk.positions.len();
    trainee.measure(&vec![0.0; 2 * rows]);
    let mut total = vec![1.0; 2 * rows];
    trainee.join(&vec![f32::NAN; 2 * rows], &mut total);
    assert!(trainee.broken && trainee.is_finished() && total.iter().all(|t| *t == 0.0));
}

#[test]
fn cancel_stops_within_a_step() {
    let (disk, start) = barrel(10, 10);
    let cancel = Cancel::default();
    let run = Run::new(|_| {}, cancel.clone(), Budget::default());
    let mut last = 0;
    let result = train(
        &[plain(&disk, &start, 0)],
        &options(500),
        &Device::cpu(),
        &run,
        &mut |step, steps, _| {
            assert_eq!(steps, 500);
            last = step;
            if step == 3 {
                cancel.cancel();
            }
        },
    );
    assert_eq!(result, Err(MapError::Canceled(Canceled)));
    assert_eq!(last, 3);
}

#[test]
fn a_spent_budget_ends_training_with_what_there_is() {
    let (disk, start) = barrel(10, 10);
    let late = Instant::now() - Duration::from_secs(70);
    let run = Run::new(|_| {}, Cancel::default(), Budget::new(Some(100.0), 4096).since(late));
    let result =
        train(&[plain(&disk, &start, 0)], &options(500), &Device::cpu(), &run, &mut |_, _, _| {});
    assert_eq!(result.unwrap()[0].uv, start);
    let given_up =
        Degradation { stage: Stage::Train, gave_up: GaveUp::Training, scarce: Scarce::Time };
    assert_eq!(run.budget.degraded(), [given_up]);
}

#[test]
fn arrays_that_do_not_fit_are_named() {
    let (disk, start) = barrel(4, 4);
    let mut chart = plain(&disk, &start, 0);
    chart.rho.pop();
    let result = train(&[chart], &options(1), &Device::cpu(), &Run::quiet(), &mut |_, _, _| {});
    assert!(matches!(result, Err(MapError::Mismatch { array: "rho", .. })));
}

#[test]
fn an_over_cut_part_closes_its_seams() {
    use super::losses::CutEdge;
    // Two unit squares of a plane that share an edge in 3D and stand apart in UV.
    let corner = |x: f64, y: f64| DVec3::new(x, y, 0.0);
    let square =
        |x: f64| [corner(x, 0.0), corner(x + 1.0, 0.0), corner(x + 1.0, 1.0), corner(x, 1.0)];
    let disk = Disk::new(
        [square(0.0), square(1.0)].concat(),
        vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
    );
    let apart = |i: usize| DVec2::new(if i < 4 { 0.0 } else { 0.3 }, 0.0);
    let start: UvMap =
        disk.positions.iter().enumerate().map(|(i, p)| p.truncate() + apart(i)).collect();
    let mut chart = plain(&disk, &start, 0);
    let edge = CutEdge { sides: [[1, 2], [4, 7]], length: 1.0, cost: 1.0 };
    chart.over_cut = Some(OverCut { edges: vec![edge], radius: 1.0 });
    let result = &trained(&[chart], &options(200))[0];
    let gap = |uv: &[DVec2]| uv[1].distance(uv[4]) + uv[2].distance(uv[7]);
    assert_eq!(result.steps, 200);
    assert!(gap(&result.uv) < 0.5 * gap(&start), "{} → {}", gap(&start), gap(&result.uv));
    assert!(result.energy < 1.05, "{}", result.energy);
}

#[test]
fn no_charts_no_work() {
    assert_eq!(trained(&[], &options(10)), []);
}
