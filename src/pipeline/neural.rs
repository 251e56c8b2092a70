//! Which charts are trained, and what their networks are told (docs/method.md, section 5): all that bend with
//! `quality = best`, and none below. Of the charts that were ever measured none gained by it enough to pay for
//! itself (docs/results.md).

use glam::{DVec2, DVec3};

use super::parts::{Found, Solvers};
use crate::charts::boundary::BoundaryFeatures;
use crate::charts::{Chart, ChartShape};
use crate::contract::{GaveUp, Quality, Run, Scarce, Stage, UnwrapOptions};
use crate::flatten::{self, Disk};
use crate::mesh::Surface;
use crate::parameterization::losses::CylinderTarget;
use crate::parameterization::{self, TrainChart, TrainOptions};

/// Which charts to train, best first. Charts whose start is isometric are never among them.
pub fn choose(charts: &[Chart], options: &UnwrapOptions, run: &Run) -> Vec<usize> {
    if options.quality != Quality::Best {
        return Vec::new();
    }
    let fits = |chart: &Chart| {
        let bytes =
            parameterization::bytes(chart.disk.positions.len(), &TrainOptions::from(options));
        bytes <= run.budget.spare_bytes()
    };
    // Expected gain: what distortion there is, times the area that has it.
    let mut ranked: Vec<(f64, usize)> = Vec::new();
    for (i, chart) in charts.iter().enumerate() {
        let quality = flatten::quality(&chart.disk, &chart.start);
        if !quality.is_isometric() {
            if fits(chart) {
                ranked.push((chart.disk.area() * (quality.mean - 1.0), i));
            } else {
                run.give_up(Stage::Train, GaveUp::Training, Scarce::Memory);
            }
        }
    }
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    ranked.into_iter().map(|(_, i)| i).collect()
}

/// What the networks of the chosen charts are told.
pub fn inputs<'a>(
    found: &Found,
    solvers: &Solvers,
    charts: &'a [Chart],
    chosen: &[usize],
) -> Vec<TrainChart<'a>> {
    if chosen.is_empty() {
        return Vec::new();
    }
    let told = Vertices::of(solvers, &found.surface);
    let of = |&i: &usize| {
        let chart = &charts[i];
        // The first face: it stays the same whatever happens to other charts.
        let id = chart.faces.first().map_or(0, |&f| u64::from(f));
        let cylinder = match chart.shape {
            ChartShape::General => None,
            ChartShape::Tubular { origin, axis, radius, taper } => {
                Some(CylinderTarget::new(&chart.disk, origin, axis, radius, taper))
            }
        };
        let input = input(&chart.disk, &chart.vertices, &chart.start, &told, id);
        TrainChart { cylinder, ..input }
    };
    chosen.iter().map(of).collect()
}

/// What the networks are told of the surface's vertices.
pub struct Vertices {
    features: BoundaryFeatures,
    creased: Vec<bool>,
}

impl Vertices {
    /// Boundary features of the cloud, and creases of a surface.
    pub fn of(solvers: &Solvers, surface: &Surface) -> Self {
        let cloud = &solvers.cloud;
        let labels: Vec<u32> = cloud.faces.iter().map(|&f| solvers.part_of[f as usize]).collect();
        let features = BoundaryFeatures::new(cloud, &labels);
        Self { features, creased: creased_vertices(surface) }
    }
}

/// A disk to be trained, without a cylinder or seams to close. `vertices`: vertex of the surface that each
/// vertex of the disk stands for.
pub fn input<'a>(
    disk: &'a Disk,
    vertices: &[u32],
    start: &'a [DVec2],
    told: &Vertices,
    id: u64,
) -> TrainChart<'a> {
    let mut normals = vec![DVec3::ZERO; disk.positions.len()];
    for triangle in &disk.triangles {
        let [a, b, c] = triangle.map(|v| disk.positions[v as usize]);
        let normal = (b - a).cross(c - a);
        triangle.iter().for_each(|&v| normals[v as usize] += normal);
    }
    let (rho, boundary) = told.features.at(&disk.positions);
    let crease = |&v: &u32| if told.creased[v as usize] { 1.0 } else { 0.0 };
    TrainChart {
        disk,
        start,
        normals: normals.into_iter().map(DVec3::normalize_or_zero).collect(),
        rho,
        boundary,
        crease: vertices.iter().map(crease).collect(),
        cylinder: None,
        over_cut: None,
        id,
    }
}

