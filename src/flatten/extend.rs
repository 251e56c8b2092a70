//! A map of some of a disk's vertices continued to the others: triangles at the edge of what is mapped are
//! unfolded next to it, ring by ring, and what was laid out is then made as nearly rigid as it can be.

use glam::DVec2;

use super::fans::Fans;
use super::unfold::third_corner;
use super::untangle::make_rigid;
use super::{Disk, UvMap};

/// Rounds that make the continued part rigid.
const ROUNDS: u32 = 40;

/// Continue a map to the vertices that are NaN, at the scale of the disk: the part that is known is scaled to
/// the area of its triangles first. `None` where nothing is known, or something is out of reach.
pub fn extend(disk: &Disk, mut uv: UvMap) -> Option<UvMap> {
    let (mut solid, mut flat) = (0.0, 0.0);
    for (f, t) in disk.triangles.iter().enumerate() {
        if t.iter().all(|&v| !uv[v as usize].is_nan()) {
            solid += disk.areas[f];
            flat += disk.uv_area(f, &uv);
        }
    }
    if solid > 0.0 && flat > 0.0 {
        let scale = (solid / flat).sqrt();
        uv.iter_mut().for_each(|p| *p *= scale);
    }
    let missing: Vec<u32> = (0..uv.len() as u32).filter(|&v| uv[v as usize].is_nan()).collect();
    if missing.is_empty() {
        return Some(uv);
    }
    let fans = Fans::of(disk);
    let mut waiting = missing.clone();
    while !waiting.is_empty() {
        let found: Vec<(u32, DVec2)> = waiting
            .iter()
            .filter_map(|&v| Some((v, laid_out(disk, &uv, fans.at(v as usize))?)))
            .collect();
        if found.is_empty() {
            return None;
        }
        found.into_iter().for_each(|(v, p)| uv[v as usize] = p);
        waiting.retain(|&v| uv[v as usize].is_nan());
    }
    for _ in 0..ROUNDS {
        for &v in &missing {
            make_rigid(disk, &mut uv, v as usize, fans.at(v as usize));
        }
    }
    Some(uv)
}

/// The mean of where a vertex comes to lie by its faces whose other corners are known.
fn laid_out(disk: &Disk, uv: &[DVec2], fan: &[u32]) -> Option<DVec2> {
    let (mut sum, mut count) = (DVec2::ZERO, 0.0);
    for &c in fan {
        let (f, k) = (c as usize / 3, c as usize % 3);
        let t = disk.triangles[f];
        let [a, b, apex] = [(k + 1) % 3, (k + 2) % 3, k].map(|k| t[k] as usize);
        if !uv[a].is_nan() && !uv[b].is_nan() {
            sum += third_corner(uv[a], uv[b], [a, b, apex].map(|v| disk.positions[v]));
            count += 1.0;
        }
    }
    (count > 0.0).then(|| sum / count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::{quality, samples};

    #[test]
    fn a_plane_is_continued_to_itself() {
        let (disk, flat) = samples::plane(12, 12, 1.0, 1.0);
        let known = flat.iter().map(|p| if p.x < 0.6 { *p } else { DVec2::NAN }).collect();
        let uv = extend(&disk, known).unwrap();
        assert!(uv.iter().zip(&flat).all(|(p, q)| p.distance(*q) < 1e-9));
    }

    #[test]
    fn a_barrel_is_continued_with_little_distortion() {
        let disk = samples::barrel(24, 24);
        let whole = crate::flatten::start_map(&disk, None).0;
        let whole = crate::flatten::slim(&disk, &whole, &Default::default(), &Default::default());
        let whole = whole.unwrap();
        let low = whole.iter().map(|p| p.x).fold(f64::MAX, f64::min);
        let high = whole.iter().map(|p| p.x).fold(f64::MIN, f64::max);
        let most = low + 0.85 * (high - low);
        let known = whole.iter().map(|p| if p.x < most { *p } else { DVec2::NAN }).collect();
        let uv = extend(&disk, known).unwrap();
        let (before, after) = (quality(&disk, &whole), quality(&disk, &uv));
        assert_eq!(after.flips, 0);
        assert!(after.mean - 1.0 < 1.5 * (before.mean - 1.0) + 1e-3, "{before:?} {after:?}");
    }

    #[test]
    fn nothing_is_made_of_nothing() {
        let (disk, flat) = samples::plane(2, 2, 1.0, 1.0);
        assert_eq!(extend(&disk, vec![DVec2::NAN; flat.len()]), None);
    }
}
