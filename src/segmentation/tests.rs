//! Parts of shapes whose parts are known, and what every segmentation promises.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DVec3, IVec3};
use proptest::prelude::*;

use super::fusion::CUT;
use super::*;
use crate::contract::ErrorCode;
use crate::device::Device;
use crate::mesh::NONE;
use crate::sampling::{SampleCounts, sample};

/// A surface of triangles whose half-edges pair by their vertices; each body is a component and a
/// primitive of its own.
fn surface(bodies: &[(Vec<DVec3>, Vec<[u32; 3]>)]) -> Surface {
    let mut s = Surface::default();
    for (number, (positions, triangles)) in (0u32..).zip(bodies) {
        let base = s.positions.len() as u32;
        s.positions.extend(positions);
        s.triangles.extend(triangles.iter().map(|t| t.map(|v| v + base)));
        let origin = crate::mesh::FaceOrigin { primitive: number, ..Default::default() };
        s.origins.resize(s.triangles.len(), origin);
        s.names.push(format!("body_{number}"));
    }
    let mut edges = BTreeMap::new();
    for (f, t) in (0u32..).zip(&s.triangles) {
        for k in 0..3 {
            edges.insert((t[k], t[(k + 1) % 3]), 3 * f + k as u32);
        }
    }
    let back = s.triangles.iter().flat_map(|t| (0..3).map(|k| (t[(k + 1) % 3], t[k])));
    s.twin = back.map(|e| edges.get(&e).copied().unwrap_or(NONE)).collect();
    let cross: Vec<DVec3> = (0..s.triangles.len())
        .map(|f| s.corners(f))
        .map(|[a, b, c]| (b - a).cross(c - a))
        .collect();
    s.normals = cross.iter().map(|c| c.normalize_or_zero()).collect();
    s.areas = cross.iter().map(|c| 0.5 * c.length()).collect();
    s.sheet_mate = vec![NONE; cross.len()];
    let bound = |f: fn(DVec3, DVec3) -> DVec3| s.positions.iter().copied().reduce(f).unwrap();
    s.diagonal = bound(DVec3::max).distance(bound(DVec3::min));
    s
}

