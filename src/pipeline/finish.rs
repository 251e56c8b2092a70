//! Pack, round to single precision, certify; what fails goes round again: a chart whose certificate
//! does not hold is divided, and at last given to the classical unwrapper. A single triangle always
//! passes, so that this ends.

use std::collections::BTreeMap;

use super::clock::Clock;
use super::error::UnwrapError;
use super::maps::Mapped;
use super::parts::Found;
use crate::atlas::{self, AtlasCertificates, Demands, Grid, PackOptions, Placed};
use crate::charts::{self, Chart, ChartOptions, ChartShape, StartKind};
use crate::contract::{
    Certificate, ChartForm, DoubleSided, JointSeams, OptionError, Run, Stage, UnwrapOptions,
};
use crate::flatten::{self, UvMap};

/// Times that failed charts are divided before the classical unwrapper gets them.
const ROUNDS: u32 = 3;

/// UDIM tiles: 1001 to 1100.
const TILES: u32 = 100;

/// Charts on pages, certified.
pub struct Finished {
    /// The charts.
    pub charts: Vec<Mapped>,
    /// Final coordinates of each chart's vertices.
    pub uvs: Vec<UvMap>,
    /// Pages in all.
    pub pages: u32,
    /// Page of each chart.
    pub page_of: Vec<u32>,
    /// The lattice that the coordinates are on.
    pub grid: Grid,
    /// The proofs.
    pub certificates: AtlasCertificates,
    /// What training the seams was worth, where it was tried.
    pub joint_seams: Option<JointSeams>,
}

/// Place and certify; divide what fails.
pub fn pack_and_certify(
    found: &Found,
    mut charts: Vec<Mapped>,
    options: &UnwrapOptions,
    run: &Run,
    clock: &mut Clock,
) -> Result<Finished, UnwrapError> {
    for round in 0.. {
        clock.stage(Stage::Pack, run)?;
        let finished = place(found, charts, options, run)?;
        let failed: Vec<bool> = finished.certificates.charts.iter().map(must_be_divided).collect();
        if round > ROUNDS || !failed.iter().any(|&f| f) {
            return Ok(finished);
        }
        clock.stage(Stage::Polish, run)?;
        charts = Vec::new();
        for (mapped, failed) in finished.charts.into_iter().zip(failed) {
            if !failed || mapped.chart.faces.len() < 2 {
                charts.push(mapped);
            } else if round < ROUNDS {
                let bound = ChartOptions { distortion_bound: options.distortion_bound };
                let pieces = charts::split_chart(&found.surface, &mapped.chart, &bound, run)?;
                charts.extend(pieces.into_iter().map(Mapped::from_cut));
            } else {
                charts.extend(classical(mapped)?);
            }
        }
    }
    Err(UnwrapError::Internal("packing did not end".into()))
}

/// Whether a certificate shows a fault of the chart itself (a narrow gutter is not one).
fn must_be_divided(c: &Certificate) -> bool {
    c.flipped > 0
        || c.zero_area_uv > 0
        || c.out_of_range > 0
        || c.overlapping_pairs > 0
        || !c.simple_boundary
}

/// Pack each page's charts, round, certify.
fn place(
    found: &Found,
    charts: Vec<Mapped>,
    options: &UnwrapOptions,
    run: &Run,
) -> Result<Finished, UnwrapError> {
    let mut groups: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (i, mapped) in charts.iter().enumerate() {
        groups.entry(found.page_of_region[mapped.chart.part as usize]).or_default().push(i);
    }
    let grid = if options.udim { Grid::Tiles } else { Grid::Page };
    let weight =
        |&i: &usize| found.weights[found.part_of_region[charts[i].chart.part as usize] as usize];
    let mut page_of = vec![0; charts.len()];
    let mut placed: Vec<UvMap> = vec![UvMap::new(); charts.len()];
    let mut pages = 0;
    for members in groups.values() {
        let input: Vec<_> =
            members.iter().map(|&i| (&charts[i].chart.disk, &charts[i].uv)).collect();
        let packing = PackOptions {
            page_size: options.page_size,
            padding: options.padding,
            rotation: options.rotation,
            block_align: options.block_align,
            pages: options.pages,
            grid,
            weights: members.iter().map(weight).collect(),
        };
        let atlas = atlas::pack(&input, &packing, &run.cancel)?;
        for ((&i, placement), uv) in members.iter().zip(&atlas.placements).zip(atlas.uvs) {
            page_of[i] = pages + placement.page;
            placed[i] = uv;
        }
        pages += atlas.pages;
    }
    if options.udim && pages > TILES {
        let detail = format!("has room for {TILES} pages and there are {pages}: ask for fewer");
        return Err(OptionError { pointer: "/udim".into(), detail }.into());
    }
    let disks: Vec<_> = charts.iter().zip(&placed).map(|(m, uv)| (&m.chart.disk, uv)).collect();
    let rounded = atlas::quantise(&disks, found.surface.diagonal, grid);
    let on_pages: Vec<Placed> = charts
        .iter()
        .zip(&rounded.uvs)
        .zip(&page_of)
        .map(|((m, uv), &page)| Placed { disk: &m.chart.disk, uv, page })
        .collect();
    let demands = Demands {
        pages,
        page_size: options.page_size,
        padding: options.padding,
        diagonal: found.surface.diagonal,
        shared_sheets: options.double_sided == DoubleSided::Share,
    };
    let certificates = atlas::certify_atlas(&on_pages, &demands);
    Ok(Finished { charts, uvs: rounded.uvs, pages, page_of, grid, certificates, joint_seams: None })
}

/// A chart as the islands of the classical unwrapper.
fn classical(mapped: Mapped) -> Result<Vec<Mapped>, UnwrapError> {
    let chart = mapped.chart;
    let islands = flatten::unwrap_classically(&chart.disk.positions, &chart.disk.triangles)
        .map_err(|error| {
            UnwrapError::Internal(format!("the classical unwrapper failed: {error}"))
        })?;
    let island = |island: flatten::Island| {
        let vertices = island.vertices.iter().map(|&v| chart.vertices[v as usize]).collect();
        let chart = Chart {
            part: chart.part,
            faces: island.faces.iter().map(|&f| chart.faces[f as usize]).collect(),
            disk: island.disk,
            vertices,
            shape: ChartShape::General,
            start: island.uv.clone(),
            cut_map: island.uv,
            start_kind: StartKind::Uvunwrap,
        };
        Mapped { form: ChartForm::Uvunwrap, ..Mapped::from_cut(chart) }
    };
    Ok(islands.into_iter().map(island).collect())
}
