//! The graph of regions: what a region is, what the border between two is, and how both add up when
//! regions are joined.

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};

use super::super::point_mae::NAMES;
use super::contact::Contact;
use super::evidence::Evidence;
use crate::mesh::{NONE, Surface};

/// An edge more concave than this (radians) is a valley in full; a flat one is none.
const FULL: f64 = 0.8;

/// Bends below this (radians) are flat.
const FLAT: f64 = 0.2;

/// A ridge says little about whether its two sides are one part.
const RIDGE: f64 = 0.25;

/// Sums over the faces of a region. Sums are by area unless they say otherwise.
#[derive(Debug, Clone, Default)]
pub struct Region {
    /// World units squared.
    pub area: f64,
    /// Of the embedding.
    pub embedding: Vec<f64>,
    /// Of the names' shares.
    pub names: Vec<f64>,
    /// Of the logarithm of the thickness, and the area where it is known.
    pub thickness: (f64, f64),
    /// Of positions.
    pub moment: DVec3,
    /// Of the products of positions.
    pub products: DMat3,
    /// Of normals.
    pub normal: DVec3,
    /// Corners of the box around it.
    pub bounds: (DVec3, DVec3),
    /// Length of its borders.
    pub perimeter: f64,
    /// The file's shell, if it is of one only.
    pub shell: Option<u32>,
    /// The file's primitive, if it is of one only.
    pub primitive: Option<u32>,
    /// Area of each true part, where the truth is known.
    pub truth: BTreeMap<i32, f64>,
}

/// Sums over the border between two regions. World units.
#[derive(Debug, Clone, Copy, Default)]
pub struct Border {
    /// Length of shared edges and of contacts.
    pub length: f64,
    /// Of shared edges.
    pub edges: f64,
    /// Of edges at which the file's shells differ.
    pub across_shells: f64,
    /// Length × how much of a valley.
    pub valley: f64,
    /// Length, ridges counting less: what `valley` is compared with.
    pub weight: f64,
    /// Length of ridges.
    pub ridge: f64,
    /// Length × bend.
    pub bend: f64,
    /// Length × how concave the two sides' patches lie: edges of a fine mesh hardly bend, patches do.
    pub bay: f64,
    /// Length × how convex they lie.
    pub bulge: f64,
    /// Length × distance of the two sides' embeddings.
    pub step: f64,
}

impl Border {
    fn add(&mut self, other: &Border) {
        self.length += other.length;
        self.edges += other.edges;
        self.across_shells += other.across_shells;
        self.valley += other.valley;
        self.weight += other.weight;
        self.ridge += other.ridge;
        self.bend += other.bend;
        self.bay += other.bay;
        self.bulge += other.bulge;
        self.step += other.step;
    }
}

impl Region {
    fn add(&mut self, other: &Region) {
        self.area += other.area;
        self.embedding.iter_mut().zip(&other.embedding).for_each(|(a, b)| *a += b);
        self.names.iter_mut().zip(&other.names).for_each(|(a, b)| *a += b);
        self.thickness.0 += other.thickness.0;
        self.thickness.1 += other.thickness.1;
        self.moment += other.moment;
        self.products += other.products;
        self.normal += other.normal;
        self.bounds = (self.bounds.0.min(other.bounds.0), self.bounds.1.max(other.bounds.1));
        self.shell = self.shell.filter(|s| other.shell == Some(*s));
        self.primitive = self.primitive.filter(|p| other.primitive == Some(*p));
        for (&part, area) in &other.truth {
            *self.truth.entry(part).or_default() += area;
        }
    }

    /// Mean logarithm of the thickness, if it is known.
    pub fn log_thickness(&self) -> Option<f64> {
        (self.thickness.1 > 0.0).then(|| self.thickness.0 / self.thickness.1)
    }

    /// Covariance of its points.
    pub fn covariance(&self) -> DMat3 {
        covariance(self.area, self.moment, self.products)
    }

    /// Covariance of the points of both.
    pub fn covariance_with(&self, other: &Region) -> DMat3 {
        let area = self.area + other.area;
        covariance(area, self.moment + other.moment, self.products + other.products)
    }

    /// The true part that has most of it, and which share it has.
    pub fn majority(&self) -> Option<(i32, f64)> {
        let total: f64 = self.truth.values().sum();
        let best = self.truth.iter().max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(a.0)))?;
        Some((*best.0, best.1 / total))
    }
}

