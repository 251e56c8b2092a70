//! Can these faces be flattened within the bound, and is the map injective? The question that every
//! patch and every merge is put to.

use glam::DMat2;

use super::ChartLimits;
use crate::charts::chart::StartKind;
use crate::contract::{Canceled, Run};
use crate::flatten::{self, Border, Disk, SlimOptions, UvMap};

/// Descent steps that a trial may take: a union that is far off after these is refused.
const STEPS: u32 = 6;

/// Times the last decrease that a trial is still hoped to descend.
const HOPELESS: f64 = 2.0;

/// Times the bound from where on a union's map is not hoped to descend. Of 3,680 unions above it that were
/// tried on 31 objects 40 came within the bound, and a fifth of all work went into them.
const FAR: f64 = 10.0;

/// A map that fits.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The map: injective, scale 1.
    pub uv: UvMap,
    /// Area-weighted mean symmetric Dirichlet energy, minus 1.
    pub energy: f64,
    /// What it was made from.
    pub kind: StartKind,
}

/// Charts laid next to each other to be one.
pub struct Joined {
    /// Every vertex at the mean of its corners.
    pub uv: UvMap,
    /// Jacobian of each triangle in its own chart's map.
    pub frames: Vec<DMat2>,
}

/// Sew joined charts together and improve their map until it is within the bound (area-weighted mean
/// symmetric Dirichlet energy, minus 1) and proved injective; `None` where that cannot be had, or not within a
/// few steps.
pub fn refine(
    disk: &Disk,
    joined: Joined,
    bound: f64,
    limits: &ChartLimits,
    run: &Run,
) -> Result<Option<Fit>, Canceled> {
    let energy = |uv: &UvMap| {
        let quality = flatten::quality(disk, uv);
        if quality.flips > 0 { f64::INFINITY } else { quality.mean - 1.0 }
    };
    let mut warm = flatten::rescale(disk, joined.uv);
    let mut least = energy(&warm);
    if least > bound
        && let Ok(sewn) = flatten::stitch(disk, &joined.frames, &warm)
    {
        let sewn = flatten::rescale(disk, sewn);
        let reached = energy(&sewn);
        if reached < least {
            (warm, least) = (sewn, reached);
        }
    }
    if least.is_infinite() {
        let start = start(disk, limits);
        if energy(&start.0) > FAR * bound {
            return Ok(None);
        }
        return descend(disk, start, bound, limits, run);
    }
    if least > FAR * bound {
        return Ok(None);
    }
    let border = Border::of(disk);
    if let Some(parted) = parted(disk, &border, &warm, limits) {
        warm = parted;
    }
    if !flatten::has_simple_boundary(&border, &warm) {
        return Ok(None);
    }
    descend(disk, (warm, StartKind::Weld), bound, limits, run)
}

/// The best start map, improved until it is within the bound and proved injective; `None` where that
/// cannot be had.
pub fn from_scratch(
    disk: &Disk,
    bound: f64,
    limits: &ChartLimits,
    run: &Run,
) -> Result<Option<Fit>, Canceled> {
    descend(disk, start(disk, limits), bound, limits, run)
}

/// The best start map, and how it was made.
fn start(disk: &Disk, limits: &ChartLimits) -> (UvMap, StartKind) {
    let (start, kind) = flatten::start_map(disk, limits.pinches.then_some(limits.clearance));
    (start, kind.into())
}

/// Whether a map is proved injective and its border keeps clear of itself.
pub fn is_sound(disk: &Disk, uv: &UvMap, clearance: f64) -> bool {
    is_sound_within(&Border::of(disk), disk, uv, clearance)
}

/// Like [`is_sound`], for a disk whose border is known.
pub fn is_sound_within(border: &Border, disk: &Disk, uv: &UvMap, clearance: f64) -> bool {
    flatten::certify_within(border, disk, uv).is_injective()
        && flatten::is_clear(border, uv, clearance)
}

/// A map with its pinched corners parted, where it has any and may.
fn parted(disk: &Disk, border: &Border, uv: &UvMap, limits: &ChartLimits) -> Option<UvMap> {
    limits.pinches.then(|| flatten::parted(disk, border, uv, limits.clearance)).flatten()
}

fn descend(
    disk: &Disk,
    (mut uv, kind): (UvMap, StartKind),
    bound: f64,
    limits: &ChartLimits,
    run: &Run,
) -> Result<Option<Fit>, Canceled> {
    let mut quality = flatten::quality(disk, &uv);
    if quality.mean - 1.0 > bound {
        let options = SlimOptions {
            iterations: STEPS,
            target: Some(1.0 + 0.9 * bound),
            give_up: Some(HOPELESS),
            // What was stitched is near the optimum already.
            newton: kind == StartKind::Weld,
            ..Default::default()
        };
        uv = flatten::slim(disk, &uv, &options, &run.cancel)?;
        quality = flatten::quality(disk, &uv);
    }
    if quality.mean - 1.0 > bound || quality.flips > 0 {
        return Ok(None);
    }
    let border = Border::of(disk);
    if !is_sound_within(&border, disk, &uv, limits.clearance) {
        let Some(parted) = parted(disk, &border, &uv, limits) else { return Ok(None) };
        uv = parted;
        quality = flatten::quality(disk, &uv);
        let sound = quality.flips == 0 && is_sound_within(&border, disk, &uv, limits.clearance);
        if !sound || quality.mean - 1.0 > bound {
            return Ok(None);
        }
    }
    Ok(Some(Fit { uv, energy: quality.mean - 1.0, kind }))
}
