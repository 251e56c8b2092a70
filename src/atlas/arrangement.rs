//! In which order the charts are placed, and along which direction each is laid down.

use glam::DVec2;

use super::piece::Piece;
use crate::device::Seeded;
use crate::flatten::smallest_rectangle;

/// Directions between an upright chart and one turned by a quarter.
const DIRECTIONS: u32 = 6;

/// Orders that a search begins with.
pub(super) const ORDERS: usize = 4;

/// Order of the charts, and which of its turns each takes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Arrangement {
    pub order: Vec<u32>,
    pub turn: Vec<u8>,
}

/// Turns (unit vectors) for a chart that may be turned freely: its smallest rectangle upright, by an
/// eighth, and by shares of a quarter.
pub(super) fn free_turns(points: &[DVec2]) -> Vec<DVec2> {
    let upright = smallest_rectangle(points, 0.0)
        .and_then(|[a, b, ..]| (b - a).try_normalize())
        .map_or(DVec2::X, |axis| DVec2::new(axis.x, -axis.y));
    let quarter = std::f64::consts::FRAC_PI_2;
    let shares = (1..DIRECTIONS).map(|k| f64::from(k) / f64::from(DIRECTIONS));
    [0.0, 0.5]
        .into_iter()
        .chain(shares)
        .map(|share| DVec2::from_angle(share * quarter).rotate(upright))
        .collect()
}

impl Arrangement {
    /// Each chart along its first turn, the largest first: by the half perimeter of its box, by
    /// what is free in its box (so that frames come before what may lie in them), by its box, or by
    /// its longer side, as `which` < [`ORDERS`] says.
    pub fn largest_first(pieces: &[Piece], which: usize) -> Self {
        let size = |piece: &Piece| {
            let extent = piece.extent();
            match which {
                0 => extent.element_sum(),
                1 => extent.element_product() - piece.area * piece.weight.powi(2),
                2 => extent.element_product(),
                _ => extent.max_element(),
            }
        };
        let sizes: Vec<f64> = pieces.iter().map(size).collect();
        let mut order: Vec<u32> = (0..pieces.len() as u32).collect();
        order.sort_by(|&a, &b| sizes[b as usize].total_cmp(&sizes[a as usize]).then(a.cmp(&b)));
        Self { order, turn: vec![0; pieces.len()] }
    }

    /// The same with up to three charts moved in the order or laid along another of their turns,
    /// the first ones more often.
    pub fn changed(&self, pieces: &[Piece], random: &mut Seeded) -> Self {
        let mut changed = self.clone();
        let count = self.order.len();
        // A whole number below `end`, small ones the likelier the larger the power.
        let mut draw = |end: usize, power: f64| {
            ((random.unit_f64().powf(power) * end as f64) as usize).min(end.saturating_sub(1))
        };
        for _ in 0..=draw(3, 3.0) {
            let at = draw(count, 1.5);
            let chart = changed.order[at];
            let turns = pieces[chart as usize].turns.len();
            if turns > 1 && draw(2, 1.0) == 0 {
                changed.turn[chart as usize] = draw(turns, 1.0) as u8;
            } else {
                changed.order.remove(at);
                changed.order.insert(draw(count, 1.5), chart);
            }
        }
        changed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::atlas::mask::Outline;
    use crate::flatten::samples;

    fn squares(count: usize) -> Vec<Piece> {
        let piece = |i: usize| {
            let (disk, uv) = samples::plane(1, 1, 1.0 + i as f64, 1.0);
            Piece::new(Outline::of(&disk, &uv), 1.0, free_turns(&uv))
        };
        (0..count).map(piece).collect()
    }

    #[test]
    fn the_largest_come_first_and_changes_keep_every_chart() {
        let pieces = squares(9);
        for which in 0..ORDERS {
            let mut last = Arrangement::largest_first(&pieces, which);
            if which != 1 {
                assert!(last.order.is_sorted_by(|a, b| a > b), "{which}");
            }
            for k in 0..200 {
                let next = last.changed(&pieces, &mut Seeded::new(1, k));
                let mut sorted = next.order.clone();
                sorted.sort_unstable();
                assert_eq!(sorted, (0..9).collect::<Vec<_>>());
                assert!(next.turn.iter().all(|&t| usize::from(t) < pieces[0].turns.len()));
                last = next;
            }
        }
    }

    #[test]
    fn the_first_turn_sets_the_smallest_rectangle_upright() {
        let (_, uv) = samples::plane(3, 2, 3.0, 1.0);
        let turned: Vec<DVec2> = uv.iter().map(|&p| DVec2::from_angle(0.7).rotate(p)).collect();
        let upright = free_turns(&turned)[0];
        let points = || turned.iter().map(|&p| upright.rotate(p));
        let extent = points().fold(DVec2::NEG_INFINITY, DVec2::max)
            - points().fold(DVec2::INFINITY, DVec2::min);
        assert!((extent.element_product() - 3.0).abs() < 1e-9);
    }
}
