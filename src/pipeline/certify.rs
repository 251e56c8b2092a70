//! What is left to do for charts whose certificate does not hold: the classical unwrapper, and at last
//! single triangles, scaled so that their height holds on the lattice of final coordinates.

use std::collections::{BTreeMap, HashMap};

use glam::DVec2;

use super::error::Cause;
use super::maps::Mapped;
use crate::charts::{Chart, ChartShape, StartKind};
use crate::contract::{Certificate, ChartForm};
use crate::flatten::{self, Disk, UvMap};
use crate::mesh::DisjointSets;

/// Height and length of a triangle that is enlarged, lattice steps: rounding takes no more than two of
/// them, and a height of 2.01 counts as none.
const HEIGHT: f64 = 8.0;

/// How large a chart is on its page.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// Page widths for a unit of the chart's map.
    pub chart: f64,
    /// The step of the lattice of final coordinates, page widths.
    pub step: f64,
}

/// What a certificate says is wrong, in words.
pub fn fault(certificate: &Certificate, padding: u32) -> String {
    let c = certificate;
    let counts = [
        (c.flipped, "flipped faces"),
        (c.overlapping_pairs, "pairs of faces that overlap"),
        (c.overlap_texels, "texels of two charts"),
        (c.out_of_range, "faces outside of the page"),
        (c.zero_area_uv, "faces without area"),
    ];
    let mut faults: Vec<String> =
        counts.iter().filter(|c| c.0 > 0).map(|(count, what)| format!("{count} {what}")).collect();
    if !c.simple_boundary {
        faults.push("a boundary that crosses itself".to_owned());
    }
    if let Some(gutter) = c.min_gutter_texels.filter(|g| *g < f64::from(padding)) {
        faults.push(format!("a gutter of {gutter:.2} texels where {padding} were asked for"));
    }
    faults.join(", ")
}

