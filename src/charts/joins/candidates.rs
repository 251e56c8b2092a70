//! Which paths of seam may be closed: between a chart and its neighbours, and from the tips of its
//! own border.

use std::f64::consts::TAU;

use crate::charts::limits::cost::edge_cost;
use crate::charts::part_mesh::PartMesh;
use crate::charts::patchwork::Patchwork;
use crate::mesh::NONE;

/// A part of a common border that is shorter than this share of the smaller chart's size (√area) is
/// too thin a neck to hang a chart by.
const NECK: f64 = 0.25;

/// A path that may be closed: half-edges on the border of `a`, in order; their twins lie on the
/// border of `b`, which is `a` itself for a slit and for a zip.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// The chart on this side.
    pub a: u32,
    /// The chart on the other side.
    pub b: u32,
    /// Whether the path runs from a tip of the border outwards.
    pub zip: bool,
    /// Local half-edges.
    pub path: Vec<u32>,
}

impl Candidate {
    /// What makes two candidates the same seam, from whichever side it was found.
    pub fn key(&self, work: &Patchwork) -> (u32, u32) {
        let twin = |h: u32| work.mesh.twin[h as usize];
        let (first, last) = (self.path[0], self.path[self.path.len() - 1]);
        (first, last).min((twin(last), twin(first)))
    }

    /// Length times cost of the seam.
    pub fn cost(&self, work: &Patchwork) -> f64 {
        self.path.iter().map(|&h| edge_cost(work.mesh, h)).sum()
    }

    /// Faces of its charts.
    pub fn size(&self, work: &Patchwork) -> usize {
        let other = if self.a == self.b { 0 } else { work.faces[self.b as usize].len() };
        work.faces[self.a as usize].len() + other
    }

    /// The path in two, parted at its inner vertex of largest angle defect; of a zip only the half
    /// at the tip. Halves that are too thin a neck are left out.
    pub fn halves(&self, work: &Patchwork, defects: &[f64]) -> Vec<Candidate> {
        // Vertex i lies between half-edges i − 1 and i.
        let n = self.path.len();
        let zip = self.zip;
        // A zip runs against the border.
        let bend = |i: usize| defects[self.path[if zip { i - 1 } else { i }] as usize].abs();
        // Of equal bends the one nearest to the middle, so that halving ends soon.
        let off = |i: usize| (2 * i).abs_diff(n);
        let best = (1..n).min_by(|&i, &j| bend(j).total_cmp(&bend(i)).then(off(i).cmp(&off(j))));
        let Some(at) = best else { return Vec::new() };
        let smaller = work.area[self.a as usize].min(work.area[self.b as usize]);
        let least = if zip { 0.0 } else { NECK * smaller.sqrt() };
        [&self.path[..at], &self.path[at..]]
            .into_iter()
            .take(if zip { 1 } else { 2 })
            .filter(|half| half.iter().map(|&h| work.mesh.length(h)).sum::<f64>() >= least)
            .map(|half| Candidate { path: half.to_vec(), ..*self })
            .collect()
    }
}

/// 2π minus the angles around the vertex that each half-edge starts from, in the part; 0 on the
/// part's border. Length: 3 × faces.
pub fn angle_defects(mesh: &PartMesh) -> Vec<f64> {
    let corners = 3 * mesh.len() as u32;
    let angle = |c: u32| {
        let p = mesh.surface.corners(mesh.faces[c as usize / 3] as usize);
        let k = c as usize % 3;
        (p[(k + 1) % 3] - p[k]).angle_between(p[(k + 2) % 3] - p[k])
    };
    let mut defects = vec![f64::NAN; corners as usize];
    let mut fan = Vec::new();
    for seed in 0..corners {
        if !defects[seed as usize].is_nan() {
            continue;
        }
        // Corners around the vertex, in turn: across the half-edge before.
        fan.clear();
        let mut c = seed;
        let closed = loop {
            fan.push(c);
            let t = mesh.twin[(3 * (c / 3) + (c % 3 + 2) % 3) as usize];
            if t == NONE {
                break false;
            }
            c = t;
            if c == seed {
                break true;
            }
        };
        let defect = if closed { TAU - fan.iter().map(|&c| angle(c)).sum::<f64>() } else { 0.0 };
        fan.iter().for_each(|&c| defects[c as usize] = defect);
    }
    defects
}

/// The paths between a chart and its neighbours, the slits of its own border, and its zips.
pub fn around(work: &Patchwork, chart: u32) -> Vec<Candidate> {
    let mut found = Vec::new();
    for border in &work.rims[chart as usize] {
        for path in runs(work, border) {
            let b = work.across(path[0]).unwrap_or(chart);
            found.push(Candidate { a: chart, b, zip: false, path });
        }
        for path in zips(work, border) {
            found.push(Candidate { a: chart, b: chart, zip: true, path });
        }
    }
    found
}

/// Maximal paths along a border that have one and the same chart on their other side, there in one
/// piece too. That chart may be the same one, across a slit; slits that end in a tip are zips.
fn runs(work: &Patchwork, border: &[u32]) -> Vec<Vec<u32>> {
    let twin = |h: u32| work.mesh.twin[h as usize];
    let n = border.len();
    let (before, after) = (|i: usize| border[(i + n - 1) % n], |i: usize| border[(i + 1) % n]);
    let other = |h: u32| work.across(h);
    let follows = |h: u32, g: u32| {
        other(h).is_some()
            && other(h) == other(g)
            && twin(h) != g
            && work.next_on_border(twin(g)) == twin(h)
    };
    // Start where a run starts, if there is such a place; a border that is one run all round has
    // its last edge left out, for it would close a sphere.
    let start = (0..n).find(|&i| !follows(before(i), border[i]));
    let Some(start) = start else {
        return vec![border[..n - 1].to_vec()];
    };
    let mut found: Vec<Vec<u32>> = Vec::new();
    let mut tips: Vec<bool> = Vec::new();
    for i in (0..n).map(|k| (start + k) % n) {
        let h = border[i];
        if other(h).is_none() {
            continue;
        }
        let at_tip = twin(h) == before(i) || twin(h) == after(i);
        match found.last_mut().zip(tips.last_mut()) {
            Some((path, tip)) if i != start && path.last().is_some_and(|&g| follows(g, h)) => {
                path.push(h);
                *tip |= at_tip;
            }
            _ => {
                found.push(vec![h]);
                tips.push(at_tip);
            }
        }
    }
    found
        .into_iter()
        .zip(tips)
        .filter(|(path, tip)| !tip && !path.is_empty())
        .map(|x| x.0)
        .collect()
}

/// Paths that close a border upon itself from a tip outwards.
fn zips(work: &Patchwork, border: &[u32]) -> Vec<Vec<u32>> {
    let n = border.len();
    let twin = |h: u32| work.mesh.twin[h as usize];
    let mut found = Vec::new();
    for i in 0..n {
        let mut path = Vec::new();
        while 2 * (path.len() + 1) < n {
            let (left, right) =
                (border[(i + n - path.len()) % n], border[(i + 1 + path.len()) % n]);
            if twin(left) != right {
                break;
            }
            path.push(left);
        }
        if !path.is_empty() {
            found.push(path);
        }
    }
    found
}
