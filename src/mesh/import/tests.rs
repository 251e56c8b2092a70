//! What import promises, on documents built here.

use glam::DVec3;
use proptest::prelude::*;
use serde_json::{Value, json};

use super::{ImportError, import};
use crate::contract::{ErrorCode, Limits, MeshKind};
use crate::mesh::export;
use crate::mesh::formats::gltf::fixture::{F32, Fixture, U8, glb, rich, squares, strip};
use crate::mesh::scene::{Component, Document, Scene, Values};

fn read(fixture: &Fixture) -> Result<Scene, ImportError> {
    import(&fixture.glb(), MeshKind::Glb, &Limits::default())
}

/// The world positions of each face's corners.
fn corners(scene: &Scene) -> Vec<[[f64; 3]; 3]> {
    let of = |p: &crate::mesh::scene::Primitive| {
        let at = |v: u32| p.position(v).to_array();
        p.triangles.iter().map(|t| t.map(at)).collect::<Vec<_>>()
    };
    scene.primitives.iter().flat_map(of).collect()
}

#[test]
fn a_document_of_everything_is_read_in_face_order() {
    let scene = read(&rich()).unwrap();
    let order: Vec<_> =
        scene.primitives.iter().map(|p| (p.node, p.mesh, p.number, p.triangles.len())).collect();
    assert_eq!(order, [(0, 0, 0, 2), (0, 0, 1, 4), (1, 1, 0, 3)]);
    assert_eq!(scene.name(&scene.primitives[0]), "bench");
    assert_eq!(scene.material_name(&scene.primitives[0]), "wood");
    let names = |p: usize| {
        scene.primitives[p].attributes.iter().map(|a| a.name.clone()).collect::<Vec<_>>()
    };
    let all = ["COLOR_0", "TEXCOORD_0", "NORMAL", "TANGENT", "JOINTS_0", "WEIGHTS_0"];
    assert_eq!(names(0), all);
    assert_eq!(names(2), ["_PART"]);
    let colors = &scene.primitives[0].attribute("COLOR_0").unwrap().values;
    assert_eq!((colors.component(), colors.is_normalized()), (Component::U8, true));
    assert_eq!((colors.count(), colors.vector::<3>(2)), (10, [8, 9, 10].map(|c| c as f64 / 255.0)));
    assert_eq!(scene.nodes[3].parent, Some(2));
    assert_eq!(scene.world(3).unwrap().w_axis.z, 0.5);
    assert_eq!(scene.meshes[2].name, "hidden");
    let corners = corners(&scene);
    assert_eq!(corners[2], [[2.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 1.0, 0.0]]);
    // The second instance is the larger one: integers × 0.5. A strip: the middle face is turned.
    assert_eq!(corners[6], [[0.0, 0.0, 0.0], [50.0, 0.0, 0.0], [0.0, 50.0, 0.0]]);
    assert_eq!(corners[7], [[0.0, 50.0, 0.0], [50.0, 0.0, 0.0], [50.0, 50.0, 0.0]]);
    assert_eq!(scene.labels, Some(vec![-1, -1, -1, -1, -1, -1, 4, 4, 4]));
    assert_eq!(scene.texture_sets, [0]);
    assert!(scene.warnings.is_empty());
}

#[test]
fn attributes_are_views_into_the_source() {
    let scene = read(&rich()).unwrap();
    let Some(Document::Gltf { buffers, .. }) = &scene.source else { panic!("a glTF document") };
    let held = buffers[0].as_ptr_range();
    let [first, second, _] = &scene.primitives[..] else { panic!("three primitives") };
    for values in first.attributes.iter().map(|a| &a.values).chain([&first.positions]) {
        let Values::View(view) = values else { panic!("a view") };
        assert!(held.contains(&view.get(0).as_ptr()));
    }
    let shared = |values: &Values| match values {
        Values::View(view) => std::sync::Arc::as_ptr(view),
        _ => panic!("a view"),
    };
    assert_eq!(shared(&first.positions), shared(&second.positions));
}

