//! All figures of one result, at all three levels.

use rayon::prelude::*;

use super::alignment::{Lengths, SampledSeams};
use super::avoidable::Avoidable;
use super::consistency::internal_consistency;
use super::contact::Contacts;
use super::distortion::{
    Dirichlet, Totals, area_distortion, quasi_conformal, stretch_l2, stretch_linf, texel_density,
};
use super::levels::{Level, Levels};
use super::seams::Seams;
use super::statistics::weighted_mean;
use super::{EdgeTable, FaceMap, paper, partuv};
use crate::contract::{
    Canceled, Figures, PaperBoundaryCompactness, PaperFigures, PaperInternalConsistency, Run,
};
use crate::mesh::rays::Rays;
use crate::mesh::{NONE, Surface};
use crate::tasks;

/// What is measured: the result as it ships.
#[derive(Debug, Clone, Copy)]
pub struct Measured<'a> {
    /// The object.
    pub surface: &'a Surface,
    /// Final coordinates of each face's corners in the surface's winding, v up, page = 1; NaN for
    /// faces in no chart. Length: faces.
    pub uvs: &'a [[[f32; 2]; 3]],
    /// Chart of each face, or [`NONE`]. Length: faces.
    pub chart_of: &'a [u32],
    /// Part of each face, or [`NONE`]. Length: faces.
    pub part_of: &'a [u32],
    /// Number of charts.
    pub charts: usize,
    /// Number of parts.
    pub parts: usize,
    /// Labels whose boundaries the seams should follow, −1 unknown: the labels that were used, or a
    /// reference. The parts themselves if `None`. Length: faces.
    pub boundary_labels: Option<&'a [i32]>,
    /// Texels across a page.
    pub page_size: u32,
    /// Pages of the atlas.
    pub pages: u32,
    /// Page of each chart, from 0. Length: charts, or empty where all are on the first.
    pub page_of: &'a [u32],
    /// Round-trip Chamfer distance of each chart that was trained. Length: charts, or empty.
    pub chamfer: &'a [Option<f64>],
}

impl Measured<'_> {
    /// The map of a face; `None` for faces without area, chart or coordinates.
    pub fn face_map(&self, face: usize) -> Option<FaceMap> {
        let s = self.surface;
        let counted = (self.chart_of[face] as usize) < self.charts;
        if counted { FaceMap::new(s.corners(face), self.uvs[face]) } else { None }
    }

    /// The page of a chart.
    pub fn page(&self, chart: u32) -> u32 {
        self.page_of.get(chart as usize).copied().unwrap_or(0)
    }

    /// The label of a face for boundaries, −1 unknown.
    pub(super) fn label(&self, face: u32) -> i64 {
        match self.boundary_labels {
            Some(labels) => i64::from(labels[face as usize]),
            None if self.part_of[face as usize] == NONE => -1,
            None => i64::from(self.part_of[face as usize]),
        }
    }
}

/// The figures of a result.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeasuredFigures {
    /// Of all faces together.
    pub atlas: Figures,
    /// Of each part. Length: parts.
    pub parts: Vec<Figures>,
    /// Of each chart. Length: charts.
    pub charts: Vec<Figures>,
}

/// Takes every figure. The slices of `input` must be as long as they say. Fails only if canceled.
pub fn measure(input: &Measured, run: &Run) -> Result<MeasuredFigures, Canceled> {
    let cancel = &run.cancel;
    cancel.check()?;
    let surface = input.surface;
    let maps: Vec<Option<FaceMap>> = tasks::even("face maps", surface.face_count(), || {
        (0..surface.face_count()).into_par_iter().map(|f| input.face_map(f)).collect()
    });
    let edges = tasks::link("edge table", || {
        EdgeTable::new(input, |f| maps[f as usize].is_some(), cancel)
    })?;
    let faces: Vec<u32> = (0..maps.len() as u32).filter(|&f| maps[f as usize].is_some()).collect();
    // What needs rays, and beside it what does not.
    let seen = || {
        let sampled = || tasks::link("seams", || SampledSeams::new(surface, &edges, cancel));
        let (sampled, rays) =
            tasks::join("seams", sampled, || tasks::link("rays", || Rays::new(surface)));
        let sampled = sampled?;
        let avoidable = || Avoidable::new(surface, &edges, &sampled, &rays, cancel);
        let contacts = || tasks::link("contacts", || Contacts::new(input, &edges, &rays, cancel));
        let (avoidable, contacts) = tasks::join("seen", avoidable, contacts);
        Ok::<_, Canceled>((avoidable?, contacts?, sampled))
    };
    let levels = || tasks::link("levels", || Levels::new(input, faces, &edges));
    let (seen, levels) = tasks::join("measured", seen, levels);
    let (avoidable, contacts, sampled) = seen?;
    let scale = Totals::of(maps.iter().flatten()).scale_squared();
    let consistency = tasks::map("consistency", &levels.charts, |chart| match scale {
        Some(s2) => internal_consistency(input, &chart.faces, s2.sqrt(), cancel),
        None => Ok(None),
    });
    let consistency = consistency.into_iter().collect::<Result<Vec<_>, _>>()?;
    let perimeters = tasks::link("perimeters", || paper::perimeters(input, &edges));
    let taken = Taken {
        input,
        maps: &maps,
        edges: &edges,
        chart_levels: &levels.charts,
        sampled: &sampled,
        avoidable: &avoidable,
        contacts: &contacts,
        scale,
        consistency: &consistency,
        perimeters: &perimeters,
    };
    let all = |levels: &[Level]| -> Result<Vec<Figures>, Canceled> {
        let figures = |level| {
            cancel.check()?;
            Ok(taken.figures(level))
        };
        tasks::map("figures", levels, figures).into_iter().collect()
    };
    let atlas = || tasks::link("atlas figures", || taken.figures(&levels.atlas));
    let rest = || Ok::<_, Canceled>((all(&levels.parts)?, all(&levels.charts)?));
    let (atlas, rest) = tasks::join("levels", atlas, rest);
    let (parts, charts) = rest?;
    Ok(MeasuredFigures { atlas, parts, charts })
}

