//! What came of flattening a piece, remembered while a component is joined: another order of joining comes to
//! the same unions again and again. A piece that was refused within a bound is refused within any smaller one;
//! a map that was found serves every bound that it keeps.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hasher};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::fit::Fit;
use crate::charts::part_mesh::Piece;

/// A piece: two hashes of its faces and of how they are glued, so that no two pieces are ever taken for one.
type Key = [u64; 2];

/// What came of a piece.
#[derive(Debug, Clone, Default)]
struct Outcomes {
    /// Maps, in the order in which they were found.
    fits: Vec<Fit>,
    /// The largest bound within which none was found.
    refused: Option<f64>,
}

/// Outcomes of the pieces of one component. What is tried at the same time is noted afterwards and in order, so
/// that what is known does not depend on which of them is done first. What was answered once is answered the same
/// for ever.
#[derive(Debug, Default)]
pub struct Known {
    outcomes: Mutex<HashMap<Key, Outcomes>>,
}

impl Known {
    /// What is known of a piece within `bound` (mean symmetric Dirichlet energy, minus 1): its map, or that it
    /// has none.
    pub fn recall(&self, piece: &Piece, bound: f64) -> Option<Option<Fit>> {
        let outcomes = self.lock();
        let Outcomes { fits, refused } = outcomes.get(&key(piece))?;
        // What was refused stays so, also where a wider bound came upon a map within this one.
        if refused.is_some_and(|refused| bound <= refused) {
            return Some(None);
        }
        fits.iter().find(|fit| fit.energy <= bound).cloned().map(Some)
    }

    /// Remember what was found within `bound`, and hand it back.
    pub fn note(&self, piece: &Piece, bound: f64, found: Option<Fit>) -> Option<Fit> {
        let mut all = self.lock();
        let outcomes = all.entry(key(piece)).or_default();
        match &found {
            Some(fit) => outcomes.fits.push(fit.clone()),
            None => outcomes.refused = Some(outcomes.refused.map_or(bound, |r| r.max(bound))),
        }
        found
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<Key, Outcomes>> {
        self.outcomes.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn key(piece: &Piece) -> Key {
    [0, 1].map(|seed| {
        let mut hasher = DefaultHasher::new();
        hasher.write_u64(seed);
        hasher.write(bytemuck::cast_slice(&piece.faces));
        hasher.write(bytemuck::cast_slice(&piece.disk.triangles));
        hasher.finish()
    })
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;
    use crate::charts::chart::StartKind;
    use crate::flatten::samples;

    fn piece(faces: Vec<u32>) -> Piece {
        let (disk, _) = samples::plane(2, 1, 2.0, 1.0);
        Piece { disk, faces, vertices: Vec::new() }
    }

    #[test]
    fn a_piece_is_flattened_again_only_where_nothing_known_answers() {
        let (known, asked) = (Known::default(), Cell::new(0));
        let ask = |piece: &Piece, bound: f64, energy: Option<f64>| {
            let kind = StartKind::Weld;
            let solve = || {
                asked.set(asked.get() + 1);
                energy.map(|energy| Fit { uv: Vec::new(), energy, kind })
            };
            let found = known.recall(piece, bound);
            let found = found.unwrap_or_else(|| known.note(piece, bound, solve()));
            (found.map(|fit| fit.energy), asked.get())
        };
        let [a, b] = [piece(vec![0, 1, 2, 3]), piece(vec![0, 1, 2, 4])];
        assert_eq!(ask(&a, 0.1, None), (None, 1));
        assert_eq!(ask(&a, 0.05, Some(0.0)), (None, 1), "a smaller bound is refused, too");
        assert_eq!(ask(&a, 0.2, Some(0.15)), (Some(0.15), 2), "a larger one may be kept");
        assert_eq!(ask(&a, 0.15, None), (Some(0.15), 2));
        assert_eq!(ask(&a, 0.1, None), (None, 2), "the refusal stands");
        assert_eq!(ask(&a, 0.12, None), (None, 3), "a map outside of the bound does not serve");
        assert_eq!(ask(&a, 0.2, None), (Some(0.15), 3), "nor does its refusal undo it");
        assert_eq!(ask(&b, 0.1, Some(0.1)), (Some(0.1), 4), "other faces are another piece");
        let cut = Piece { disk: samples::plane(1, 2, 1.0, 2.0).0, ..piece(a.faces.clone()) };
        assert_eq!(
            ask(&cut, 0.1, None),
            (None, 5),
            "so are the same ones that are glued otherwise"
        );
        let c = piece(vec![0, 1, 2, 5]);
        assert_eq!(ask(&c, 0.1, None), (None, 6));
        assert_eq!(ask(&c, 0.2, Some(0.08)), (Some(0.08), 7));
        assert_eq!(ask(&c, 0.1, None), (None, 7), "one answer for ever");
    }
}
