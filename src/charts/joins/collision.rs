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
    let Some(first) = near.next() else { return false };
    let rows = Rows::new(other, low.y - depth, high.y + depth, depth);
    [first].into_iter().chain(near).any(|&p| rows.is_inside(p) && rows.is_clear_of(p, depth))
}

fn edges(outline: &[Vec<DVec2>]) -> impl Iterator<Item = [DVec2; 2]> {
    outline.iter().flat_map(|ring| {
        let before = ring.iter().cycle().skip(ring.len().saturating_sub(1));
        before.zip(ring).map(|(&a, &b)| [a, b])
    })
}

/// The edges of an outline in rows, each in those that it reaches: a plate has holes by the thousand, and a point
/// asks only what is beside it.
struct Rows {
    low: f64,
    height: f64,
    rows: Vec<Vec<[DVec2; 2]>>,
}

impl Rows {
    /// Rows from `low` to `high`, none of them lower than `least`.
    fn new(outline: &[Vec<DVec2>], low: f64, high: f64, least: f64) -> Self {
        let edges: Vec<[DVec2; 2]> = edges(outline).collect();
        let count = (edges.len() as f64).sqrt().min((high - low) / least).max(1.0) as usize;
        let height = (high - low) / count as f64;
        let mut rows = Self { low, height, rows: vec![Vec::new(); count] };
        for [a, b] in edges {
            for row in rows.row(a.y.min(b.y))..=rows.row(a.y.max(b.y)) {
                rows.rows[row].push([a, b]);
            }
        }
        rows
    }

    fn row(&self, y: f64) -> usize {
        (((y - self.low) / self.height).max(0.0) as usize).min(self.rows.len() - 1)
    }

    /// Even-odd rule: a point in a hole is outside.
    fn is_inside(&self, p: DVec2) -> bool {
        let crossed = self.rows[self.row(p.y)].iter().filter(|[a, b]| {
            (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
        });
        crossed.count() % 2 == 1
    }

    /// Whether no edge is as near as this.
    fn is_clear_of(&self, p: DVec2, distance: f64) -> bool {
        let is_far = |&[a, b]: &[DVec2; 2]| {
            let d = b - a;
            let t = if d == DVec2::ZERO { 0.0 } else { (p - a).dot(d) / d.length_squared() };
            p.distance_squared(a + d * t.clamp(0.0, 1.0)) > distance * distance
        };
        let rows = self.row(p.y - distance)..=self.row(p.y + distance);
        self.rows[rows].iter().flatten().all(is_far)
    }
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
    fn of_a_plate_with_many_holes_each_is_known() {
        let hole = |x: usize, y: usize| -> Vec<DVec2> {
            let at = DVec2::new(x as f64, y as f64) + 0.25;
            square(0.0, 0.5).into_iter().rev().map(|p| p + at).collect()
        };
        let holes = (0..400).map(|i| hole(i % 20, i / 20));
        let plate: Vec<Vec<DVec2>> = [square(0.0, 20.0)].into_iter().chain(holes).collect();
        let dot = |x: f64, y: f64| [square(x, 0.1).into_iter().map(|p| p + DVec2::Y * y).collect()];
        for (x, y) in [(0, 0), (7, 3), (19, 19), (12, 0)].map(|(x, y)| (f64::from(x), f64::from(y)))
        {
            assert!(!collide(&plate, &dot(x + 0.4, y + 0.4), 0.01), "in a hole");
            assert!(collide(&plate, &dot(x + 0.1, y + 0.1), 0.01), "between holes");
        }
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
