//! The authored components of a file, and which of them are alike. A shell,
//! faces that are connected by the file's own vertices, may be a thing that stands beside others, as a
//! screen in its frame does, or a smooth area of a file that splits vertices at hard edges, as most
//! exporters do for normals. What tells them apart: who splits at hard edges leaves none inside a file
//! component. Where they say nothing, the welded components are taken instead.

use std::collections::{BTreeMap, HashMap};

use crate::mesh::{DisjointSets, NONE, Surface};

/// Edges that bend more than this are hard (radians).
const HARD: f64 = 0.7;

/// From this share of hard edges inside shells on, these are the authored ones. Of labelled
/// authored objects, parts end at 60 % of the length between shells where the share is higher,
/// at 1 % where it is lower, and few objects lie between 0.3 and 0.6.
const INSIDE: f64 = 0.6;

/// Areas are alike that, in order of size, follow each other within this share.
const ALIKE: f64 = 0.004;

/// Authored components of a surface.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct AuthoredComponents {
    /// Authored component of each face.
    pub of_face: Vec<u32>,
    /// Area of each, world units squared.
    pub areas: BTreeMap<u32, f64>,
    /// Whether they are the shells, and there are several; if not, they are the welded ones.
    pub told: bool,
    /// Root of the probability that two places lie on different ones: 0 for one, whatever specks are
    /// beside it, near 1 for many of a size.
    pub apart: f64,
}

impl AuthoredComponents {
    /// The authored components of a surface whose `welded` ones are known.
    pub fn new(surface: &Surface, welded: &[u32]) -> Self {
        let told = hard_inside(surface) >= INSIDE;
        let of_face = if told {
            number(surface, |h, t| shell(surface, h) == shell(surface, t))
        } else {
            welded.to_vec()
        };
        let mut areas = BTreeMap::new();
        for (&own, area) in of_face.iter().zip(&surface.areas).filter(|(s, _)| **s != NONE) {
            *areas.entry(own).or_default() += area;
        }
        let all = areas.values().sum::<f64>().max(f64::MIN_POSITIVE);
        let same: f64 = areas.values().map(|a| (a / all).powi(2)).sum();
        Self { of_face, told: told && areas.len() > 1, apart: (1.0 - same).max(0.0).sqrt(), areas }
    }

    /// Whether an edge is between two of them.
    pub fn differ(&self, h: u32, twin: u32) -> bool {
        self.of_face[h as usize / 3] != self.of_face[twin as usize / 3]
    }
}

/// Authored components that are alike in area, such as the keys of a keyboard or the legs of a chair.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Alike {
    /// Group of each face's component.
    pub of_face: Vec<u32>,
    /// Components of each group.
    pub components: Vec<u32>,
}

impl Alike {
    /// Group the components.
    pub fn new(components: &AuthoredComponents) -> Self {
        let mut order: Vec<(u32, f64)> = components.areas.iter().map(|(s, a)| (*s, *a)).collect();
        order.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        let mut counts: Vec<u32> = Vec::new();
        let mut last = f64::NEG_INFINITY;
        let mut group = HashMap::new();
        for (own, area) in order {
            match counts.last_mut() {
                Some(count) if area <= last * (1.0 + ALIKE) => *count += 1,
                _ => counts.push(1),
            }
            last = area;
            group.insert(own, counts.len() as u32 - 1);
        }
        let of = |own: &u32| group.get(own).copied().unwrap_or(NONE);
        Self { of_face: components.of_face.iter().map(of).collect(), components: counts }
    }
}

/// Number the welded components: faces connected over twins or mates. [`NONE`] for faces that are not
/// usable.
pub fn welded(surface: &Surface) -> Vec<u32> {
    number(surface, |_, _| true)
}

/// Number what is connected over the edges that `holds` lets through, or over mates.
fn number(surface: &Surface, holds: impl Fn(u32, u32) -> bool) -> Vec<u32> {
    let mut sets = DisjointSets::new(surface.face_count());
    for (h, t) in edges(surface).filter(|(h, t)| holds(*h, *t)) {
        sets.join(h / 3, t / 3);
    }
    for (f, &m) in (0u32..).zip(&surface.sheet_mate).filter(|(_, m)| **m != NONE) {
        sets.join(f, m);
    }
    (0..surface.face_count() as u32).map(|f| sets.root(f)).collect()
}

/// Share of the length of hard edges that lies inside shells; 1 if there are no hard edges.
fn hard_inside(surface: &Surface) -> f64 {
    let (mut inside, mut all) = (0.0, 0.0);
    for (h, t) in edges(surface).filter(|(h, _)| surface.dihedral(*h).abs() > HARD) {
        let length = surface.length(h);
        all += length;
        if shell(surface, h) == shell(surface, t) {
            inside += length;
        }
    }
    if all > 0.0 { inside / all } else { 1.0 }
}

/// Both half-edges of each edge with two faces.
fn edges(surface: &Surface) -> impl Iterator<Item = (u32, u32)> {
    let halves = (0u32..).zip(&surface.twin).map(|(h, &t)| (h, t));
    halves.filter(|(h, t)| *t != NONE && h < t)
}

fn shell(surface: &Surface, h: u32) -> u32 {
    surface.origins[h as usize / 3].shell
}
