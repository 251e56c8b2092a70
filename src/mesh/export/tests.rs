//! What export promises, on documents built here.

use bytes::Bytes;
use proptest::prelude::*;
use serde_json::{Value, json};

use super::{ExportError, as_exported, glb, part_glb};
use crate::contract::{Limits, MeshKind};
use crate::mesh::formats::gltf::fixture::{Fixture, U8, rich, squares};
use crate::mesh::formats::gltf::view::GltfView;
use crate::mesh::import::import;
use crate::mesh::scene::{Document, Scene};

fn read(bytes: &[u8]) -> Scene {
    import(bytes, MeshKind::Glb, &Limits::default()).unwrap()
}

/// Coordinates of their own for each face: every vertex is split at every face.
fn apart(faces: usize) -> Vec<[[f32; 2]; 3]> {
    (0..faces)
        .map(|f| {
            [[0.0, 0.0], [0.01, 0.0], [0.0, 0.01]].map(|[u, v]| [u + f as f32 * 0.05, v + 0.3])
        })
        .collect()
}

/// The planar map: a vertex has one coordinate wherever it stands.
fn planar(scene: &Scene) -> Vec<[[f32; 2]; 3]> {
    let of = |p: &crate::mesh::scene::Primitive| {
        let uv = |v: u32| [p.position(v).x as f32 / 8.0, p.position(v).y as f32 / 8.0];
        p.triangles.iter().map(|t| t.map(uv)).collect::<Vec<_>>()
    };
    scene.primitives.iter().flat_map(of).collect()
}

fn gltf(scene: &Scene) -> (&Value, &[Bytes]) {
    match &scene.source {
        Some(Document::Gltf { json, buffers }) => (json, buffers),
        None => panic!("a glTF document"),
    }
}

/// The values of an attribute of a primitive at the corners of its faces, and its accessor.
fn attribute(scene: &Scene, mesh: usize, primitive: usize, path: &str) -> (Vec<Vec<f64>>, Value) {
    let (json, buffers) = gltf(scene);
    let view = GltfView::new(json, buffers).unwrap();
    let of = &json["meshes"][mesh]["primitives"][primitive];
    let accessor = of.pointer(path).unwrap().as_u64().unwrap() as usize;
    let values = view.elements(accessor, path).unwrap();
    let wide = values.shape.multiplicity();
    let at = |v: usize| (0..wide).map(|k| values.value(v, k)).collect::<Vec<_>>();
    let corners = match of.get("indices").and_then(Value::as_u64) {
        Some(indices) => {
            let indices = view.elements(indices as usize, "indices").unwrap();
            (0..indices.count).map(|i| at(indices.index(i) as usize)).collect()
        }
        None => (0..values.count).map(at).collect(),
    };
    (corners, json["accessors"][accessor].clone())
}

#[test]
fn vertices_split_only_at_seams() {
    let scene = read(&squares().glb());
    let count = |uvs: &[[[f32; 2]; 3]]| {
        let out = read(&glb(&scene, uvs, 0, None).unwrap());
        attribute(&out, 0, 0, "/attributes/POSITION").1["count"].as_u64().unwrap()
    };
    let mut uvs = planar(&scene);
    assert_eq!(count(&uvs), 6);
    // A seam between the two squares: two vertices stand on it.
    for corner in uvs[2..].as_flattened_mut() {
        corner[1] += 0.5;
    }
    assert_eq!(count(&uvs), 8);
    assert_eq!(count(&apart(4)), 12);
}

#[test]
fn coordinates_come_back_in_face_order_with_v_down_in_the_file() {
    let scene = read(&rich().glb());
    let uvs = apart(scene.face_count());
    let out = read(&glb(&scene, &uvs, 0, None).unwrap());
    let mut found = Vec::new();
    for p in &out.primitives {
        let place = (p.mesh as usize, p.number as usize);
        found.extend(attribute(&out, place.0, place.1, "/attributes/TEXCOORD_0").0);
    }
    let expected: Vec<_> =
        uvs.as_flattened().iter().map(|[u, v]| vec![f64::from(*u), f64::from(1.0 - v)]).collect();
    assert_eq!(found, expected);
}

