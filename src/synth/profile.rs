//! Profiles of turned wood: radii along an axis, smooth between the turner's marks.

use glam::DVec2;

/// A Catmull–Rom curve through the marks, (radius, height) each, sampled so that every mark is hit
/// and the rest of about `points` samples lie where the profile is long.
pub(super) fn turned(marks: &[DVec2], points: usize) -> Vec<DVec2> {
    let lengths: Vec<f64> = marks.windows(2).map(|w| w[0].distance(w[1])).collect();
    let total: f64 = lengths.iter().sum();
    let last = marks.len() - 1;
    let mut out = vec![marks[0]];
    for (i, length) in lengths.iter().enumerate() {
        let pieces = ((points as f64 * length / total).round() as usize).max(1);
        let (p0, p1) = (marks[i.saturating_sub(1)], marks[i]);
        let (p2, p3) = (marks[i + 1], marks[(i + 2).min(last)]);
        for k in 1..=pieces {
            let t = k as f64 / pieces as f64;
            let (t2, t3) = (t * t, t * t * t);
            let bend = (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3) * t2;
            let x = 0.5 * (2.0 * p1 + (p2 - p0) * t + bend + (3.0 * p1 - p0 - 3.0 * p2 + p3) * t3);
            // Heights run evenly between marks, so that the curve never turns back.
            out.push(DVec2::new(x.x.max(1e-4), p1.y + t * (p2.y - p1.y)));
        }
    }
    out
}

/// The marks (share of the largest radius, share of the length) at a real size.
pub(super) fn marks(shape: &[(f64, f64)], radius: f64, length: f64) -> Vec<DVec2> {
    shape.iter().map(|&(r, t)| DVec2::new(r * radius, t * length)).collect()
}

/// Legs of chairs and tables, from the floor upwards.
pub(super) const LEGS: [&[(f64, f64)]; 3] = [
    // A vase on a foot, a ring below the seat.
    &[
        (0.52, 0.0),
        (0.60, 0.05),
        (0.46, 0.14),
        (0.80, 0.36),
        (1.0, 0.52),
        (0.62, 0.70),
        (0.86, 0.77),
        (0.64, 0.84),
        (0.80, 1.0),
    ],
    // A long taper with one swelling.
    &[(0.48, 0.0), (0.56, 0.10), (0.78, 0.38), (1.0, 0.64), (0.86, 0.84), (0.72, 1.0)],
    // Two bulbs.
    &[
        (0.60, 0.0),
        (0.44, 0.10),
        (0.72, 0.24),
        (0.92, 0.36),
        (0.58, 0.50),
        (0.84, 0.62),
        (1.0, 0.74),
        (0.66, 0.88),
        (0.78, 1.0),
    ],
];
