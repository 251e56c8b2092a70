//! Ray casting over a surface: what a ray meets first, whether it meets anything, how much of the
//! sky a point sees, and which faces are near a point. A bounding volume hierarchy over the usable
//! faces, split at the median of the longest axis, so that its depth is ⌈log₂ n⌉ whatever the input.
//!
//! A ray that starts on a face sees neither that face nor its mate behind it ([`Surface::sheet_mate`]):
//! in a file where every face stands twice, everything would read as hidden otherwise.

#[cfg(test)]
mod tests;
mod triangle;

use glam::DVec3;

use triangle::crossing;
pub use triangle::nearest_on_triangle;

use super::{NONE, Surface};
use crate::tasks;

/// Faces in a leaf.
const LEAF: usize = 4;
/// Faces above which the two halves are built side by side.
const SIDE_BY_SIDE: usize = 4096;
/// How far above the surface a ray starts, over the diagonal.
const LIFT: f64 = 1e-5;

/// Where a ray meets the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The face.
    pub face: u32,
    /// Distance from the origin, in lengths of the direction.
    pub distance: f64,
}

/// A node: its children are `first` and `first + 1`, or its faces start at `first`.
#[derive(Debug, Clone, Copy)]
struct Node {
    low: DVec3,
    high: DVec3,
    first: u32,
    /// Faces of a leaf; 0 for an inner node.
    count: u32,
}

/// A surface made ready for rays.
#[derive(Debug, Clone)]
pub struct Rays {
    nodes: Vec<Node>,
    faces: Vec<u32>,
    corners: Vec<[DVec3; 3]>,
    sheet_mate: Vec<u32>,
    lift: f64,
}

/// What the hierarchy is built from.
struct Builder<'a> {
    surface: &'a Surface,
    centers: &'a [DVec3],
}

impl Builder<'_> {
    /// The nodes over some faces, the root first; `start`: the place of the first of them among all.
    fn nodes(&self, faces: &mut [u32], start: u32) -> Vec<Node> {
        if faces.len() <= SIDE_BY_SIDE {
            return self.in_turn(faces, start);
        }
        let (root, middle) = self.node(faces, start);
        let (lower, upper) = faces.split_at_mut(middle);
        let second = start + middle as u32;
        let (left, right) =
            tasks::join("rays", || self.nodes(lower, start), || self.nodes(upper, second));
        // The two children stand side by side, behind them what is below the first, then the second.
        let mut nodes = Vec::with_capacity(1 + left.len() + right.len());
        nodes.push(Node { first: 1, ..root });
        let moved = |node: &Node, by: usize| match node.count {
            0 => Node { first: node.first + by as u32, ..*node },
            _ => *node,
        };
        let by = [2, left.len() + 1];
        nodes.extend([moved(&left[0], by[0]), moved(&right[0], by[1])]);
        nodes.extend(left[1..].iter().map(|node| moved(node, by[0])));
        nodes.extend(right[1..].iter().map(|node| moved(node, by[1])));
        nodes
    }

    /// The same on one thread.
    fn in_turn(&self, faces: &mut [u32], start: u32) -> Vec<Node> {
        let mut nodes = vec![Node { low: DVec3::ZERO, high: DVec3::ZERO, first: 0, count: 0 }];
        let mut open = vec![(0, 0, faces.len())];
        while let Some((node, from, to)) = open.pop() {
            let (made, middle) = self.node(&mut faces[from..to], start + from as u32);
            nodes[node] = made;
            if made.count == 0 {
                let first = nodes.len();
                nodes[node].first = first as u32;
                nodes.extend([made; 2]);
                open.push((first, from, from + middle));
                open.push((first + 1, from + middle, to));
            }
        }
        nodes
    }

    /// The node over some faces, which are parted in its two halves, and where; a leaf where they are few.
    fn node(&self, faces: &mut [u32], start: u32) -> (Node, usize) {
        let (low, high) = bounds(faces.iter().flat_map(|&f| self.surface.corners(f as usize)));
        if faces.len() <= LEAF {
            return (Node { low, high, first: start, count: faces.len() as u32 }, 0);
        }
        let (from, to) = bounds(faces.iter().map(|&f| self.centers[f as usize]));
        let axis = longest(to - from);
        let middle = faces.len() / 2;
        faces.select_nth_unstable_by(middle, |&a, &b| {
            let (x, y) = (self.centers[a as usize][axis], self.centers[b as usize][axis]);
            x.total_cmp(&y).then(a.cmp(&b))
        });
        (Node { low, high, first: 0, count: 0 }, middle)
    }
}

