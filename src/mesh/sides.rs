//! The sides of a surface that get coordinates, and how they are wound. Solvers see a double-sided sheet once,
//! from its front; here its second side is put back, and what the file winds the other way is turned over, so
//! that what follows sees it as the file does.

use std::collections::BTreeMap;

use super::{NONE, Surface, Telling};

/// Share of a component's area that the file must wind the other way.
const AGAINST: f64 = 0.6;

/// The sides of a surface.
#[derive(Debug, Clone)]
pub struct Sides {
    /// A surface of all sides: the faces of the one they were made of, then their second sides.
    pub surface: Surface,
    /// How the file tells it.
    pub telling: Telling,
    /// The face that each is a side of.
    pub of: Vec<u32>,
    /// The second side of each face, or [`NONE`].
    pub second: Vec<u32>,
    /// Whether each is wound the other way than the face that it is a side of.
    pub turned: Vec<bool>,
}

impl Sides {
    /// The sides of a surface; `both`: whether second sides get coordinates of their own. `follow`: whether
    /// what the file winds the other way is turned.
    pub fn of(surface: &Surface, telling: &Telling, both: bool, follow: bool) -> Self {
        let count = surface.face_count();
        let mut own = Surface::clone(surface);
        let mut second = vec![NONE; count];
        let mut of: Vec<u32> = (0..count as u32).collect();
        if both {
            let behind = telling.face.iter().zip(&telling.second).filter(|(_, second)| **second);
            let mut behind: Vec<u32> = behind.map(|(&f, _)| f).collect();
            behind.sort_unstable();
            behind.dedup();
            let closed = |cap: &u32| behind.binary_search(&surface.closes[*cap as usize]).is_ok();
            let caps = (0..surface.closes.len() as u32).filter(|&f| surface.is_cap(f));
            behind.extend(caps.filter(closed).collect::<Vec<_>>());
            for (i, &f) in (count as u32..).zip(&behind) {
                second[f as usize] = i;
            }
            of.extend(&behind);
            add_second(&mut own, surface, &behind, &second);
        }
        let face = |(&f, &is_second): (&u32, &bool)| match is_second && both {
            true => second[f as usize],
            false => f,
        };
        let telling = Telling {
            face: telling.face.iter().zip(&telling.second).map(face).collect(),
            second: vec![false; telling.second.len()],
            triangles: telling.triangles.clone(),
            primitives: telling.primitives.clone(),
        };
        // The first of the faces that are a second side stands for it.
        let is_second = |f: u32| f != NONE && f as usize >= count;
        for (i, &f) in telling.face.iter().enumerate().rev().filter(|(_, f)| is_second(**f)) {
            let origin = &mut own.origins[f as usize];
            (origin.face, origin.primitive) = (i as u32, telling.primitive(i as u32));
        }
        let mut flags = vec![false; own.face_count()];
        if follow {
            against(&own, &telling, &mut flags);
        }
        let surface = own.turned(&flags);
        let turned = flags.iter().enumerate().map(|(f, &flag)| flag != (f >= count)).collect();
        Self { surface, telling, of, second, turned }
    }
}

/// Add the second sides of the faces `behind`.
fn add_second(own: &mut Surface, surface: &Surface, behind: &[u32], second: &[u32]) {
    if behind.is_empty() {
        return;
    }
    let back = surface.clone().turned(&vec![true; surface.face_count()]);
    for &f in behind {
        let f = f as usize;
        own.triangles.push(back.triangles[f]);
        own.normals.push(back.normals[f]);
        own.areas.push(back.areas[f]);
        own.origins.push(back.origins[f]);
        own.sheet_mate[f] = second[f];
        own.sheet_mate.push(f as u32);
        if surface.is_cap(f as u32) {
            own.closes.push(second[surface.closes[f] as usize]);
        } else if !surface.closes.is_empty() {
            own.closes.push(NONE);
        }
        for h in 3 * f..3 * f + 3 {
            let t = back.twin[h];
            let there = if t == NONE { NONE } else { second[t as usize / 3] };
            own.twin.push(if there == NONE { NONE } else { 3 * there + t % 3 });
            if !back.existing_seams.is_empty() {
                own.existing_seams.push(back.existing_seams[h]);
            }
        }
        if let (Some(own), Some(back)) = (&mut own.labels, &back.labels) {
            own.push(back[f]);
        }
    }
}

/// Mark the components most of whose area the file winds the other way.
fn against(surface: &Surface, telling: &Telling, flags: &mut [bool]) {
    let roots = surface.components(|_| true);
    let mut areas: BTreeMap<u32, (f64, f64)> = BTreeMap::new();
    for (f, root) in roots.iter().enumerate() {
        let area = areas.entry(*root).or_default();
        area.0 += surface.areas[f];
        if telling.is_against(surface, surface.origins[f].face as usize) {
            area.1 += surface.areas[f];
        }
    }
    for (flag, root) in flags.iter_mut().zip(&roots) {
        *flag = areas[root].1 >= AGAINST * areas[root].0;
    }
}
