//! Where charts stand: pages and tiles, densities, blocks, turns, materials, and which set of texture
//! coordinates they are written to. All of it is read from the GLB that ships.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;
use uvsegnet::contract::{
    ArtifactKind, AtlasGrouping, ErrorCode, Limits, MeshKind, Quality, Rotation, UnwrapOptions,
};
use uvsegnet::mesh;
use uvsegnet::pipeline::Unwrapped;

use super::{example, quick, unwrap, unwrap_example};

fn fast() -> UnwrapOptions {
    UnwrapOptions { quality: Quality::Fast, ..quick() }
}

/// `count` squares of side 1 beside each other, as OBJ; `before` says what stands before the faces of each.
fn squares(count: u32, before: impl Fn(u32) -> String) -> String {
    let square = |k: u32| {
        let (x, i) = (2 * k, 4 * k);
        let corners = [(x, 0), (x + 1, 0), (x + 1, 1), (x, 1)].map(|(x, y)| format!("v {x} {y} 0"));
        let face = format!("f {} {} {} {}", i + 1, i + 2, i + 3, i + 4);
        format!("{}\n{}{face}\n", corners.join("\n"), before(k))
    };
    (0..count).map(square).collect()
}

/// A face as it stands in a result.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Face {
    /// Its chart.
    chart: i64,
    /// Its material.
    material: Option<u32>,
    /// Its corners in pages, v up.
    uv: [DVec2; 3],
}

/// The faces of a result, in face order.
fn faces(result: &Unwrapped) -> Vec<Face> {
    let glb = result.artifact(ArtifactKind::Model).unwrap();
    let json = gltf::Gltf::from_slice(glb).unwrap().document.into_json();
    let extras: serde_json::Value =
        serde_json::from_str(json.asset.extras.as_ref().unwrap().get()).unwrap();
    let runs: Vec<(usize, i64)> =
        serde_json::from_value(extras["uvsegnet"]["face_charts"].clone()).unwrap();
    let charts = runs.into_iter().flat_map(|(count, chart)| std::iter::repeat_n(chart, count));
    let scene = mesh::import(glb, MeshKind::Glb, &Limits::default()).unwrap();
    let corners = scene
        .primitives
        .iter()
        .flat_map(|primitive| primitive.texcoords().unwrap().map(|uv| (primitive.material, uv)));
    let up = |[u, v]: [f32; 2]| DVec2::new(f64::from(u), 1.0 - f64::from(v));
    let faces: Vec<Face> = charts
        .zip(corners)
        .map(|(chart, (material, uv))| Face { chart, material, uv: uv.map(up) })
        .collect();
    assert_eq!(faces.len(), scene.face_count());
    faces
}

#[test]
fn pages_go_to_tiles_of_their_own_or_share_one() {
    // Twelve squares: each fills a page of its own.
    let squares = squares(12, |_| String::new());
    let on = |pages, udim| {
        unwrap(squares.as_bytes(), None, &UnwrapOptions { pages, udim, ..fast() }).unwrap()
    };
    let (one, many, apart) = (on(1, false), on(12, false), on(12, true));
    let density = |result: &Unwrapped| result.metrics.atlas.figures.texel_density.unwrap().mean;
    assert!(density(&many) > 3.0 * density(&one));
    for (result, udim) in [(&many, false), (&apart, true)] {
        let m = &result.metrics;
        assert!(m.atlas.certificate.valid);
        assert_eq!((m.atlas.pages, m.atlas.udim), (12, udim));
        let pages: BTreeSet<u32> = m.charts.iter().map(|c| c.page).collect();
        assert_eq!(pages, (0..12).collect());
        let tile = |p: DVec2| 1001 + p.x.floor() as u32 + 10 * p.y.floor() as u32;
        let tiles: Vec<[u32; 3]> = faces(result).iter().map(|face| face.uv.map(tile)).collect();
        assert!(tiles.iter().all(|t| t.iter().all(|&tile| tile == t[0])), "no triangle is torn");
        let tiles: BTreeSet<u32> = tiles.iter().map(|t| t[0]).collect();
        assert_eq!(tiles, if udim { (1001..1013).collect() } else { [1001].into() });
        let layout = std::str::from_utf8(result.artifact(ArtifactKind::Layout).unwrap()).unwrap();
        assert_eq!(layout.matches("<rect").count(), 12);
    }
}