impl Rays {
    /// Builds the hierarchy. O(n log n).
    pub fn new(surface: &Surface) -> Self {
        let mut faces: Vec<u32> = (0..surface.face_count() as u32).collect();
        let centers = tasks::fill("centers", faces.len(), |f| surface.centroid(f));
        let builder = Builder { surface, centers: &centers };
        let nodes = if faces.is_empty() { Vec::new() } else { builder.nodes(&mut faces, 0) };
        let corners = tasks::fill("corners", faces.len(), |i| surface.corners(faces[i] as usize));
        let sheet_mate = surface.sheet_mate.clone();
        Self { nodes, faces, corners, sheet_mate, lift: LIFT * surface.diagonal }
    }

    /// How many nodes a line through the object's box visits in the mean (surface area heuristic:
    /// MacDonald and Booth 1990, doi:10.1007/BF01911006): some tens for a surface, thousands for a
    /// soup of large faces. For those who count their work before they start it.
    pub fn expected_visits(&self) -> f64 {
        let area = |n: &Node| {
            let e = n.high - n.low;
            e.x * e.y + e.y * e.z + e.z * e.x
        };
        let whole = self.nodes.first().map_or(0.0, area);
        if whole > 0.0 { self.nodes.iter().map(area).sum::<f64>() / whole } else { 0.0 }
    }

    /// The first face that a ray meets within `reach` (in lengths of `direction`). A ray that starts
    /// on face `from` sees neither it nor its mate ([`NONE`]: it sees all).
    pub fn closest_hit(
        &self,
        origin: DVec3,
        direction: DVec3,
        reach: f64,
        from: u32,
    ) -> Option<Hit> {
        let mut best = None;
        self.walk(origin, direction, reach, from, |hit| {
            best = Some(hit);
            Some(hit.distance)
        });
        best
    }

    /// Whether a ray meets any face within `reach`; `from` as in [`Rays::closest_hit`].
    pub fn any_hit(&self, origin: DVec3, direction: DVec3, reach: f64, from: u32) -> bool {
        let mut met = false;
        self.walk(origin, direction, reach, from, |_| {
            met = true;
            None
        });
        met
    }

    /// Every face that a ray meets within `reach`, in no order; `from` as in [`Rays::closest_hit`].
    pub fn hits(
        &self,
        origin: DVec3,
        direction: DVec3,
        reach: f64,
        from: u32,
        mut visit: impl FnMut(Hit),
    ) {
        self.walk(origin, direction, reach, from, |hit| {
            visit(hit);
            Some(reach)
        });
    }

    /// Ambient visibility: the share of `rays` cosine-weighted rays over the hemisphere about
    /// `normal` that escape. 1 is open sky, 0 is sealed. The rays are stratified in radius, spread
    /// in angle by the golden ratio, and turned and jittered by `seed`.
    pub fn ambient_visibility(
        &self,
        point: DVec3,
        normal: DVec3,
        rays: u32,
        seed: u64,
        from: u32,
    ) -> f64 {
        let (Some(normal), true) = (normal.try_normalize(), rays > 0) else { return 1.0 };
        let (side, up) = normal.any_orthonormal_pair();
        let origin = point + normal * self.lift;
        let mut state = seed;
        let turn = uniform(&mut state);
        let golden = 0.5 * (5.0f64.sqrt() - 1.0);
        let escaped = (0..rays)
            .filter(|&i| {
                let across = (f64::from(i) + uniform(&mut state)) / f64::from(rays);
                let angle = std::f64::consts::TAU * (turn + f64::from(i) * golden).fract();
                let (sin, cos) = angle.sin_cos();
                let direction =
                    (side * cos + up * sin) * across.sqrt() + normal * (1.0 - across).sqrt();
                !self.any_hit(origin, direction, f64::INFINITY, from)
            })
            .count();
        escaped as f64 / f64::from(rays)
    }