#[test]
fn everything_else_is_carried() {
    let before = read(&rich().glb());
    let after = read(&glb(&before, &apart(before.face_count()), 0, None).unwrap());
    let paths = [
        (0, "/attributes/POSITION"),
        (0, "/attributes/COLOR_0"),
        (0, "/attributes/NORMAL"),
        (0, "/attributes/JOINTS_0"),
        (0, "/attributes/WEIGHTS_0"),
        (0, "/targets/0/POSITION"),
        (1, "/attributes/TANGENT"),
        (1, "/targets/0/POSITION"),
    ];
    for (primitive, path) in paths {
        let (old, old_accessor) = attribute(&before, 0, primitive, path);
        let (new, accessor) = attribute(&after, 0, primitive, path);
        assert_eq!(old, new, "{path}");
        for key in ["componentType", "type", "normalized"] {
            assert_eq!(accessor.get(key), old_accessor.get(key), "{path} {key}");
        }
        assert_eq!(accessor.get("sparse").is_some(), old_accessor.get("sparse").is_some());
    }
    // Tangents follow the set that was replaced, and only where there was one.
    assert!(gltf(&after).0["meshes"][0]["primitives"][0]["attributes"].get("TANGENT").is_none());
    // A strip becomes a list of triangles; points and lines stay.
    let modes =
        |mesh: usize, p: usize| gltf(&after).0["meshes"][mesh]["primitives"][p]["mode"].clone();
    assert_eq!((modes(1, 0), modes(1, 1), modes(0, 2)), (json!(4), json!(0), json!(1)));
    for (mesh, primitive) in [(0, 2), (1, 1), (2, 0)] {
        let path = "/attributes/POSITION";
        assert_eq!(
            attribute(&before, mesh, primitive, path).0,
            attribute(&after, mesh, primitive, path).0
        );
    }
    assert_eq!(after.labels, before.labels);
    let (old, new) = (gltf(&before).0, gltf(&after).0);
    for list in ["nodes", "scenes", "scene", "materials", "textures", "extras", "extensionsUsed"] {
        assert_eq!(old.get(list), new.get(list), "{list}");
    }
    assert_eq!(new["meshes"][0]["primitives"][0]["extras"], json!({"keep": 1}));
    assert_eq!(new["meshes"][2]["name"], "hidden");
    let image = |scene: &Scene| {
        let (json, buffers) = gltf(scene);
        let view = json["images"][0]["bufferView"].as_u64().unwrap() as usize;
        GltfView::new(json, buffers).unwrap().view_slice(view).unwrap().to_vec()
    };
    assert_eq!(image(&after), b"not really a png");
    for (path, list) in
        [("/skins/0/inverseBindMatrices", 16), ("/animations/0/samplers/0/output", 3)]
    {
        let values = |scene: &Scene| {
            let (json, buffers) = gltf(scene);
            let accessor = json.pointer(path).unwrap().as_u64().unwrap() as usize;
            let view = GltfView::new(json, buffers).unwrap();
            let e = view.elements(accessor, path).unwrap();
            (0..e.count)
                .flat_map(|i| (0..list).map(move |k| (i, k)))
                .map(|(i, k)| e.stored(i, k))
                .collect::<Vec<_>>()
        };
        assert_eq!(values(&after), values(&before), "{path}");
    }
}

#[test]
fn nothing_stale_is_left_behind() {
    // What a pass wrote is what the next one replaces, so the file does not grow.
    let pass = |scene: &Scene| glb(scene, &apart(scene.face_count()), 0, None).unwrap();
    let scene = read(&rich().glb());
    let once = read(&pass(&scene));
    let twice = pass(&once);
    assert_eq!(pass(&read(&twice)).len(), twice.len());
    let size = |scene: &Scene, list: &str| gltf(scene).0[list].as_array().unwrap().len();
    assert!(size(&once, "bufferViews") < size(&scene, "bufferViews"));
    // Three primitives with new coordinates; one loses its tangents.
    assert_eq!(size(&once, "accessors"), 25);
}

