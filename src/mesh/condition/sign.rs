//! Which side of each component is its front, whatever the file's windings say. What is closed faces outward,
//! but for a cavity: a closed component inside another that the file winds the other way. What is open faces
//! where its vertex normals point, if they agree among themselves, else where more rays escape; where that
//! says nothing, as its first face is numbered.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use crate::contract::{Canceled, Run};
use crate::mesh::rays::Rays;
use crate::mesh::{NONE, Surface};
use crate::tasks;

/// Share of the area whose vertex normals must agree.
const AGREE: f64 = 0.9;

/// Share of the area whose windings must agree for a cavity.
const CAVITY: f64 = 0.99;

/// Difference of the shares of rays that escape on the two sides below which they say nothing.
const UNDECIDED: f64 = 0.05;

/// Rays a face, and faces of a component that send them.
const RAYS: u32 = 8;
const FACES: usize = 48;

/// Visits of the ray caster in all: in a soup of thousands of large faces no side is the front.
const MOST_VISITS: f64 = 1e8;

/// Components held against components, and faces of those, in the search for cavities; beyond, there are none.
const MOST_CHECKS: usize = 200_000_000;

/// What the file says of each face, in its present winding.
pub struct Said {
    /// Whether its winding is the same.
    pub alike: Vec<bool>,
    /// Cosine of the angle between its normal and the mean of its vertex normals, or 0.
    pub normal: Vec<f32>,
}

struct Component {
    faces: Vec<u32>,
    area: f64,
    closed: bool,
    volume: f64,
    low: DVec3,
    high: DVec3,
    /// Area that the file winds as the surface is now, over all area.
    alike: f64,
}

/// The components that are to be turned over, by face.
pub fn turned(surface: &Surface, said: &Said, run: &Run) -> Result<Vec<bool>, Canceled> {
    let roots = surface.components(|_| true);
    let mut members: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (f, &root) in (0u32..).zip(&roots) {
        members.entry(root).or_default().push(f);
    }
    let components: Vec<Component> =
        members.into_values().map(|faces| Component::new(surface, said, faces)).collect();
    let open: Vec<usize> = (0..components.len()).filter(|&i| !components[i].closed).collect();
    let mut turned: Vec<bool> = components.iter().map(|c| c.closed && c.volume < 0.0).collect();
    for i in cavities(surface, &components, &turned) {
        turned[i] = !turned[i];
    }
    let by_normals = |c: &Component| {
        let share = |sign: f32| {
            let with = c.faces.iter().filter(|&&f| said.normal[f as usize] * sign > 0.0);
            with.map(|&f| surface.areas[f as usize]).sum::<f64>() / c.area
        };
        match (share(1.0), share(-1.0)) {
            (same, _) if same >= AGREE => Some(false),
            (_, other) if other >= AGREE => Some(true),
            _ => None,
        }
    };
    let told: Vec<Option<bool>> = open.iter().map(|&i| by_normals(&components[i])).collect();
    let asked: Vec<usize> =
        open.iter().zip(&told).filter(|(_, told)| told.is_none()).map(|(&i, _)| i).collect();
    let seen = by_rays(surface, &components, &asked, run)?;
    for (&i, told) in open.iter().zip(told) {
        turned[i] = told.unwrap_or(false);
    }
    for (&i, seen) in asked.iter().zip(seen) {
        // As its first face is numbered: the corner after the least is the lesser of the two.
        let [_, b, c] = surface.triangles[components[i].faces[0] as usize];
        turned[i] = seen.unwrap_or(b > c);
    }
    let mut flags = vec![false; surface.face_count()];
    for (component, _) in components.iter().zip(&turned).filter(|(_, turned)| **turned) {
        component.faces.iter().for_each(|&f| flags[f as usize] = true);
    }
    Ok(flags)
}

impl Component {
    fn new(surface: &Surface, said: &Said, faces: Vec<u32>) -> Self {
        let origin = surface.centroid(faces[0] as usize);
        let mut c = Self {
            faces: Vec::new(),
            area: f64::MIN_POSITIVE,
            closed: true,
            volume: 0.0,
            low: DVec3::INFINITY,
            high: DVec3::NEG_INFINITY,
            alike: 0.0,
        };
        for f in faces.iter().map(|&f| f as usize) {
            let corners = surface.corners(f);
            let [p, q, r] = corners.map(|p| p - origin);
            c.volume += p.dot(q.cross(r)) / 6.0;
            c.low = corners.iter().fold(c.low, |low, p| low.min(*p));
            c.high = corners.iter().fold(c.high, |high, p| high.max(*p));
            c.closed &= !surface.twin[3 * f..3 * f + 3].contains(&NONE);
            c.area += surface.areas[f];
            if said.alike[f] {
                c.alike += surface.areas[f];
            }
        }
        c.alike /= c.area;
        c.faces = faces;
        c
    }

