//! `uvsegnet bench stages`: what each stage makes of one object, a picture each, for docs/method.md.

use std::path::PathBuf;

use anyhow::{Context, Result, anyhow, ensure};
use serde_json::Value;

use super::options::unwrap;
use crate::charts::{self, ChartOptions};
use crate::cli::input::{Beside, Files};
use crate::contract::{ArtifactKind, DoubleSided, Limits, MeshKind, Metrics, Run, UnwrapOptions};
use crate::device::Device;
use crate::mesh::{
    self, Conditioned, Document, NONE, Scene, Sides, Surface, Telling, TexcoordOrigin,
};
use crate::metrics::Measured;
use crate::pipeline::Engine;
use crate::preview::StagePictures;
use crate::sampling::{self, SampleCounts};

/// Arguments of `uvsegnet bench stages`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The mesh.
    #[arg(help = format!("The mesh ({})", MeshKind::names()))]
    pub mesh: PathBuf,
    /// Where the pictures go: samples.png, parts.png, patches.png, charts.png, map.png, page.png. Made if
    /// need be.
    #[arg(short, long, value_name = "DIR", default_value = "stages")]
    pub output: PathBuf,
}

/// Run it: a job with default options on the CPU, and a picture of each stage.
pub fn run(args: Args) -> Result<()> {
    let files = Files::read(&args.mesh, &Beside::default())?;
    std::fs::create_dir_all(&args.output)
        .with_context(|| format!("cannot make {}", args.output.display()))?;
    for (name, picture) in pictures(&files)? {
        let path = args.output.join(name);
        std::fs::write(&path, &picture)
            .with_context(|| format!("cannot write {}", path.display()))?;
        println!("{:<32} {:>9} bytes", path.display(), picture.len());
    }
    Ok(())
}

/// Every picture with its name. What the result says is read from its own file; what it no longer has, the
/// samples and the patches, is made again as the job made it.
fn pictures(files: &Files) -> Result<[(&'static str, Vec<u8>); 6]> {
    let (options, run) = (UnwrapOptions::default(), Run::quiet());
    let unwrapped = unwrap(files, &options, &Engine::new(Device::cpu()))?;
    let metrics = &unwrapped.metrics;
    let input = files.input();
    let scene = mesh::import(input.mesh(), input.kind(), &Limits::default())?;
    let Conditioned { surface, telling } = mesh::condition(&scene, options.winding, &run)?;
    let both = options.double_sided == DoubleSided::Separate;
    let Sides { surface, telling, .. } = Sides::of(&surface, &telling, both, true);
    drop(scene);
    let model = unwrapped.artifact(ArtifactKind::Model).context("there is no model")?;
    let faces = Faces::read(model, &surface, &telling)?;

    let counts = SampleCounts::dense(surface.face_count());
    let cloud = sampling::sample(&surface, counts, options.seed.0, &run)?;
    // Specks are cut together with their neighbours, so that a chart knows better than its faces.
    let region = |&c: &u32| metrics.charts.get(c as usize).map_or(NONE, |chart| chart.parts[0]);
    let region_of: Vec<u32> = faces.chart_of.iter().map(region).collect();
    let cut = ChartOptions::from(&options);
    let patch_of = charts::initial_patches(&surface, &region_of, &cut, &run)?;

    let page_of: Vec<u32> = metrics.charts.iter().map(|chart| chart.page).collect();
    let measured = faces.measured(&surface, metrics, &page_of);
    let names: Vec<String> = metrics.parts.iter().map(|part| part.name.clone()).collect();
    let draw = StagePictures::new(&measured, &run)?;
    Ok([
        ("samples.png", draw.samples(&cloud)?),
        ("parts.png", draw.parts(&names)?),
        ("patches.png", draw.patches(&patch_of)?),
        ("charts.png", draw.charts()?),
        ("map.png", draw.maps()?),
        ("page.png", draw.page(&names)?),
    ])
}

/// What a result's file says of each face.
struct Faces {
    /// Coordinates of the corners in the surface's winding, v up; NaN for faces in no chart.
    uvs: Vec<[[f32; 2]; 3]>,
    chart_of: Vec<u32>,
    part_of: Vec<u32>,
}

impl Faces {
    /// Reads the model of a result. `surface`: what it was made of, in the way of `telling`.
    fn read(model: &[u8], surface: &Surface, telling: &Telling) -> Result<Self> {
        let scene = mesh::import(model, MeshKind::Glb, &Limits::default())?;
        let count = telling.face.len();
        let Some(Document::Gltf { json, .. }) = &scene.source else {
            return Err(anyhow!("the model has no document"));
        };
        let told = &json["asset"]["extras"]["uvsegnet"];
        let of_face = |key: &str| spelled_out(&told[key], count);
        let (chart_of, part_of) = (of_face("face_charts")?, of_face("face_parts")?);
        let file = coordinates(&scene);
        ensure!(file.len() == count, "the model has {} faces and the mesh {count}", file.len());
        let faces = surface.face_count();
        let mut uvs = vec![[[f32::NAN; 2]; 3]; faces];
        let (mut charts, mut parts) = (vec![NONE; faces], vec![NONE; faces]);
        for (i, &f) in telling.face.iter().enumerate().filter(|(_, f)| **f != NONE) {
            let f = f as usize;
            (charts[f], parts[f]) = (chart_of[i], part_of[i]);
            for k in (0..3).filter(|_| chart_of[i] != NONE) {
                uvs[f][telling.corner(surface, i, k)] = file[i][k];
            }
        }
        Ok(Self { uvs, chart_of: charts, part_of: parts })
    }

    fn measured<'a>(
        &'a self,
        surface: &'a Surface,
        metrics: &Metrics,
        page_of: &'a [u32],
    ) -> Measured<'a> {
        Measured {
            surface,
            uvs: &self.uvs,
            chart_of: &self.chart_of,
            part_of: &self.part_of,
            charts: metrics.charts.len(),
            parts: metrics.parts.len(),
            boundary_labels: None,
            page_size: metrics.atlas.width,
            pages: metrics.atlas.pages,
            page_of,
            chamfer: &[],
        }
    }
}

