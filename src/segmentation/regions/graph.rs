//! The graph of regions: what the border between two regions is, and how both add up when regions are
//! joined.

use std::collections::BTreeMap;

use super::components::{Alike, AuthoredComponents};
use super::contact::Contact;
use super::evidence::Evidence;
use super::region::{Region, embedding_distance};
use crate::mesh::{NONE, Surface};

/// An edge more concave than this (radians) is a valley in full; a flat one is none.
const FULL: f64 = 0.8;

/// Bends below this (radians) are flat.
const FLAT: f64 = 0.2;

/// A ridge says little about whether its two sides are one part.
const RIDGE: f64 = 0.25;

/// Sums over the border between two regions. World units.
#[derive(Debug, Clone, Copy, Default)]
pub struct Border {
    /// Length of shared edges and of contacts.
    pub length: f64,
    /// Of shared edges.
    pub edges: f64,
    /// Of edges between two authored components.
    pub across_solids: f64,
    /// Length × how much of a valley.
    pub valley: f64,
    /// Length, ridges counting less: what `valley` is compared with.
    pub weight: f64,
    /// Length of ridges.
    pub ridge: f64,
    /// Length × bend.
    pub bend: f64,
    /// Length × how concave the two sides' initial regions lie: edges of a fine mesh hardly bend,
    /// regions do.
    pub bay: f64,
    /// Length × how convex they lie.
    pub bulge: f64,
    /// Length × distance of the two sides' embeddings.
    pub step: f64,
}

impl Border {
    /// Length of edges inside an authored component.
    fn within_solids(&self) -> f64 {
        self.edges - self.across_solids
    }

    fn add(&mut self, other: &Border) {
        self.length += other.length;
        self.edges += other.edges;
        self.across_solids += other.across_solids;
        self.valley += other.valley;
        self.weight += other.weight;
        self.ridge += other.ridge;
        self.bend += other.bend;
        self.bay += other.bay;
        self.bulge += other.bulge;
        self.step += other.step;
    }
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
    /// The authored components.
    pub components: AuthoredComponents,
    /// Authored components of each group of those that are alike.
    pub likes: Vec<u32>,
}

impl RegionGraph {
    /// The graph of initial regions (`patch`: one a face). `truth` is known when it is to be learned from.
    pub fn new(
        surface: &Surface,
        evidence: &Evidence,
        (patch, count): (&[u32], usize),
        (contacts, components): (&[Contact], AuthoredComponents),
        truth: Option<&[i32]>,
    ) -> Self {
        let likes = Alike::new(&components);
        let mut regions = vec![Region::empty(evidence); count];
        for f in (0..surface.face_count()).filter(|&f| patch[f] != NONE) {
            regions[patch[f] as usize].add_face(
                surface,
                evidence,
                (components.of_face[f], likes.of_face[f]),
                f,
                truth,
            );
        }
        let mut borders = vec![BTreeMap::<u32, Border>::new(); count];
        let mut between = |a: u32, b: u32, border: Border| {
            borders[a as usize].entry(b).or_default().add(&border);
            borders[b as usize].entry(a).or_default().add(&border);
        };
        for (h, &t) in (0u32..).zip(&surface.twin).filter(|(h, t)| **t != NONE && h < *t) {
            let (a, b) = (patch[h as usize / 3], patch[t as usize / 3]);
            if a != b && a != NONE && b != NONE {
                between(a, b, edge(surface, &regions, (a, b), h, components.differ(h, t)));
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
            region.edges = borders.values().map(Border::within_solids).sum();
        }
        let area = regions.iter().map(|r| r.area).sum();
        let regions = regions.into_iter().map(Some).collect();
        let (left, diagonal, likes) = (count, surface.diagonal, likes.components);
        Self { regions, borders, left, area, diagonal, components, likes }
    }

    /// Authored components that are like those of a region; 0 if it has several kinds.
    pub fn alike(&self, region: &Region) -> u32 {
        region.like.map_or(0, |l| self.likes[l as usize])
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
            let edges = region.edges + other.edges - 2.0 * between.within_solids();
            region.add(&other);
            region.perimeter = perimeter;
            region.edges = edges;
        }
        self.left -= 1;
        self.borders[keep as usize].keys().copied().collect()
    }
}

/// The border that one edge is.
fn edge(surface: &Surface, regions: &[Region], (a, b): (u32, u32), h: u32, across: bool) -> Border {
    let (length, angle) = (surface.length(h), surface.dihedral(h));
    let lie = lie(&regions[a as usize], &regions[b as usize]);
    Border {
        bay: length * (-lie / FULL).clamp(0.0, 1.0),
        bulge: length * (lie / FULL).clamp(0.0, 1.0),
        length,
        edges: length,
        across_solids: if across { length } else { 0.0 },
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

#[cfg(test)]
mod tests {
    use glam::{DMat3, DVec3};

    use super::*;
    use crate::contract::{Limits, MeshKind, Run, Winding};

    /// The unit cube in two regions: four sides; top and bottom.
    fn cube() -> RegionGraph {
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
            f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nf 1 4 3 2\nf 5 6 7 8\n";
        let scene = crate::mesh::import(text.as_bytes(), MeshKind::Obj, &Limits::default());
        let conditioned = crate::mesh::condition(&scene.unwrap(), Winding::Surface, &Run::quiet());
        let surface = conditioned.unwrap().surface;
        let evidence = Evidence { thickness: vec![0.0; 12], ..Default::default() };
        let patch: Vec<u32> = surface.origins.iter().map(|o| u32::from(o.face >= 8)).collect();
        let components =
            AuthoredComponents::new(&surface, &super::super::components::welded(&surface));
        RegionGraph::new(&surface, &evidence, (&patch, 2), (&[], components), None)
    }

    #[test]
    fn moments_are_those_of_a_cube() {
        let mut graph = cube();
        let sides = graph.region(0).unwrap();
        assert!(sides.misfit().abs() < 1e-12, "sides of a prism: {}", sides.misfit());
        assert!((sides.misfit_with(graph.region(1).unwrap()) - 1.0 / 3.0).abs() < 1e-12);
        let border = graph.borders[0][&1];
        assert!((border.length - 8.0).abs() < 1e-12 && border.valley == 0.0);
        graph.join(0, 1);
        let whole = graph.region(0).unwrap();
        assert!((whole.area - 6.0).abs() < 1e-12 && whole.perimeter.abs() < 1e-12);
        // Two faces at a distance of ½, four spread evenly: (2/4 + 4/12) / 6.
        let want = DMat3::from_diagonal(DVec3::splat(5.0 / 36.0));
        assert!((whole.covariance() - want).abs_diff_eq(DMat3::ZERO, 1e-12));
        assert_eq!((graph.alike(whole), graph.left), (1, 1));
    }
}
