//! Patches joined to charts: the weld of the joint seams (pipeline 5a.3). The dearest seams are
//! closed first; a path is closed only if the union keeps its distortion within the bound and is
//! proved injective. Two disks joined along one path are a disk, and so is a disk whose border is
//! zipped from a tip, so that charts are disks at every moment.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

use glam::{DMat2, DVec2};

use super::cost::edge_cost;
use super::fit::refine;
use super::patchwork::{Patchwork, next};
use crate::contract::{Canceled, Run};

/// A path whose two sides differ by more than this share of its length (rms, after the best rigid
/// motion) is not worth a solve.
const MISMATCH: f64 = 0.12;

/// Faces that all attempts together may flatten, per face of the part.
const WORK_PER_FACE: usize = 24;

/// A path that may be closed: half-edges on the border of `a`, in order; their twins lie on the
/// border of `b`, which is `a` itself for a zip.
struct Candidate {
    a: u32,
    b: u32,
    versions: (u32, u32),
    path: Vec<u32>,
}

/// Close paths until none is left that may be.
pub fn merge(work: &mut Patchwork, bound: f64, run: &Run) -> Result<(), Canceled> {
    let charts = work.faces.len();
    let mut version = vec![0u32; charts];
    let mut candidates: Vec<Candidate> = Vec::new();
    let mut heap = BinaryHeap::new();
    let mut failed: Vec<BTreeSet<u32>> = vec![BTreeSet::new(); charts];
    let mut allowance = WORK_PER_FACE * work.mesh.len() + 20_000;
    for chart in 0..charts as u32 {
        offer(work, chart, &version, |b| b > chart, &mut candidates, &mut heap);
    }
    while let Some((_, Reverse(id))) = heap.pop() {
        run.cancel.check()?;
        let candidate = &candidates[id as usize];
        let (a, b) = (candidate.a, candidate.b);
        let current = (version[a as usize], version[b as usize]);
        if candidate.versions != current || failed[a as usize].contains(&b) {
            continue;
        }
        let size = work.faces[a as usize].len() + work.faces[b as usize].len();
        if size > allowance {
            continue;
        }
        allowance -= size;
        let path = std::mem::take(&mut candidates[id as usize].path);
        if !close(work, a, b, &path, bound, run)? {
            failed[a as usize].insert(b);
            failed[b as usize].insert(a);
            continue;
        }
        version[a as usize] += 1;
        if a != b {
            version[b as usize] += 1;
            // What one of the two could not be joined to, the union cannot either.
            let others = std::mem::take(&mut failed[b as usize]);
            others.iter().for_each(|&o| {
                failed[o as usize].insert(a);
            });
            failed[a as usize].extend(others);
        }
        failed[a as usize].remove(&a);
        offer(work, a, &version, |_| true, &mut candidates, &mut heap);
    }
    Ok(())
}

/// Find the paths between a chart and its neighbours, and the zips of its own border.
fn offer(
    work: &Patchwork,
    chart: u32,
    version: &[u32],
    wanted: impl Fn(u32) -> bool,
    candidates: &mut Vec<Candidate>,
    heap: &mut BinaryHeap<(u64, Reverse<u32>)>,
) {
    let border = work.border(chart);
    let mut push = |b: u32, path: Vec<u32>| {
        let gain: f64 = path.iter().map(|&h| edge_cost(work.mesh, h)).sum();
        let versions = (version[chart as usize], version[b as usize]);
        heap.push((gain.to_bits(), Reverse(candidates.len() as u32)));
        candidates.push(Candidate { a: chart, b, versions, path });
    };
    for path in runs(work, chart, &border) {
        let b = work.across(path[0]).unwrap_or(chart);
        if wanted(b) {
            push(b, path);
        }
    }
    for path in zips(work, &border) {
        push(chart, path);
    }
}