#[test]
fn parts_get_the_density_that_was_asked_for() {
    let with = |density: &str| {
        let options = UnwrapOptions { density: Some(density.to_owned()), ..fast() };
        let bytes = std::fs::read(example("table.glb")).unwrap();
        unwrap(&bytes, None, &options)
    };
    let even = with("").unwrap().metrics;
    let name = even.parts[1].name.clone();
    assert_eq!(even.parts.iter().filter(|p| p.name == name).count(), 1);
    let m = with(&format!("0=2,{name}=0.5")).unwrap().metrics;
    assert!(m.atlas.certificate.valid);
    let density = |part: usize| m.parts[part].figures.texel_density.unwrap().mean;
    assert!((density(0) / density(2) - 2.0).abs() < 0.03, "{}", density(0) / density(2));
    assert!((density(1) / density(2) - 0.5).abs() < 0.01, "{}", density(1) / density(2));
    let error = with("lamp=2").unwrap_err();
    assert_eq!(error.job_error().unwrap().code, ErrorCode::InvalidOption);
    let said = error.to_string();
    assert!(said.contains("lamp") && said.contains(&name) && said.contains("`density`"), "{said}");
}

/// Whether a triangle and a square of side 1 overlap: no side of either separates them.
fn overlaps(t: &[DVec2; 3], low: DVec2) -> bool {
    let corners = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y].map(|corner| low + corner);
    let sides = (0..3).map(|k| (t[(k + 1) % 3] - t[k]).perp());
    sides.chain([DVec2::X, DVec2::Y]).all(|axis| {
        let span = |points: &[DVec2]| {
            let along = points.iter().map(|p| p.dot(axis));
            along.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)))
        };
        let (a, b) = (span(t), span(&corners));
        a.0 < b.1 && b.0 < a.1
    })
}

/// Blocks of 4 × 4 texels that more than one chart touches, on one page.
fn shared_blocks(faces: &[Face], page_size: u32) -> usize {
    let mut charts: BTreeMap<(i64, i64), BTreeSet<i64>> = BTreeMap::new();
    for face in faces {
        let t = face.uv.map(|p| p * f64::from(page_size / 4));
        let low = t[0].min(t[1]).min(t[2]).floor().as_i64vec2();
        let high = t[0].max(t[1]).max(t[2]).floor().as_i64vec2();
        for (x, y) in (low.x..=high.x).flat_map(|x| (low.y..=high.y).map(move |y| (x, y))) {
            if overlaps(&t, DVec2::new(x as f64, y as f64)) {
                charts.entry((x, y)).or_default().insert(face.chart);
            }
        }
    }
    charts.values().filter(|charts| charts.len() > 1).count()
}

#[test]
fn charts_keep_to_blocks_when_asked() {
    for name in ["table.glb", "chair_small.glb"] {
        let shared = |block_align| {
            let result = unwrap_example(name, &UnwrapOptions { block_align, ..fast() });
            assert!(result.metrics.atlas.certificate.valid, "{name}");
            shared_blocks(&faces(&result), 1024)
        };
        assert_eq!(shared(true), 0, "{name}");
        // The same charts share blocks where nothing was asked.
        assert!(shared(false) > 0, "{name}");
    }
}

/// By how much each chart is turned against where it stood before: quarter turns, 0 to 4.
fn turns(before: &[Face], after: &[Face]) -> Vec<f64> {
    let edge = |face: &Face, k: usize| face.uv[(k + 1) % 3] - face.uv[k];
    let mut longest: BTreeMap<i64, (f64, f64)> = BTreeMap::new();
    for (a, b) in before.iter().zip(after) {
        assert_eq!(a.chart, b.chart, "these are not the same charts");
        for k in 0..3 {
            let turn = edge(a, k).angle_to(edge(b, k)) / std::f64::consts::FRAC_PI_2;
            let length = edge(a, k).length();
            let entry = longest.entry(a.chart).or_default();
            if length > entry.0 {
                *entry = (length, turn.rem_euclid(4.0));
            }
        }
    }
    longest.into_values().map(|(_, turn)| turn).collect()
}