#[test]
fn other_sets_stay_and_gaps_are_filled() {
    let scene = read(&rich().glb());
    let out = read(&glb(&scene, &apart(scene.face_count()), 2, None).unwrap());
    let attributes = |p: usize| gltf(&out).0["meshes"][0]["primitives"][p]["attributes"].clone();
    let (old, _) = attribute(&scene, 0, 0, "/attributes/TEXCOORD_0");
    assert_eq!(attribute(&out, 0, 0, "/attributes/TEXCOORD_0").0, old);
    assert!(attributes(0).get("TANGENT").is_some());
    assert_eq!(attributes(0)["TEXCOORD_1"], attributes(0)["TEXCOORD_2"]);
    assert_eq!(attributes(1)["TEXCOORD_0"], attributes(1)["TEXCOORD_2"]);
}

#[test]
fn bounds_are_those_of_the_written_positions() {
    let scene = read(&rich().glb());
    let out = read(&glb(&scene, &apart(scene.face_count()), 0, None).unwrap());
    let (_, accessor) = attribute(&out, 0, 1, "/attributes/POSITION");
    assert_eq!(
        (&accessor["min"], &accessor["max"]),
        (&json!([2.0, 0.0, 0.0]), &json!([4.0, 1.0, 0.0]))
    );
    let (_, accessor) = attribute(&out, 1, 0, "/attributes/POSITION");
    assert_eq!((&accessor["min"], &accessor["max"]), (&json!([0, 0, 0]), &json!([100, 200, 0])));
}

#[test]
fn parts_are_read_back_as_labels_and_all_else_stays() {
    let before = read(&rich().glb());
    let parts: Vec<i32> = (0..before.face_count() as i32).map(|f| f % 5 - 1).collect();
    let after = read(&part_glb(&before, &parts, Some(&json!({"parts": 4}))).unwrap());
    assert_eq!(after.labels.as_deref(), Some(parts.as_slice()));
    assert_eq!(gltf(&after).0["asset"]["extras"]["uvsegnet"]["parts"], 4);
    for (old, new) in before.primitives.iter().zip(&after.primitives) {
        let corners = |p: &crate::mesh::scene::Primitive| {
            let of = |t: &[u32; 3]| t.map(|v| p.position(v));
            p.triangles.iter().map(of).collect::<Vec<_>>()
        };
        assert_eq!(corners(old), corners(new));
        let names = |scene: &Scene, p: &crate::mesh::scene::Primitive| {
            let of = &gltf(scene).0["meshes"][p.mesh as usize]["primitives"][p.number as usize];
            let names = of["attributes"].as_object().unwrap().keys().cloned();
            names.filter(|n| n != "_PART").collect::<Vec<_>>()
        };
        assert_eq!(names(&before, old), names(&after, new));
        for name in names(&before, old) {
            let at = |scene| {
                attribute(
                    scene,
                    old.mesh as usize,
                    old.number as usize,
                    &format!("/attributes/{name}"),
                )
                .0
            };
            if old.triangles.len() * 3 == at(&before).len() {
                assert_eq!(at(&before), at(&after), "{name}");
            }
        }
    }
    let error = part_glb(&before, &parts[1..], None).unwrap_err();
    assert!(matches!(error, ExportError::FaceCount { .. }), "{error}");
}

#[test]
fn parts_of_an_obj_leave_its_texture_coordinates() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
        f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";
    let scene = import(text.as_bytes(), MeshKind::Obj, &Limits::default()).unwrap();
    let out = read(&part_glb(&scene, &[7, 2], None).unwrap());
    assert_eq!(out.labels, Some(vec![7, 2]));
    let (uvs, _) = attribute(&out, 0, 0, "/attributes/TEXCOORD_0");
    assert_eq!(uvs[1], [1.0, 1.0], "v points down in glTF");
    assert_eq!(attribute(&out, 0, 0, "/attributes/_PART").1["type"], "SCALAR");
}