fn covariance(area: f64, moment: DVec3, products: DMat3) -> DMat3 {
    let area = area.max(f64::MIN_POSITIVE);
    let mean = moment / area;
    let outer = DMat3::from_cols(mean * mean.x, mean * mean.y, mean * mean.z);
    products * (1.0 / area) - outer
}

/// Regions and their borders. A region that was joined to another is `None`.
#[derive(Debug, Clone, Default)]
pub struct RegionGraph {
    /// The regions.
    pub regions: Vec<Option<Region>>,
    /// Borders of each region, by neighbour.
    pub borders: Vec<BTreeMap<u32, Border>>,
    /// Regions that are left.
    pub left: usize,
    /// Area of all.
    pub area: f64,
    /// Diagonal of the surface.
    pub diagonal: f64,
    /// Area of each shell.
    pub shells: BTreeMap<u32, f64>,
}

impl RegionGraph {
    /// The graph of patches (`patch`: one a face). `truth` is known when it is to be learned from.
    pub fn new(
        surface: &Surface,
        evidence: &Evidence,
        (patch, count): (&[u32], usize),
        contacts: &[Contact],
        truth: Option<&[i32]>,
    ) -> Self {
        let empty = Region {
            embedding: vec![0.0; evidence.width],
            names: vec![0.0; if evidence.names.is_empty() { 0 } else { NAMES.len() }],
            bounds: (DVec3::INFINITY, DVec3::NEG_INFINITY),
            ..Default::default()
        };
        let mut regions = vec![empty; count];
        for f in (0..surface.face_count()).filter(|&f| patch[f] != NONE) {
            add_face(&mut regions[patch[f] as usize], surface, evidence, f, truth);
        }
        let mut borders = vec![BTreeMap::<u32, Border>::new(); count];
        let mut between = |a: u32, b: u32, border: Border| {
            borders[a as usize].entry(b).or_default().add(&border);
            borders[b as usize].entry(a).or_default().add(&border);
        };
        for (h, &t) in (0u32..).zip(&surface.twin).filter(|(h, t)| **t != NONE && h < *t) {
            let (a, b) = (patch[h as usize / 3], patch[t as usize / 3]);
            if a != b && a != NONE && b != NONE {
                between(a, b, edge(surface, &regions, (a, b), h));
            }
        }
        for contact in contacts {
            let (a, b) = (patch[contact.faces.0 as usize], patch[contact.faces.1 as usize]);
            if a != b && a != NONE && b != NONE {
                let step = contact.length * distance(&regions, a, b);
                between(a, b, Border { length: contact.length, step, ..Default::default() });
            }
        }
        for (region, borders) in regions.iter_mut().zip(&borders) {
            region.perimeter = borders.values().map(|b| b.length).sum();
        }
        let area = regions.iter().map(|r| r.area).sum();
        let regions = regions.into_iter().map(Some).collect();
        let mut shells = BTreeMap::new();
        for (origin, own) in surface.origins.iter().zip(&surface.areas) {
            *shells.entry(origin.shell).or_default() += own;
        }
        Self { regions, borders, left: count, area, diagonal: surface.diagonal, shells }
    }

    /// Share of the area that a shell has.
    pub fn shell_share(&self, shell: Option<u32>) -> f64 {
        let area = shell.and_then(|s| self.shells.get(&s)).copied().unwrap_or(0.0);
        area / self.area.max(f64::MIN_POSITIVE)
    }

    /// The region of a number that is left.
    pub fn region(&self, number: u32) -> Option<&Region> {
        self.regions[number as usize].as_ref()
    }

    /// Join region `gone` to region `keep`; both must be left. Returns the neighbours of the whole.
    pub fn join(&mut self, keep: u32, gone: u32) -> Vec<u32> {
        let Some(other) = self.regions[gone as usize].take() else { return Vec::new() };
        let moved = std::mem::take(&mut self.borders[gone as usize]);
        let between = self.borders[keep as usize].remove(&gone).unwrap_or_default();
        for (&n, border) in moved.iter().filter(|(n, _)| **n != keep) {
            self.borders[n as usize].remove(&gone);
            self.borders[n as usize].entry(keep).or_default().add(border);
            self.borders[keep as usize].entry(n).or_default().add(border);
        }
        if let Some(region) = self.regions[keep as usize].as_mut() {
            let perimeter = region.perimeter + other.perimeter - 2.0 * between.length;
            region.add(&other);
            region.perimeter = perimeter;
        }
        self.left -= 1;
        self.borders[keep as usize].keys().copied().collect()
    }
}

