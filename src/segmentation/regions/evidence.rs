//! What is known of each face before any part is: the network's embedding and names, and its shape
//! diameter.

use std::collections::VecDeque;

use burn::tensor::Tensor;
use glam::DVec3;

use super::super::Seen;
use super::super::network::Network;
use super::super::point_mae::{NAMES, NetworkCloud};
use super::super::thickness::thickness;
use crate::contract::{Canceled, Run};
use crate::device::DeviceKind;
use crate::mesh::rays::Rays;
use crate::mesh::{NONE, Surface};
use crate::sampling::{NETWORK_POINTS, PointCloud, farthest_points};
use crate::tasks;

/// Places on the surface at which the network is asked, at most …
const QUERIES: usize = 16_384;

/// … and on a surface of few faces so many a face, but not fewer than these.
const QUERIES_A_FACE: usize = 2;
const LEAST_QUERIES: usize = 4_096;

/// Places that a processor asks about at a time.
const BLOCK: usize = 1024;

/// Attitudes in which the object is shown: as it stands and turned from z up to y up, for it is not known which
/// of the two a file means. A third, on its side, found no better parts of 86 labelled objects (docs/results.md).
const POSES: usize = 2;

/// Share of the stage's time that goes before the first pose …
const BEFORE_POSES: f64 = 0.25;

/// … and that is gone after the last one.
const POSES_DONE: f64 = 0.85;

/// Evidence for each face. Faces without area have none.
#[derive(Debug, Clone, Default)]
pub struct Evidence {
    /// Channels of the embedding; 0 without a network.
    pub width: usize,
    /// Embedding of each face, `width` values each.
    pub embedding: Vec<f32>,
    /// Share of each of [`NAMES`] for each face; empty without a network.
    pub names: Vec<f32>,
    /// Shape diameter over the diagonal, 0 where unknown.
    pub thickness: Vec<f32>,
}

/// Gather the evidence, with a network or without.
pub fn gather(seen: Seen, network: Option<&Network>, run: &Run) -> Result<Evidence, Canceled> {
    let Seen { surface, cloud } = seen;
    if cloud.is_empty() {
        return Ok(Evidence { thickness: vec![0.0; surface.face_count()], ..Default::default() });
    }
    let faces = surface.face_count();
    let asked = cloud.subset(&spread(cloud, faces));
    run.count(asked.positions.len());
    let rays = tasks::link("rays", || Rays::new(surface));
    let shown = || network.map(|_| farthest_points(cloud, NETWORK_POINTS, run)).transpose();
    let (through, shown) = tasks::join(
        "looks",
        || thickness(surface, &rays, &asked.positions, &asked.faces),
        || tasks::link("points shown", shown),
    );
    let shown = shown?;
    run.cancel.check()?;
    let relative: Vec<f32> = through.iter().map(|t| t / surface.diagonal as f32).collect();
    let fill = tasks::link("nearest known", || nearest_known(surface, &asked));
    let mut evidence =
        Evidence { thickness: on_faces(faces, &asked, &relative, 1, &fill), ..Default::default() };
    let (Some(Network { model, config, device, .. }), Some(shown)) = (network, shown) else {
        return Ok(evidence);
    };
    let shown = cloud.subset(&shown);
    let shown_through = thickness(surface, &rays, &shown.positions, &shown.faces);
    let mut whole = network_cloud(&shown, &shown_through);
    let (middle, scale) = whole.normalise();
    let mut places = network_cloud(&asked, &through);
    places.place(middle, scale);
    evidence.width = POSES * config.part;
    evidence.embedding = vec![0.0; faces * evidence.width];
    evidence.names = vec![0.0; faces * NAMES.len()];
    run.advance(BEFORE_POSES);
    let steps = run.steps(POSES, BEFORE_POSES, POSES_DONE);
    // The processor asks few at a time, so that what comes between stays in its cache.
    let block = if device.kind() == DeviceKind::Cpu { BLOCK } else { QUERIES };
    let hear = |pose: usize| {
        run.cancel.check()?;
        let (shown, asked_places) = (turned(&whole, pose), turned(&places, pose));
        let tensors = device.burn();
        let sight = model.look(config, &[shown], device, &tensors);
        let (mut part, mut names) = (Vec::new(), Vec::new());
        for first in (0..asked_places.len()).step_by(block) {
            let some = asked_places.slice(first..asked_places.len().min(first + block));
            let features = model.ask(config, &sight, &[some], device, &tensors);
            let shares = burn::tensor::activation::softmax(features.names, 2);
            part.extend(values(features.part));
            names.extend(values(shares));
        }
        let part = on_faces(faces, &asked, &part, config.part, &fill);
        let names = on_faces(faces, &asked, &names, NAMES.len(), &fill);
        steps.step();
        Ok((part, names))
    };
    // Much of a pass runs on one thread of the processor; a GPU does one at a time.
    let heard: Result<Vec<_>, Canceled> = match device.kind() {
        DeviceKind::Cpu => tasks::map("pose", 0..POSES, hear).into_iter().collect(),
        _ => (0..POSES).map(hear).collect(),
    };
    for (pose, (part, names)) in heard?.iter().enumerate() {
        // Distances in the joined embedding are root mean squares over the poses.
        let share = 1.0 / (POSES as f32).sqrt();
        for (f, from) in part.chunks(config.part).enumerate() {
            let to = &mut evidence.embedding[f * evidence.width + pose * config.part..];
            to.iter_mut().zip(from).for_each(|(to, from)| *to = share * from);
        }
        let sum = evidence.names.iter_mut().zip(names);
        sum.for_each(|(sum, name)| *sum += name / POSES as f32);
    }
    Ok(evidence)
}

