//! Pack, round to single precision, certify; what fails goes round again until the certificate holds. A
//! chart at fault is divided, then given to the classical unwrapper, and at last taken apart to single
//! triangles of a height that the lattice holds; a gutter that is too narrow is packed anew with a texel
//! more. Nothing leaves here that is not valid.

use std::collections::BTreeMap;

use super::certify::{self, Scale};
use super::error::Cause;
use super::maps::Mapped;
use super::parts::Found;
use super::regions::Regions;
use crate::atlas::{self, AtlasCertificates, Demands, Grid, PackOptions, Placed};
use crate::charts::{self, ChartOptions};
use crate::contract::{Certificate, DoubleSided, OptionError, Run, Stage, UnwrapOptions};
use crate::flatten::UvMap;
use crate::mesh::Surface;
use crate::tasks;

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
    regions: &Regions,
    charts: Vec<Mapped>,
    options: &UnwrapOptions,
    run: &Run,
) -> Result<CertifiedAtlas, Cause> {
    let placing = |charts, padding| place(found, regions, charts, options, padding, run);
    settle(&found.surface, charts, options, run, placing)
}

/// The rounds. `placing` lays charts on pages, so many texels apart, and certifies them.
fn settle(
    surface: &Surface,
    mut charts: Vec<Mapped>,
    options: &UnwrapOptions,
    run: &Run,
    mut placing: impl FnMut(Vec<Mapped>, u32) -> Result<Packed, Cause>,
) -> Result<CertifiedAtlas, Cause> {
    let mut fault = String::new();
    let asked = PackOptions::from(options).padding;
    let mut padding = asked;
    for round in 0..ROUNDS {
        run.stage(Stage::Pack)?;
        let Packed { atlas, scales, lost } = placing(charts, padding)?;
        if atlas.certificates.atlas.valid {
            return Ok(atlas);
        }
        fault = certify::fault(&atlas.certificates.atlas, asked);
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
        "no valid atlas was found: {fault}. Give it a larger `page_size`, densities nearer to each other, or a \
         smaller `padding`"
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
struct Packed {
    atlas: CertifiedAtlas,
    /// Page widths for a unit of each chart's map.
    scales: Vec<f64>,
    /// Triangles that the lattice has lost: chart and face of its disk.
    lost: Vec<(u32, u32)>,
}

/// Pack each page's charts, round, certify.
fn place(
    found: &Found,
    regions: &Regions,
    charts: Vec<Mapped>,
    options: &UnwrapOptions,
    padding: u32,
    run: &Run,
) -> Result<Packed, Cause> {
    let mut groups: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (i, mapped) in charts.iter().enumerate() {
        groups.entry(regions.atlas[mapped.chart.part as usize]).or_default().push(i);
    }
    let asked = PackOptions::from(options);
    let grid = asked.grid;
    let weight = |&i: &usize| found.densities[regions.part[charts[i].chart.part as usize] as usize];
    let mut page_of = vec![0; charts.len()];
    let mut scales = vec![0.0; charts.len()];
    let mut placed: Vec<UvMap> = vec![UvMap::new(); charts.len()];
    let mut pages = 0;
    for members in groups.values() {
        let input: Vec<_> =
            members.iter().map(|&i| (&charts[i].chart.disk, &charts[i].uv)).collect();
        let packing =
            PackOptions { padding, weights: members.iter().map(weight).collect(), ..asked.clone() };
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
    let rounded = tasks::link("quantise", || atlas::quantise(&disks, found.surface.diagonal, grid));
    let on_pages: Vec<Placed> = charts
        .iter()
        .zip(&rounded.uvs)
        .zip(&page_of)
        .map(|((m, uv), &page)| Placed { disk: &m.chart.disk, uv, page })
        .collect();
    let demands = Demands {
        pages,
        page_size: asked.page_size,
        padding: asked.padding,
        diagonal: found.surface.diagonal,
        shared_sheets: options.double_sided == DoubleSided::Share,
    };
    let certificates = tasks::link("certify", || atlas::certify_atlas(&on_pages, &demands));
    let atlas = CertifiedAtlas { charts, uvs: rounded.uvs, pages, page_of, grid, certificates };
    Ok(Packed { atlas, scales, lost: rounded.lost })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::charts::Chart;
    use crate::contract::{ChartForm, ErrorCode};
    use crate::pipeline::{maps, scenes};

    #[test]
    fn a_gutter_that_is_too_thin_is_packed_anew_with_a_texel_more() {
        let run = Run::quiet();
        let options = UnwrapOptions { padding: 6, ..scenes::options() };
        let (found, solvers, cut) = scenes::cut(&scenes::squares(2), &options, &run);
        let mut asked = Vec::new();
        let placing = |charts, padding| {
            asked.push(padding);
            let given = if asked.len() == 1 { 1 } else { padding };
            place(&found, &cut.regions, charts, &options, given, &run)
        };
        let charts = maps::untrained(cut.charts);
        let atlas = settle(&solvers.surface, charts, &options, &run, placing).unwrap();
        assert_eq!(asked, [6, 7]);
        assert!(atlas.certificates.atlas.valid);
        assert!(atlas.certificates.atlas.min_gutter_texels.unwrap() >= 6.0);
    }

    #[test]
    fn an_atlas_that_stays_invalid_is_an_error() {
        let (options, run) = (scenes::options(), Run::quiet());
        let (found, solvers, cut) = scenes::cut(scenes::CUBE, &options, &run);
        let mut rounds = 0;
        let placing = |charts, padding| {
            rounds += 1;
            let mut packed = place(&found, &cut.regions, charts, &options, padding, &run)?;
            blame(&mut packed, 0);
            Ok(packed)
        };
        let charts = maps::untrained(cut.charts);
        let error = settle(&solvers.surface, charts, &options, &run, placing).err().unwrap();
        assert_eq!(rounds, ROUNDS);
        assert!(error.to_string().contains("1 flipped faces"), "{error}");
        assert_eq!(error.of(&run).job_error().unwrap().code, ErrorCode::NotCertified);
    }

    /// Break a chart's certificate.
    fn blame(packed: &mut Packed, chart: usize) {
        let proof = &mut packed.atlas.certificates;
        (proof.atlas.valid, proof.atlas.flipped) = (false, 1);
        proof.charts[chart].flipped = 1;
    }

    /// The charts of each round on a sheet of 32 faces, where in the first `faulty` rounds the chart of face
    /// 0 is at fault: as a whole, or for this face alone. The last of them are the result's.
    fn rounds(faulty: usize, lose: bool) -> Vec<Vec<Mapped>> {
        let (options, run) = (scenes::options(), Run::quiet());
        let (found, solvers, cut) = scenes::cut(&scenes::sheet(4, |_, _| 0.0), &options, &run);
        let mut rounds: Vec<Vec<Mapped>> = Vec::new();
        let placing = |charts: Vec<Mapped>, padding| {
            rounds.push(charts.clone());
            let mut packed = place(&found, &cut.regions, charts, &options, padding, &run)?;
            if rounds.len() <= faulty {
                let charts = &packed.atlas.charts;
                let at = charts.iter().position(|m| m.chart.faces[0] == 0).unwrap();
                blame(&mut packed, at);
                packed.lost = if lose { vec![(at as u32, 0)] } else { Vec::new() };
            }
            Ok(packed)
        };
        let charts = maps::untrained(cut.charts);
        let atlas = settle(&solvers.surface, charts, &options, &run, placing).unwrap();
        assert!(atlas.certificates.atlas.valid);
        assert_eq!(rounds.len(), faulty + 1);
        rounds
    }

    /// The chart of face 0.
    fn first(charts: &[Mapped]) -> &Mapped {
        charts.iter().find(|m| m.chart.faces[0] == 0).unwrap()
    }

    #[test]
    fn a_chart_at_fault_is_divided_then_unwrapped_classically_then_taken_apart() {
        let rounds = rounds(5, false);
        let blamed: Vec<&Mapped> = rounds.iter().map(|charts| first(charts)).collect();
        let sizes: Vec<usize> = blamed.iter().map(|m| m.chart.faces.len()).collect();
        assert!(sizes[..4].windows(2).all(|w| w[0] > w[1]) && sizes[3] > 1, "divided: {sizes:?}");
        let forms: Vec<ChartForm> = blamed.iter().map(|m| m.form).collect();
        let (start, classical) = (ChartForm::Start, ChartForm::Uvunwrap);
        assert_eq!(forms, [start, start, start, start, classical, start]);
        assert_eq!(sizes[5], 1, "taken apart");
        for w in rounds.windows(2) {
            let mut faces: Vec<u32> = w[1].iter().flat_map(|m| m.chart.faces.clone()).collect();
            faces.sort_unstable();
            assert_eq!(faces, (0..32).collect::<Vec<u32>>(), "each face is in one chart");
            // Whoever is not at fault stays as it is.
            let same = |m: &Mapped, n: &Mapped| (&m.chart, &m.uv) == (&n.chart, &n.uv);
            let sound = w[0].iter().filter(|m| m.chart.faces[0] != 0);
            assert!(sound.into_iter().all(|m| w[1].iter().any(|n| same(m, n))));
        }
        // Of the chart that was taken apart all faces are alone.
        let alone = |f: &u32| rounds[5].iter().any(|m| m.chart.faces == [*f]);
        assert!(blamed[4].chart.faces.iter().all(alone));
    }

    #[test]
    fn a_face_that_the_lattice_has_lost_is_taken_out_alone() {
        let rounds = rounds(5, true);
        let before: &Chart = &first(&rounds[4]).chart;
        assert_eq!(first(&rounds[5]).chart.faces, [0]);
        let rest = rounds[5].iter().filter(|m| before.faces[1..].contains(&m.chart.faces[0]));
        let sizes: Vec<usize> = rest.map(|m| m.chart.faces.len()).collect();
        assert_eq!(sizes.iter().sum::<usize>(), before.faces.len() - 1);
        assert!(sizes.iter().any(|&n| n > 1), "the others hang together: {sizes:?}");
    }
}