#[test]
fn labels_that_vary_over_a_face_are_told_and_left() {
    let mut f = squares();
    let parts = f.floats(&[[1.0], [1.0], [1.0], [1.0], [2.0], [1.0]]);
    f.json["meshes"][0]["primitives"][0]["attributes"]["_PART"] = json!(parts);
    let scene = read(&f).unwrap();
    assert_eq!(scene.labels, None);
    assert_eq!(scene.warnings[0].code.as_str(), "part_attribute_ignored");
}

#[test]
fn interleaved_and_sparse_positions_are_read() {
    let mut f = squares();
    let rows: Vec<[f32; 6]> = strip(2).iter().map(|p| [p[0], p[1], p[2], 0.0, 0.0, 1.0]).collect();
    let view = f.view(bytemuck::cast_slice(&rows));
    f.json["bufferViews"][view]["byteStride"] = json!(24);
    f.json["accessors"][0]["bufferView"] = json!(view);
    f.json["accessors"][1]["bufferView"] = json!(view);
    f.json["accessors"][1]["byteOffset"] = json!(12);
    assert_eq!(corners(&read(&f).unwrap()), corners(&read(&squares()).unwrap()));
    let keys = f.view(&[5]);
    let values = f.view(bytemuck::cast_slice(&[9.0f32, 9.0, 9.0]));
    f.json["accessors"][0]["sparse"] = json!({"count": 1,
        "indices": {"bufferView": keys, "componentType": U8}, "values": {"bufferView": values}});
    assert_eq!(corners(&read(&f).unwrap())[2][2], [9.0; 3]);
}

#[test]
fn data_uris_and_scenes_without_nodes_lists_are_read() {
    let f = squares();
    let mut json = f.json.clone();
    use base64::Engine;
    let data = base64::engine::general_purpose::STANDARD.encode(&f.bin);
    json["buffers"] = json!([{"byteLength": f.bin.len(), "uri": format!("data:;base64,{data}")}]);
    json.as_object_mut().unwrap().remove("scenes");
    let scene = import(json.to_string().as_bytes(), MeshKind::Gltf, &Limits::default()).unwrap();
    assert_eq!(corners(&scene), corners(&read(&f).unwrap()));
}

/// Squares with one value of the JSON replaced, read.
fn with(path: &str, value: Value) -> ImportError {
    let mut f = squares();
    let (parent, key) = path.rsplit_once('/').unwrap();
    f.json.pointer_mut(parent).unwrap()[key] = value;
    read(&f).unwrap_err()
}

#[test]
fn what_is_broken_is_named_with_its_place() {
    let primitive = json!({"attributes": {"POSITION": 0}, "indices": 2});
    let table = [
        ("/accessors/0/count", json!(1u64 << 62), "accessor 0 declares"),
        ("/accessors/0/count", json!(7), "run past the end of buffer view 0"),
        ("/accessors/0/count", json!(5), "NORMAL (accessor 1) has 6 elements"),
        ("/accessors/0/count", json!(-1), "accessors[0]"),
        ("/accessors/0/componentType", json!(U8), "must be VEC3 of F32"),
        ("/accessors/0/componentType", json!(1), "unknown componentType"),
        ("/accessors/0/type", json!("SCALAR"), "must be VEC3 of F32"),
        ("/accessors/0/type", json!("VEC9"), "unknown type"),
        ("/accessors/0/bufferView", json!(99), "buffer view 99 does not exist"),
        ("/accessors/0/byteOffset", json!(u64::MAX), "run past the end"),
        ("/accessors/1/count", json!(5), "NORMAL (accessor 1) has 5 elements"),
        ("/accessors/1/bufferView", json!(2), "NORMAL"),
        ("/accessors/2/componentType", json!(5120), "indices must be SCALAR"),
        ("/bufferViews/0/byteStride", json!(4), "byteStride 4"),
        ("/bufferViews/0/byteLength", json!(u64::MAX), "buffer view 0"),
        ("/bufferViews/0/byteOffset", json!(u64::MAX), "buffer view 0"),
        ("/bufferViews/0/buffer", json!(4), "buffer 4"),
        ("/meshes/0/primitives/0/mode", json!(7), "mode"),
        ("/meshes/0/primitives/0/material", json!(0), "material 0 does not exist"),
        ("/meshes/0/primitives/0/indices", json!(9), "accessor 9 does not exist"),
        ("/meshes/0/primitives/0/attributes", json!({"POSITION": "x"}), "meshes[0]"),
        ("/meshes/0/primitives", primitive, "meshes[0]"),
        ("/nodes/0/children", json!([0]), "cycles"),
        ("/nodes/0/scale", json!([1e38, 1, 1e300]), "finite"),
        ("/meshes", json!({}), "`meshes` must be an array"),
        ("/scene", json!(5), "scene 5 does not exist"),
        ("/scenes/0/nodes", json!([]), "no triangles"),
    ];
    for (path, value, word) in table {
        let error = with(path, value.clone());
        assert_eq!(error.code(), ErrorCode::InvalidMesh, "{path} = {value}: {error}");
        assert!(error.to_string().contains(word), "{path} = {value}: {error}");
    }
}

