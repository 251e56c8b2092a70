//! Each stage of the pipeline by itself, on the samples with default options, through the functions
//! that the pipeline calls. `cargo bench --bench stages -- --sort location` has them in their order.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use divan::Bencher;
use glam::DVec3;
use rayon::prelude::*;
use uvsegnet::atlas::{self, Atlas, AtlasCertificates, Demands, Grid, PackOptions, Placed};
use uvsegnet::charts::boundary::BoundaryFeatures;
use uvsegnet::charts::{self, Chart, ChartOptions};
use uvsegnet::contract::{Limits, MeshKind, Quality, Run, UnwrapOptions, Winding};
use uvsegnet::device::Device;
use uvsegnet::flatten::{self, SlimOptions, UvMap};
use uvsegnet::mesh::{self, Conditioned, NONE, Scene, Surface, export};
use uvsegnet::metrics::{self, Measured, MeasuredFigures};
use uvsegnet::parameterization::{self, TrainChart, TrainOptions, TrainedChart};
use uvsegnet::preview;
use uvsegnet::sampling::{self, PointCloud, SampleCounts};
use uvsegnet::segmentation::{self, PartLabels, SegmentOptions, Weights};

const SAMPLES: [&str; 5] = ["chair", "chair_small", "table", "laptop", "skateboard"];

/// Steps of the training; a job takes many times as many.
const TRAINING: u32 = 20;
/// Steps of the polish, as in the pipeline.
const POLISH: u32 = 20;

/// What each stage of a job is given.
struct Job {
    bytes: Vec<u8>,
    scene: Scene,
    surface: Surface,
    cloud: PointCloud,
    parts: PartLabels,
    charts: Vec<Chart>,
    polished: Vec<UvMap>,
    atlas: Atlas,
    /// Coordinates of each chart's vertices on its page, in single precision.
    placed: Vec<UvMap>,
    chart_of: Vec<u32>,
    /// Coordinates of each face's corners, in the surface's winding and in the file's.
    uvs: Vec<[[f32; 2]; 3]>,
    file_uvs: Vec<[[f32; 2]; 3]>,
}

/// A job a sample, run up to its end once, when the first benchmark asks.
static JOBS: LazyLock<BTreeMap<&str, Job>> =
    LazyLock::new(|| SAMPLES.into_iter().map(|name| (name, Job::new(name))).collect());

impl Job {
    fn new(name: &str) -> Self {
        let path = format!("{}/examples/{name}.glb", env!("CARGO_MANIFEST_DIR"));
        let bytes = std::fs::read(path).expect("the samples are in the tree");
        let scene = import(&bytes);
        let Conditioned { surface, telling } = condition(&scene);
        let cloud = sample(&surface);
        let parts = segment(&surface, &cloud);
        let charts = cut(&surface, &parts);
        let polished = polish(&surface, &charts);
        let atlas = pack(&charts, &polished);
        let placed = quantise(&surface, &charts, &atlas);
        let mut chart_of = vec![NONE; surface.face_count()];
        let mut uvs = vec![[[f32::NAN; 2]; 3]; surface.face_count()];
        for (c, (chart, uv)) in (0..).zip(charts.iter().zip(&placed)) {
            for (&f, triangle) in chart.faces.iter().zip(&chart.disk.triangles) {
                chart_of[f as usize] = c;
                uvs[f as usize] = triangle.map(|v| uv[v as usize].as_vec2().to_array());
            }
        }
        let mut file_uvs = vec![[[0.0; 2]; 3]; telling.face.len()];
        for (i, &f) in telling.face.iter().enumerate().filter(|(_, f)| **f != NONE) {
            let corner = |k| telling.corner(&surface, i, k);
            file_uvs[i] = [0, 1, 2].map(|k| uvs[f as usize][corner(k)]);
        }
        Self {
            bytes,
            scene,
            surface,
            cloud,
            parts,
            charts,
            polished,
            atlas,
            placed,
            chart_of,
            uvs,
            file_uvs,
        }
    }

    fn measured(&self) -> Measured<'_> {
        Measured {
            surface: &self.surface,
            uvs: &self.uvs,
            chart_of: &self.chart_of,
            part_of: &self.parts.labels,
            charts: self.charts.len(),
            parts: self.parts.parts.len(),
            boundary_labels: None,
            page_size: self.atlas.page_size,
            pages: self.atlas.pages,
            page_of: &[],
            chamfer: &[],
        }
    }
}

