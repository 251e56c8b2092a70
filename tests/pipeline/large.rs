//! A mesh of exactly the most triangles that are taken, within the memory that a job has by default.

use uvsegnet::contract::{
    ArtifactKind, Budget, Cancel, Limits, Run, SegmentationSource, UnwrapOptions,
};
use uvsegnet::device::Device;
use uvsegnet::pipeline::{Engine, Input, unwrap_input};

use super::glb::glb;
use super::kind_of;

/// Memory of a job by default, MiB.
const MEMORY: u64 = 6144;

/// A torus of `n` × `n` cells of two triangles, as GLB.
fn torus(n: u32) -> Vec<u8> {
    let turn = |i: u32| (std::f32::consts::TAU * i as f32 / n as f32).sin_cos();
    let mut bin = Vec::new();
    for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
        let ((around, along), (up, out)) = (turn(i), turn(j));
        let radius = 1.0 + 0.4 * out;
        for x in [radius * along, radius * around, 0.4 * up] {
            bin.extend(x.to_le_bytes());
        }
    }
    let positions = bin.len();
    let vertex = |i: u32, j: u32| j % n * n + i % n;
    for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
        let [a, b, c, d] =
            [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| vertex(i, j));
        [a, b, c, a, c, d].into_iter().for_each(|v| bin.extend(v.to_le_bytes()));
    }
    let document = serde_json::json!({
        "asset": { "version": "2.0" },
        "buffers": [{ "byteLength": bin.len() }],
        "bufferViews": [
            { "buffer": 0, "byteLength": positions },
            { "buffer": 0, "byteOffset": positions, "byteLength": bin.len() - positions },
        ],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": n * n, "type": "VEC3",
              "min": [-1.4, -1.4, -0.4], "max": [1.4, 1.4, 0.4] },
            { "bufferView": 1, "componentType": 5125, "count": 6 * n * n, "type": "SCALAR" },
        ],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "nodes": [{ "mesh": 0 }],
        "scenes": [{ "nodes": [0] }],
        "scene": 0,
    });
    glb(&document, &bin)
}

#[test]
fn two_million_triangles_come_out_valid() {
    let most = Limits::default().triangles;
    assert_eq!(most, 2_000_000);
    let bytes = torus(1000);
    let run = Run::new(|_| {}, Cancel::default(), Budget::new(None, MEMORY));
    let options =
        UnwrapOptions { segmentation: SegmentationSource::Authored, ..Default::default() };
    let input = Input::new(kind_of(&bytes), &bytes);
    let engine = Engine::new(Device::cpu());
    let result = unwrap_input(&input, &options, &Limits::default(), &engine, &run).unwrap();
    let m = &result.metrics;
    assert!(m.atlas.certificate.valid, "{:?}", m.atlas.certificate);
    assert_eq!(m.charts.iter().map(|c| c.faces).sum::<u64>(), most);
    assert!(m.charts.len() <= 12, "{} charts", m.charts.len());
    let dense = m.atlas.coarse_to_fine.unwrap();
    assert_eq!((dense.components, dense.as_they_are), (1, 0));
    assert!(dense.carried_area.unwrap() >= 0.99, "{dense:?}");
    assert!(m.degraded.is_empty(), "{:?}", m.degraded);
    assert!(result.artifact(ArtifactKind::Preview).is_some());
}
