//! What the OBJ reader promises.

use super::document::ObjDocument;
use super::read::{MOST_RUNS, read};
use crate::contract::{ErrorCode, Limits, Warning};
use crate::mesh::import::ImportError;
use crate::mesh::scene::ABSENT;

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0.5\nvn 0 0 2\n";

fn parse(text: &str) -> Result<(ObjDocument, Vec<Warning>), ImportError> {
    read(text.as_bytes(), &Limits::default())
}

fn faces(text: &str) -> Vec<[[u32; 3]; 3]> {
    let (document, _) = parse(&format!("{SQUARE}{text}")).unwrap();
    let run = &document.runs[0];
    let of = |list: &[[u32; 3]], f: usize| list.get(f).copied().unwrap_or([ABSENT; 3]);
    let face = |(f, at): (usize, &[u32; 3])| {
        let (texcoords, normals) = (of(&run.texcoords, f), of(&run.normals, f));
        [0, 1, 2].map(|k| [at[k], texcoords[k], normals[k]])
    };
    run.triangles.iter().enumerate().map(face).collect()
}

#[test]
fn every_form_of_index_is_read() {
    let a = ABSENT;
    assert_eq!(faces("f 1 2 3"), [[[0, a, a], [1, a, a], [2, a, a]]]);
    assert_eq!(faces("f 1/2 2/1 3/1"), [[[0, 1, a], [1, 0, a], [2, 0, a]]]);
    assert_eq!(faces("f 1//1 2//1 3//1"), [[[0, a, 0], [1, a, 0], [2, a, 0]]]);
    assert_eq!(faces("f 1/1/1 2/2/1 3/1/1"), [[[0, 0, 0], [1, 1, 0], [2, 0, 0]]]);
    assert_eq!(faces("f -4/-2/-1 -3// -2"), [[[0, 0, 0], [1, a, a], [2, a, a]]]);
    assert_eq!(faces("f 1 \\\r\n 2 3 # note"), [[[0, a, a], [1, a, a], [2, a, a]]]);
    let fan: Vec<_> = faces("f 1 2 3 4").iter().map(|f| f.map(|c| c[0])).collect();
    assert_eq!(fan, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(faces("f 5 1 2\nv 9 9 9\n")[0][0][0], 4);
}

#[test]
fn runs_follow_the_file() {
    let text = format!(
        "{SQUARE}usemtl a\ng x\nf 1 2 3\nusemtl b\nf 1 2 3\nf 1 2 4\no y z\nf 1 2 3\ng x\nf 1 2 3\nusemtl\nf 1 2 3"
    );
    let (document, warnings) = parse(&text).unwrap();
    let runs: Vec<_> =
        document.runs.iter().map(|r| (r.group, r.material, r.triangles.len())).collect();
    let expected =
        [(0, Some(0), 1), (0, Some(1), 2), (1, Some(1), 1), (2, Some(1), 1), (2, None, 1)];
    assert_eq!(runs, expected);
    assert_eq!(document.groups, ["x", "y z", "x"]);
    assert_eq!(document.materials, ["a", "b"]);
    assert_eq!(document.normals, [[0.0, 0.0, 1.0]]);
    assert!(warnings.is_empty());
    let scene = document.into_scene();
    let own: Vec<_> = scene.primitives.iter().map(|p| (p.node, p.mesh, p.number)).collect();
    assert_eq!(own, [(0, 0, 0), (0, 0, 1), (1, 1, 0), (2, 2, 0), (2, 2, 1)]);
    let third = &scene.primitives[2];
    assert_eq!((scene.name(third), scene.material_name(third)), ("y z", "b"));
}

#[test]
fn polygons_and_what_corners_lack_are_kept() {
    let text = format!("{SQUARE}vn 0 0 0\nf 1 2 3\nf 1/1/1 2/2/2 3/1/1 4\nf 1 3 4\ng x\nf 1 2 3\n");
    let scene = parse(&text).unwrap().0.into_scene();
    let [square, triangle] = &scene.primitives[..] else { panic!("two groups") };
    assert_eq!(square.polygons, Some(vec![3, 4, 3]));
    assert_eq!(square.triangles, [[0, 1, 2], [0, 1, 2], [0, 2, 3], [0, 2, 3]]);
    let corners = |name: &str| square.attribute(name).unwrap().corners.clone().unwrap();
    let none = [ABSENT; 3];
    assert_eq!(corners("TEXCOORD_0"), [none, [0, 1, 0], [0, 0, ABSENT], none]);
    // The second normal has no direction.
    assert_eq!(corners("NORMAL"), [none, [0, ABSENT, 0], [0, 0, ABSENT], none]);
    assert_eq!((&triangle.polygons, triangle.attributes.len()), (&None, 0));
}

#[test]
fn colors_stand_behind_positions() {
    let (document, warnings) = parse("v 0 0 0\nv 1 0 0 1 0.5 0\nv 0 1 0 nan 2 0\nf 1 2 3").unwrap();
    let colors = document.colors.unwrap();
    assert_eq!(colors, [[1.0; 3], [1.0, 0.5, 0.0], [1.0, 1.0, 0.0]]);
    assert_eq!(warnings[0].code.as_str(), "bad_colors");
    let (document, _) = parse("v 0 0 0 1.0\nv 1 0 0 1.0\nv 1 1 0 1.0\nf 1 2 3").unwrap();
    assert!(document.colors.is_none());
}

#[test]
fn errors_name_the_line() {
    let tail = SQUARE.lines().count() + 1;
    for text in [
        "f 1 2 9",
        "f 0 1 2",
        "f 1 2 -9",
        "f 1 2 x",
        "f 1/9 2 3",
        "f 1//9 2 3",
        "f /1 2 3",
        "f 1 2 99999999999",
        "f 1 2 4294967296",
        "v 1 2",
        "v 1 2 x",
        "v nan 0 0",
        "v inf 0 0",
        "v 1e300 0 0",
        "vn 1 2",
        "vt",
    ] {
        let error = parse(&format!("{SQUARE}{text}\nf 1 2 3\n")).unwrap_err();
        assert_eq!(error.code(), ErrorCode::InvalidMesh);
        assert!(error.to_string().starts_with(&format!("line {tail} ")), "{text}: {error}");
    }
}

#[test]
fn limits_hold_before_anything_grows() {
    let limits = Limits { triangles: 2, ..Limits::default() };
    let error = read(format!("{SQUARE}f 1 2 3 4\nf 1 2 3").as_bytes(), &limits).unwrap_err();
    assert_eq!(error.code(), ErrorCode::MeshTooLarge);
    let error = read("v 0 0 0\n".repeat(9).as_bytes(), &limits).unwrap_err();
    assert_eq!(error.code(), ErrorCode::MeshTooLarge);
    let toggled = "usemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\n".repeat(MOST_RUNS / 2 + 1);
    let error = parse(&format!("{SQUARE}{toggled}")).unwrap_err();
    assert_eq!(error.code(), ErrorCode::MeshTooLarge);
}

#[test]
fn what_can_be_passed_over_is() {
    let text =
        format!("{SQUARE}mtllib a.mtl\nl 1 2\np 1\ns off\ncurv 0 1\nf 1 2\nf 1 2 3\n\0\u{fffd}\n");
    let (document, warnings) = parse(&text).unwrap();
    assert_eq!(document.runs[0].triangles.len(), 1);
    let codes: Vec<_> = warnings.iter().map(|w| w.code.as_str()).collect();
    assert_eq!(codes, ["short_faces", "mtllib_ignored"]);
}