/// Maximal paths along a border that have one and the same other chart on their other side, there
/// in one piece too.
fn runs(work: &Patchwork, chart: u32, border: &[u32]) -> Vec<Vec<u32>> {
    let twin = |h: u32| work.mesh.twin[h as usize];
    let other = |h: u32| work.across(h).filter(|&b| b != chart);
    let follows = |h: u32, g: u32| {
        other(h).is_some() && other(h) == other(g) && work.next_on_border(twin(g)) == twin(h)
    };
    let n = border.len();
    // Start where a run starts, if there is such a place; a border that is one run all round has
    // its last edge left out, for it would close a sphere.
    let start = (0..n).find(|&i| !follows(border[(i + n - 1) % n], border[i]));
    let mut found: Vec<Vec<u32>> = Vec::new();
    let Some(start) = start else {
        return vec![border[..n - 1].to_vec()];
    };
    for i in 0..n {
        let h = border[(start + i) % n];
        if other(h).is_none() {
            continue;
        }
        match found.last_mut() {
            Some(path) if i > 0 && path.last().is_some_and(|&g| follows(g, h)) => path.push(h),
            _ => found.push(vec![h]),
        }
    }
    // Closing every edge of the other's border would close it up too.
    found.retain(|path| !path.is_empty());
    found
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

/// Try to close one path. On success the union is chart `a`.
fn close(
    work: &mut Patchwork,
    a: u32,
    b: u32,
    path: &[u32],
    bound: f64,
    run: &Run,
) -> Result<bool, Canceled> {
    let mut moved = None;
    if a != b {
        let Some(motion) = rigid_motion(work, path) else { return Ok(false) };
        moved = Some(motion);
    }
    work.set_glued(path, true);
    let mut faces = work.faces[a as usize].clone();
    if a != b {
        faces.extend_from_slice(&work.faces[b as usize]);
        faces.sort_unstable();
    }
    let piece = work.mesh.cut_open(faces, &work.glued);
    // Warm map: every vertex at the mean of its corners, `b` moved next to `a`.
    let mut sum = vec![(DVec2::ZERO, 0.0); piece.disk.positions.len()];
    for (&f, triangle) in piece.faces.iter().zip(&piece.disk.triangles) {
        let theirs = moved.filter(|_| work.chart_of[f as usize] == b);
        for (k, &v) in triangle.iter().enumerate() {
            let at = work.uv[3 * f as usize + k];
            let at = theirs.map_or(at, |(rotation, shift): (DMat2, DVec2)| rotation * at + shift);
            let entry = &mut sum[v as usize];
            *entry = (entry.0 + at, entry.1 + 1.0);
        }
    }
    let warm = sum.into_iter().map(|(total, count)| total / count).collect();
    let Some(uv) = refine(&piece.disk, warm, bound, run)? else {
        work.set_glued(path, false);
        return Ok(false);
    };
    for (&f, triangle) in piece.faces.iter().zip(&piece.disk.triangles) {
        work.chart_of[f as usize] = a;
        for (k, &v) in triangle.iter().enumerate() {
            work.uv[3 * f as usize + k] = uv[v as usize];
        }
    }
    if a != b {
        work.faces[b as usize].clear();
    }
    work.faces[a as usize] = piece.faces;
    Ok(true)
}

/// The rotation and shift that lay the far side of a path best onto its near side, unless they
/// differ too much to be worth a solve.
fn rigid_motion(work: &Patchwork, path: &[u32]) -> Option<(DMat2, DVec2)> {
    let mut pairs = Vec::with_capacity(2 * path.len());
    let mut length = 0.0;
    for &h in path {
        let t = work.mesh.twin[h as usize];
        let (h, t) = (h as usize, t as usize);
        pairs.push((work.uv[h], work.uv[next(t as u32) as usize]));
        pairs.push((work.uv[next(h as u32) as usize], work.uv[t]));
        length += work.mesh.length(h as u32);
    }
    let n = pairs.len() as f64;
    let near = pairs.iter().map(|p| p.0).sum::<DVec2>() / n;
    let far = pairs.iter().map(|p| p.1).sum::<DVec2>() / n;
    let (mut dot, mut perp) = (0.0, 0.0);
    for (p, q) in &pairs {
        dot += (q - far).dot(p - near);
        perp += (q - far).perp_dot(p - near);
    }
    let rotation = DMat2::from_angle(perp.atan2(dot));
    let shift = near - rotation * far;
    let error: f64 = pairs.iter().map(|(p, q)| (rotation * *q + shift - *p).length_squared()).sum();
    ((error / n).sqrt() <= MISMATCH * length).then_some((rotation, shift))
}