fn values(tensor: Tensor<3>) -> Vec<f32> {
    tensor.into_data().try_into_vec().unwrap_or_default()
}

/// Points at which to ask, spread over the cloud of a surface of so many faces.
fn spread(cloud: &PointCloud, faces: usize) -> Vec<u32> {
    let most = (QUERIES_A_FACE * faces).clamp(LEAST_QUERIES, QUERIES);
    let count = cloud.len().min(most);
    (0..count).map(|i| (i * cloud.len() / count) as u32).collect()
}

fn network_cloud(cloud: &PointCloud, through: &[f32]) -> NetworkCloud {
    let narrow = |p: &DVec3| p.as_vec3().to_array();
    NetworkCloud {
        positions: cloud.positions.iter().map(narrow).collect(),
        normals: cloud.normals.iter().map(narrow).collect(),
        thickness: through.to_vec(),
    }
}

/// As it stands, or with what points along z upright.
fn turned(cloud: &NetworkCloud, pose: usize) -> NetworkCloud {
    let turn = |[x, y, z]: [f32; 3]| match pose {
        0 => [x, y, z],
        _ => [x, z, -y],
    };
    NetworkCloud {
        positions: cloud.positions.iter().map(|&p| turn(p)).collect(),
        normals: cloud.normals.iter().map(|&n| turn(n)).collect(),
        thickness: cloud.thickness.clone(),
    }
}

/// Means over the points of each face; a face without any takes those of the face in `fill`.
fn on_faces(
    faces: usize,
    cloud: &PointCloud,
    values: &[f32],
    width: usize,
    fill: &[u32],
) -> Vec<f32> {
    let mut sums = vec![0.0; faces * width];
    let mut counts = vec![0u32; faces];
    for (&face, row) in cloud.faces.iter().zip(values.chunks(width)) {
        let sum = &mut sums[face as usize * width..][..width];
        sum.iter_mut().zip(row).for_each(|(s, v)| *s += v);
        counts[face as usize] += 1;
    }
    for (f, &count) in counts.iter().enumerate().filter(|(_, c)| **c > 1) {
        sums[f * width..][..width].iter_mut().for_each(|s| *s /= count as f32);
    }
    for (f, &from) in
        fill.iter().enumerate().filter(|(f, from)| **from != NONE && **from as usize != *f)
    {
        sums.copy_within(from as usize * width..(from as usize + 1) * width, f * width);
    }
    sums
}

/// For each face the nearest one, over edges, that has a point; itself if it has.
fn nearest_known(surface: &Surface, cloud: &PointCloud) -> Vec<u32> {
    let mut from = vec![NONE; surface.face_count()];
    let mut queue = VecDeque::new();
    for &f in &cloud.faces {
        if from[f as usize] == NONE {
            from[f as usize] = f;
            queue.push_back(f);
        }
    }
    while let Some(f) = queue.pop_front() {
        let across = (3 * f..3 * f + 3).map(|h| surface.twin[h as usize]).filter(|t| *t != NONE);
        for g in across.map(|t| t / 3) {
            if from[g as usize] == NONE {
                from[g as usize] = from[f as usize];
                queue.push_back(g);
            }
        }
    }
    from
}