/// What is known once for the whole atlas.
struct Taken<'a> {
    input: &'a Measured<'a>,
    maps: &'a [Option<FaceMap>],
    edges: &'a EdgeTable,
    chart_levels: &'a [Level],
    sampled: &'a SampledSeams,
    avoidable: &'a Avoidable,
    contacts: &'a Contacts,
    /// s² of the atlas.
    scale: Option<f64>,
    consistency: &'a [Option<PaperInternalConsistency>],
    perimeters: &'a [f64],
}

impl<'a> Taken<'a> {
    fn maps(&self, level: &'a Level) -> impl Iterator<Item = &'a FaceMap> + Clone + use<'a> {
        let maps = self.maps;
        level.faces.iter().filter_map(move |&f| maps[f as usize].as_ref())
    }

    fn figures(&self, level: &'a Level) -> Figures {
        let totals = Totals::of(self.maps(level));
        if level.faces.is_empty() {
            let island_count = level.charts.len() as u64;
            let paper = PaperFigures { island_count, ..PaperFigures::default() };
            return Figures { paper, ..Figures::default() };
        }
        let maps = || self.maps(level);
        let charts = || level.charts.iter().filter_map(|&c| self.chart_levels.get(c as usize));
        let at_scale = |f: &dyn Fn(f64) -> Option<f64>| self.scale.and_then(f);
        let seams = Seams::of(self.edges, level);
        let seam_length = seams.normalised(totals.area, self.input.surface.diagonal);
        let lengths = Lengths::of(self.edges, level);
        let precision = self.sampled.precision(self.edges, level);
        let contact =
            || self.contacts.length(self.input, level.scope) / self.input.surface.diagonal;
        Figures {
            quasi_conformal: quasi_conformal(maps()),
            symmetric_dirichlet: Dirichlet::of(maps()).common(),
            symmetric_dirichlet_chart: Dirichlet::each(
                charts().map(|c| Dirichlet::of(self.maps(c))),
            ),
            area_distortion: self.scale.and_then(|s2| area_distortion(maps().map(|m| (m, s2)))),
            area_distortion_chart: area_distortion(charts().flat_map(|c| {
                let s2 = Totals::of(self.maps(c)).scale_squared().unwrap_or(0.0);
                self.maps(c).map(move |m| (m, s2))
            })),
            stretch_l2: at_scale(&|s2| stretch_l2(maps(), s2)),
            stretch_linf: at_scale(&|s2| stretch_linf(maps(), s2)),
            texel_density: texel_density(maps(), self.input.page_size),
            seam_edges: seams.edges,
            seam_length,
            avoidable_seam: self.avoidable.of(self.edges, level),
            boundary_alignment: precision.and_then(|p| lengths.alignment(p, contact)),
            partuv_angular: partuv::angular(maps()),
            partuv_area: partuv::area(maps(), charts().map(|c| self.maps(c).collect())),
            paper: PaperFigures {
                conformality: paper::conformality(maps()),
                internal_consistency: self.consistency(level),
                boundary_compactness: self.isoperimetric(level).map(|isoperimetric| {
                    PaperBoundaryCompactness {
                        seam_boundary_overlap: lengths.overlap(),
                        isoperimetric,
                    }
                }),
                texture_distortion: at_scale(&|s2| paper::texture_distortion(maps(), s2)),
                mean_texture_error: at_scale(&|s2| paper::mean_texture_error(maps(), s2)),
                chamfer: self.over_charts(level, |c| self.input.chamfer.get(c).copied().flatten()),
                total_seam_length: seam_length.map(|l| l.per_diagonal),
                seam_count: seams.curves,
                island_count: level.charts.len() as u64,
                boundary_alignment_score: precision,
            },
        }
    }

    /// Mean of a figure of charts, weighted by their 3D area, over those that have it.
    fn over_charts(&self, level: &Level, figure: impl Fn(usize) -> Option<f64>) -> Option<f64> {
        weighted_mean(level.charts.iter().map(|&c| c as usize).filter_map(|c| {
            Some((figure(c)?, Totals::of(self.maps(self.chart_levels.get(c)?)).area))
        }))
    }

    fn consistency(&self, level: &Level) -> Option<PaperInternalConsistency> {
        let of = |c: usize| self.consistency.get(c).copied().flatten();
        Some(PaperInternalConsistency {
            geodesic: self.over_charts(level, |c| of(c).map(|x| x.geodesic))?,
            euclidean: self.over_charts(level, |c| of(c).map(|x| x.euclidean))?,
        })
    }

    fn isoperimetric(&self, level: &Level) -> Option<f64> {
        self.over_charts(level, |c| {
            let uv = Totals::of(self.maps(self.chart_levels.get(c)?)).uv;
            Some(paper::isoperimetric(uv, *self.perimeters.get(c)?))
        })
    }
}
