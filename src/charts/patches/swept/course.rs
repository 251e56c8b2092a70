//! The course of a tube along a curve: a harmonic function from one end to the other, and stations at its
//! level sets, which are single loops since such a function has no other extremes.

use glam::DVec3;

use super::net::Net;

/// Faces of a station …
const FACES: usize = 24;

/// … and most stations.
const STATIONS: usize = 256;

/// A tube is at least so many girths long.
const SLENDER: f64 = 2.0;

/// A level set.
struct Station {
    /// Value of the function.
    level: f64,
    /// Mean of its points, by length.
    center: DVec3,
    /// Its length.
    girth: f64,
}

/// Where on its way from end to end each vertex of a net is.
pub struct Course {
    stations: Vec<Station>,
    /// Of each station, from the first.
    walked: Vec<f64>,
    /// Way along the course of each vertex, world units from the first station; before it negative.
    pub along: Vec<f64>,
    /// Length from the first station to the last.
    pub length: f64,
    /// Median length of the sections.
    pub girth: f64,
}

impl Course {
    /// The course of a function on a net.
    pub fn new(net: &Net, function: Vec<f64>) -> Option<Self> {
        let (disk, mesh) = (&net.piece.disk, net.mesh);
        let mean = |t: &[u32; 3]| t.iter().map(|&v| function[v as usize]).sum::<f64>() / 3.0;
        let mut faces: Vec<(f64, f64)> = disk
            .triangles
            .iter()
            .zip(&net.piece.faces)
            .map(|(t, &f)| (mean(t), mesh.area(f as usize)))
            .collect();
        faces.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Levels that part the area evenly.
        let count = (faces.len() / FACES).clamp(8, STATIONS);
        let total: f64 = faces.iter().map(|f| f.1).sum();
        let mut levels = Vec::with_capacity(count);
        let mut sum = 0.0;
        for (value, area) in faces {
            sum += area;
            if sum * count as f64 >= total * (levels.len() as f64 + 0.5) && levels.len() < count {
                levels.push(value);
            }
        }
        levels.dedup();
        let mut sums = vec![(DVec3::ZERO, 0.0); levels.len()];
        for t in &disk.triangles {
            let [a, b, c] = t.map(|v| function[v as usize]);
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            let first = levels.partition_point(|&l| l <= low);
            for (&level, sum) in levels.iter().zip(&mut sums).skip(first) {
                if level >= high {
                    break;
                }
                let [p, q] = crossing(net, t, &function, level)?;
                let length = p.distance(q);
                *sum = (sum.0 + 0.5 * (p + q) * length, sum.1 + length);
            }
        }
        let stations: Vec<Station> = levels
            .into_iter()
            .zip(sums)
            .filter(|(_, (_, girth))| *girth > 0.0)
            .map(|(level, (sum, girth))| Station { level, center: sum / girth, girth })
            .collect();
        let mut walked = vec![0.0];
        for pair in stations.windows(2) {
            walked.push(walked[walked.len() - 1] + pair[0].center.distance(pair[1].center));
        }
        if stations.len() < 4 {
            return None;
        }
        let mut girths: Vec<f64> = stations.iter().map(|s| s.girth).collect();
        girths.sort_by(f64::total_cmp);
        let mut course = Self {
            length: walked[walked.len() - 1],
            girth: girths[girths.len() / 2],
            stations,
            walked,
            along: Vec::new(),
        };
        course.along = function.iter().map(|&value| course.at(value)).collect();
        Some(course)
    }

    /// Way along the course at a value of the function.
    fn at(&self, value: f64) -> f64 {
        let above = self.stations.partition_point(|s| s.level <= value);
        let k = above.clamp(1, self.stations.len() - 1);
        let (a, b) = (&self.stations[k - 1], &self.stations[k]);
        let t = (value - a.level) / (b.level - a.level);
        self.walked[k - 1] + t * (self.walked[k] - self.walked[k - 1])
    }

    /// Whether it is long enough for its girth.
    pub fn is_slender(&self) -> bool {
        self.length >= SLENDER * self.girth
    }

    /// Unit direction of the course.
    pub fn tangent(&self, along: f64) -> DVec3 {
        let above = self.walked.partition_point(|&w| w <= along);
        let last = self.stations.len() - 1;
        let (a, b) = (above.clamp(1, last) - 1, above.clamp(1, last));
        let (a, b) = (a.saturating_sub(1), (b + 1).min(last));
        (self.stations[b].center - self.stations[a].center).normalize_or_zero()
    }

    /// Way along the course of the middle of a net's face.
    pub fn of_face(&self, net: &Net, face: usize) -> f64 {
        let t = net.piece.disk.triangles[face];
        t.iter().map(|&v| self.along[v as usize]).sum::<f64>() / 3.0
    }
}

/// Where a level crosses the edges of a triangle that has values on both sides of it.
fn crossing(net: &Net, t: &[u32; 3], function: &[f64], level: f64) -> Option<[DVec3; 2]> {
    let mut points = (0..3).filter_map(|k| {
        let (a, b) = (t[k], t[(k + 1) % 3]);
        let (low, high) = (function[a as usize], function[b as usize]);
        ((low <= level) != (high <= level))
            .then(|| net.position(a).lerp(net.position(b), (level - low) / (high - low)))
    });
    Some([points.next()?, points.next()?])
}
