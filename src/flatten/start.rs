//! The start map of a disk: the best of those that cost little and flip nothing.

use super::injective::certify_within;
use super::jacobian::{quality, rescale};
use super::pinches::parted;
use super::{Border, Disk, UvMap, lscm, planar, tutte, unfold};

/// How a start map was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StartMap {
    /// Projected onto the best plane.
    Planar,
    /// Unfolded triangle by triangle.
    Unfold,
    /// Least squares conformal.
    Lscm,
    /// Tutte's embedding in a circle.
    Tutte,
}

/// Excess energy below which nothing better is looked for.
const ISOMETRY: f64 = 1e-9;

/// A way to make a map, where it can be made.
type Maker = fn(&Disk) -> Option<UvMap>;

/// The best map by symmetric Dirichlet energy of those proved injective: projection, unfolding and
/// least squares conformal, or Tutte's embedding where none of them is. Scaled to the 3D area. What
/// is no disk, or is beyond double precision, gets the map with the fewest flips; the caller
/// certifies it as any other. Corners that meet in a point are parted by more than `apart`, where it is given.
pub fn start_map(disk: &Disk, apart: Option<f64>) -> (UvMap, StartMap) {
    let mut best: Option<(f64, UvMap, StartMap)> = None;
    let mut fallback: Option<(u64, f64, UvMap, StartMap)> = None;
    let border = Border::of(disk);
    let makers: [(StartMap, Maker); 4] = [
        (StartMap::Planar, |disk| Some(planar(disk))),
        (StartMap::Unfold, unfold),
        (StartMap::Lscm, |disk| lscm(disk).ok()),
        (StartMap::Tutte, |disk| tutte(disk).ok()),
    ];
    for (kind, make) in makers {
        // The first isometry ends the search; the circle is only a last resort.
        let settled = best
            .as_ref()
            .is_some_and(|(energy, ..)| kind == StartMap::Tutte || *energy - 1.0 <= ISOMETRY);
        if settled {
            break;
        }
        let Some(uv) = make(disk).map(|uv| rescale(disk, uv)) else { continue };
        let uv = apart.and_then(|by| parted(disk, &border, &uv, by)).unwrap_or(uv);
        let q = quality(disk, &uv);
        if q.flips == 0 && certify_within(&border, disk, &uv).is_injective() {
            if best.as_ref().is_none_or(|(energy, ..)| q.optimal < *energy) {
                best = Some((q.optimal, uv, kind));
            }
        } else {
            let order = (q.flips, q.optimal);
            let fewer =
                |&(flips, energy, ..): &(u64, f64, UvMap, StartMap)| order < (flips, energy);
            if fallback.as_ref().is_none_or(fewer) {
                fallback = Some((q.flips, q.optimal, uv, kind));
            }
        }
    }
    let best = best.map(|(_, uv, kind)| (uv, kind));
    let fallback = fallback.map(|(_, _, uv, kind)| (uv, kind));
    best.or(fallback).unwrap_or_else(|| (planar(disk), StartMap::Planar))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::{certify, samples};
    use glam::{DVec2, DVec3};
    use std::f64::consts::TAU;

    #[test]
    fn each_kind_is_taken_where_it_is_best() {
        assert_eq!(start_map(&samples::plane(4, 4, 1.0, 1.0).0, None).1, StartMap::Planar);
        assert_eq!(start_map(&samples::open_box(), None).1, StartMap::Unfold);
        assert_eq!(start_map(&samples::barrel(16, 8), None).1, StartMap::Lscm);
    }

    #[test]
    fn tutte_steps_in_where_the_others_overlap() {
        // A flat spiral staircase of 1.3 turns overlaps itself when flattened in any other way.
        let disk = samples::bent(64, 3, |x, y| {
            (DVec2::from_angle(1.3 * TAU * x) * (0.6 + y)).extend(0.2 * x)
        });
        let (uv, kind) = start_map(&disk, None);
        assert_eq!(kind, StartMap::Tutte);
        assert!(certify(&disk, &uv).is_injective());
    }

    #[test]
    fn what_is_no_disk_still_gets_a_map() {
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y];
        let disk = Disk::new(positions, vec![[0, 1, 2], [0, 3, 4]]);
        assert_eq!(start_map(&disk, None).0.len(), 5);
        assert_eq!(start_map(&Disk::default(), None).0.len(), 0);
    }
}
