//! The proxy's map of a piece of a fine chart: carried over the record (prolongation), continued beyond the
//! chart's proxy, mended, relaxed, parted where it overlaps itself, and proved.

use glam::{DMat2, DVec2, DVec3};

use super::refine::{Counterpart, Opened, Refiner};
use crate::charts::{self, Chart, Piece, StartKind};
use crate::contract::Canceled;
use crate::flatten::{self, Border, Disk, SlimOptions, UvMap};
use crate::mesh::Place;
use crate::tasks;

/// What a map's energy may have over its proxy's: so many times the noise floor, and a little for borders that
/// were moved.
const FLOORS: f64 = 1.5;
const MOVED: f64 = 0.0025;

/// Energy over 1 from which a face is no noise: it was collapsed.
const COLLAPSED: f64 = 1.0;

/// Distance that parts of a border which were pushed apart have, in mean edges of the border.
const GAP: f64 = 0.02;

/// An edge that is carried over with more than this stretch crosses a cut.
const STRETCH: f64 = 6.0;

/// Energy over 1 of a chart that would be divided on the fine surface otherwise.
const STRAINED: f64 = 0.25;

/// Sweeps over the vertices of a map that was carried over: least and most, and the faces of all of them.
const SWEEPS: [usize; 2] = [2, 8];
const SWEPT: usize = 400_000;

/// The descent that follows: faces times steps, most steps, and share of the excess that each takes off at least.
const WORK: usize = 200_000;
const STEPS: usize = 20;
const GAIN: f64 = 0.02;

/// Faces from which on a step is solved by conjugate gradients, how many of them it takes, and how many such steps
/// cost what one with a factor does.
const MANY: usize = 6_000;
const CHEAPER: usize = 2;
const GRADIENTS: u32 = 12;

/// Mean edge of a border.
fn border_edge(border: &Border, uv: &UvMap) -> f64 {
    let (mut length, mut count) = (0.0, 0.0);
    for ring in &border.loops {
        for (k, &v) in ring.iter().enumerate() {
            length += uv[v as usize].distance(uv[ring[(k + 1) % ring.len()] as usize]);
            count += 1.0;
        }
    }
    length / f64::max(count, 1.0)
}

/// A piece of a fine chart that is to be mapped.
struct Unmapped<'a> {
    /// The proxy's chart.
    chart: &'a Chart,
    /// Faces of the surface, ascending.
    faces: Vec<u32>,
    disk: Disk,
    border: Border,
    /// Most energy over 1 that a map of it may have.
    most: f64,
    /// Sweeps that relax a map.
    sweeps: u32,
}

impl Unmapped<'_> {
    fn excess(&self, uv: &UvMap) -> f64 {
        flatten::mean_energy(&self.disk, uv) - 1.0
    }
    fn fits(&self, uv: &UvMap) -> bool {
        self.excess(uv) <= self.most
    }
}

