//! The first stages: condition, sample, segment. They end in two values: what the result indexes, and
//! what the solvers see.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::dense_components::DenseComponents;
use super::densities::densities;
use super::engine::Engine;
use super::error::Cause;
use super::regions::Segmented;
use crate::charts::{Chart, ChartOptions};
use crate::coarse_to_fine;
use crate::contract::{
    Canceled, GaveUp, Run, Scarce, SegmentationSource, Stage, UnwrapOptions, WarningCode, Winding,
};
use crate::mesh::{
    self, Conditioned, ImportError, NONE, Proxy, ProxySize, Scene, Surface, Telling,
};
use crate::sampling::{self, PointCloud, SampleCounts};
use crate::segmentation::{self, PartLabels, SegmentOptions};
use crate::tasks;

/// What the result indexes: the surface face for face, and its parts.
pub struct Found {
    /// The conditioned surface; of what is delivered, all sides that have coordinates.
    pub surface: Arc<Surface>,
    /// How the file tells it.
    pub telling: Telling,
    /// Its parts.
    pub parts: PartLabels,
    /// SHA-256 of the network's weights, where it was asked for the parts.
    pub weights: Option<String>,
    /// Texel density of each part relative to the others.
    pub densities: Vec<f64>,
    /// Its dense components.
    pub dense: DenseComponents,
}

/// What the solvers see: the surface that is cut, its samples, and the parts on it.
pub struct Solvers {
    /// The surface: the conditioned one, or its proxy.
    pub surface: Arc<Surface>,
    /// How it goes back to the conditioned surface, where it is a proxy.
    pub proxy: Option<Proxy>,
    /// The dense cloud on it.
    pub cloud: PointCloud,
    /// Part of each face.
    pub part_of: Vec<u32>,
}

impl Found {
    /// The surface with its parts.
    #[cfg(test)]
    pub fn segmented(&self) -> Segmented<'_> {
        Segmented { surface: &self.surface, labels: &self.parts.labels }
    }
}

impl Solvers {
    /// The surface with its parts.
    pub fn segmented(&self) -> Segmented<'_> {
        Segmented { surface: &self.surface, labels: &self.part_of }
    }

    /// Charts of this surface as charts of the conditioned one.
    pub fn refined(
        &self,
        charts: Vec<Chart>,
        found: &Found,
        options: &UnwrapOptions,
        run: &Run,
    ) -> Result<Vec<Chart>, Canceled> {
        let Some(proxy) = &self.proxy else { return Ok(charts) };
        let parts = [&found.parts.labels[..], &self.part_of];
        let how = ChartOptions { pinches: false, ..options.into() };
        coarse_to_fine::charts(&found.surface, proxy, charts, parts, &how, run)
    }
}

/// Parts of a proxy carried to the surface. Each keeps at least the faces that its proxy's are left of.
fn carried(surface: &Surface, proxy: &Proxy, of_proxy: &[u32]) -> Vec<u32> {
    let mut labels =
        tasks::link("parts carried", || coarse_to_fine::labels(surface, proxy, of_proxy));
    let count = of_proxy.iter().filter(|l| **l != NONE).max().map_or(0, |&most| most as usize + 1);
    let mut has = vec![false; count];
    labels.iter().filter(|l| **l != NONE).for_each(|&l| has[l as usize] = true);
    for (&face, &part) in proxy.left_of.iter().zip(of_proxy).filter(|(_, l)| **l != NONE) {
        if !has[part as usize] {
            labels[face as usize] = part;
        }
    }
    labels
}

/// Condition, sample, segment.
pub fn find(
    scene: &Scene,
    options: &UnwrapOptions,
    engine: &Engine,
    run: &Run,
) -> Result<(Found, Solvers), Cause> {
    run.stage(Stage::Condition)?;
    let Conditioned { surface, telling } = mesh::condition(scene, options.winding, run)?;
    run.count(surface.face_count());
    let surface = Arc::new(surface);
    check_area(scene, &surface)?;
    if options.winding == Winding::File {
        warn_of_windings(&surface, run);
    }
    // What is dense is looked at and cut as a coarser surface that stands for it.
    let size = ProxySize::default();
    let proxy = mesh::proxy(&surface, size, run)?;
    let dense = DenseComponents::of(&surface, proxy.as_ref(), size);
    let seen = proxy.as_ref().map_or(&surface, |proxy| &proxy.surface).clone();
    run.stage(Stage::Sample)?;
    let counts = SampleCounts::dense(seen.face_count());
    let cloud = sampling::sample(&seen, counts, options.seed.0, run)?;
    run.count(cloud.len());
    run.stage(Stage::Segment)?;
    let asked = SegmentOptions::from(options);
    let how = affordable(asked, &seen, run);
    let parts = segmentation::segment(&seen, &cloud, &how, &engine.weights, &engine.device, run)?;
    let part_of = parts.labels.clone();
    let parts = match &proxy {
        Some(proxy) => PartLabels { labels: carried(&surface, proxy, &part_of), ..parts },
        None => parts,
    };
    let found = Found {
        weights: how.hears_network(&seen).then(|| engine.weights.digest().to_owned()),
        densities: densities(&parts.parts, options)?,
        surface,
        telling,
        parts,
        dense,
    };
    run.parts(0, found.parts.parts.len() as u32);
    Ok((found, Solvers { surface: seen, proxy, cloud, part_of }))
}

