//! The standard figures of distortion: quasi-conformal ratio, symmetric Dirichlet energy, area,
//! stretch and texel density.
//!
//! Symmetric Dirichlet: Smith and Schaefer 2015, doi:10.1145/2766947, at its best scale. Stretch:
//! Sander, Snyder, Gortler and Hoppe 2001, doi:10.1145/383259.383307.

use super::FaceMap;
use super::statistics::{CAP, either_way, face_stats, weighted_mean};
use crate::contract::{FaceStats, TexelDensity};

/// Total UV area and total 3D area.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Totals {
    pub uv: f64,
    pub area: f64,
}

impl Totals {
    pub(super) fn of<'a>(maps: impl Iterator<Item = &'a FaceMap>) -> Self {
        maps.fold(Self::default(), |t, m| Self {
            uv: t.uv + m.uv_area.abs(),
            area: t.area + m.area,
        })
    }

    /// s²: UV area a unit of 3D area. `None` where nothing has area.
    pub(super) fn scale_squared(self) -> Option<f64> {
        (self.uv > 0.0 && self.area > 0.0).then(|| self.uv / self.area)
    }
}

/// σ1/σ2.
pub(super) fn quasi_conformal<'a>(maps: impl Iterator<Item = &'a FaceMap>) -> Option<FaceStats> {
    let ratio = |m: &FaceMap| if m.sigma2 > 0.0 { (m.sigma1 / m.sigma2).min(CAP) } else { CAP };
    face_stats(maps.map(|m| (ratio(m), m.area)))
}

/// max(r, 1/r), r = σ1σ2/s²; each face with the s² that stands beside it.
pub(super) fn area_distortion<'a>(
    maps: impl Iterator<Item = (&'a FaceMap, f64)>,
) -> Option<FaceStats> {
    face_stats(maps.map(|(m, s2)| (either_way(m.uv_area.abs() / (m.area * s2)), m.area)))
}

/// The two halves of the symmetric Dirichlet energy, Σw(σ1² + σ2²) and Σw(σ1⁻² + σ2⁻²), and Σw.
/// At the scale that balances them the energy is ½√(forward · backward)/weight.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Dirichlet {
    forward: f64,
    backward: f64,
    weight: f64,
}

impl Dirichlet {
    pub(super) fn of<'a>(maps: impl Iterator<Item = &'a FaceMap>) -> Self {
        maps.filter(|m| m.sound).fold(Self::default(), |d, m| {
            let (p, q) = (m.sigma1 * m.sigma1, m.sigma2 * m.sigma2);
            Self {
                forward: d.forward + m.area * (p + q),
                backward: d.backward + m.area * (1.0 / p + 1.0 / q),
                weight: d.weight + m.area,
            }
        })
    }

    /// At the best common scale.
    pub(super) fn common(self) -> Option<f64> {
        Self::each(std::iter::once(self))
    }

    /// With each member at its own best scale, weighted by area.
    pub(super) fn each(members: impl Iterator<Item = Self>) -> Option<f64> {
        let (energy, weight) = members.fold((0.0, 0.0), |(e, w), d| {
            (e + 0.5 * (d.forward * d.backward).sqrt(), w + d.weight)
        });
        (weight > 0.0).then(|| energy / weight)
    }
}

/// Root of the area-weighted mean of (σ1⁻² + σ2⁻²)/2, scaled.
pub(super) fn stretch_l2<'a>(maps: impl Iterator<Item = &'a FaceMap>, s2: f64) -> Option<f64> {
    let term = |m: &FaceMap| 0.5 * (m.sigma1.powi(-2) + m.sigma2.powi(-2)) * s2;
    weighted_mean(maps.filter(|m| m.sound).map(|m| (term(m), m.area))).map(f64::sqrt)
}

/// Largest 1/σ2, scaled.
pub(super) fn stretch_linf<'a>(maps: impl Iterator<Item = &'a FaceMap>, s2: f64) -> Option<f64> {
    maps.filter(|m| m.sound).map(|m| s2.sqrt() / m.sigma2).reduce(f64::max)
}

/// Texels a world unit, √(σ1σ2) times the page size.
pub(super) fn texel_density<'a>(
    maps: impl Iterator<Item = &'a FaceMap> + Clone,
    page_size: u32,
) -> Option<TexelDensity> {
    let density = |m: &FaceMap| (m.uv_area.abs() / m.area).sqrt() * f64::from(page_size);
    let pairs = maps.map(|m| (density(m), m.area));
    let mean = weighted_mean(pairs.clone())?;
    let variance = weighted_mean(pairs.clone().map(|(d, w)| ((d - mean).powi(2), w)))?;
    let min = pairs.clone().map(|p| p.0).fold(f64::INFINITY, f64::min);
    let max = pairs.map(|p| p.0).fold(0.0, f64::max);
    (mean > 0.0).then(|| TexelDensity { min, mean, max, cv: variance.sqrt() / mean })
}
