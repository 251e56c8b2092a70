//! Can these faces be flattened within the bound, and is the map injective? The question that every
//! patch and every merge is put to.

use glam::DMat2;

use super::ChartLimits;
use crate::charts::chart::StartKind;
use crate::contract::{Canceled, Run};
use crate::flatten::{self, Border, Disk, Pattern, Slim, SlimOptions, UvMap};
use crate::tasks;

/// Descent steps that a trial may take: a union that is far off after these is refused.
const STEPS: u32 = 6;

/// Times the decrease that a step promises, or took, that a trial is still hoped to descend. Of 13,279 unions of
/// 66 objects that took Newton's steps 2,855 came within the bound, 71 of them against this.
const HOPELESS: f64 = 2.5;

/// Times the bound from where on a union's map is not hoped to descend. Of the 20,441 unions of these objects that
/// came within the bound 53 started farther off.
const FAR: f64 = 6.0;

/// A map that fits.
#[derive(Debug, Clone, PartialEq)]
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
    run.count(disk.triangles.len());
    let energy = |uv: &UvMap| flatten::mean_energy(disk, uv) - 1.0;
    let mut warm = flatten::rescale(disk, joined.uv);
    let mut least = energy(&warm);
    // Sewing and descent solve on one pattern.
    let found = || tasks::link("pattern", || disk.pattern().ok());
    let pattern = if least > bound { found() } else { None };
    if let Some(pattern) = &pattern
        && let Ok(sewn) =
            tasks::link("stitch", || flatten::stitch(disk, pattern, &joined.frames, &warm))
    {
        let torn = flatten::misfit(disk, &joined.frames, &sewn);
        let sewn = flatten::rescale(disk, sewn);
        let reached = energy(&sewn);
        if least.min(reached).is_infinite() && torn > FAR * bound {
            return Ok(None);
        }
        if reached < least {
            (warm, least) = (sewn, reached);
        }
    }
    if least.is_infinite() {
        let start = start(disk, limits);
        if energy(&start.0) > FAR * bound {
            return Ok(None);
        }
        return descend(disk, (None, pattern.as_ref()), start, bound, limits, run);
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
    descend(disk, (Some(border), pattern.as_ref()), (warm, StartKind::Weld), bound, limits, run)
}

/// The best start map, improved until it is within the bound and proved injective; `None` where that
/// cannot be had.
pub fn from_scratch(
    disk: &Disk,
    bound: f64,
    limits: &ChartLimits,
    run: &Run,
) -> Result<Option<Fit>, Canceled> {
    run.count(disk.triangles.len());
    descend(disk, (None, None), start(disk, limits), bound, limits, run)
}

/// The best start map, and how it was made.
fn start(disk: &Disk, limits: &ChartLimits) -> (UvMap, StartKind) {
    let clearance = limits.pinches.then_some(limits.clearance);
    let (start, kind) = tasks::link("start map", || flatten::start_map(disk, clearance));
    (start, kind.into())
}

/// Whether a map is proved injective and its border keeps clear of itself.
pub fn is_sound(disk: &Disk, uv: &UvMap, clearance: f64) -> bool {
    is_sound_within(&Border::of(disk), disk, uv, clearance)
}

/// Like [`is_sound`], for a disk whose border is known.
pub fn is_sound_within(border: &Border, disk: &Disk, uv: &UvMap, clearance: f64) -> bool {
    tasks::link("proof", || {
        flatten::certify_within(border, disk, uv).is_injective()
            && flatten::is_clear(border, uv, clearance)
    })
}

/// A map with its pinched corners parted, where it has any and may.
fn parted(disk: &Disk, border: &Border, uv: &UvMap, limits: &ChartLimits) -> Option<UvMap> {
    limits.pinches.then(|| flatten::parted(disk, border, uv, limits.clearance)).flatten()
}

/// Improve a map until it is within the bound, and prove it injective. `border`, `pattern`: those of the disk, if
/// they are known.
fn descend(
    disk: &Disk,
    (border, pattern): (Option<Border>, Option<&Pattern>),
    (mut uv, kind): (UvMap, StartKind),
    bound: f64,
    limits: &ChartLimits,
    run: &Run,
) -> Result<Option<Fit>, Canceled> {
    let mut energy = flatten::mean_energy(disk, &uv) - 1.0;
    if energy > bound {
        let options = SlimOptions {
            iterations: STEPS,
            target: Some(1.0 + 0.9 * bound),
            give_up: Some(HOPELESS),
            // What was stitched is near the optimum already.
            newton: kind == StartKind::Weld,
            ..Default::default()
        };
        uv = Slim::descend_on(disk, pattern, &uv, &options, &run.cancel)?.uv;
        energy = flatten::mean_energy(disk, &uv) - 1.0;
    }
    // A map with flips has infinite energy.
    if energy > bound {
        return Ok(None);
    }
    let border = border.unwrap_or_else(|| Border::of(disk));
    if !is_sound_within(&border, disk, &uv, limits.clearance) {
        let Some(parted) = parted(disk, &border, &uv, limits) else { return Ok(None) };
        uv = parted;
        energy = flatten::mean_energy(disk, &uv) - 1.0;
        if energy > bound || !is_sound_within(&border, disk, &uv, limits.clearance) {
            return Ok(None);
        }
    }
    Ok(Some(Fit { uv, energy, kind }))
}
