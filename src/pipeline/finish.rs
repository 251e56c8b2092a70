//! Pack, round to single precision, certify; what fails goes round again until the certificate holds. A
//! chart at fault is divided, then given to the classical unwrapper, and at last taken apart to single
//! triangles of a height that the lattice holds; a gutter that is too narrow is packed anew with a texel
//! more. Nothing leaves here that is not valid.

use std::collections::BTreeMap;

use super::certify::{self, Scale};
use super::error::Cause;
use super::maps::Mapped;
use super::parts::{Found, Solvers};
use crate::atlas::{self, AtlasCertificates, Demands, Grid, PackOptions, Placed};
use crate::charts::{self, ChartOptions};
use crate::contract::{Certificate, DoubleSided, OptionError, Run, Stage, UnwrapOptions};
use crate::flatten::UvMap;
use crate::mesh::Surface;

/// Times that failed charts are divided before the classical unwrapper gets them.
const DIVIDED: u32 = 3;

/// Rounds in all.
const ROUNDS: u32 = 12;

/// UDIM tiles: 1001 to 1100.
const TILES: u32 = 100;

/// Charts on pages, with the proof that they are valid.
pub struct CertifiedAtlas {
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
}

/// Place and certify; mend what fails.
pub fn pack_and_certify(
    found: &Found,
    solvers: &Solvers,
    charts: Vec<Mapped>,
    options: &UnwrapOptions,
    run: &Run,
) -> Result<CertifiedAtlas, Cause> {
    let placing = |charts, padding| place(found, solvers, charts, options, padding, run);
    settle(&solvers.surface, charts, options, run, placing)
}

/// The rounds. `placing` lays charts on pages, so many texels apart, and certifies them.
fn settle(
    surface: &Surface,
    mut charts: Vec<Mapped>,
    options: &UnwrapOptions,
    run: &Run,
    mut placing: impl FnMut(Vec<Mapped>, u32) -> Result<Attempt, Cause>,
) -> Result<CertifiedAtlas, Cause> {
    let mut fault = String::new();
    let mut padding = options.padding;
    for round in 0..ROUNDS {
        run.stage(Stage::Pack)?;
        let Attempt { atlas, scales, lost } = placing(charts, padding)?;
        if atlas.certificates.atlas.valid {
            return Ok(atlas);
        }
        fault = certify::fault(&atlas.certificates.atlas, options.padding);
        let failed: Vec<bool> = atlas.certificates.charts.iter().map(is_at_fault).collect();
        if !failed.iter().any(|&f| f) {
            padding += 1;
            charts = atlas.charts;
            continue;
        }
        run.stage(Stage::Polish)?;
        charts = Vec::new();
        for (i, (mapped, failed)) in atlas.charts.into_iter().zip(failed).enumerate() {
            if !failed {
                charts.push(mapped);
            } else if round < DIVIDED && mapped.chart.faces.len() > 1 {
                let bound = ChartOptions::from(options);
                let pieces = charts::split_chart(surface, &mapped.chart, &bound, run)?;
                charts.extend(pieces.into_iter().map(Mapped::from_cut));
            } else if round == DIVIDED && mapped.chart.faces.len() > 1 {
                charts.extend(certify::classical(mapped)?);
            } else {
                let scale = Scale { chart: scales[i], step: atlas.grid.step() };
                let lost = lost.iter().filter(|l| l.0 == i as u32).map(|l| l.1);
                charts.extend(certify::last_resort(mapped, &lost.collect::<Vec<_>>(), scale));
            }
        }
    }
    Err(Cause::NotCertified(format!(
        "no valid atlas was found: {fault}. Give it a larger page_size, densities nearer to each other, or a \
         smaller padding"
    )))
}

/// Whether a certificate shows a fault of the chart itself (a narrow gutter is not one).
fn is_at_fault(c: &Certificate) -> bool {
    c.flipped > 0
        || c.zero_area_uv > 0
        || c.out_of_range > 0
        || c.overlapping_pairs > 0
        || !c.simple_boundary
}

/// An atlas, valid or not.
struct Attempt {
    atlas: CertifiedAtlas,
    /// Page widths for a unit of each chart's map.
    scales: Vec<f64>,
    /// Triangles that the lattice has lost: chart and face of its disk.
    lost: Vec<(u32, u32)>,
}