fn import(bytes: &[u8]) -> Scene {
    mesh::import(bytes, MeshKind::Glb, &Limits::default()).expect("samples are sound")
}

fn condition(scene: &Scene) -> Conditioned {
    mesh::condition(scene, Winding::Surface, &Run::quiet()).expect("samples are sound")
}

fn sample(surface: &Surface) -> PointCloud {
    let (counts, seed) =
        (SampleCounts::dense(surface.face_count()), UnwrapOptions::default().seed.0);
    sampling::sample(surface, counts, seed, &Run::quiet()).expect("nothing cancels it")
}

fn segment(surface: &Surface, cloud: &PointCloud) -> PartLabels {
    let options = SegmentOptions::from(&UnwrapOptions::default());
    let (weights, device) = (Weights::shipped(), Device::cpu());
    segmentation::segment(surface, cloud, &options, &weights, &device, &Run::quiet())
        .expect("samples have parts")
}

fn cut(surface: &Surface, parts: &PartLabels) -> Vec<Chart> {
    let options = ChartOptions::from(&UnwrapOptions::default());
    charts::build(surface, &parts.labels, &options, &Run::quiet()).expect("nothing cancels it")
}

/// What the networks of the charts that bend are told, creases and tubes apart.
fn inputs(job: &Job) -> Vec<TrainChart<'_>> {
    let labels: Vec<u32> = job.cloud.faces.iter().map(|&f| job.parts.labels[f as usize]).collect();
    let features = BoundaryFeatures::new(&job.cloud, &labels);
    let bent = job.charts.iter().filter(|c| !flatten::quality(&c.disk, &c.start).is_isometric());
    let input = |(id, chart)| {
        let Chart { disk, start, .. }: &Chart = chart;
        let mut normals = vec![DVec3::ZERO; disk.positions.len()];
        for triangle in &disk.triangles {
            let [a, b, c] = triangle.map(|v| disk.positions[v as usize]);
            triangle.iter().for_each(|&v| normals[v as usize] += (b - a).cross(c - a));
        }
        let normals = normals.into_iter().map(DVec3::normalize_or_zero).collect();
        let (rho, boundary) = features.at(&disk.positions);
        let crease = vec![0.0; disk.positions.len()];
        let (cylinder, over_cut) = (None, None);
        TrainChart { disk, start, normals, rho, boundary, crease, cylinder, over_cut, id }
    };
    (0..).zip(bent).map(input).collect()
}

fn train(charts: &[TrainChart]) -> Vec<TrainedChart> {
    let options = TrainOptions { steps: TRAINING, ..TrainOptions::from(&UnwrapOptions::default()) };
    let mut told = |_: u32, _: u32, _: &[usize]| {};
    parameterization::train(charts, &options, &Device::cpu(), &Run::quiet(), &mut told)
        .expect("nothing cancels it")
}

/// Descend from the start of each chart that bends, and prove what comes out.
fn polish(surface: &Surface, charts: &[Chart]) -> Vec<UvMap> {
    let clearance = charts::clearance(surface);
    let options = SlimOptions { iterations: POLISH, ..Default::default() };
    let one = |chart: &Chart| {
        if flatten::quality(&chart.disk, &chart.start).is_isometric() {
            return chart.cut_map.clone();
        }
        let uv = flatten::slim(&chart.disk, &chart.cut_map, &options, &Run::quiet().cancel)
            .expect("nothing cancels it");
        if charts::is_sound(&chart.disk, &uv, clearance) { uv } else { chart.cut_map.clone() }
    };
    charts.par_iter().map(one).collect()
}

fn pack(charts: &[Chart], maps: &[UvMap]) -> Atlas {
    let UnwrapOptions { page_size, padding, rotation, block_align, pages, .. } =
        UnwrapOptions::default();
    let disks: Vec<_> = charts.iter().map(|c| &c.disk).zip(maps).collect();
    let options = PackOptions {
        page_size,
        padding,
        rotation,
        block_align,
        pages,
        grid: Grid::Page,
        weights: Vec::new(),
        quality: Quality::Balanced,
    };
    atlas::pack(&disks, &options, &Run::quiet()).expect("samples fit a page")
}

fn quantise(surface: &Surface, charts: &[Chart], atlas: &Atlas) -> Vec<UvMap> {
    let disks: Vec<_> = charts.iter().map(|c| &c.disk).zip(&atlas.uvs).collect();
    atlas::quantise(&disks, surface.diagonal, Grid::Page).uvs
}