fn add_face(
    region: &mut Region,
    surface: &Surface,
    evidence: &Evidence,
    face: usize,
    truth: Option<&[i32]>,
) {
    let area = surface.areas[face];
    let first = region.area == 0.0;
    region.area += area;
    let row = |values: &[f32], width: usize, sum: &mut [f64]| {
        let values = &values[face * width..][..width];
        sum.iter_mut().zip(values).for_each(|(s, v)| *s += area * f64::from(*v));
    };
    row(&evidence.embedding, evidence.width, &mut region.embedding);
    if !evidence.names.is_empty() {
        row(&evidence.names, NAMES.len(), &mut region.names);
    }
    let through = f64::from(evidence.thickness[face]);
    if through > 0.0 {
        region.thickness.0 += area * through.ln();
        region.thickness.1 += area;
    }
    let corners = surface.corners(face);
    let mean = surface.centroid(face);
    region.moment += area * mean;
    // Exact for a triangle: a twelfth of the corners' products and nine of the centroid's.
    for p in corners {
        region.products += DMat3::from_cols(p * p.x, p * p.y, p * p.z) * (area / 12.0);
        region.bounds = (region.bounds.0.min(p), region.bounds.1.max(p));
    }
    let of_mean = DMat3::from_cols(mean * mean.x, mean * mean.y, mean * mean.z);
    region.products += of_mean * (area * 0.75);
    // The two faces of a double-sided sheet would cancel.
    let mate = surface.sheet_mate[face];
    if mate == NONE || face < mate as usize {
        region.normal += area * surface.normals[face];
    }
    let origin = &surface.origins[face];
    let keep = |known: Option<u32>, own: u32| {
        if first { Some(own) } else { known.filter(|k| *k == own) }
    };
    region.shell = keep(region.shell, origin.shell);
    region.primitive = keep(region.primitive, origin.primitive);
    if let Some(truth) = truth
        && truth[face] >= 0
    {
        *region.truth.entry(truth[face]).or_default() += area;
    }
}

/// The border that one edge is.
fn edge(surface: &Surface, regions: &[Region], (a, b): (u32, u32), h: u32) -> Border {
    let (length, angle) = (surface.length(h), surface.dihedral(h));
    let shell = |h: u32| surface.origins[h as usize / 3].shell;
    let across = shell(h) != shell(surface.twin[h as usize]);
    let lie = lie(&regions[a as usize], &regions[b as usize]);
    Border {
        bay: length * (-lie / FULL).clamp(0.0, 1.0),
        bulge: length * (lie / FULL).clamp(0.0, 1.0),
        length,
        edges: length,
        across_shells: if across { length } else { 0.0 },
        valley: length * (-angle / FULL).clamp(0.0, 1.0),
        weight: if angle > FLAT { RIDGE * length } else { length },
        ridge: if angle > FLAT { length } else { 0.0 },
        bend: length * angle.abs(),
        step: length * distance(regions, a, b),
    }
}

/// Angle between the mean normals of two patches, radians: positive where they lie convex.
fn lie(a: &Region, b: &Region) -> f64 {
    let (n, m) = (a.normal.normalize_or_zero(), b.normal.normalize_or_zero());
    let between = b.moment / b.area.max(1e-300) - a.moment / a.area.max(1e-300);
    let angle = n.cross(m).length().atan2(n.dot(m));
    if (m - n).dot(between) < 0.0 { -angle } else { angle }
}

/// Distance of the mean embeddings of two regions.
fn distance(regions: &[Region], a: u32, b: u32) -> f64 {
    embedding_distance(&regions[a as usize], &regions[b as usize])
}

/// Distance of the mean embeddings of two regions; 0 without a network.
pub fn embedding_distance(a: &Region, b: &Region) -> f64 {
    let (s, t) = (1.0 / a.area.max(f64::MIN_POSITIVE), 1.0 / b.area.max(f64::MIN_POSITIVE));
    let pairs = a.embedding.iter().zip(&b.embedding);
    pairs.map(|(x, y)| (x * s - y * t).powi(2)).sum::<f64>().sqrt()
}