#[test]
fn extras_go_under_the_asset() {
    let scene = read(&squares().glb());
    let extras = json!({"parts": [3, 1]});
    let out = read(&glb(&scene, &planar(&scene), 0, Some(&extras)).unwrap());
    assert_eq!(gltf(&out).0["asset"]["extras"]["uvsegnet"], extras);
    let again = read(&glb(&out, &planar(&out), 0, Some(&json!(7))).unwrap());
    assert_eq!(gltf(&again).0["asset"]["extras"], json!({"uvsegnet": 7}));
}

#[test]
fn wide_indices_where_narrow_ones_do_not_reach() {
    let soup = |faces: usize| {
        let mut f = Fixture::new();
        let corners: Vec<[f32; 3]> =
            (0..faces as u32 * 3).map(|i| [i as f32, (i % 3) as f32, (i % 2) as f32]).collect();
        let positions = f.floats(&corners);
        f.show(json!([{"attributes": {"POSITION": positions}}]));
        let scene = read(&f.glb());
        let out = read(&glb(&scene, &vec![[[0.0; 2]; 3]; faces], 0, None).unwrap());
        let points = |scene: &Scene| {
            let shown = &scene.primitives[0];
            (0..shown.positions.count() as u32).map(|v| shown.position(v)).collect::<Vec<_>>()
        };
        assert_eq!(points(&out), points(&scene));
        attribute(&out, 0, 0, "/indices").1["componentType"].clone()
    };
    assert_eq!(soup(21_845), json!(5123)); // 65,535 vertices
    assert_eq!(soup(21_846), json!(5125));
}

#[test]
fn several_buffers_become_one() {
    let mut f = squares();
    let image = f.view(b"picture");
    f.json["bufferViews"][image] =
        json!({"buffer": 1, "byteOffset": 1, "byteLength": 7, "name": "here"});
    f.json["images"] = json!([{"bufferView": image, "mimeType": "image/png"}]);
    f.json["buffers"] =
        json!([{"byteLength": f.bin.len()}, {"byteLength": 8, "uri": "data:,xpicture"}]);
    let bytes = crate::mesh::formats::gltf::fixture::glb(f.json.to_string().as_bytes(), &f.bin);
    let scene = read(&bytes);
    let out = read(&glb(&scene, &planar(&scene), 0, None).unwrap());
    let (json, buffers) = gltf(&out);
    assert_eq!(buffers.len(), 1);
    let view = json["images"][0]["bufferView"].as_u64().unwrap() as usize;
    assert_eq!(json["bufferViews"][view]["name"], "here");
    assert_eq!(GltfView::new(json, buffers).unwrap().view_slice(view).unwrap(), b"picture"[..]);
}

