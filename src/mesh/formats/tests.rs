//! What the table of formats says of each is so.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::json;

use super::gltf::fixture::{Fixture, rich};
use crate::contract::{Carry, Limits, MeshKind};
use crate::mesh::{Primitive, Scene, export, import};

/// A document with all that a format can carry.
fn full() -> Fixture {
    let mut f = rich();
    let attributes = &mut f.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["TEXCOORD_1"] = attributes["TEXCOORD_0"].clone();
    f
}

const OBJ: &str = "o seat\nusemtl oak\nv 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n\
    f 1/1/1 2/1/1 3/1/1 4/1/1\n";

/// A file of each format.
fn sample(kind: MeshKind) -> Vec<u8> {
    match kind {
        MeshKind::Glb => full().glb(),
        MeshKind::Gltf => {
            let Fixture { mut json, bin } = full();
            let uri = format!("data:;base64,{}", STANDARD.encode(&bin));
            json["buffers"] = json!([{"byteLength": bin.len(), "uri": uri}]);
            json.to_string().into_bytes()
        }
        MeshKind::Obj => OBJ.into(),
    }
}

#[test]
fn every_format_is_told_and_read_and_carries_what_it_says() {
    for &kind in MeshKind::ALL {
        let bytes = sample(kind);
        assert_eq!(MeshKind::detect(&bytes), Some(kind));
        let scene = import(&bytes, kind, &Limits::default()).unwrap();
        for carry in kind.carries() {
            assert!(shows(&scene, *carry), "{kind:?} carries no {}", carry.as_str());
        }
    }
}

fn shows(scene: &Scene, carry: Carry) -> bool {
    let any = |shown: &dyn Fn(&Primitive) -> bool| scene.primitives.iter().any(shown);
    let attribute = |name| any(&|p| p.attribute(name).is_some());
    match carry {
        Carry::Hierarchy => scene.nodes.iter().any(|node| node.parent.is_some()),
        Carry::Names => any(&|p| !scene.name(p).is_empty()),
        Carry::Materials => any(&|p| !scene.material_name(p).is_empty()),
        Carry::Polygons => any(&|p| p.polygons.is_some()),
        Carry::Normals => attribute("NORMAL"),
        Carry::Colors => attribute("COLOR_0"),
        Carry::Texcoords => attribute("TEXCOORD_0"),
        Carry::TexcoordSets => attribute("TEXCOORD_0") && attribute("TEXCOORD_1"),
        Carry::Parts => scene.labels.is_some(),
    }
}

#[test]
fn what_is_written_is_glb_whatever_was_read() {
    let written: Vec<_> = MeshKind::ALL.iter().filter(|kind| kind.is_written()).collect();
    assert_eq!(written, [&MeshKind::Glb]);
    for &kind in MeshKind::ALL {
        let scene = import(&sample(kind), kind, &Limits::default()).unwrap();
        let uvs = vec![[[0.25, 0.5]; 3]; scene.face_count()];
        let file = export::glb(&scene, &uvs, 0, None).unwrap();
        assert_eq!(MeshKind::detect(&file), Some(MeshKind::Glb), "from {kind:?}");
    }
}