/// A chart as the islands of the classical unwrapper.
pub fn classical(mapped: Mapped) -> Result<Vec<Mapped>, Cause> {
    let chart = mapped.chart;
    let islands = flatten::unwrap_classically(&chart.disk.positions, &chart.disk.triangles)
        .map_err(|error| Cause::Internal(format!("the classical unwrapper failed: {error}")))?;
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

/// A chart without the faces that the lattice has `lost`, which become charts of their own; where it is at
/// fault in another way every face does. Those are enlarged until they hold at this scale.
pub fn last_resort(mapped: Mapped, lost: &[u32], scale: Scale) -> Vec<Mapped> {
    let faces = mapped.chart.faces.len();
    let mut alone = vec![lost.is_empty(); faces];
    lost.iter().for_each(|&f| alone[f as usize] = true);
    let mut result = pieces(&mapped, &alone);
    result.extend((0..faces).filter(|&f| alone[f]).map(|f| triangle(&mapped.chart, f, scale)));
    result
}

/// One face as a chart: isometric where the lattice holds it, else higher and longer than it is.
fn triangle(chart: &Chart, face: usize, scale: Scale) -> Mapped {
    let corners = chart.disk.triangles[face];
    let positions = corners.map(|v| chart.disk.positions[v as usize]);
    // Along its longest edge.
    let length = |k: usize| positions[k].distance(positions[(k + 1) % 3]);
    let first = (0..3).max_by(|&a, &b| length(a).total_cmp(&length(b))).unwrap_or(0);
    let order = [0, 1, 2].map(|k| (first + k) % 3);
    let [a, b, c] = order.map(|k| positions[k]);
    let [origin, end, tip] = flatten::flatten_triangle(a, b, c);
    let least = HEIGHT * scale.step / scale.chart;
    let stretch = DVec2::new((least / end.x).max(1.0), (least / tip.y).max(1.0));
    let enlarged = stretch != DVec2::ONE;
    let flat = [origin, end, tip].map(|p| DVec2::new(p.x * stretch.x, p.y * stretch.y));
    // A face without any extent still gets a place.
    let flat = if flat.iter().all(|p| p.is_finite()) && end.x > 0.0 {
        flat
    } else {
        [DVec2::ZERO, DVec2::new(least, 0.0), DVec2::new(0.0, least)]
    };
    let mut uv: UvMap = vec![DVec2::ZERO; 3];
    order.iter().zip(flat).for_each(|(&k, p)| uv[k] = p);
    let alone = Chart {
        part: chart.part,
        faces: vec![chart.faces[face]],
        disk: Disk::new(positions.to_vec(), vec![[0, 1, 2]]),
        vertices: corners.map(|v| chart.vertices[v as usize]).to_vec(),
        shape: ChartShape::General,
        start: uv.clone(),
        cut_map: uv,
        start_kind: StartKind::Planar,
    };
    Mapped { enlarged, ..Mapped::from_cut(alone) }
}

/// What is left of a chart without some of its faces, each connected component with the chart's map.
fn pieces(mapped: &Mapped, without: &[bool]) -> Vec<Mapped> {
    let chart = &mapped.chart;
    let kept: Vec<usize> = (0..without.len()).filter(|&f| !without[f]).collect();
    let mut edges: HashMap<(u32, u32), (u32, u32)> = HashMap::new();
    let corner = |f: usize, k: usize| (3 * f + k % 3) as u32;
    for &f in &kept {
        let t = chart.disk.triangles[f];
        for k in 0..3 {
            edges.insert((t[k], t[(k + 1) % 3]), (corner(f, k), corner(f, k + 1)));
        }
    }
    // Corners are one vertex where an edge between kept faces connects them.
    let mut corners = DisjointSets::new(3 * without.len());
    let mut faces = DisjointSets::new(without.len());
    for (&(a, b), &(at_a, at_b)) in &edges {
        if let Some(&(twin_b, twin_a)) = edges.get(&(b, a)) {
            corners.join(at_a, twin_a);
            corners.join(at_b, twin_b);
            faces.join(at_a / 3, twin_a / 3);
        }
    }
    let mut groups: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    let mut first: HashMap<u32, u32> = HashMap::new();
    for &f in &kept {
        let root = faces.root(f as u32);
        groups.entry(*first.entry(root).or_insert(f as u32)).or_default().push(f);
    }
    let piece = |faces: Vec<usize>| {
        let mut number: HashMap<u32, u32> = HashMap::new();
        let (mut vertices, mut uv) = (Vec::new(), UvMap::new());
        let mut triangles = Vec::with_capacity(faces.len());
        for &f in &faces {
            triangles.push([0, 1, 2].map(|k| {
                let v = chart.disk.triangles[f][k];
                *number.entry(corners.root(corner(f, k))).or_insert_with(|| {
                    vertices.push(v);
                    uv.push(mapped.uv[v as usize]);
                    vertices.len() as u32 - 1
                })
            }));
        }
        let positions = vertices.iter().map(|&v| chart.disk.positions[v as usize]).collect();
        let disk = Disk::new(positions, triangles);
        let uv = flatten::rescale(&disk, uv);
        Mapped::from_cut(Chart {
            part: chart.part,
            faces: faces.iter().map(|&f| chart.faces[f]).collect(),
            disk,
            vertices: vertices.iter().map(|&v| chart.vertices[v as usize]).collect(),
            shape: ChartShape::General,
            start: uv.clone(),
            cut_map: uv,
            start_kind: chart.start_kind,
        })
    };
    groups.into_values().map(piece).collect()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::contract::Run;
    use crate::flatten::{Border, certify, samples};
    use crate::pipeline::scenes;

    /// A disk as a chart of its own surface, faces numbered from 100 and vertices from 1000.
    fn chart(disk: Disk, uv: UvMap) -> Mapped {
        let faces = (100..).take(disk.triangles.len()).collect();
        let vertices = (1000..).take(disk.positions.len()).collect();
        let (start, start_kind) = (uv.clone(), StartKind::Lscm);
        let shape = ChartShape::General;
        Mapped::from_cut(Chart {
            part: 7,
            faces,
            disk,
            vertices,
            shape,
            start,
            cut_map: uv,
            start_kind,
        })
    }

    /// Every face once, each with the vertices that it had.
    fn assert_whole(of: &Mapped, charts: &[Mapped]) {
        let mut faces: Vec<u32> = charts.iter().flat_map(|m| m.chart.faces.clone()).collect();
        faces.sort_unstable();
        assert_eq!(faces, of.chart.faces);
        for m in charts {
            assert_eq!(m.chart.part, of.chart.part);
            for (t, &f) in m.chart.disk.triangles.iter().zip(&m.chart.faces) {
                let before = of.chart.disk.triangles[f as usize - 100];
                let now = t.map(|v| m.chart.vertices[v as usize]);
                assert_eq!(now, before.map(|v| of.chart.vertices[v as usize]));
            }
        }
    }

    #[test]
    fn what_is_left_of_a_chart_keeps_its_map() {
        // Of the faces around a middle vertex two opposite ones are lost. Where there are no others the two
        // fans that are left are apart; else they hang together around a hole, and only there.
        for (n, pieces, loops) in [(2, 2, 1), (6, 1, 2)] {
            let middle = (n * (n + 2) / 2) as u32;
            let (disk, uv) = samples::plane(n, n, 2.0, 2.0);
            let fan: Vec<u32> = (0..disk.triangles.len() as u32)
                .filter(|&f| disk.triangles[f as usize].contains(&middle))
                .collect();
            let lost = [fan[0], fan[fan.len() - 1]];
            let of = chart(disk, uv);
            let charts = last_resort(of.clone(), &lost, Scale { chart: 0.25, step: 1e-6 });
            assert_whole(&of, &charts);
            let (alone, left): (Vec<&Mapped>, Vec<&Mapped>) =
                charts.iter().partition(|m| lost.contains(&(m.chart.faces[0] - 100)));
            assert_eq!((alone.len(), left.len()), (2, pieces));
            for m in &left {
                assert_eq!(Border::of(&m.chart.disk).loops.len(), loops);
                for (p, v) in m.uv.iter().zip(&m.chart.vertices) {
                    assert!(p.distance(of.uv[*v as usize - 1000]) < 1e-12);
                }
            }
            let vertices = left.iter().flat_map(|m| &m.chart.vertices);
            assert_eq!(vertices.filter(|&&v| v == 1000 + middle).count(), 2, "one for each fan");
        }
    }

    #[test]
    fn a_face_alone_is_isometric_where_the_lattice_holds_it() {
        let of = chart(samples::barrel(6, 4), vec![DVec2::ZERO; 35]);
        let charts = last_resort(of.clone(), &[], Scale { chart: 0.1, step: 1e-6 });
        assert_whole(&of, &charts);
        for m in &charts {
            assert_eq!(m.chart.faces.len(), 1);
            assert!(!m.enlarged && certify(&m.chart.disk, &m.uv).is_injective());
            assert!(flatten::quality(&m.chart.disk, &m.uv).max - 1.0 < 1e-9);
        }
    }

    #[test]
    fn a_face_that_is_too_thin_is_enlarged_until_the_lattice_holds_it() {
        let scale = Scale { chart: 0.1, step: 1e-6 };
        let steps = |m: &Mapped| {
            let [a, b, c] = [0, 1, 2].map(|k| m.uv[k] * scale.chart / scale.step);
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            (longest, (b - a).perp_dot(c - a) / longest)
        };
        // A needle along each of its sides, a speck, and a face without any extent.
        let (long, tip) = (DVec3::X, DVec3::new(0.4, 1e-9, 0.0));
        let needle = [DVec3::ZERO, long, tip];
        let speck = [DVec3::ZERO, DVec3::X * 1e-8, DVec3::Y * 1e-8];
        let turned = (0..3).map(|k| [0, 1, 2].map(|i| needle[(i + k) % 3]));
        for corners in turned.chain([speck, [DVec3::ONE; 3]]) {
            let of = chart(Disk::new(corners.to_vec(), vec![[0, 1, 2]]), vec![DVec2::ZERO; 3]);
            let [m] = &last_resort(of, &[], scale)[..] else { panic!("one face, one chart") };
            let (length, height) = steps(m);
            assert!(length >= 0.99 * HEIGHT && height >= 0.7 * HEIGHT, "{length} {height}");
            assert!(m.enlarged);
        }
        // The needle is no longer than it was.
        let of = chart(Disk::new(needle.to_vec(), vec![[0, 1, 2]]), vec![DVec2::ZERO; 3]);
        let (length, _) = steps(&last_resort(of, &[0], scale)[0]);
        assert!((length - 1e5).abs() < 1.0, "{length}");
    }

    #[test]
    fn the_classical_islands_of_a_chart_have_its_faces() {
        let run = Run::quiet();
        let text = scenes::sheet(6, |x, y| 0.8 * (x + 0.3 * y).sin());
        let (_, solvers, cut) = scenes::cut(&text, &scenes::options(), &run);
        for mapped in cut.charts.into_iter().map(Mapped::from_cut) {
            let (part, mut faces) = (mapped.chart.part, mapped.chart.faces.clone());
            for island in classical(mapped).unwrap() {
                assert_eq!((island.chart.part, island.form), (part, ChartForm::Uvunwrap));
                assert!(certify(&island.chart.disk, &island.uv).is_injective());
                for (t, f) in island.chart.disk.triangles.iter().zip(&island.chart.faces) {
                    let own = t.map(|v| island.chart.vertices[v as usize]);
                    assert_eq!(own, solvers.surface.triangles[*f as usize]);
                    let at = faces.iter().position(|g| g == f).expect("each face is in one island");
                    faces.remove(at);
                }
            }
            assert!(faces.is_empty(), "{faces:?} are in none");
        }
    }

    #[test]
    fn every_fault_has_its_words() {
        let sound = Certificate { simple_boundary: true, ..Default::default() };
        assert_eq!(fault(&sound, 2), "");
        let all = Certificate {
            flipped: 1,
            overlapping_pairs: 2,
            overlap_texels: 3,
            out_of_range: 4,
            zero_area_uv: 5,
            min_gutter_texels: Some(1.5),
            ..Default::default()
        };
        let said = "1 flipped faces, 2 pairs of faces that overlap, 3 texels of two charts, 4 faces \
            outside of the page, 5 faces without area, a boundary that crosses itself, a gutter of \
            1.50 texels where 2 were asked for";
        assert_eq!(fault(&all, 2), said);
        assert!(!fault(&all, 1).contains("gutter"), "as wide as asked for");
    }
}