/// The surface of a set of unit cubes, each square two triangles.
fn voxels(set: &BTreeSet<[i32; 3]>) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut ids: BTreeMap<[i32; 3], u32> = BTreeMap::new();
    let (mut positions, mut triangles) = (vec![], vec![]);
    for &cell in set {
        for axis in 0..3 {
            for side in [0, 1] {
                let mut next = cell;
                next[axis] += 2 * side - 1;
                if set.contains(&next) {
                    continue;
                }
                let unit = |a: usize| IVec3::AXES[a % 3];
                let (u, v) = (unit(axis + 1), unit(axis + 2));
                let at = IVec3::from_array(cell) + side * unit(axis);
                let mut quad = [at, at + u, at + u + v, at + v].map(|p| {
                    *ids.entry(p.to_array()).or_insert_with(|| {
                        positions.push(p.as_dvec3());
                        positions.len() as u32 - 1
                    })
                });
                if side == 0 {
                    quad.reverse();
                }
                let [a, b, c, d] = quad;
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    (positions, triangles)
}

fn block(low: [i32; 3], high: [i32; 3]) -> BTreeSet<[i32; 3]> {
    let span = |a: usize| low[a]..high[a];
    span(0).flat_map(|x| span(1).flat_map(move |y| span(2).map(move |z| [x, y, z]))).collect()
}

/// A tall block on a wide one, in one body.
fn joined() -> Surface {
    surface(&[voxels(&(&block([0, 0, 0], [12, 3, 12]) | &block([4, 3, 4], [8, 15, 8])))])
}

/// Asked with the weights that ship.
fn ask(
    s: &Surface,
    cloud: &PointCloud,
    source: SegmentationSource,
    cut: f64,
) -> Result<PartLabels, SegmentationError> {
    let options = SegmentOptions { source, cut };
    segment(s, cloud, &options, &Weights::shipped(), &Device::cpu(), &Run::quiet())
}

fn parts_of(s: &Surface, source: SegmentationSource) -> PartLabels {
    let run = Run::quiet();
    let cloud = sample(s, SampleCounts::dense(s.face_count()), 1, &run).unwrap();
    ask(s, &cloud, source, CUT).unwrap()
}

/// Every face has a part, parts are connected and numbered in order of first face, names
/// are unique.
fn assert_sound(s: &Surface, found: &PartLabels) {
    assert_eq!(assert_numbered(s, found), found.parts.len());
}

/// The same of parts that may be several components that touch; returns how many components there are.
fn assert_numbered(s: &Surface, found: &PartLabels) -> usize {
    assert_eq!(found.labels.len(), s.face_count());
    let mut seen = 0;
    for (f, &l) in found.labels.iter().enumerate() {
        assert_ne!(l, NONE, "face {f}");
        if l != NONE {
            assert!(l <= seen, "part {l} comes before part {seen}");
            seen += u32::from(l == seen);
        }
    }
    assert_eq!(seen as usize, found.parts.len());
    let names: BTreeSet<_> = found.parts.iter().map(|p| &p.name).collect();
    assert_eq!(names.len(), found.parts.len(), "{:?}", found.parts);
    let mut reached = vec![false; s.face_count()];
    let mut components = 0;
    for seed in 0..s.face_count() {
        if reached[seed] {
            continue;
        }
        components += 1;
        let mut stack = vec![seed];
        reached[seed] = true;
        while let Some(f) = stack.pop() {
            let mates = [s.sheet_mate[f]].into_iter().filter(|&m| m != NONE);
            let across = (0..3).map(|k| s.twin[3 * f + k]).filter(|&t| t != NONE).map(|t| t / 3);
            for g in across.chain(mates).map(|g| g as usize) {
                if !reached[g] && found.labels[g] == found.labels[f] {
                    reached[g] = true;
                    stack.push(g);
                }
            }
        }
    }
    components
}

#[test]
fn two_blocks_in_one_component_come_apart_in_the_valley() {
    let s = joined();
    let found = parts_of(&s, SegmentationSource::Geometric);
    assert_sound(&s, &found);
    assert_eq!(found.parts.len(), 2);
    assert!(found.parts.iter().all(|p| p.source == SegmentationSource::Geometric));
    assert!(found.parts.iter().all(|p| p.confidence > 0.7), "a right-angled valley is sure");
    for f in 0..s.face_count() {
        let tall = s.centroid(f).y > 3.0;
        let floor = found.labels[0];
        assert_eq!(found.labels[f] == floor, !tall, "face {f} at {}", s.centroid(f));
    }
}

#[test]
fn a_ledge_in_one_plane_is_no_part() {
    // The tall block is flush with the wide one on one side: no valley closes around it, and the
    // strips between the valleys' ends are no parts either.
    let s = surface(&[voxels(&(&block([0, 0, 0], [12, 3, 12]) | &block([0, 3, 4], [4, 15, 8])))]);
    let found = parts_of(&s, SegmentationSource::Geometric);
    assert_sound(&s, &found);
    assert!(found.parts.len() <= 2, "{:?}", found.parts);
}

/// A closed solid of revolution about y: (radius, height) from the bottom upwards.
fn turned(profile: &[(f64, f64)], sides: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (mut positions, mut triangles) = (vec![], vec![]);
    for &(r, y) in profile {
        for j in 0..sides {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(j) / f64::from(sides)).sin_cos();
            positions.push(DVec3::new(r * cos, y, -r * sin));
        }
    }
    let rings = profile.len() as u32;
    for i in 0..rings - 1 {
        for j in 0..sides {
            let k = (j + 1) % sides;
            let (a, b) = (i * sides + j, i * sides + k);
            triangles.extend([[a, b, b + sides], [a, b + sides, a + sides]]);
        }
    }
    for (ring, up) in [(0, false), (rings - 1, true)] {
        let centre = positions.len() as u32;
        positions.push(DVec3::new(0.0, profile[ring as usize].1, 0.0));
        for j in 0..sides {
            let (a, b) = (ring * sides + j, ring * sides + (j + 1) % sides);
            triangles.push(if up { [centre, a, b] } else { [centre, b, a] });
        }
    }
    (positions, triangles)
}

#[test]
fn a_stem_and_a_cap_are_two_parts_and_a_turned_leg_is_one() {
    let stem = (0..8).map(|i| (1.0, 0.5 * f64::from(i)));
    let cap = (0..6).map(|i| (3.0 - 0.05 * f64::from(i), 3.5 + 0.4 * f64::from(i)));
    let profile: Vec<(f64, f64)> = stem.chain([(2.0, 3.5)]).chain(cap).collect();
    let found = parts_of(&surface(&[turned(&profile, 24)]), SegmentationSource::Geometric);
    assert_eq!(found.parts.len(), 2, "{:?}", found.parts);

    let waves: Vec<(f64, f64)> =
        (0..40).map(|i| f64::from(i) / 4.0).map(|y| (1.0 + 0.25 * y.sin(), y)).collect();
    let found = parts_of(&surface(&[turned(&waves, 24)]), SegmentationSource::Geometric);
    assert_eq!(found.parts.len(), 1, "{:?}", found.parts);
}

#[test]
fn what_the_author_said_is_kept() {
    let box_at = |x: i32| voxels(&block([x, 0, 0], [x + 2, 2, 2]));
    let mut s = surface(&[box_at(0), box_at(2), box_at(9)]);
    s.names = vec!["leg".into(), "leg".into(), "seat".into()];
    let found = parts_of(&s, SegmentationSource::Authored);
    assert_sound(&s, &found);
    let names: Vec<_> = found.parts.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["leg_1", "leg_2", "seat"]);
    assert!(found.parts.iter().all(|p| p.source == SegmentationSource::Authored));
    assert!(found.parts.iter().all(|p| p.confidence > 0.8));
    // A name that a number would make twice is passed over.
    s.names = vec!["leg".into(), "leg".into(), "leg_1".into()];
    assert_sound(&s, &parts_of(&s, SegmentationSource::Authored));
}

