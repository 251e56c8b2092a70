//! The result at a glance, and the warning of many charts.

use super::finish::CertifiedAtlas;
use super::maps::Mapped;
use super::parts::Found;
use crate::contract::{
    AtlasGrouping, AtlasMetrics, ChartForm, Run, Summary, UnwrapOptions, WarningCode,
};

/// Charts from which on a result is told to have many, if they are also [`MANY_A_PART`] a part.
const MANY: usize = 100;

/// Charts a part, in the mean, that are many.
const MANY_A_PART: usize = 10;

/// The result at a glance, without the seconds.
pub fn of_atlas(
    atlas: &AtlasMetrics,
    found: &Found,
    finished: &CertifiedAtlas,
    options: &UnwrapOptions,
    run: &Run,
) -> Summary {
    let figures = &atlas.figures;
    let is_asked_to_differ = options.density.is_some() || options.atlas == AtlasGrouping::Material;
    let variation = figures.texel_density.map(|density| density.cv);
    let is_trained = |m: &&Mapped| m.form == ChartForm::Trained;
    Summary {
        valid: Some(atlas.certificate.valid),
        parts: found.parts.parts.len() as u32,
        charts: atlas.charts,
        pages: atlas.pages,
        seam_length: figures.seam_length.map(|length| length.per_sqrt_area),
        symmetric_dirichlet: figures.symmetric_dirichlet_chart,
        density_variation: variation.filter(|_| is_asked_to_differ),
        packing: atlas.packing_efficiency.covered,
        charts_of_network: finished.charts.iter().filter(is_trained).count() as u32,
        seconds: 0.0,
        warnings: run.warnings(),
    }
}

/// Tell that there are more charts than the parts give reason for, if it is so.
pub fn warn_of_many_charts(finished: &CertifiedAtlas, found: &Found, run: &Run) {
    let (charts, parts) = (finished.charts.len(), found.parts.parts.len());
    if charts >= MANY && charts >= MANY_A_PART * parts {
        let message = format!(
            "{charts} charts for {parts} parts are many: pieces that share no edge each need one, so weld what \
             belongs together; where the surface is rough, a larger `distortion_bound` gives fewer"
        );
        run.warn(WarningCode::ManyCharts, message);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::scenes;

    #[test]
    fn many_charts_are_told_by_the_part() {
        let told = |parts: usize, charts: usize| {
            let run = Run::quiet();
            let (mut found, _, mut atlas) =
                scenes::atlas(&scenes::squares(1), &scenes::options(), &run);
            let (part, chart) = (found.parts.parts[0].clone(), atlas.charts[0].clone());
            found.parts.parts = vec![part; parts];
            atlas.charts = vec![chart; charts];
            warn_of_many_charts(&atlas, &found, &run);
            run.warnings().iter().map(|w| w.code).collect::<Vec<_>>()
        };
        assert_eq!(told(10, 100), [WarningCode::ManyCharts]);
        assert_eq!(told(11, 100), []);
        assert_eq!(told(1, 99), []);
    }
}
