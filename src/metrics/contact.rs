//! Contact curves: where parts touch without sharing edges. A point of a crease or of an open border
//! of one component that lies within 0.5 % of the diagonal of another component, with another label,
//! is on one. Both components may see the same curve: the longer reading counts. A part that is sunk
//! deeper into another than that has no contact curve by this definition.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::alignment::sample_edges;
use super::levels::Scope;
use super::{EdgeTable, Measured};
use crate::contract::{Cancel, Canceled};
use crate::mesh::rays::Rays;
use crate::mesh::{DisjointSets, NONE};
use crate::tasks;

/// Contact is within this share of the diagonal.
const TOUCH: f64 = 0.005;
/// Most samples on feature edges, beside one an edge.
const MOST_SAMPLES: f64 = 10_000.0;

/// A stretch of contact curve.
#[derive(Debug, Clone, Copy)]
struct Piece {
    /// Component that it lies on, and the one it touches.
    components: (u32, u32),
    /// A face on each.
    faces: (u32, u32),
    /// World units.
    length: f64,
}

/// Every contact of the object.
#[derive(Debug, Clone, Default)]
pub(super) struct Contacts(Vec<Piece>);

impl Contacts {
    pub(super) fn new(
        input: &Measured,
        table: &EdgeTable,
        rays: &Rays,
        cancel: &Cancel,
    ) -> Result<Self, Canceled> {
        let surface = input.surface;
        let component = components(surface.face_count(), table);
        let mut others = table.all_half_edges().iter().map(|h| component[*h as usize / 3]);
        let first = others.next();
        if others.all(|c| Some(c) == first) {
            return Ok(Self::default());
        }
        let feature = |e: usize| {
            table
                .half_edges(e)
                .any(|(h, _)| surface.twin[h as usize] == NONE || surface.is_crease(h))
        };
        let touch = TOUCH * surface.diagonal;
        let whole: f64 = (0..table.len()).filter(|&e| feature(e)).map(|e| table.length[e]).sum();
        let samples = sample_edges(surface, table, touch.max(whole / MOST_SAMPLES), feature);
        let pieces: Vec<Vec<Piece>> = tasks::even("contacts", samples.len(), || {
            samples
                .par_iter()
                .map(|s| {
                    let own = table.half_edges(s.edge as usize).next().map_or(NONE, |(h, _)| h / 3);
                    if own == NONE || cancel.is_canceled() {
                        return vec![];
                    }
                    let mut touched: BTreeMap<u32, u32> = BTreeMap::new();
                    rays.visit_within(s.point, touch, |face, _| {
                        let other = component[face as usize];
                        if other != NONE
                            && other != component[own as usize]
                            && input.label(face) != input.label(own)
                        {
                            touched.entry(other).and_modify(|f| *f = face.min(*f)).or_insert(face);
                        }
                    });
                    touched
                        .into_iter()
                        .map(|(other, face)| Piece {
                            components: (component[own as usize], other),
                            faces: (own, face),
                            length: s.share * table.length[s.edge as usize],
                        })
                        .collect()
                })
                .collect()
        });
        cancel.check()?;
        Ok(Self(pieces.into_iter().flatten().collect()))
    }

    /// Length of the contact curves in which the faces of `scope` take part, world units.
    pub(super) fn length(&self, input: &Measured, scope: Scope) -> f64 {
        let mut readings: BTreeMap<(u32, u32), [f64; 2]> = BTreeMap::new();
        for piece in &self.0 {
            if scope.holds(input, piece.faces.0) || scope.holds(input, piece.faces.1) {
                let (a, b) = piece.components;
                let reading = readings.entry((a.min(b), a.max(b))).or_default();
                reading[usize::from(a > b)] += piece.length;
            }
        }
        readings.values().fold(0.0, |sum, [x, y]| sum + x.max(*y))
    }
}

/// Component of each face over shared edges, or [`NONE`] for faces that are not measured.
fn components(faces: usize, table: &EdgeTable) -> Vec<u32> {
    let mut sets = DisjointSets::new(faces);
    let mut measured = vec![false; faces];
    for e in 0..table.len() {
        let mut around = table.half_edges(e).map(|(h, _)| h as usize / 3);
        let Some(first) = around.next() else { continue };
        measured[first] = true;
        for f in around {
            measured[f] = true;
            sets.join(first as u32, f as u32);
        }
    }
    (0..faces).map(|f| if measured[f] { sets.root(f as u32) } else { NONE }).collect()
}