impl Refiner<'_> {
    /// The chart of a piece with a map that is proved; else the faces of the surface, ascending, at which it
    /// fails. `last`: whether a classical start is tried, too, and a map that is strained is better than none.
    pub fn mapped(
        &self,
        part: &Counterpart,
        Opened { piece, border }: Opened,
        last: bool,
    ) -> Result<Result<Chart, Vec<u32>>, Canceled> {
        let Counterpart { chart, mesh, .. } = part;
        let Piece { faces, disk, vertices } = piece;
        let faces: Vec<u32> = faces.iter().map(|&f| mesh.faces[f as usize]).collect();
        // The cut may have been made with a higher bound, for `max_charts`.
        let reached = flatten::mean_energy(&chart.disk, &chart.cut_map) - 1.0;
        let floor = self.noise_floor(&faces, &disk);
        let most = self.options.distortion_bound.max(reached) + FLOORS * floor + MOVED;
        let sweeps = (SWEPT / faces.len().max(1)).clamp(SWEEPS[0], SWEEPS[1]) as u32;
        let unmapped = Unmapped { chart, border, faces, disk, most, sweeps };
        let (mut best, trouble) = match self.carried(&unmapped)? {
            Ok(uv) => (Some((uv, StartKind::Prolonged)), Vec::new()),
            Err(trouble) => (None, trouble),
        };
        if last && best.as_ref().is_none_or(|(uv, _)| !unmapped.fits(uv)) {
            let ways = best.into_iter().chain(self.classical(&unmapped)?);
            best = ways.min_by(|a, b| unmapped.excess(&a.0).total_cmp(&unmapped.excess(&b.0)));
        }
        let most = if last { STRAINED } else { unmapped.most };
        let best = best.filter(|(uv, _)| unmapped.excess(uv) <= most);
        let made = |(uv, start_kind): (UvMap, StartKind)| {
            let uv = flatten::rescale(&unmapped.disk, uv);
            Chart {
                part: chart.part,
                shape: chart.shape.clone(),
                start: uv.clone(),
                cut_map: uv,
                start_kind,
                faces: unmapped.faces,
                vertices,
                disk: unmapped.disk,
            }
        };
        Ok(best.map(made).ok_or(trouble))
    }

    fn is_sound(&self, unmapped: &Unmapped, uv: &UvMap) -> bool {
        tasks::link("proof", || {
            charts::is_sound_within(&unmapped.border, &unmapped.disk, uv, self.clearance)
        })
    }

    /// The proxy's map carried over, proved and polished, or the faces of the surface at which that fails.
    fn carried(&self, unmapped: &Unmapped) -> Result<Result<UvMap, Vec<u32>>, Canceled> {
        let Unmapped { chart, faces, disk, border, .. } = unmapped;
        let Some(carried) =
            tasks::link("prolong", || flatten::extend(disk, self.prolonged(chart, faces, disk)))
        else {
            return Ok(Err(Vec::new()));
        };
        let mended = match tasks::link("untangle", || flatten::untangle(disk, carried)) {
            Ok(mended) => mended,
            Err(flipped) => return Ok(Err(flipped.iter().map(|&f| faces[f as usize]).collect())),
        };
        let relaxed = || flatten::relax(disk, mended, unmapped.sweeps, &self.run.cancel);
        let mut uv = tasks::link("relax", relaxed)?;
        if !unmapped.fits(&uv) {
            uv = self.descended(disk, &uv, false)?;
        }
        if !self.is_sound(unmapped, &uv) {
            let at = tasks::link("touching", || flatten::touching(border, &uv, self.clearance));
            let gap = (GAP * border_edge(border, &uv)).max(2.0 * self.clearance);
            let apart = tasks::link("separate", || flatten::separate(disk, uv, border, gap));
            let Some(apart) = apart.filter(|uv| self.is_sound(unmapped, uv)) else {
                let touches = |t: &[u32; 3]| t.iter().any(|v| at.binary_search(v).is_ok());
                let own = faces.iter().zip(&disk.triangles).filter(|(_, t)| touches(t));
                return Ok(Err(own.map(|(&f, _)| f).collect()));
            };
            uv = apart;
        }
        Ok(Ok(self.polished(unmapped, uv)?))
    }

    /// The classical start, relaxed or as it is, where it is proved, polished.
    fn classical(&self, unmapped: &Unmapped) -> Result<Option<(UvMap, StartKind)>, Canceled> {
        let (start, kind) = flatten::start_map(&unmapped.disk, None);
        let relaxed =
            flatten::relax(&unmapped.disk, start.clone(), unmapped.sweeps, &self.run.cancel)?;
        let sound = [relaxed, start].into_iter().find(|uv| self.is_sound(unmapped, uv));
        sound.map(|uv| Ok((self.polished(unmapped, uv)?, kind.into()))).transpose()
    }

    /// A sound map after a descent, where it stays sound.
    fn polished(&self, unmapped: &Unmapped, uv: UvMap) -> Result<UvMap, Canceled> {
        let polished = self.descended(&unmapped.disk, &uv, true)?;
        Ok(if self.is_sound(unmapped, &polished) { polished } else { uv })
    }

    /// Newton steps, as many as there are in so much work. `keep_simple`: whether the border may not come to touch
    /// itself.
    fn descended(&self, disk: &Disk, uv: &UvMap, keep_simple: bool) -> Result<UvMap, Canceled> {
        let many = disk.triangles.len() > MANY;
        let work = if many { CHEAPER * WORK } else { WORK };
        let iterations = (work / disk.triangles.len().max(1)).clamp(1, STEPS) as u32;
        let options = SlimOptions {
            iterations,
            keep_simple,
            newton: true,
            tolerance: GAIN,
            gradients: many.then_some(GRADIENTS),
            ..Default::default()
        };
        flatten::slim(disk, uv, &options, &self.run.cancel)
    }

    /// Mean energy over 1 that the fine faces have laid on the proxy, each where its corners lie: what noise and
    /// roughness, which the proxy has not, add to any map.
    fn noise_floor(&self, faces: &[u32], disk: &Disk) -> f64 {
        let at = |v: u32| {
            let Place { face, weights } = self.proxy.places[v as usize];
            let corners = self.proxy.surface.corners(face as usize);
            corners.iter().zip(weights).map(|(c, w)| *c * f64::from(w)).sum::<DVec3>()
        };
        let block = |places: std::ops::Range<usize>| {
            let (mut sum, mut area) = (0.0, 0.0);
            for i in places.filter(|&i| disk.areas[i] > 0.0) {
                let [a, b, c] = self.proxy.corners[faces[i] as usize].map(at);
                let [_, second, third] = flatten::flatten_triangle(a, b, c);
                let laid = DMat2::from_cols(second, third) * disk.rest[i];
                let energy = flatten::symmetric_dirichlet(laid) - 1.0;
                if energy < COLLAPSED {
                    sum += disk.areas[i] * energy;
                    area += disk.areas[i];
                }
            }
            (sum, area)
        };
        let blocks = tasks::blocks("noise floor", faces.len(), block);
        let (sum, area) = blocks.into_iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x, b + y));
        if area > 0.0 { sum / area } else { 0.0 }
    }

    /// The map carried over: each vertex where it lies in its proxy face, NaN beyond the chart's proxy.
    fn prolonged(&self, chart: &Chart, faces: &[u32], disk: &Disk) -> UvMap {
        let coarse = &chart.cut_map;
        let mut uv = vec![DVec2::NAN; disk.positions.len()];
        let corners = |face: u32| {
            let at = chart.faces.binary_search(&face).ok()?;
            Some(chart.disk.triangles[at].map(|v| coarse[v as usize]))
        };
        // Where a face around a vertex is parted from its place, that lies on the other side of a cut.
        let mut across = vec![false; uv.len()];
        for (&f, triangle) in faces.iter().zip(&disk.triangles) {
            let label = self.labels[f as usize];
            for (k, &v) in triangle.iter().enumerate() {
                let Place { face, weights } =
                    self.proxy.places[self.proxy.corners[f as usize][k] as usize];
                match corners(face).filter(|_| self.fits(label, face)) {
                    Some(c) => {
                        uv[v as usize] = c.iter().zip(weights).map(|(p, w)| *p * f64::from(w)).sum()
                    }
                    None => across[v as usize] = true,
                }
            }
        }
        let scale = flatten::scale(&chart.disk, coarse);
        for triangle in &disk.triangles {
            for k in 0..3 {
                let [a, b] = [k, (k + 1) % 3].map(|k| triangle[k] as usize);
                let length = disk.positions[a].distance(disk.positions[b]);
                if uv[a].distance(uv[b]) > STRETCH * scale * length {
                    (across[a], across[b]) = (true, true);
                }
            }
        }
        uv.iter_mut().zip(across).filter(|(_, across)| *across).for_each(|(p, _)| *p = DVec2::NAN);
        uv
    }
}