fn certify(job: &Job) -> AtlasCertificates {
    let pages = job.charts.iter().zip(&job.placed).zip(&job.atlas.placements);
    let charts: Vec<Placed> =
        pages.map(|((c, uv), at)| Placed { disk: &c.disk, uv, page: at.page }).collect();
    let demands = Demands {
        pages: job.atlas.pages,
        page_size: job.atlas.page_size,
        padding: UnwrapOptions::default().padding,
        diagonal: job.surface.diagonal,
        shared_sheets: false,
    };
    atlas::certify_atlas(&charts, &demands)
}

fn measure(measured: &Measured) -> MeasuredFigures {
    metrics::measure(measured, &Run::quiet()).expect("nothing cancels it")
}

/// Both pictures.
fn draw(measured: &Measured) -> (String, Vec<u8>) {
    let run = Run::quiet();
    let layout = preview::uv_layout_svg(measured, &[], &run.cancel).expect("nothing cancels it");
    (layout, preview::preview_png(measured, None, &run).expect("nothing cancels it"))
}

fn write(job: &Job) -> Vec<u8> {
    export::glb(&job.scene, &job.file_uvs, 0, None).expect("every face has coordinates")
}

#[divan::bench_group(sample_count = 20, sample_size = 1, max_time = 1)]
mod stage {
    use super::{Bencher, JOBS, SAMPLES};

    #[divan::bench(args = SAMPLES)]
    fn import(bencher: Bencher, sample: &str) {
        let job = &JOBS[sample];
        bencher.bench_local(|| super::import(&job.bytes));
    }

    #[divan::bench(args = SAMPLES)]
    fn condition(bencher: Bencher, sample: &str) {
        let job = &JOBS[sample];
        bencher.bench_local(|| super::condition(&job.scene));
    }

    #[divan::bench(args = SAMPLES)]
    fn sample(bencher: Bencher, sample: &str) {
        let job = &JOBS[sample];
        bencher.bench_local(|| super::sample(&job.surface));
    }

    #[divan::bench(args = SAMPLES)]
    fn segment(bencher: Bencher, sample: &str) {
        let job = &JOBS[sample];
        bencher.bench_local(|| super::segment(&job.surface, &job.cloud));
    }

    #[divan::bench(args = SAMPLES)]
    fn charts(bencher: Bencher, sample: &str) {
        let job = &JOBS[sample];
        bencher.bench_local(|| super::cut(&job.surface, &job.parts));
    }

    #[divan::bench(args = SAMPLES)]
    fn train_twenty_steps(bencher: Bencher, sample: &str) {
        let inputs = super::inputs(&JOBS[sample]);
        bencher.bench_local(|| super::train(&inputs));
    }

    #[divan::bench(args = SAMPLES)]
    fn polish(bencher: Bencher, sample: &str) {
        let job = &JOBS[sample];
        bencher.bench_local(|| super::polish(&job.surface, &job.charts));
    }

    #[divan::bench(args = SAMPLES)]
    fn pack(bencher: Bencher, sample: &str) {
        let job = &JOBS[sample];
        bencher.bench_local(|| super::pack(&job.charts, &job.polished));
    }

    #[divan::bench(args = SAMPLES)]
    fn round(bencher: Bencher, sample: &str) {
        let job = &JOBS[sample];
        bencher.bench_local(|| super::quantise(&job.surface, &job.charts, &job.atlas));
    }

    #[divan::bench(args = SAMPLES)]
    fn certify(bencher: Bencher, sample: &str) {
        let job = &JOBS[sample];
        bencher.bench_local(|| super::certify(job));
    }

    #[divan::bench(args = SAMPLES)]
    fn measure(bencher: Bencher, sample: &str) {
        let measured = JOBS[sample].measured();
        bencher.bench_local(|| super::measure(&measured));
    }

    #[divan::bench(args = SAMPLES)]
    fn preview(bencher: Bencher, sample: &str) {
        let measured = JOBS[sample].measured();
        bencher.bench_local(|| super::draw(&measured));
    }

    #[divan::bench(args = SAMPLES)]
    fn export(bencher: Bencher, sample: &str) {
        let job = &JOBS[sample];
        bencher.bench_local(|| super::write(job));
    }
}

/// As in the program.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() {
    divan::main();
}