/// Pack each page's charts, round, certify.
fn place(
    found: &Found,
    solvers: &Solvers,
    charts: Vec<Mapped>,
    options: &UnwrapOptions,
    padding: u32,
    run: &Run,
) -> Result<Attempt, Cause> {
    let regions = &solvers.regions;
    let mut groups: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (i, mapped) in charts.iter().enumerate() {
        groups.entry(regions.atlas[mapped.chart.part as usize]).or_default().push(i);
    }
    let grid = if options.udim { Grid::Tiles } else { Grid::Page };
    let weight = |&i: &usize| found.densities[regions.part[charts[i].chart.part as usize] as usize];
    let mut page_of = vec![0; charts.len()];
    let mut scales = vec![0.0; charts.len()];
    let mut placed: Vec<UvMap> = vec![UvMap::new(); charts.len()];
    let mut pages = 0;
    for members in groups.values() {
        let input: Vec<_> =
            members.iter().map(|&i| (&charts[i].chart.disk, &charts[i].uv)).collect();
        let packing = PackOptions {
            padding,
            weights: members.iter().map(weight).collect(),
            ..PackOptions::from(options)
        };
        let atlas = atlas::pack(&input, &packing, run)?;
        for ((&i, placement), uv) in members.iter().zip(&atlas.placements).zip(atlas.uvs) {
            page_of[i] = pages + placement.page;
            scales[i] = placement.scale;
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
    let atlas = CertifiedAtlas { charts, uvs: rounded.uvs, pages, page_of, grid, certificates };
    Ok(Attempt { atlas, scales, lost: rounded.lost })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::{ErrorCode, MeshKind, SegmentationSource};
    use crate::device::Device;
    use crate::mesh;
    use crate::pipeline::{Engine, charting, maps, parts};

    /// A cube, cut and ready to be packed.
    fn cube(options: &UnwrapOptions, run: &Run) -> (Found, Solvers, Vec<Mapped>) {
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
            f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
        let kind = MeshKind::Obj;
        let scene = mesh::import(text.as_bytes(), kind, &Default::default()).unwrap();
        let engine = Engine::new(Device::cpu());
        let (found, solvers) = parts::find(&scene, options, &engine, run).unwrap();
        let cut = charting::cut(&solvers, options, &engine, run).unwrap();
        (found, solvers, maps::untrained(cut.charts))
    }

    fn options() -> UnwrapOptions {
        let segmentation = SegmentationSource::Authored;
        // Several charts, so that there is a gutter.
        UnwrapOptions { segmentation, padding: 6, distortion_bound: 1e-9, ..Default::default() }
    }

    #[test]
    fn a_gutter_that_is_too_thin_is_packed_anew_with_a_texel_more() {
        let (options, run) = (options(), Run::quiet());
        let (found, solvers, charts) = cube(&options, &run);
        // Two charts, and so a gutter.
        let charts: Vec<Mapped> = charts.into_iter().flat_map(|m| [m.clone(), m]).collect();
        let mut asked = Vec::new();
        let placing = |charts, padding| {
            asked.push(padding);
            let given = if asked.len() == 1 { 1 } else { padding };
            place(&found, &solvers, charts, &options, given, &run)
        };
        let atlas = settle(&solvers.surface, charts, &options, &run, placing).unwrap();
        assert_eq!(asked, [6, 7]);
        assert!(atlas.certificates.atlas.valid);
        assert!(atlas.certificates.atlas.min_gutter_texels.unwrap() >= 6.0);
    }

    #[test]
    fn an_atlas_that_stays_invalid_is_an_error() {
        let (options, run) = (options(), Run::quiet());
        let (found, solvers, charts) = cube(&options, &run);
        let mut rounds = 0;
        let placing = |charts, padding| {
            rounds += 1;
            let mut attempt = place(&found, &solvers, charts, &options, padding, &run)?;
            // The certificate is broken on purpose.
            let proof = &mut attempt.atlas.certificates;
            (proof.atlas.valid, proof.atlas.flipped) = (false, 1);
            proof.charts[0].flipped = 1;
            Ok(attempt)
        };
        let error = settle(&solvers.surface, charts, &options, &run, placing).err().unwrap();
        assert_eq!(rounds, ROUNDS);
        assert!(error.to_string().contains("1 flipped faces"), "{error}");
        assert_eq!(error.of(&run).job_error().unwrap().code, ErrorCode::NotCertified);
    }
}
