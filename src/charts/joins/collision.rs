//! Whether two charts laid next to each other run into each other: cheap evidence that their union
//! cannot be injective, before it is solved for.

use glam::DVec2;

/// Whether a corner of one outline lies deeper than `depth` inside the other. An outline is the
/// polygons of a chart's border, holes among them. Says nothing of outlines that cross without that.
pub fn collide(one: &[Vec<DVec2>], other: &[Vec<DVec2>], depth: f64) -> bool {
    reaches_into(one, other, depth) || reaches_into(other, one, depth)
}

fn reaches_into(one: &[Vec<DVec2>], other: &[Vec<DVec2>], depth: f64) -> bool {
    let low = other.iter().flatten().copied().fold(DVec2::INFINITY, DVec2::min) + depth;
    let high = other.iter().flatten().copied().fold(DVec2::NEG_INFINITY, DVec2::max) - depth;
    let mut near = one.iter().flatten().filter(|p| p.cmpge(low).all() && p.cmple(high).all());
    near.any(|&p| is_inside(p, other) && distance_squared(p, other) > depth * depth)
}

fn edges(outline: &[Vec<DVec2>]) -> impl Iterator<Item = [DVec2; 2]> {
    outline.iter().flat_map(|ring| {
        let before = ring.iter().cycle().skip(ring.len().saturating_sub(1));
        before.zip(ring).map(|(&a, &b)| [a, b])
    })
}

/// Even-odd rule: a point in a hole is outside.
fn is_inside(p: DVec2, outline: &[Vec<DVec2>]) -> bool {
    let crossed = edges(outline).filter(|[a, b]| {
        (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
    });
    crossed.count() % 2 == 1
}

fn distance_squared(p: DVec2, outline: &[Vec<DVec2>]) -> f64 {
    let to_edge = |[a, b]: [DVec2; 2]| {
        let d = b - a;
        let t = if d == DVec2::ZERO { 0.0 } else { (p - a).dot(d) / d.length_squared() };
        p.distance_squared(a + d * t.clamp(0.0, 1.0))
    };
    edges(outline).map(to_edge).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, side: f64) -> Vec<DVec2> {
        [(0., 0.), (1., 0.), (1., 1.), (0., 1.)]
            .map(|(u, v)| DVec2::new(x + side * u, side * v))
            .to_vec()
    }

    #[test]
    fn the_depth_decides() {
        let left = [square(0.0, 1.0)];
        let shift = DVec2::new(0.0, 0.3);
        let right = [square(0.9, 0.5).into_iter().map(|p| p + shift).collect::<Vec<_>>()];
        assert!(collide(&left, &right, 0.05) && collide(&right, &left, 0.05));
        assert!(!collide(&left, &right, 0.15));
    }

    #[test]
    fn what_lies_in_a_hole_does_not_collide() {
        let hole: Vec<DVec2> = square(0.0, 0.6).into_iter().rev().map(|p| p + 0.2).collect();
        let frame = [square(0.0, 1.0), hole];
        let inside = [square(0.0, 0.4).into_iter().map(|p| p + 0.3).collect::<Vec<_>>()];
        assert!(!collide(&frame, &inside, 0.01));
        assert!(collide(&frame[..1], &inside, 0.01));
    }
}