#[test]
fn unknown_labels_are_filled_in_and_known_ones_kept() {
    let mut s = joined();
    let known = |f: usize, s: &Surface| match s.centroid(f).y {
        y if y > 6.0 => 7,
        y if y < 2.0 => 4,
        _ => -1,
    };
    s.labels = Some((0..s.face_count()).map(|f| known(f, &s)).collect());
    for source in [SegmentationSource::Labels, SegmentationSource::Auto] {
        let found = parts_of(&s, source);
        assert_sound(&s, &found);
        let mut names: Vec<_> = found.parts.iter().map(|p| p.name.as_str()).collect();
        names.sort_unstable();
        assert_eq!(names, ["label_4", "label_7"]);
        for f in 0..s.face_count() {
            // The cheapest border is the valley between.
            let name = &found.parts[found.labels[f] as usize].name;
            let want = if s.centroid(f).y > 3.0 { "label_7" } else { "label_4" };
            assert_eq!(name, want, "face {f} at {}", s.centroid(f));
        }
    }
}

#[test]
fn a_component_without_labels_is_a_part_that_says_so() {
    let box_at = |x: i32| voxels(&block([x, 0, 0], [x + 2, 2, 2]));
    let mut s = surface(&[box_at(0), box_at(9)]);
    let half = s.face_count() / 2;
    s.labels = Some((0..2 * half).map(|f| if f < half { 0 } else { -1 }).collect());
    let found = parts_of(&s, SegmentationSource::Labels);
    assert_sound(&s, &found);
    assert_eq!(found.parts[1].name, "unlabelled");
    assert_eq!(found.parts[1].confidence, 0.0);
}

#[test]
fn components_of_one_label_are_separate_parts() {
    let box_at = |x: i32| voxels(&block([x, 0, 0], [x + 2, 2, 2]));
    let mut s = surface(&[box_at(0), box_at(9)]);
    s.labels = Some(vec![3; s.face_count()]);
    let found = parts_of(&s, SegmentationSource::Labels);
    assert_sound(&s, &found);
    let names: Vec<_> = found.parts.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["label_3_1", "label_3_2"]);
}

