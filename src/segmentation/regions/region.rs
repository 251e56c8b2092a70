//! A region: sums over its faces, from which size, moments, names and evidence follow, and which add up
//! when regions are joined.

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};

use super::super::point_mae::NAMES;
use super::evidence::Evidence;
use crate::mesh::{Surface, least_eigenvalue};

/// Sums over the faces of a region. Sums are by area unless they say otherwise.
#[derive(Debug, Clone)]
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
    /// Of the products of normals.
    pub normals: DMat3,
    /// Corners of the box around it.
    pub bounds: (DVec3, DVec3),
    /// Length of its borders.
    pub perimeter: f64,
    /// Length of those that are edges inside an authored component; 0 for whole components.
    pub edges: f64,
    /// Group of authored components that are alike ([`Alike`](super::components::Alike)), if it is of one only.
    pub like: Option<u32>,
    /// The authored component, if it is of one only.
    pub component: Option<u32>,
    /// The file's primitive, if it is of one only.
    pub primitive: Option<u32>,
    /// Area of each true part, where the truth is known.
    pub truth: BTreeMap<i32, f64>,
}

impl Region {
    /// A region without faces.
    pub fn empty(evidence: &Evidence) -> Self {
        Self {
            area: 0.0,
            embedding: vec![0.0; evidence.width],
            names: vec![0.0; if evidence.names.is_empty() { 0 } else { NAMES.len() }],
            thickness: (0.0, 0.0),
            moment: DVec3::ZERO,
            products: DMat3::ZERO,
            normal: DVec3::ZERO,
            normals: DMat3::ZERO,
            bounds: (DVec3::INFINITY, DVec3::NEG_INFINITY),
            perimeter: 0.0,
            edges: 0.0,
            like: None,
            component: None,
            primitive: None,
            truth: BTreeMap::new(),
        }
    }

    /// Add a face of an authored component and its group.
    pub fn add_face(
        &mut self,
        surface: &Surface,
        evidence: &Evidence,
        (component, like): (u32, u32),
        face: usize,
        truth: Option<&[i32]>,
    ) {
        let area = surface.areas[face];
        let first = self.area == 0.0;
        self.area += area;
        let row = |values: &[f32], width: usize, sum: &mut [f64]| {
            let values = &values[face * width..][..width];
            sum.iter_mut().zip(values).for_each(|(s, v)| *s += area * f64::from(*v));
        };
        row(&evidence.embedding, evidence.width, &mut self.embedding);
        if !evidence.names.is_empty() {
            row(&evidence.names, NAMES.len(), &mut self.names);
        }
        let through = f64::from(evidence.thickness[face]);
        if through > 0.0 {
            self.thickness.0 += area * through.ln();
            self.thickness.1 += area;
        }
        let corners = surface.corners(face);
        let mean = surface.centroid(face);
        self.moment += area * mean;
        // Exact for a triangle: a twelfth of the corners' products and nine of the centroid's.
        for p in corners {
            self.products += DMat3::from_cols(p * p.x, p * p.y, p * p.z) * (area / 12.0);
            self.bounds = (self.bounds.0.min(p), self.bounds.1.max(p));
        }
        let of_mean = DMat3::from_cols(mean * mean.x, mean * mean.y, mean * mean.z);
        self.products += of_mean * (area * 0.75);
        let n = surface.normals[face];
        self.normal += area * n;
        self.normals += DMat3::from_cols(n * n.x, n * n.y, n * n.z) * area;
        let origin = &surface.origins[face];
        let keep = |known: Option<u32>, own: u32| {
            if first { Some(own) } else { known.filter(|k| *k == own) }
        };
        self.component = keep(self.component, component);
        self.like = keep(self.like, like);
        self.primitive = keep(self.primitive, origin.primitive);
        if let Some(truth) = truth
            && truth[face] >= 0
        {
            *self.truth.entry(truth[face]).or_default() += area;
        }
    }

    /// Add another region; borders are the graph's to count.
    pub fn add(&mut self, other: &Region) {
        self.area += other.area;
        self.embedding.iter_mut().zip(&other.embedding).for_each(|(a, b)| *a += b);
        self.names.iter_mut().zip(&other.names).for_each(|(a, b)| *a += b);
        self.thickness.0 += other.thickness.0;
        self.thickness.1 += other.thickness.1;
        self.moment += other.moment;
        self.products += other.products;
        self.normal += other.normal;
        self.normals += other.normals;
        self.bounds = (self.bounds.0.min(other.bounds.0), self.bounds.1.max(other.bounds.1));
        self.component = self.component.filter(|s| other.component == Some(*s));
        self.primitive = self.primitive.filter(|p| other.primitive == Some(*p));
        self.like = self.like.filter(|l| other.like == Some(*l));
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

    /// How far it is from a plane, a cylinder or a cone: the least variance that its normals have in any
    /// direction. 0 for all three, whose normals lie on a circle; ⅓ for a ball.
    pub fn misfit(&self) -> f64 {
        misfit(self.area, self.normal, self.normals)
    }

    /// [`misfit`](Self::misfit) of both together.
    pub fn misfit_with(&self, other: &Region) -> f64 {
        let area = self.area + other.area;
        misfit(area, self.normal + other.normal, self.normals + other.normals)
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

fn misfit(area: f64, normal: DVec3, products: DMat3) -> f64 {
    least_eigenvalue(covariance(area, normal, products)).max(0.0)
}

fn covariance(area: f64, moment: DVec3, products: DMat3) -> DMat3 {
    let area = area.max(f64::MIN_POSITIVE);
    let mean = moment / area;
    let outer = DMat3::from_cols(mean * mean.x, mean * mean.y, mean * mean.z);
    products * (1.0 / area) - outer
}

/// Distance of the mean embeddings of two regions; 0 without a network.
pub fn embedding_distance(a: &Region, b: &Region) -> f64 {
    let (s, t) = (1.0 / a.area.max(f64::MIN_POSITIVE), 1.0 / b.area.max(f64::MIN_POSITIVE));
    let pairs = a.embedding.iter().zip(&b.embedding);
    pairs.map(|(x, y)| (x * s - y * t).powi(2)).sum::<f64>().sqrt()
}