#[test]
fn charts_are_turned_as_freely_as_asked() {
    let with = |rotation| {
        let result = unwrap_example("table.glb", &UnwrapOptions { rotation, ..fast() });
        assert!(result.metrics.atlas.certificate.valid);
        faces(&result)
    };
    let [none, quarter, free] = [Rotation::None, Rotation::Quarter, Rotation::Free].map(with);
    let is_whole = |turn: &f64| (turn - turn.round()).abs() < 1e-3;
    let quarters = turns(&none, &quarter);
    assert!(quarters.iter().all(is_whole), "{quarters:?}");
    assert!(quarters.iter().any(|turn| turn.round() % 4.0 != 0.0), "no chart is turned");
    // Were either of the two options dropped, all would be turned freely.
    let freely = turns(&none, &free);
    assert!(!freely.iter().all(is_whole), "{freely:?}");
    assert!(!turns(&quarter, &free).iter().all(is_whole));
}

#[test]
fn each_material_has_an_atlas_when_asked() {
    // Squares of three materials, and one square whose halves differ.
    let material = |k: u32| format!("usemtl {}\n", ["oak", "steel", "felt"][k as usize % 3]);
    let halves =
        "v 0 3 0\nv 1 3 0\nv 1 4 0\nv 0 4 0\nusemtl oak\nf 37 38 39\nusemtl felt\nf 37 39 40\n";
    let text = squares(9, material) + halves;
    let labels = "0\n".repeat(20);
    let with = |atlas| {
        let options = UnwrapOptions { atlas, ..fast() };
        unwrap(text.as_bytes(), Some(labels.as_bytes()), &options).unwrap()
    };
    // Material of each chart, and of each page; 9 where there are several.
    let materials = |result: &Unwrapped| {
        let (mut of_chart, mut of_page) = (BTreeMap::new(), BTreeMap::new());
        for face in faces(result) {
            let page = result.metrics.charts[face.chart as usize].page;
            let material = face.material.unwrap();
            for met in [
                of_chart.entry(face.chart).or_insert(material),
                of_page.entry(i64::from(page)).or_insert(material),
            ] {
                *met = if *met == material { material } else { 9 };
            }
        }
        let known = |of: BTreeMap<i64, u32>| of.into_values().collect::<Vec<u32>>();
        (known(of_chart), known(of_page))
    };
    let (apart, together) = (with(AtlasGrouping::Material), with(AtlasGrouping::Scene));
    assert!(apart.metrics.atlas.certificate.valid && together.metrics.atlas.certificate.valid);
    assert_eq!((apart.metrics.atlas.pages, together.metrics.atlas.pages), (3, 1));
    let (charts, mut pages) = materials(&apart);
    pages.sort_unstable();
    assert_eq!((charts.len(), pages), (11, vec![0, 1, 2]));
    assert!(!charts.contains(&9), "{charts:?}");
    let (charts, pages) = materials(&together);
    assert_eq!((charts.len(), pages), (10, vec![9]));
    assert_eq!(charts.iter().filter(|&&material| material == 9).count(), 1, "the two halves");
}

/// A set of texture coordinates at the corners of each face, as it stands in a file.
fn texcoords(glb: &[u8], set: u32) -> Option<Vec<[[f32; 2]; 3]>> {
    let file = gltf::Gltf::from_slice(glb).unwrap();
    let mut corners = Vec::new();
    for primitive in file.meshes().flat_map(|m| m.primitives()) {
        let reader = primitive.reader(|_| file.blob.as_deref());
        let uvs: Vec<[f32; 2]> = reader.read_tex_coords(set)?.into_f32().collect();
        let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
        corners.extend(indices.chunks_exact(3).map(|t| [0, 1, 2].map(|k| uvs[t[k] as usize])));
    }
    Some(corners)
}

#[test]
fn a_set_of_texture_coordinates_that_was_not_asked_for_stays() {
    let first = unwrap_example("table.glb", &fast());
    let first = first.artifact(ArtifactKind::Model).unwrap();
    // Another arrangement, in the second set.
    let options = UnwrapOptions { uv_channel: 1, rotation: Rotation::None, ..fast() };
    let second = unwrap(first, None, &options).unwrap();
    assert!(second.metrics.atlas.certificate.valid);
    let second = second.artifact(ArtifactKind::Model).unwrap();
    let before = texcoords(first, 0).unwrap();
    assert_eq!(texcoords(first, 1), None);
    assert_eq!(texcoords(second, 0).unwrap(), before);
    let written = texcoords(second, 1).unwrap();
    assert_eq!(written.len(), before.len());
    assert_ne!(written, before);
    // It is the set that a job without the option would have written.
    let plain = unwrap(first, None, &UnwrapOptions { uv_channel: 0, ..options }).unwrap();
    let plain = texcoords(plain.artifact(ArtifactKind::Model).unwrap(), 0).unwrap();
    assert_eq!(written, plain);
}
