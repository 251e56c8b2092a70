//! From what was cut to what is delivered. Double-sided sheets are cut once, from their front: with
//! `double_sided = separate` the second side gets the same charts, mirrored. What the file winds the other way
//! is turned over with its charts, so that they are positive in the file's winding, too.

use std::sync::Arc;

use glam::DVec2;

use super::caps;
use super::error::Cause;
use super::maps::Mapped;
use super::parts::Found;
use crate::charts::{self, ChartOptions};
use crate::contract::{DoubleSided, Run, UnwrapOptions, Winding};
use crate::flatten::Disk;
use crate::mesh::{NONE, Sides};
use crate::segmentation::PartLabels;

/// All sides that get coordinates, and their charts: those that were made, then those of second sides.
pub fn deliver(
    found: &Found,
    charts: Vec<Mapped>,
    options: &UnwrapOptions,
    run: &Run,
) -> Result<(Found, Vec<Mapped>), Cause> {
    let both = options.double_sided == DoubleSided::Separate;
    let follow = options.winding == Winding::Surface;
    let Sides { surface, telling, of, second, turned } =
        Sides::of(&found.surface, &found.telling, both, follow);
    let surface = Arc::new(surface);
    let mut delivered = Vec::with_capacity(charts.len());
    let mut behind = Vec::new();
    // Regions of second sides whose charts are not second to a whole one.
    let mut rest = vec![NONE; surface.face_count()];
    for m in caps::of_the_file(&found.surface, charts) {
        let faces: Vec<u32> = m.chart.faces.iter().map(|&f| second[f as usize]).collect();
        if faces.iter().all(|&f| f != NONE) {
            let mut mate = m.clone();
            mate.chart.faces = faces;
            behind.push(wound(mate, &turned));
        } else {
            let faces = faces.into_iter().filter(|&f| f != NONE);
            faces.for_each(|f| rest[f as usize] = m.chart.part);
        }
        delivered.push(wound(m, &turned));
    }
    delivered.extend(behind);
    if rest.iter().any(|&region| region != NONE) {
        let how = ChartOptions::from(options);
        let built = charts::build_jointly(&surface, &rest, &how, None, run)?;
        delivered.extend(built.charts.into_iter().map(Mapped::from_cut));
    }
    let labels = of.iter().map(|&f| found.parts.labels[f as usize]).collect();
    let found = Found {
        surface,
        telling,
        parts: PartLabels { labels, ..found.parts.clone() },
        weights: found.weights.clone(),
        densities: found.densities.clone(),
        dense: found.dense.sides(&of),
    };
    Ok((found, delivered))
}

/// A chart of faces that may be turned over, all of them or none.
fn wound(mut m: Mapped, turned: &[bool]) -> Mapped {
    if m.chart.faces.first().is_none_or(|&f| !turned[f as usize]) {
        return m;
    }
    let mirror = |uv: &mut Vec<DVec2>| uv.iter_mut().for_each(|p| p.x = -p.x);
    [&mut m.uv, &mut m.chart.start, &mut m.chart.cut_map].into_iter().for_each(mirror);
    let Disk { positions, triangles, .. } = std::mem::take(&mut m.chart.disk);
    m.chart.disk = Disk::new(positions, triangles.into_iter().map(|[a, b, c]| [a, c, b]).collect());
    m
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten;
    use crate::pipeline::scenes;

    #[test]
    fn a_side_that_stands_in_part_has_charts_of_its_own() {
        // A sheet, and behind two thirds of it its other side.
        let sheet = scenes::sheet(6, |_, _| 0.0);
        let back = sheet.lines().filter(|line| line.starts_with("f ")).take(24).map(|line| {
            // From the same corner, so that it has the same diagonal.
            let mut corners: Vec<&str> = line[2..].split(' ').collect();
            corners[1..].reverse();
            format!("f {}\n", corners.join(" "))
        });
        let text = format!("{sheet}{}", back.collect::<String>());
        let (found, _, atlas) = scenes::atlas(&text, &scenes::options(), &Run::quiet());
        assert_eq!(found.surface.face_count(), 72 + 48);
        let charts = atlas.charts.iter().map(|m| m.chart.faces.len());
        assert_eq!(charts.collect::<Vec<_>>(), [72, 48]);
        assert!(atlas.certificates.atlas.valid);
        assert!((72..120).all(|f| found.surface.sheet_mate[f] < 72));
    }

    #[test]
    fn what_the_file_winds_the_other_way_is_mirrored() {
        let sheet = scenes::sheet(4, |x, y| 0.2 * x * y);
        let turned: String = sheet
            .lines()
            .map(|line| match line.strip_prefix("f ") {
                Some(corners) => {
                    let mut corners: Vec<&str> = corners.split(' ').collect();
                    corners[1..].reverse();
                    format!("f {}\n", corners.join(" "))
                }
                None => format!("{line}\n"),
            })
            .collect();
        let of = |text: &str| {
            let run = Run::quiet();
            let (found, _, cut) = scenes::cut(text, &scenes::options(), &run);
            let charts = crate::pipeline::maps::untrained(cut.charts);
            deliver(&found, charts, &scenes::options(), &run).unwrap()
        };
        let ((one, a), (other, b)) = (of(&sheet), of(&turned));
        assert_ne!(one.surface.normals[0].z > 0.0, other.surface.normals[0].z > 0.0);
        for (m, n) in a.iter().zip(&b) {
            assert_eq!(m.chart.faces, n.chart.faces);
            assert!(m.uv.iter().zip(&n.uv).all(|(p, q)| (p.x, p.y) == (-q.x, q.y)));
            for m in [m, n] {
                let areas = (0..m.chart.faces.len()).map(|f| m.chart.disk.uv_area(f, &m.uv));
                assert!(areas.fold(f64::INFINITY, f64::min) > 0.0);
                assert!(flatten::quality(&m.chart.disk, &m.uv).max < 1.2);
            }
        }
    }
}