/// Share of an object's size that neighbouring numbers may be apart.
const FEW_STEPS: f64 = 0.02;

/// An error where no face has area: there is nothing to unwrap.
fn check_area(scene: &Scene, surface: &Surface) -> Result<(), ImportError> {
    if surface.face_count() > 0 {
        return Ok(());
    }
    let count = scene.face_count();
    let corners = scene
        .primitives
        .iter()
        .flat_map(|primitive| primitive.triangles.iter().flatten().map(|&v| primitive.position(v)));
    let far = corners.map(|p| p.abs().max_element()).fold(0.0, f64::max);
    // What single precision, which most files hold, tells apart at that distance.
    let step = far * f64::from(f32::EPSILON);
    if far > 0.0 && step > FEW_STEPS * surface.diagonal {
        return Err(ImportError::Invalid(format!(
            "none of the mesh's {count} faces has an area: it lies {far:.3e} from the origin, where single \
             precision tells places {step:.1e} apart and no nearer. Move the object to the origin in your tool \
             and export it again"
        )));
    }
    let holder = scene.primitives.iter().find(|primitive| !primitive.triangles.is_empty());
    let first = holder.map_or_else(String::new, |primitive| match scene.name(primitive) {
        "" => ", the first is face 0".to_owned(),
        name => format!(", the first is face 0 of {name:?}"),
    });
    Err(ImportError::Invalid(format!(
        "none of the mesh's {count} faces has an area{first}: its corners are in one place or on one line. \
         Repair the mesh"
    )))
}

/// Share of edges between faces that are wound against each other from which on it is told.
const TOLD: f64 = 0.02;

/// Tell that windings tear charts apart, where they count.
fn warn_of_windings(surface: &Surface, run: &Run) {
    let mut borders: BTreeMap<[u32; 2], Vec<bool>> = BTreeMap::new();
    for h in (0u32..).zip(&surface.twin).filter(|(_, t)| **t == NONE).map(|(h, _)| h) {
        let (from, to) = (surface.from(h), surface.to(h));
        borders.entry([from.min(to), from.max(to)]).or_default().push(from < to);
    }
    let against = borders.values().filter(|ways| matches!(ways[..], [a, b] if a == b)).count();
    let edges = surface.twin.len().div_ceil(2);
    if against as f64 >= TOLD * edges as f64 && against > 0 {
        let message = format!(
            "at {against} of {edges} edges the faces are wound against each other, and charts end there: ask for \
             `winding=surface`, or recalculate the normals in your tool and unwrap it again"
        );
        run.warn(WarningCode::MixedWindings, message);
    }
}

