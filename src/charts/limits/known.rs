//! What came of flattening a piece, remembered while a component is joined: another order of joining comes to
//! the same unions again and again. A piece that was refused within a bound is refused within any smaller one;
//! a map that was found serves every bound that it keeps.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hasher};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::fit::Fit;
use crate::charts::part_mesh::Piece;
use crate::contract::Canceled;

/// A piece: two hashes of its faces and of how they are glued, so that no two pieces are ever taken for one.
type Key = [u64; 2];

/// What came of a piece.
#[derive(Debug, Clone)]
enum Outcome {
    /// It has this map.
    Fits(Fit),
    /// No map was found within this bound.
    Refused(f64),
}

/// Outcomes of the pieces of one component. Pieces that are flattened at the same time have no face in common, so
/// that what is known does not depend on which of them is done first.
#[derive(Debug, Default)]
pub struct Known(Mutex<HashMap<Key, Outcome>>);

impl Known {
    /// The map of a piece within `bound` (mean symmetric Dirichlet energy, minus 1), from what is known or from
    /// `solve`; `None` where it has none.
    pub fn fit(
        &self,
        piece: &Piece,
        bound: f64,
        solve: impl FnOnce() -> Result<Option<Fit>, Canceled>,
    ) -> Result<Option<Fit>, Canceled> {
        let key = key(piece);
        match self.lock().get(&key) {
            Some(Outcome::Fits(fit)) if fit.energy <= bound => return Ok(Some(fit.clone())),
            Some(Outcome::Refused(refused)) if bound <= *refused => return Ok(None),
            _ => {}
        }
        let found = solve()?;
        let outcome = found.clone().map_or(Outcome::Refused(bound), Outcome::Fits);
        self.lock().insert(key, outcome);
        Ok(found)
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<Key, Outcome>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
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
                Ok(energy.map(|energy| Fit { uv: Vec::new(), energy, kind }))
            };
            let found = known.fit(piece, bound, solve).unwrap().map(|fit| fit.energy);
            (found, asked.get())
        };
        let [a, b] = [piece(vec![0, 1, 2, 3]), piece(vec![0, 1, 2, 4])];
        assert_eq!(ask(&a, 0.1, None), (None, 1));
        assert_eq!(ask(&a, 0.05, Some(0.0)), (None, 1), "a smaller bound is refused, too");
        assert_eq!(ask(&a, 0.2, Some(0.15)), (Some(0.15), 2), "a larger one may be kept");
        assert_eq!(ask(&a, 0.15, None), (Some(0.15), 2));
        assert_eq!(ask(&a, 0.1, None), (None, 3), "a map outside of the bound does not serve");
        assert_eq!(ask(&b, 0.1, Some(0.1)), (Some(0.1), 4), "other faces are another piece");
        let cut = Piece { disk: samples::plane(1, 2, 1.0, 2.0).0, ..piece(a.faces.clone()) };
        assert_eq!(
            ask(&cut, 0.1, None),
            (None, 5),
            "so are the same ones that are glued otherwise"
        );
    }
}