/// Which vertices of the surface lie on a salient edge.
fn creased_vertices(surface: &Surface) -> Vec<bool> {
    let mut creased = vec![false; surface.positions.len()];
    for h in 0..surface.twin.len() as u32 {
        if surface.is_crease(h) {
            creased[surface.from(h) as usize] = true;
            creased[surface.to(h) as usize] = true;
        }
    }
    creased
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::charts::StartKind;
    use crate::contract::{Budget, Cancel, Degradation};
    use crate::flatten::samples;
    use crate::pipeline::scenes;

    /// A bump of a height over a square of side `size`, seen from above.
    fn bump(size: f64, height: f64) -> Chart {
        let lift = |x: f64, y: f64| height * (6.0 * x).sin() * (6.0 * y).sin();
        let disk = samples::bent(12, 12, |x, y| DVec3::new(x, y, lift(x, y)) * size);
        let seen = disk.positions.iter().map(|p| p.truncate()).collect();
        let start = flatten::rescale(&disk, seen);
        Chart {
            faces: (0..disk.triangles.len() as u32).collect(),
            vertices: (0..disk.positions.len() as u32).collect(),
            cut_map: start.clone(),
            start_kind: StartKind::Planar,
            start,
            disk,
            ..Chart::default()
        }
    }

    fn chosen(charts: &[Chart], quality: Quality) -> Vec<usize> {
        let options = UnwrapOptions { quality, ..Default::default() };
        choose(charts, &options, &Run::quiet())
    }

    #[test]
    fn the_best_paying_charts_come_first_and_flat_ones_never() {
        // As bent as another but smaller, flat, as large as another but bent less, bent most.
        let charts = [bump(0.5, 0.1), bump(9.0, 0.0), bump(1.0, 0.05), bump(1.0, 0.1)];
        assert_eq!(chosen(&charts, Quality::Best), [3, 0, 2]);
        assert!(chosen(&charts[1..2], Quality::Best).is_empty());
        for quality in [Quality::Fast, Quality::Balanced] {
            assert!(chosen(&charts, quality).is_empty());
        }
    }

    #[test]
    fn a_chart_that_memory_does_not_hold_is_given_up() {
        let charts = [bump(1.0, 0.1), bump(1.0, 0.0)];
        for (spare, chosen) in [(64 << 20, vec![0]), (1 << 10, vec![])] {
            let budget = Budget::new(None, 64);
            budget.hold((64 << 20) - spare).unwrap();
            let run = Run::new(|_| {}, Cancel::default(), budget);
            let options = UnwrapOptions { quality: Quality::Best, ..Default::default() };
            assert_eq!(choose(&charts, &options, &run), chosen);
            let (stage, scarce) = (Stage::Train, Scarce::Memory);
            let given_up = Degradation { stage, gave_up: GaveUp::Training, scarce };
            let expected = if chosen.is_empty() { vec![given_up] } else { Vec::new() };
            assert_eq!(run.budget.degraded(), expected);
        }
    }

    #[test]
    fn networks_are_told_normals_creases_and_where_parts_end() {
        // A roof over the line x = 2 of a sheet of 4 × 4 cells, of two parts that meet at y = 2.
        let text = scenes::sheet(4, |x, _| -(x - 2.0).abs());
        let mut scene = scenes::scene(&text);
        scene.labels = Some((0..32).map(|f| f / 16).collect());
        let segmentation = crate::contract::SegmentationSource::Labels;
        let options = UnwrapOptions { segmentation, ..scenes::options() };
        let (engine, run) = (scenes::engine(), Run::quiet());
        let (found, solvers) =
            crate::pipeline::parts::find(&scene, &options, &engine, &run).unwrap();
        let charts = crate::pipeline::charting::cut(&found, &solvers, &options, &engine, &run)
            .unwrap()
            .charts;
        let all: Vec<usize> = (0..charts.len()).collect();
        for (told, chart) in inputs(&found, &solvers, &charts, &all).iter().zip(&charts) {
            assert_eq!(told.id, u64::from(chart.faces[0]));
            for (v, p) in chart.disk.positions.iter().enumerate() {
                assert_eq!(told.crease[v] == 1.0, p.x == 2.0, "{p}");
                assert!((told.normals[v].length() - 1.0).abs() < 1e-9);
                if p.x != 2.0 {
                    assert!(
                        (told.normals[v].x - (p.x - 2.0).signum() * 0.5f64.sqrt()).abs() < 1e-9
                    );
                }
                assert_eq!(told.boundary[v] == 1.0, told.rho[v] > 0.3);
                if (p.y - 2.0).abs() > 1.5 {
                    assert_eq!(told.rho[v], 0.0, "far from the other part: {p}");
                }
                if p.y == 2.0 {
                    assert!(told.rho[v] > 0.2, "on the border of the other part: {p}");
                }
            }
        }
    }
}