#[test]
fn indices_and_positions_are_checked_in_the_data() {
    let mut f = squares();
    let at = f.bin.len() - 2;
    f.bin[at] = 6;
    let error = read(&f).unwrap_err().to_string();
    assert!(error.contains("index 11 is 6 and there are 6 vertices"), "{error}");
    for bad in [f32::NAN, f32::INFINITY] {
        let mut f = squares();
        f.bin[4 * 3 * 4..][..4].copy_from_slice(&bad.to_le_bytes());
        let error = read(&f).unwrap_err();
        assert_eq!(error.code(), ErrorCode::InvalidMesh);
        assert!(error.to_string().contains("POSITION (accessor 0), vertex 4"), "{error}");
    }
}

#[test]
fn limits_count_what_is_declared() {
    let limits = |triangles| Limits { triangles, ..Limits::default() };
    let f = rich();
    let count = |n| import(&f.glb(), MeshKind::Glb, &limits(n)).map(|scene| scene.face_count());
    assert_eq!(count(9), Ok(9));
    assert_eq!(count(8).unwrap_err().code(), ErrorCode::MeshTooLarge);

    let mut f = squares();
    f.json["accessors"][0] =
        json!({"componentType": F32, "type": "VEC3", "count": 4_000_000_000u32});
    assert_eq!(read(&f).unwrap_err().code(), ErrorCode::MeshTooLarge);

    // A few bytes that ask for many: the same morph target over and over.
    let mut f = squares();
    f.json["meshes"][0]["primitives"][0]["targets"] = json!(vec![json!({"POSITION": 0}); 1000]);
    let small = Limits { upload_bytes: f.glb().len() as u64, ..Limits::default() };
    assert!(import(&f.glb(), MeshKind::Glb, &small).is_err());
    assert!(read(&f).is_ok());

    let small = Limits { json_bytes: 100, ..Limits::default() };
    let error = import(&f.glb(), MeshKind::Glb, &small).unwrap_err();
    assert_eq!(error.code(), ErrorCode::MeshTooLarge);
    let error = import(&f.glb(), MeshKind::Glb, &Limits { upload_bytes: 9, ..small }).unwrap_err();
    assert_eq!(error.code(), ErrorCode::MeshTooLarge);
}

#[test]
fn hidden_geometry_and_outside_files_have_codes_of_their_own() {
    let error = with("/extensionsRequired", json!(["KHR_draco_mesh_compression"]));
    assert_eq!(error.code(), ErrorCode::UnsupportedExtension);
    let error = with("/images", json!([{"uri": "https://example.org/wood.png"}]));
    assert_eq!(error.code(), ErrorCode::ExternalUriForbidden);
    let mut f = squares();
    f.json["meshes"][0]["primitives"][0]["extensions"] = json!({"KHR_draco_mesh_compression": {}});
    f.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(read(&f).unwrap_err().code(), ErrorCode::UnsupportedExtension);
}