    /// The winding that the file gives it against the surface's once that faces outward; `None` where it has
    /// both.
    fn file_is_outward(&self, turned: bool) -> Option<bool> {
        match self.alike {
            w if w >= CAVITY => Some(!turned),
            w if w <= 1.0 - CAVITY => Some(turned),
            _ => None,
        }
    }

    fn may_hold(&self, other: &Self) -> bool {
        self.low.cmple(other.low).all() && self.high.cmpge(other.high).all()
    }
}

/// The closed components that are cavities: what encloses each most closely is wound the other way.
fn cavities(surface: &Surface, components: &[Component], turned: &[bool]) -> Vec<usize> {
    let outward = |i: usize| components[i].file_is_outward(turned[i]);
    let closed: Vec<usize> = (0..components.len())
        .filter(|&i| components[i].closed && components[i].volume != 0.0 && outward(i).is_some())
        .collect();
    // Without both kinds there is no cavity.
    if closed.iter().all(|&i| outward(i) == outward(closed[0])) {
        return Vec::new();
    }
    let mut by_volume = closed.clone();
    by_volume.sort_by(|&a, &b| {
        components[a].volume.abs().total_cmp(&components[b].volume.abs()).then(a.cmp(&b))
    });
    let mut found = Vec::new();
    let mut work = MOST_CHECKS;
    for &i in &closed {
        let inside = &components[i];
        let at = surface.positions[surface.triangles[inside.faces[0] as usize][0] as usize];
        let holder = by_volume.iter().copied().find(|&j| {
            let holder = &components[j];
            work = work.saturating_sub(1);
            if work == 0 || !holder.may_hold(inside) {
                return false;
            }
            work = work.saturating_sub(holder.faces.len());
            j != i
                && holder.volume.abs() > inside.volume.abs()
                && winding_number(surface, holder, at).abs() > 0.5
        });
        if holder.is_some_and(|j| outward(j) != outward(i)) {
            found.push(i);
        }
    }
    found
}

/// How often a closed component winds around a point (van Oosterom and Strackee 1983,
/// doi:10.1109/TBME.1983.325207).
fn winding_number(surface: &Surface, component: &Component, at: DVec3) -> f64 {
    let angle = |&f: &u32| {
        let [a, b, c] = surface.corners(f as usize).map(|p| p - at);
        let (x, y, z) = (a.length(), b.length(), c.length());
        let below = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
        a.dot(b.cross(c)).atan2(below)
    };
    component.faces.iter().map(angle).sum::<f64>() / (2.0 * std::f64::consts::PI)
}

/// Of these components whether more rays escape at the back than in front, where it is clear.
fn by_rays(
    surface: &Surface,
    components: &[Component],
    asked: &[usize],
    run: &Run,
) -> Result<Vec<Option<bool>>, Canceled> {
    if asked.is_empty() {
        return Ok(Vec::new());
    }
    let rays = Rays::new(surface);
    let faces: usize = asked.iter().map(|&i| components[i].faces.len().min(FACES)).sum();
    let visits = rays.expected_visits().max(1.0) * faces as f64 * f64::from(2 * RAYS);
    if visits > MOST_VISITS {
        return Ok(vec![None; asked.len()]);
    }
    let looked = asked.par_iter().map(|&i| {
        run.cancel.check()?;
        let component = &components[i];
        let stride = component.faces.len().div_ceil(FACES);
        let (mut front, mut back, mut all) = (0.0, 0.0, 0.0);
        for &f in component.faces.iter().step_by(stride) {
            let (center, normal) = (surface.centroid(f as usize), surface.normals[f as usize]);
            let escape = |normal| rays.ambient_visibility(center, normal, RAYS, u64::from(f), f);
            let area = surface.areas[f as usize];
            front += area * escape(normal);
            back += area * escape(-normal);
            all += area;
        }
        let clear = (front - back).abs() > UNDECIDED * all;
        Ok(clear.then_some(back > front))
    });
    tasks::even("sides seen", asked.len(), || looked.collect())
}