#[test]
fn a_deeper_cut_gives_more_parts() {
    let asked = UnwrapOptions::default().part_boundary;
    assert_eq!(asked, CUT, "the benchmark measures what a user gets");
    let s = joined();
    let cloud = sample(&s, SampleCounts::dense(s.face_count()), 1, &Run::quiet()).unwrap();
    let found = |cut| {
        let auto = SegmentationSource::Auto;
        ask(&s, &cloud, auto, cut).unwrap()
    };
    assert!(found(CUT).coarser(1.0).iter().all(|&g| g == 0));
    assert!(found(0.05).parts.len() >= found(CUT).parts.len());
    assert_eq!(found(1.0).parts.len(), 1);
}

#[test]
fn what_cannot_be_done_is_an_invalid_option() {
    let mut s = joined();
    let run = Run::quiet();
    let cloud = sample(&s, SampleCounts::dense(s.face_count()), 1, &run).unwrap();
    let error = |s: &Surface, source| ask(s, &cloud, source, CUT).unwrap_err();
    assert_eq!(error(&s, SegmentationSource::Labels), SegmentationError::NoLabels);
    s.labels = Some(vec![-1; s.face_count()]);
    assert_eq!(error(&s, SegmentationSource::Labels), SegmentationError::NoneKnown);
    let further = parts_of(&s, SegmentationSource::Auto);
    assert!(further.parts.iter().all(|p| p.source != SegmentationSource::Labels));
    s.labels = Some(vec![0; 3]);
    assert_eq!(error(&s, SegmentationSource::Labels).code(), ErrorCode::InvalidOption);
    run.cancel.cancel();
    let authored = SegmentOptions { source: SegmentationSource::Authored, cut: CUT };
    let canceled =
        segment(&s, &cloud, &authored, &Weights::shipped(), &Device::cpu(), &run).unwrap_err();
    assert!(matches!(canceled, SegmentationError::Canceled(_)));
}

#[test]
fn nothing_gives_nothing() {
    let s = Surface { diagonal: 1.0, ..Default::default() };
    for source in [SegmentationSource::Auto, SegmentationSource::Geometric] {
        let found = ask(&s, &Default::default(), source, CUT).unwrap();
        assert!(found.parts.is_empty() && found.labels.is_empty());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn every_segmentation_is_sound(
        cells in prop::collection::btree_set((0..5i32, 0..5i32, 0..5i32), 4..60),
        given in prop::collection::vec(-1..4i32, 20),
        source in prop::sample::select(vec![
            SegmentationSource::Auto, SegmentationSource::Geometric,
            SegmentationSource::Authored, SegmentationSource::Labels,
        ]),
    ) {
        let cells = cells.into_iter().map(|(x, y, z)| [x, y, z]).collect();
        let mut s = surface(&[voxels(&cells)]);
        // Edges of four faces pair at random here: twins may be one-sided.
        for h in 0..s.twin.len() {
            let t = s.twin[h];
            if t != NONE && s.twin[t as usize] != h as u32 {
                s.twin[h] = NONE;
            }
        }
        let n = s.face_count();
        if source == SegmentationSource::Labels {
            s.labels = Some((0..n).map(|f| given[f * 7 % 20]).collect());
            prop_assume!(s.labels.iter().flatten().any(|&l| l >= 0));
        }
        let found = parts_of(&s, source);
        if source == SegmentationSource::Auto {
            prop_assert!(assert_numbered(&s, &found) >= found.parts.len());
        } else {
            assert_sound(&s, &found);
        }
        prop_assert_eq!(&found, &parts_of(&s, source));
        if let Some(labels) = &s.labels {
            // Given labels are never changed.
            for f in (0..n).filter(|&f| labels[f] >= 0) {
                let name = &found.parts[found.labels[f] as usize].name;
                let of_label = format!("label_{}", labels[f]);
                let numbered = format!("{of_label}_");
                prop_assert!(*name == of_label || name.starts_with(&numbered), "{}", name);
            }
        }
    }
}
