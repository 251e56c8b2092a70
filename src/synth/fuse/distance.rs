//! Signed distances to closed triangle meshes near their surface. The sign comes from
//! angle-weighted pseudonormals (Bærentzen and Aanæs, "Signed distance computation using the angle
//! weighted pseudonormal", 2005, doi:10.1109/TVCG.2005.49), the closest point on a triangle from
//! Ericson, "Real-Time Collision Detection", 2005, section 5.1.5.

use std::collections::{BTreeMap, HashMap};

use glam::{DVec3, IVec3};

use crate::synth::SynthPart;

struct Triangle {
    part: u32,
    corners: [DVec3; 3],
    /// Pseudonormals of the face, its edges (k to k + 1) and its corners.
    face: DVec3,
    edges: [DVec3; 3],
    vertices: [DVec3; 3],
}

/// The solids of an object.
pub(super) struct Parts {
    triangles: Vec<Triangle>,
    pub count: usize,
    pub low: DVec3,
    pub high: DVec3,
}

/// The closest point on one part.
#[derive(Debug, Clone, Copy)]
pub(super) struct Closest {
    pub part: u32,
    pub point: DVec3,
    /// Unit normal of the surface there.
    pub normal: DVec3,
    /// Negative inside.
    pub distance: f64,
}

impl Parts {
    pub fn new(parts: &[SynthPart]) -> Self {
        let mut triangles = vec![];
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for (number, part) in (0u32..).zip(parts) {
            let at = |v: u32| part.positions[v as usize];
            let normal =
                |t: &[u32; 3]| (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).normalize_or_zero();
            let mut vertices = vec![DVec3::ZERO; part.positions.len()];
            let mut edges: BTreeMap<(u32, u32), DVec3> = BTreeMap::new();
            for t in &part.triangles {
                for k in 0..3 {
                    let (a, b, c) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
                    let angle = (at(b) - at(a)).angle_between(at(c) - at(a));
                    vertices[a as usize] += angle * normal(t);
                    *edges.entry((a.min(b), a.max(b))).or_default() += normal(t);
                }
            }
            for t in &part.triangles {
                let edge = |k: usize| {
                    let (a, b) = (t[k], t[(k + 1) % 3]);
                    edges.get(&(a.min(b), a.max(b))).copied().unwrap_or_default()
                };
                triangles.push(Triangle {
                    part: number,
                    corners: t.map(at),
                    face: normal(t),
                    edges: [edge(0), edge(1), edge(2)],
                    vertices: t.map(|v| vertices[v as usize]),
                });
            }
            for &p in &part.positions {
                low = low.min(p);
                high = high.max(p);
            }
        }
        Self { triangles, count: parts.len(), low, high }
    }

    /// An index that answers within `reach` of the surface.
    pub fn near(&self, reach: f64) -> Near<'_> {
        let mut buckets: HashMap<IVec3, Vec<u32>> = HashMap::new();
        for (i, t) in (0u32..).zip(&self.triangles) {
            let [a, b, c] = t.corners;
            let from = ((a.min(b).min(c) - reach) / reach).floor().as_ivec3();
            let to = ((a.max(b).max(c) + reach) / reach).floor().as_ivec3();
            for x in from.x..=to.x {
                for y in from.y..=to.y {
                    for z in from.z..=to.z {
                        buckets.entry(IVec3::new(x, y, z)).or_default().push(i);
                    }
                }
            }
        }
        Near { parts: self, reach, buckets }
    }
}

/// Closest points within reach of the surface.
pub(super) struct Near<'a> {
    parts: &'a Parts,
    reach: f64,
    buckets: HashMap<IVec3, Vec<u32>>,
}

impl Near<'_> {
    /// The closest point on each part within reach, parts in ascending order.
    pub fn each(&self, p: DVec3) -> Vec<Closest> {
        let mut out: Vec<Closest> = vec![];
        let Some(bucket) = self.buckets.get(&(p / self.reach).floor().as_ivec3()) else {
            return out;
        };
        for &i in bucket {
            let t = &self.parts.triangles[i as usize];
            let (point, pseudonormal) = t.closest(p);
            let away = point.distance(p);
            if away > self.reach {
                continue;
            }
            let inside = (p - point).dot(pseudonormal) < 0.0;
            let found = Closest {
                part: t.part,
                point,
                normal: t.face,
                distance: if inside { -away } else { away },
            };
            match out.last_mut().filter(|last| last.part == t.part) {
                Some(last) if away < last.distance.abs() => *last = found,
                Some(_) => {}
                None => out.push(found),
            }
        }
        out
    }

    /// The closest point on the union.
    pub fn closest(&self, p: DVec3) -> Option<Closest> {
        self.each(p).into_iter().min_by(|a, b| a.distance.total_cmp(&b.distance))
    }
}

impl Triangle {
    /// The closest point and the pseudonormal of the feature that it lies on.
    fn closest(&self, p: DVec3) -> (DVec3, DVec3) {
        let [a, b, c] = self.corners;
        let (ab, ac, ap) = (b - a, c - a, p - a);
        let (d1, d2) = (ab.dot(ap), ac.dot(ap));
        if d1 <= 0.0 && d2 <= 0.0 {
            return (a, self.vertices[0]);
        }
        let bp = p - b;
        let (d3, d4) = (ab.dot(bp), ac.dot(bp));
        if d3 >= 0.0 && d4 <= d3 {
            return (b, self.vertices[1]);
        }
        let vc = d1 * d4 - d3 * d2;
        if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            return (a + ab * (d1 / (d1 - d3)), self.edges[0]);
        }
        let cp = p - c;
        let (d5, d6) = (ab.dot(cp), ac.dot(cp));
        if d6 >= 0.0 && d5 <= d6 {
            return (c, self.vertices[2]);
        }
        let vb = d5 * d2 - d1 * d6;
        if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            return (a + ac * (d2 / (d2 - d6)), self.edges[2]);
        }
        let va = d3 * d6 - d5 * d4;
        if va <= 0.0 && d4 >= d3 && d5 >= d6 {
            let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
            return (b + (c - b) * t, self.edges[1]);
        }
        let sum = va + vb + vc;
        (a + ab * (vb / sum) + ac * (vc / sum), self.face)
    }
}
