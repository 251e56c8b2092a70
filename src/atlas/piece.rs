//! A chart as the search for an arrangement sees it.

use glam::DVec2;

use super::mask::Outline;

/// A chart to be placed.
#[derive(Debug, Clone)]
pub(super) struct Piece {
    /// Its border, in its own units.
    pub outline: Outline,
    /// Density relative to the other charts.
    pub weight: f64,
    /// Turns (unit vectors) that it may be laid down with, besides quarter turns; never empty.
    pub turns: Vec<DVec2>,
    /// Its area at weight 1; a needle counts as a thin box.
    pub area: f64,
}

impl Piece {
    /// A chart by its outline.
    pub fn new(outline: Outline, weight: f64, turns: Vec<DVec2>) -> Self {
        let mut piece = Self { area: outline.area(), outline, weight, turns };
        piece.area = piece.area.max(1e-6 * (piece.extent() / weight).max_element().powi(2));
        piece
    }

    /// Width and height of its box along its first turn, weighted.
    pub fn extent(&self) -> DVec2 {
        let [low, high] = self.outline.extent(self.turns[0]);
        (high - low) * self.weight
    }
}
