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

/// What is left of a chart without some of its faces, each connected piece with the chart's map.
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
