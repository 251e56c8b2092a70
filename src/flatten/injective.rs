//! The proof that a chart's map is injective: every triangle positively oriented and a simple
//! boundary polygon make a map of a disk one to one (Lipman, "Bijective mappings of meshes with
//! boundary and the degree in mesh processing", 2014, theorem 1). With holes the same holds: a point is
//! covered as often as the boundary polygons wind around it, all together, and that is at most once
//! where they are simple, do not meet, and only one of them runs counter-clockwise. Signs are decided
//! by exact predicates (Shewchuk 1997), so that rounding cannot lie.

use std::ops::Range;

use glam::DVec2;
use robust::{Coord, orient2d};

use super::Disk;
use super::border::Border;
use super::sweep::Sweep;
use crate::tasks;

/// What was found about one chart's map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ChartProof {
    /// Triangles of positive 3D area with negative orientation, or a coordinate that is not finite.
    pub flipped: u64,
    /// Triangles of positive 3D area whose corners are collinear in UV.
    pub zero_area: u64,
    /// Whether the chart is one connected manifold whose boundary polygons neither cross nor touch, one of
    /// them around all others.
    pub simple_boundary: bool,
}

impl ChartProof {
    /// Whether the map is proved injective.
    pub fn is_injective(&self) -> bool {
        self.flipped == 0 && self.zero_area == 0 && self.simple_boundary
    }
}

/// Exact sign of the orientation of a triangle: 1 counter-clockwise, −1 clockwise, 0 collinear.
/// A triangle with a coordinate that is not finite counts as −1.
pub fn orientation([a, b, c]: [DVec2; 3]) -> i32 {
    if !(a.is_finite() && b.is_finite() && c.is_finite()) {
        return -1;
    }
    let at = |p: DVec2| Coord { x: p.x, y: p.y };
    let sign = orient2d(at(a), at(b), at(c));
    i32::from(sign > 0.0) - i32::from(sign < 0.0)
}

/// Whether a triangle is counter-clockwise, exactly.
pub fn is_positive(triangle: [DVec2; 3]) -> bool {
    orientation(triangle) > 0
}

/// How many triangles of positive 3D area are not positively oriented.
pub fn count_flips(disk: &Disk, uv: &[DVec2]) -> u64 {
    let corners = |f: usize| disk.triangles[f].map(|v| uv[v as usize]);
    let flipped = |&f: &usize| disk.areas[f] > 0.0 && !is_positive(corners(f));
    let count = |faces: Range<usize>| faces.filter(flipped).count() as u64;
    tasks::blocks("flips", disk.triangles.len(), count).into_iter().sum()
}

/// Prove, or say why not, that a map is injective.
pub fn certify(disk: &Disk, uv: &[DVec2]) -> ChartProof {
    certify_within(&Border::of(disk), disk, uv)
}

/// Like [`certify`], for a disk whose border is known.
pub fn certify_within(border: &Border, disk: &Disk, uv: &[DVec2]) -> ChartProof {
    let block = |faces: Range<usize>| {
        let (mut flipped, mut zero_area) = (0, 0);
        for f in faces.filter(|&f| disk.areas[f] > 0.0) {
            match orientation(disk.triangles[f].map(|v| uv[v as usize])) {
                -1 => flipped += 1,
                0 => zero_area += 1,
                _ => {}
            }
        }
        (flipped, zero_area)
    };
    let blocks = tasks::blocks("orientations", disk.triangles.len(), block);
    let (flipped, zero_area) = blocks.into_iter().fold((0, 0), |(a, b), (x, y)| (a + x, b + y));
    ChartProof { flipped, zero_area, simple_boundary: has_simple_boundary(border, uv) }
}

/// Whether a chart is one connected manifold whose boundary polygons neither cross nor touch, exactly one
/// of them counter-clockwise.
pub fn has_simple_boundary(border: &Border, uv: &[DVec2]) -> bool {
    if !border.manifold || border.pieces != 1 {
        return false;
    }
    let rings: Vec<Vec<DVec2>> =
        border.loops.iter().map(|ring| ring.iter().map(|&v| uv[v as usize]).collect()).collect();
    rings.iter().filter(|ring| signed_area(ring) > 0.0).count() == 1 && are_simple(&rings)
}

/// Area within a polygon, negative if it runs clockwise.
fn signed_area(ring: &[DVec2]) -> f64 {
    let at = |k: usize| ring[k % ring.len()] - ring[0];
    (1..ring.len()).map(|k| 0.5 * at(k).perp_dot(at(k + 1))).sum()
}

/// Whether a closed polygon neither crosses nor touches itself.
pub fn is_simple(polygon: &[DVec2]) -> bool {
    are_simple(&[polygon.to_vec()])
}

/// Whether closed polygons neither cross nor touch themselves or each other: neighbouring edges share
/// their common vertex and nothing else, other edges share nothing.
fn are_simple(rings: &[Vec<DVec2>]) -> bool {
    // Edges of all rings in a row, each with the number of the edge after it.
    let (mut edges, mut after) = (Vec::new(), Vec::new());
    for ring in rings {
        let n = ring.len();
        if n < 3 || ring.iter().any(|p| !p.is_finite()) {
            return false;
        }
        let first = edges.len() as u32;
        for k in 0..n {
            edges.push([ring[k], ring[(k + 1) % n]]);
            after.push(first + ((k + 1) % n) as u32);
        }
    }
    if edges.iter().any(|[a, b]| a == b) {
        return false;
    }
    let boxes = edges.iter().map(|[a, b]| [a.min(*b), a.max(*b)]).collect();
    !Sweep::new(boxes).any(|i, j| {
        let (e, f) = (edges[i as usize], edges[j as usize]);
        // In a triangle the last edge both precedes the first and follows the second: each pair
        // shares one vertex all the same.
        match (after[i as usize] == j, after[j as usize] == i) {
            (true, _) => folds_back(e, f),
            (_, true) => folds_back(f, e),
            _ => segments_meet(e, f),
        }
    })
}