/// The first texture coordinates of every corner, v up, in face order.
fn coordinates(scene: &Scene) -> Vec<[[f32; 2]; 3]> {
    let up = |[u, v]: [f32; 2]| match scene.texcoord_origin {
        TexcoordOrigin::BottomLeft => [u, v],
        TexcoordOrigin::TopLeft => [u, 1.0 - v],
    };
    let sets = scene.primitives.iter().filter_map(|p| p.texcoords());
    sets.flatten().map(|corners| corners.map(up)).collect()
}

/// The numbers behind `[count, value]` pairs, −1 as [`NONE`].
pub fn spelled_out(runs: &Value, count: usize) -> Result<Vec<u32>> {
    let runs: Vec<(usize, i64)> = serde_json::from_value(runs.clone())
        .context("the model does not say which face is where")?;
    let told = runs.iter().fold(0usize, |sum, run| sum.saturating_add(run.0));
    ensure!(told == count, "the model tells of {told} faces and the mesh has {count}");
    let number = |value: i64| u32::try_from(value).unwrap_or(NONE);
    Ok(runs.into_iter().flat_map(|(n, value)| vec![number(value); n]).collect())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::contract::Winding;
    use crate::mesh::condition;
    use crate::preview::STAGE_SIZE;

    /// A cube, and beside it a pyramid.
    const OBJECT: &str = "o box\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
        f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n\
        o tent\nv 2 0 0\nv 3 0 0\nv 3 0 1\nv 2 0 1\nv 2.5 1 0.5\n\
        f 9 10 11 12\nf 10 9 13\nf 11 10 13\nf 12 11 13\nf 9 12 13\n";

    #[test]
    fn a_folder_of_six_pictures_of_one_size_that_all_show_something_else() {
        let folder = tempfile::tempdir().unwrap();
        let mesh = folder.path().join("object.obj");
        std::fs::write(&mesh, OBJECT).unwrap();
        let output = folder.path().join("pictures");
        run(Args { mesh, output: output.clone() }).unwrap();
        let mut seen = BTreeSet::new();
        for name in ["samples", "parts", "patches", "charts", "map", "page"] {
            let bytes = std::fs::read(output.join(name).with_extension("png")).unwrap();
            let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
            assert_eq!(<[u32; 2]>::from(reader.info().size()), STAGE_SIZE, "{name}");
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            // Of the panel on the left alone: a legend is no picture.
            let [width, side] = STAGE_SIZE.map(|n| n as usize);
            let (pixels, _) = pixels.as_chunks::<3>();
            let panel = pixels.chunks(width).flat_map(|row| &row[..side]);
            let paper = pixels[0];
            let drawn = panel.clone().filter(|pixel| **pixel != paper).count();
            assert!(drawn > side * side / 20, "{name}: {drawn}");
            let colors: BTreeSet<_> = panel.collect();
            assert!(colors.len() > 8, "{name}: {}", colors.len());
            assert!(seen.insert(bytes), "{name} is another picture");
        }
        assert_eq!(std::fs::read_dir(&output).unwrap().count(), seen.len());
    }

    #[test]
    fn the_faces_are_those_that_the_result_was_measured_on() {
        let folder = tempfile::tempdir().unwrap();
        let mesh = folder.path().join("object.obj");
        std::fs::write(&mesh, OBJECT).unwrap();
        let files = Files::read(&mesh, &Beside::default()).unwrap();
        let engine = Engine::new(Device::cpu());
        let unwrapped = unwrap(&files, &UnwrapOptions::default(), &engine).unwrap();
        let (input, run) = (files.input(), Run::quiet());
        let scene = mesh::import(input.mesh(), input.kind(), &Limits::default()).unwrap();
        let Conditioned { surface, telling } = condition(&scene, Winding::Surface, &run).unwrap();
        let Sides { surface, telling, .. } = Sides::of(&surface, &telling, true, true);
        let model = unwrapped.artifact(ArtifactKind::Model).unwrap();
        let faces = Faces::read(model, &surface, &telling).unwrap();
        let measured = faces.measured(&surface, &unwrapped.metrics, &[]);
        let figures = crate::metrics::measure(&measured, &run).unwrap();
        assert_eq!(
            figures.atlas.symmetric_dirichlet,
            unwrapped.metrics.atlas.figures.symmetric_dirichlet
        );
        assert!(figures.atlas.symmetric_dirichlet.is_some());
        assert_eq!(figures.atlas.seam_edges, unwrapped.metrics.atlas.figures.seam_edges);
        assert!(Faces::read(b"glTF", &surface, &telling).is_err());
    }

    #[test]
    fn runs_must_add_up() {
        let runs = |text: &str| spelled_out(&serde_json::from_str(text).unwrap(), 4);
        assert_eq!(runs("[[1, 2], [2, 0], [1, -1]]").unwrap(), [2, 0, 0, NONE]);
        for wrong in ["[[1, 2]]", "[[9, 2]]", "[[3, 2], [2, 1]]", "null"] {
            assert!(runs(wrong).is_err(), "{wrong}");
        }
    }
}
