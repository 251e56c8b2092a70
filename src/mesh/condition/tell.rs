//! Which face of the file is which of the surface's, and on which side. A component is double-sided if half of
//! its area stands with both windings: then what stands twice has two sides. Everything else that stands more
//! than once shares the place of the first.

use std::collections::BTreeMap;

use super::file::FileFaces;
use super::places::{Instance, Places};
use super::walls::Walls;
use crate::contract::{FirstFaces, Repairs};
use crate::mesh::{NONE, Surface, Telling};

/// Share of a component's area that stands with both windings from which on it is double-sided.
const DOUBLE: f64 = 0.5;

/// Tell it, and what there is to be told in `repairs`. The surface's faces come from the first of their
/// instances on their side.
pub fn tell(
    surface: &mut Surface,
    file: &FileFaces,
    places: &Places,
    walls: &Walls,
) -> (Telling, Repairs) {
    let mut telling = Telling {
        face: vec![NONE; file.welded.len()],
        second: vec![false; file.welded.len()],
        triangles: file.welded.clone(),
        primitives: file.primitives.clone(),
    };
    let double = double_sided(surface, places);
    let mut told = Told::default();
    let ascends = |surface: &Surface, f: usize| surface.triangles[f][1] < surface.triangles[f][2];
    for (f, instances) in places.iter().enumerate() {
        let wall = walls.second(f as u32);
        let up = ascends(surface, f);
        // Where there are two sides, the first is that of the surface.
        let two = wall != NONE || double[f];
        let agreeing = instances.iter().find(|i| two && i.ascending == up);
        let first = agreeing.unwrap_or(&instances[0]);
        let behind = |i: &&Instance| two && i.face != first.face;
        let other = |i: &&Instance| i.ascending != first.ascending;
        // With one winding for both, the next is the second.
        let second = instances.iter().filter(behind).find(other);
        let second = second.or_else(|| instances.iter().find(behind));
        for i in instances {
            let on_second = second.is_some_and(|second| {
                i.face == second.face || (other(&i) && second.ascending != first.ascending)
            });
            let at = if on_second && wall != NONE { wall } else { f as u32 };
            telling.face[i.face as usize] = at;
            telling.second[i.face as usize] = on_second && wall == NONE;
            let of_side = second.filter(|_| on_second).unwrap_or(first);
            if i.face != of_side.face {
                match i.ascending == of_side.ascending {
                    true => told.copies.add(i.face),
                    false => told.shared.add(i.face),
                }
            } else if on_second && wall == NONE {
                told.double += 2;
            }
        }
        surface.origins[f] = file.origins[first.face as usize];
        if let (Some(second), true) = (second, wall != NONE) {
            surface.origins[wall as usize] = file.origins[second.face as usize];
        }
    }
    let repairs = Repairs {
        double_sided_faces: told.double,
        copies: told.copies.count,
        shared_faces: told.shared.count,
        first_faces: FirstFaces {
            copies: told.copies.first,
            shared_faces: told.shared.first,
            ..FirstFaces::default()
        },
        ..Repairs::default()
    };
    (telling, repairs)
}

#[derive(Default)]
struct Told {
    double: u64,
    copies: Count,
    shared: Count,
}

/// Faces of the file of one kind.
#[derive(Default)]
pub struct Count {
    /// How many.
    pub count: u64,
    /// The first.
    pub first: Option<u64>,
}

impl Count {
    /// One more.
    pub fn add(&mut self, face: u32) {
        let face = u64::from(face);
        self.count += 1;
        self.first = Some(self.first.map_or(face, |first| first.min(face)));
    }
}

/// Whether each place's face belongs to a double-sided component.
fn double_sided(surface: &Surface, places: &Places) -> Vec<bool> {
    let mixed = |i: &[Instance]| i.iter().any(|j| j.ascending != i[0].ascending);
    let both: Vec<bool> = places.iter().map(mixed).collect();
    if !both.contains(&true) {
        return both;
    }
    let roots = surface.components(|_| true);
    let mut areas: BTreeMap<u32, (f64, f64)> = BTreeMap::new();
    for (f, root) in roots.iter().enumerate() {
        let area = areas.entry(*root).or_default();
        area.0 += surface.areas[f];
        if both.get(f) == Some(&true) {
            area.1 += surface.areas[f];
        }
    }
    roots[..both.len()].iter().map(|root| areas[root].1 >= DOUBLE * areas[root].0).collect()
}