#[test]
fn the_container_is_checked() {
    let whole = squares().glb();
    let error = |bytes: &[u8]| import(bytes, MeshKind::Glb, &Limits::default()).unwrap_err();
    for end in 0..whole.len() {
        assert_eq!(error(&whole[..end]).code(), ErrorCode::InvalidMesh, "{end}");
    }
    let mut old = whole.clone();
    old[4] = 1;
    assert!(error(&old).to_string().contains("version 1"));
    let mut turned = whole.clone();
    turned[16..20].copy_from_slice(b"BIN\0");
    assert!(error(&turned).to_string().contains("first chunk"));
    let mut longer = whole.clone();
    longer.extend([0; 5]);
    let scene = import(&longer, MeshKind::Glb, &Limits::default()).unwrap();
    assert_eq!(scene.warnings[0].code.as_str(), "passed_over");
    let not_json = glb(b"{\"asset\": ", b"");
    assert!(error(&not_json).to_string().contains("JSON"));
}

/// Import bytes, and if they are a scene, write it: neither may panic, and what was written reads
/// back as the same faces.
fn survive(bytes: &[u8], kind: MeshKind) {
    let limits = Limits { upload_bytes: 1 << 20, triangles: 10_000, ..Limits::default() };
    let Ok(scene) = import(bytes, kind, &limits) else { return };
    let uvs: Vec<[[f32; 2]; 3]> =
        (0..scene.face_count()).map(|f| [0.0, 0.25, 0.5].map(|x| [x, f as f32 * 0.01])).collect();
    let Ok(out) = export::glb(&scene, &uvs, 0, None) else { return };
    let again = import(&out, MeshKind::Glb, &Limits::default()).unwrap();
    let close = |a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]| {
        let near = |(a, b): (&[f64; 3], &[f64; 3])| {
            let (a, b) = (DVec3::from_array(*a), DVec3::from_array(*b));
            a.distance(b) <= 1e-6 * a.length()
        };
        a.iter().zip(b).all(near)
    };
    let (before, after) = (corners(&scene), corners(&again));
    assert!(before.len() == after.len() && before.iter().zip(&after).all(|(a, b)| close(a, b)));
}

/// The paths of all values inside a JSON value.
fn paths(value: &Value, path: String, out: &mut Vec<String>) {
    match value {
        Value::Object(map) => {
            map.iter().for_each(|(key, inner)| paths(inner, format!("{path}/{key}"), out));
        }
        Value::Array(list) => {
            list.iter().enumerate().for_each(|(i, inner)| paths(inner, format!("{path}/{i}"), out));
        }
        _ => {}
    }
    out.push(path);
}

fn odd_value() -> impl Strategy<Value = Value> {
    prop_oneof![
        (0u64..12).prop_map(Value::from),
        Just(json!(-1)),
        Just(json!(1u64 << 62)),
        Just(json!(u64::MAX)),
        Just(json!(0.5)),
        Just(json!(1e300)),
        Just(json!(null)),
        Just(json!("%FF")),
        Just(json!("data:;base64,%FF")),
        Just(json!([0, 1])),
        Just(json!({})),
        Just(json!("VEC2")),
        Just(json!("MAT3")),
        Just(json!(5120)),
        Just(json!(5125)),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn mutated_bytes_never_panic(
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        end in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut bytes = rich().glb();
        for (at, byte) in edits {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if let Some(end) = end {
            bytes.truncate(end.index(bytes.len()));
        }
        survive(&bytes, MeshKind::Glb);
    }

    #[test]
    fn mutated_json_never_panics(
        edits in prop::collection::vec((any::<prop::sample::Index>(), odd_value()), 1..4),
    ) {
        let mut f = rich();
        for (at, value) in edits {
            let mut all = Vec::new();
            paths(&f.json, String::new(), &mut all);
            if let Some(held) = f.json.pointer_mut(all[at.index(all.len())].as_str()) {
                *held = value;
            }
        }
        if f.json.is_object() {
            survive(&f.glb(), MeshKind::Glb);
        }
    }

    #[test]
    fn any_text_as_obj_never_panics(
        lines in prop::collection::vec("(v|f|vn|vt|g|usemtl|#) ?(-?[0-9]{1,2}[/. ]{0,2}){0,9}\\\\?", 0..40),
        noise in prop::collection::vec(any::<u8>(), 0..20),
    ) {
        let mut bytes = b"v 0 0 0\nv 1 0 0 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec();
        bytes.extend(lines.join("\n").bytes());
        survive(&bytes, MeshKind::Obj);
        bytes.extend(noise);
        survive(&bytes, MeshKind::Obj);
    }
}