/// The segmentation that there is time for: without the network parts are the file's own.
fn affordable(asked: SegmentOptions, surface: &Surface, run: &Run) -> SegmentOptions {
    if !asked.hears_network(surface) || !run.is_late(Stage::Sample) {
        return asked;
    }
    run.give_up(Stage::Segment, GaveUp::Network, Scarce::Time);
    SegmentOptions { source: SegmentationSource::Authored, ..asked }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::{AtlasGrouping, Degradation, ErrorCode};
    use crate::pipeline::{regions, scenes};

    fn asked(segmentation: SegmentationSource) -> UnwrapOptions {
        UnwrapOptions { segmentation, ..scenes::options() }
    }

    #[test]
    fn a_mesh_without_area_is_refused_with_its_first_face() {
        let flat = "o wire\nv 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\nf 1 1 2\n";
        let run = Run::quiet();
        let error = find(&scenes::scene(flat), &scenes::options(), &scenes::engine(), &run);
        let error = error.err().unwrap().of(&run).job_error().unwrap();
        assert_eq!(error.code, ErrorCode::InvalidMesh);
        let said = "none of the mesh's 2 faces has an area, the first is face 0 of \"wire\"";
        assert!(error.message.starts_with(said), "{}", error.message);
    }

    #[test]
    fn what_single_precision_does_not_hold_is_refused_with_where_it_lies() {
        // Neighbouring numbers in single precision are 8 apart there.
        let far = "v 1e8 0 0\nv 100000001 0 0\nv 1e8 1 0\nf 1 2 3\n";
        let run = Run::quiet();
        let error = find(&scenes::scene(far), &scenes::options(), &scenes::engine(), &run);
        let error = error.err().unwrap().of(&run).job_error().unwrap();
        assert_eq!(error.code, ErrorCode::InvalidMesh);
        for said in ["1.000e8 from the origin", "1.2e1 apart", "Move the object to the origin"] {
            assert!(error.message.contains(said), "{}", error.message);
        }
    }

    #[test]
    fn windings_are_told_where_charts_end_at_them() {
        let codes = |text: &str, winding| {
            let run = Run::quiet();
            scenes::found(text, &UnwrapOptions { winding, ..scenes::options() }, &run);
            run.warnings().iter().map(|w| w.code).collect::<Vec<_>>()
        };
        let sheet = scenes::sheet(10, |_, _| 0.0);
        assert_eq!(codes(&sheet, Winding::File), []);
        let turned = sheet.lines().enumerate().map(|(i, line)| {
            let mut words: Vec<&str> = line.split(' ').collect();
            if words[0] == "f" && i % 3 == 0 {
                words[1..].reverse();
            }
            words.join(" ") + "\n"
        });
        let turned: String = turned.collect();
        assert_eq!(codes(&turned, Winding::File), [WarningCode::MixedWindings]);
        assert_eq!(codes(&turned, Winding::Surface), []);
    }

    #[test]
    fn the_weights_are_told_where_the_network_was_heard() {
        let (run, engine) = (Run::quiet(), scenes::engine());
        let told = |text: &str, labels: Option<Vec<i32>>, segmentation| {
            let mut scene = scenes::scene(text);
            scene.labels = labels;
            find(&scene, &asked(segmentation), &engine, &run).unwrap().0.weights
        };
        let digest = Some(engine.weights.digest().to_owned());
        assert_eq!(told(scenes::CUBE, None, SegmentationSource::Auto), digest);
        assert_eq!(told(scenes::CUBE, None, SegmentationSource::Learned), digest);
        for source in [SegmentationSource::Authored, SegmentationSource::Geometric] {
            assert_eq!(told(scenes::CUBE, None, source), None, "{source}");
        }
        // Given labels are taken as they are.
        assert_eq!(told(scenes::CUBE, Some(vec![3; 12]), SegmentationSource::Auto), None);
        assert!(run.budget.degraded().is_empty());
    }

    #[test]
    fn the_network_is_given_up_when_it_is_late() {
        for (seconds, heard) in [(10, true), (22, false)] {
            let run = scenes::late(seconds);
            let (found, _) = scenes::found(scenes::CUBE, &asked(SegmentationSource::Auto), &run);
            assert_eq!(found.weights.is_some(), heard);
            let (stage, scarce) = (Stage::Segment, Scarce::Time);
            let given_up = Degradation { stage, gave_up: GaveUp::Network, scarce };
            assert_eq!(run.budget.degraded().contains(&given_up), !heard);
            let authored = found.parts.parts[0].source == SegmentationSource::Authored;
            assert!(heard || authored, "the parts are the file's own");
        }
        // Who does not ask for it gives up nothing.
        let run = scenes::late(22);
        scenes::found(scenes::CUBE, &asked(SegmentationSource::Authored), &run);
        assert!(run.budget.degraded().is_empty());
    }

    #[test]
    fn what_charts_may_not_cross_are_parts_and_if_asked_materials() {
        // A square of two materials.
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\n";
        for (atlas, atlases) in
            [(AtlasGrouping::Scene, vec![0]), (AtlasGrouping::Material, vec![0, 1])]
        {
            let mut scene = scenes::scene(text);
            scene.labels = Some(vec![5, 5]);
            let options = UnwrapOptions { atlas, ..asked(SegmentationSource::Labels) };
            let (found, solvers) =
                find(&scene, &options, &scenes::engine(), &Run::quiet()).unwrap();
            assert_eq!(found.parts.parts.len(), 1);
            assert_eq!(regions::divide(&found, &found.segmented(), atlas).atlas, atlases);
            assert_eq!(solvers.part_of, [0, 0]);
        }
    }
}