/// Whether the edge b→c runs back over the edge a→b.
fn folds_back([a, b]: [DVec2; 2], [_, c]: [DVec2; 2]) -> bool {
    orientation([a, b, c]) == 0 && {
        // Comparisons of coordinates are exact where a dot product would not be.
        let side = |p: f64, q: f64| (p > q) as i32 - (p < q) as i32;
        side(a.x, b.x) == side(c.x, b.x) && side(a.y, b.y) == side(c.y, b.y)
    }
}

/// Whether two closed segments share a point, exactly.
pub fn segments_meet([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> bool {
    let (abc, abd) = (orientation([a, b, c]), orientation([a, b, d]));
    let (cda, cdb) = (orientation([c, d, a]), orientation([c, d, b]));
    if abc * abd < 0 && cda * cdb < 0 {
        return true;
    }
    let within = |p: DVec2, q: DVec2, r: DVec2| r.cmpge(p.min(q)).all() && r.cmple(p.max(q)).all();
    (abc == 0 && within(a, b, c))
        || (abd == 0 && within(a, b, d))
        || (cda == 0 && within(c, d, a))
        || (cdb == 0 && within(c, d, b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::samples;

    fn polygon(points: &[(f64, f64)]) -> Vec<DVec2> {
        points.iter().map(|&(x, y)| DVec2::new(x, y)).collect()
    }

    #[test]
    fn squares_are_simple_and_bowties_are_not() {
        assert!(is_simple(&polygon(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])));
        assert!(!is_simple(&polygon(&[(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)])));
        assert!(is_simple(&polygon(&[(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])));
        assert!(!is_simple(&polygon(&[(0.0, 0.0), (1.0, 0.0)])));
    }

    #[test]
    fn touching_is_not_simple() {
        // A vertex that lies exactly on a far edge, and one a rounding unit beside it.
        let dent = |y: f64| polygon(&[(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, y), (0.0, 1.0)]);
        assert!(!is_simple(&dent(0.0)));
        assert!(is_simple(&dent(f64::MIN_POSITIVE)));
        // Two vertices at one place; an edge that runs back over its neighbour; an empty edge.
        let pinch = [(0.0, 0.0), (2.0, 0.0), (1.0, 1.0), (2.0, 2.0), (0.0, 2.0), (1.0, 1.0)];
        assert!(!is_simple(&polygon(&pinch)));
        assert!(!is_simple(&polygon(&[(0.0, 0.0), (2.0, 0.0), (1.0, 0.0), (1.0, 1.0)])));
        assert!(!is_simple(&polygon(&[(0.0, 0.0), (2.0, 0.0), (2.0, 0.0), (1.0, 1.0)])));
        // Straight on is no fold.
        assert!(is_simple(&polygon(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (1.0, 1.0)])));
    }

    #[test]
    fn certificate_proves_a_plane_and_finds_what_is_wrong() {
        let (disk, uv) = samples::plane(4, 4, 1.0, 1.0);
        assert!(certify(&disk, &uv).is_injective());

        let mut flipped = uv.clone();
        flipped[12] = DVec2::new(0.9, 0.55);
        let proof = certify(&disk, &flipped);
        assert!(proof.flipped > 0 && proof.simple_boundary && !proof.is_injective());

        // All corners on a line, and none anywhere.
        let (square, _) = samples::plane(1, 1, 1.0, 1.0);
        let one = Disk::new(square.positions[..3].to_vec(), vec![[0, 1, 2]]);
        let line = [0.0, 0.1, 0.2].map(|x| DVec2::new(x, x)).to_vec();
        assert_eq!(certify(&one, &line).zero_area, 1);
        let nan = vec![DVec2::NAN; 3];
        assert_eq!(certify(&one, &nan).flipped, 1);
    }

    #[test]
    fn a_flat_sheet_with_a_hole_is_proved_and_one_that_is_filled_twice_is_not() {
        let (disk, uv) = samples::plane(3, 3, 3.0, 3.0);
        let center = |t: &[u32; 3]| t.iter().map(|&v| uv[v as usize]).sum::<DVec2>() / 3.0;
        let hole = |t: &&[u32; 3]| (center(t) - 1.5).abs().max_element() > 0.5;
        let ring = Disk::new(
            disk.positions.clone(),
            disk.triangles.iter().filter(hole).copied().collect(),
        );
        assert_eq!(Border::of(&ring).loops.len(), 2);
        assert!(certify(&ring, &uv).is_injective());
        let mirrored: Vec<DVec2> = uv.iter().map(|p| DVec2::new(-p.x, p.y)).collect();
        assert!(!certify(&ring, &mirrored).is_injective());
        // The hole's rim pulled out over the border.
        let mut pulled = uv.clone();
        pulled[5] = DVec2::new(-0.5, 1.0);
        assert!(!certify(&ring, &pulled).is_injective());
    }

    #[test]
    fn a_ring_that_laps_over_itself_has_no_flips_but_no_simple_boundary() {
        // A strip bent through 1.5 turns.
        let (disk, flat) = samples::plane(60, 1, 60.0, 1.0);
        let spiral: Vec<DVec2> = flat
            .iter()
            .map(|p| DVec2::from_angle(-p.x / 60.0 * 3.0 * std::f64::consts::PI) * (5.0 + p.y))
            .collect();
        let proof = certify(&disk, &spiral);
        assert_eq!((proof.flipped, proof.simple_boundary), (0, false));
    }
}