#[test]
fn obj_becomes_a_document_of_its_own() {
    let text = "mtllib x.mtl\ng seat\nusemtl oak\nv 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n\
        vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 3\nf 1/1/1 2/2/1 3/3/1\nusemtl pine\nf 1 3 4\ng back\nf 1/1 2/1 4/1\n";
    let scene = import(text.as_bytes(), MeshKind::Obj, &Limits::default()).unwrap();
    let uvs = planar(&scene);
    let out = read(&glb(&scene, &uvs, 1, None).unwrap());
    let json = gltf(&out).0;
    let name = |list: &str| {
        json[list].as_array().unwrap().iter().map(|n| n["name"].clone()).collect::<Vec<_>>()
    };
    assert_eq!(name("nodes"), ["seat", "back"]);
    assert_eq!(name("materials"), ["oak", "pine"]);
    let order: Vec<_> = out.primitives.iter().map(|p| (p.mesh, p.number, p.material)).collect();
    assert_eq!(order, [(0, 0, Some(0)), (0, 1, Some(1)), (1, 0, Some(1))]);
    for (before, after) in scene.primitives.iter().zip(&out.primitives) {
        let at = |p: &crate::mesh::scene::Primitive| {
            p.triangles.iter().map(|t| t.map(|v| p.position(v).to_array())).collect::<Vec<_>>()
        };
        assert_eq!(at(before), at(after));
    }
    let keys = |mesh: usize, p: usize| {
        let attributes = json["meshes"][mesh]["primitives"][p]["attributes"].as_object().unwrap();
        attributes.keys().cloned().collect::<Vec<_>>()
    };
    assert_eq!(keys(0, 0), ["POSITION", "NORMAL", "COLOR_0", "TEXCOORD_0", "TEXCOORD_1"]);
    assert_eq!(keys(0, 1), ["POSITION", "COLOR_0", "TEXCOORD_0", "TEXCOORD_1"]);
    let file = attribute(&out, 0, 0, "/attributes/TEXCOORD_0").0;
    assert_eq!(file, [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0]]);
    let given = attribute(&out, 0, 0, "/attributes/TEXCOORD_1").0;
    assert_eq!(given, [[0.0, 1.0], [0.125, 1.0], [0.125, 0.875]]);
    assert_eq!(attribute(&out, 0, 0, "/attributes/NORMAL").0[0], [0.0, 0.0, 1.0]);
    assert_eq!(attribute(&out, 0, 0, "/attributes/COLOR_0").0[..2], [[1.0, 0.0, 0.0], [1.0; 3]]);
}

#[test]
fn wrong_coordinates_are_refused() {
    let scene = read(&squares().glb());
    let error = glb(&scene, &apart(3), 0, None).unwrap_err();
    assert_eq!(error, ExportError::FaceCount { faces: 4, given: 3 });
    let mut uvs = apart(4);
    uvs[2][1][0] = f32::NAN;
    assert_eq!(glb(&scene, &uvs, 0, None).unwrap_err(), ExportError::NotFinite { face: 2 });
}

#[test]
fn a_compressed_copy_beside_the_data_goes() {
    let mut f = squares();
    let packed = f.view(&[1, 2, 3]);
    f.json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    f.json["meshes"][0]["primitives"][0]["extensions"] = json!({"KHR_draco_mesh_compression": {"bufferView": packed, "attributes": {"POSITION": 0}}});
    let scene = read(&f.glb());
    let out = read(&glb(&scene, &planar(&scene), 0, None).unwrap());
    assert!(gltf(&out).0["meshes"][0]["primitives"][0].get("extensions").is_none());
}

#[test]
fn matrices_keep_the_padding_of_their_columns() {
    let mut f = squares();
    let bytes: Vec<u8> = (0..72).collect();
    let matrices = f.accessor(U8, "MAT3", 6, &bytes);
    f.json["meshes"][0]["primitives"][0]["attributes"]["_TURN"] = json!(matrices);
    let scene = read(&f.glb());
    let out = read(&glb(&scene, &planar(&scene), 0, None).unwrap());
    let (json, buffers) = gltf(&out);
    let view = GltfView::new(json, buffers).unwrap();
    let index = json["meshes"][0]["primitives"][0]["attributes"]["_TURN"].as_u64().unwrap();
    let elements = view.elements(index as usize, "_TURN").unwrap();
    assert_eq!((0..6).flat_map(|i| elements.get(i).to_vec()).collect::<Vec<_>>(), bytes);
}

proptest! {
    #[test]
    fn exported_coordinates_survive_another_round(u in 0.0f32..=1.0, v in 0.0f32..=1.0) {
        let [a, b] = as_exported([u, v]);
        prop_assert_eq!(as_exported([a, b]), [a, b]);
        prop_assert!(a == u && (b - v).abs() <= f32::EPSILON / 2.0);
        // What a reader computes in double precision is the same number.
        prop_assert_eq!(1.0 - f64::from(1.0 - v), f64::from(b));
    }
}

#[test]
fn numbers_of_a_document_come_back_as_they_were() {
    for text in ["0.9019607843137255", "-36.17963027954102", "0.08848590403795242", "1e-7", "3"] {
        let value: Value = serde_json::from_str(text).unwrap();
        assert_eq!(value.to_string(), text);
    }
}