    /// Calls `visit` with every face within `radius` of `point` and the point of it that is nearest.
    pub fn visit_within(&self, point: DVec3, radius: f64, mut visit: impl FnMut(u32, DVec3)) {
        let mut open: Vec<u32> = if self.nodes.is_empty() { vec![] } else { vec![0] };
        while let Some(i) = open.pop() {
            let node = &self.nodes[i as usize];
            if point.clamp(node.low, node.high).distance_squared(point) > radius * radius {
                continue;
            }
            if node.count == 0 {
                open.extend([node.first, node.first + 1]);
                continue;
            }
            for k in node.first as usize..(node.first + node.count) as usize {
                let nearest = nearest_on_triangle(point, self.corners[k]);
                if nearest.distance_squared(point) <= radius * radius {
                    visit(self.faces[k], nearest);
                }
            }
        }
    }

    /// Visits the hits of a ray, near nodes first. `met` returns the new reach, or `None` to stop.
    fn walk(
        &self,
        origin: DVec3,
        direction: DVec3,
        mut reach: f64,
        from: u32,
        mut met: impl FnMut(Hit) -> Option<f64>,
    ) {
        let mate = self.sheet_mate.get(from as usize).copied().unwrap_or(NONE);
        // Not infinite: 0 · ∞ is no number, and rays along an axis do start on the side of a box.
        let inverse = direction.map(|d| if d.abs() < 1e-300 { 1e300 } else { 1.0 / d });
        let enter = |i: u32, reach: f64| self.nodes[i as usize].enter(origin, inverse, reach);
        // Depth ⌈log₂ n⌉, one waiting sibling a level.
        let mut open = [(0u32, 0.0f64); 64];
        let mut waiting = 0;
        if !self.nodes.is_empty()
            && let Some(t) = enter(0, reach)
        {
            open[0] = (0, t);
            waiting = 1;
        }
        while waiting > 0 {
            waiting -= 1;
            let (i, t) = open[waiting];
            if t > reach {
                continue;
            }
            let node = &self.nodes[i as usize];
            if node.count == 0 {
                let mut pair = [(node.first, None), (node.first + 1, None)];
                for (child, t) in &mut pair {
                    *t = enter(*child, reach);
                }
                // The nearer child goes on top.
                if pair[0].1.unwrap_or(f64::INFINITY) < pair[1].1.unwrap_or(f64::INFINITY) {
                    pair.swap(0, 1);
                }
                for (child, t) in pair {
                    if let Some(t) = t {
                        open[waiting] = (child, t);
                        waiting += 1;
                    }
                }
                continue;
            }
            for k in node.first as usize..(node.first + node.count) as usize {
                let face = self.faces[k];
                if face == from || face == mate {
                    continue;
                }
                if let Some(distance) = crossing(origin, direction, self.corners[k])
                    && distance < reach
                {
                    match met(Hit { face, distance }) {
                        Some(nearer) => reach = nearer,
                        None => return,
                    }
                }
            }
        }
    }
}

impl Node {
    /// Where a ray enters the box, if it does within `reach` (slab test).
    fn enter(&self, origin: DVec3, inverse: DVec3, reach: f64) -> Option<f64> {
        let (a, b) = ((self.low - origin) * inverse, (self.high - origin) * inverse);
        let near = a.min(b).max_element().max(0.0);
        // A little wider than the box: flat boxes must not lose rays to rounding.
        let far = a.max(b).min_element().min(reach) * (1.0 + 1e-12);
        (near <= far).then_some(near)
    }
}

/// The box around points.
fn bounds(points: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
}

/// The axis along which a box is longest.
fn longest(extent: DVec3) -> usize {
    if extent.x >= extent.y && extent.x >= extent.z {
        0
    } else if extent.y >= extent.z {
        1
    } else {
        2
    }
}

/// The next number in [0, 1) of a sequence (SplitMix64: Steele, Lea and Flood 2014,
/// doi:10.1145/2660193.2660195). Small, since every point has a sequence of its own.
fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}
