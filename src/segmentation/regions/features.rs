//! What speaks for and against joining two regions, as numbers of about the same size.

use glam::{DMat3, DVec3};

use super::graph::{Border, RegionGraph};
use super::region::{Region, embedding_distance};

/// How many numbers.
pub const FEATURES: usize = super::super::point_mae::PAIR_FEATURES;

/// Those that come from the network: a classifier without one must not see them.
pub const LEARNED: std::ops::Range<usize> = 0..5;

/// Those that come from the file's structure.
pub const AUTHORED: std::ops::Range<usize> = 5..17;

/// Those that come from the shape.
pub const SHAPE: std::ops::Range<usize> = 18..37;

/// From this probability that two places lie on different authored components on, these say all they can:
/// one with specks beside it may have any parts.
const SEVERAL: f64 = 0.006;

/// Where some of the numbers stand.
pub mod at {
    /// Distance of the embeddings.
    pub const APART: usize = 0;
    /// Distance of the embeddings along the border.
    pub const STEP: usize = 1;
    /// Share of the border that is between two authored components.
    pub const ACROSS_SOLIDS: usize = 5;
    /// Share of the border where welded components touch and share no edge.
    pub const CONTACT: usize = 17;
    /// How much of a valley the border is, ridges counting less.
    pub const VALLEY: usize = 18;
    /// How much of its edges is a ridge.
    pub const RIDGE: usize = 20;
    /// How concave the border's two sides lie.
    pub const BAY: usize = 22;
    /// Logarithm of the smaller one's share of the area.
    pub const SMALL: usize = 26;
    /// Logarithm of the larger one's.
    pub const LARGE: usize = 27;
    /// How much thicker one is than the other.
    pub const THICK: usize = 28;
    /// Volume of both boxes over that of the box about both.
    pub const BOXES: usize = 32;
    /// How far both together are from a plane, a cylinder, a cone.
    pub const MISFIT_BOTH: usize = 36;
}

/// The numbers for a pair of neighbours.
pub fn features(graph: &RegionGraph, a: &Region, b: &Region, border: &Border) -> [f32; FEATURES] {
    let (small, large) = if a.area <= b.area { (a, b) } else { (b, a) };
    let (length, edges) = (border.length.max(1e-300), border.edges.max(1e-300));
    let share = |x: &Region| (x.area / graph.area.max(1e-300)).max(1e-9).ln() / 7.0;
    let [apart, alike, best_a, best_b] = learned(a, b);
    let (own_component, mixed) = (
        a.component.is_some() && a.component == b.component,
        a.component.is_none() || b.component.is_none(),
    );
    let spread = Spread::of(a, b);
    let thick = match (a.log_thickness(), b.log_thickness()) {
        (Some(s), Some(t)) => ((s - t).abs() / 2.0).min(1.5),
        _ => 0.0,
    };
    let flag = |yes: bool| f64::from(u8::from(yes));
    let normals = (a.normal.length() / a.area).min(1.0) * (b.normal.length() / b.area).min(1.0);
    let facing = a.normal.normalize_or_zero().dot(b.normal.normalize_or_zero()) * normals;
    let around = a.perimeter.min(b.perimeter).max(1e-300);
    let neck = small.log_thickness().map_or(0.0, |t| {
        (length / (std::f64::consts::PI * t.exp() * graph.diagonal)).min(4.0) / 2.0
    });
    let values: [f64; FEATURES] = [
        (apart / 3.0).min(1.5),
        (border.step / length / 3.0).min(1.5),
        alike,
        best_a.max(best_b),
        flag(!a.names.is_empty()),
        border.across_solids / edges,
        flag(own_component),
        flag(mixed),
        flag(a.primitive.is_some() && a.primitive == b.primitive),
        // That all is one component says nothing; that two halves of a board are says all.
        if own_component { (graph.components.apart.powi(2) / SEVERAL).min(1.0) } else { 0.0 },
        flag(graph.components.told),
        // Whole components have no borders that are edges; a row of alike ones is often one part.
        (small.edges / small.perimeter.max(1e-300)).clamp(0.0, 1.0),
        (large.edges / large.perimeter.max(1e-300)).clamp(0.0, 1.0),
        flag(small.like.is_some() && small.like == large.like),
        f64::from(graph.alike(small).max(1)).ln() / 4.0,
        f64::from(graph.alike(large).max(1)).ln() / 4.0,
        graph.components.apart,
        1.0 - border.edges / length,
        if border.weight > 0.0 { border.valley / border.weight } else { 0.0 },
        border.valley / edges,
        border.ridge / edges,
        border.bend / edges,
        border.bay / edges,
        border.bulge / edges,
        (length / around).min(1.0),
        (length / small.area.sqrt() / 4.0).min(2.0),
        share(small),
        share(large),
        thick,
        neck,
        facing,
        spread.volume,
        spread.boxes,
        spread.flatness,
        // Planes, cylinders and cones fit each or both.
        3.0 * small.misfit(),
        3.0 * large.misfit(),
        3.0 * a.misfit_with(b),
        (graph.left as f64).ln() / 7.0,
        flag(small.area < 1e-3 * graph.area),
    ];
    values.map(|v: f64| if v.is_finite() { v as f32 } else { 0.0 })
}

/// Distance of embeddings, overlap of names, how sure each side's name is.
fn learned(a: &Region, b: &Region) -> [f64; 4] {
    if a.names.is_empty() {
        return [0.0; 4];
    }
    let (s, t) = (1.0 / a.area.max(1e-300), 1.0 / b.area.max(1e-300));
    let pairs = a.names.iter().zip(&b.names);
    let alike = pairs.map(|(x, y)| (x * s * y * t).max(0.0).sqrt()).sum::<f64>();
    let best = |r: &Region, s: f64| r.names.iter().copied().fold(0.0, f64::max) * s;
    [embedding_distance(a, b), alike, best(a, s), best(b, t)]
}

/// How the two together fill space, against how each does.
struct Spread {
    volume: f64,
    boxes: f64,
    flatness: f64,
}

impl Spread {
    fn of(a: &Region, b: &Region) -> Self {
        let (own_a, own_b, both) = (a.covariance(), b.covariance(), a.covariance_with(b));
        let least = 1e-4 * trace(&both);
        let extent = |m: &DMat3| {
            let m = *m + DMat3::from_diagonal(DVec3::splat(least));
            m.determinant().max(0.0).sqrt()
        };
        let whole = extent(&both).max(1e-300);
        let volume = ((extent(&own_a) + extent(&own_b)) / whole).max(1e-3).ln() / 3.0;
        let size = |r: &Region| {
            let e = r.bounds.1 - r.bounds.0 + DVec3::splat(least.sqrt());
            e.x * e.y * e.z
        };
        let joined = {
            let (low, high) = (a.bounds.0.min(b.bounds.0), a.bounds.1.max(b.bounds.1));
            let e = high - low + DVec3::splat(least.sqrt());
            (e.x * e.y * e.z).max(1e-300)
        };
        let boxes = ((size(a) + size(b)) / joined).min(2.0);
        // Determinant over the trace's cube: 0 for what is flat or straight.
        let round = |m: &DMat3| 27.0 * m.determinant().max(0.0) / trace(m).powi(3).max(1e-300);
        let flatness = round(&both) - round(&own_a).max(round(&own_b));
        Self { volume, boxes, flatness }
    }
}

fn trace(m: &DMat3) -> f64 {
    m.x_axis.x + m.y_axis.y + m.z_axis.z
}
