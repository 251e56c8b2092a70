//! The smallest rectangle around a set of points: one of its sides runs along an edge of the convex
//! hull (Freeman & Shapira 1975; hull by Andrew's monotone chain, 1979).

use glam::DVec2;

/// The corners of the rectangle of least area around finite points, counter-clockwise, made at
/// least `thinnest` times as thick as it is long. `None` where the points do not span a length.
pub fn smallest_rectangle(points: &[DVec2], thinnest: f64) -> Option<[DVec2; 4]> {
    let hull = convex_hull(points);
    let edges = (0..hull.len()).map(|k| hull[(k + 1) % hull.len()] - hull[k]);
    let boxes = edges.filter_map(DVec2::try_normalize).map(|axis| {
        let across = |p: &DVec2| DVec2::new(axis.dot(*p), axis.perp_dot(*p));
        let low = hull.iter().map(across).fold(DVec2::INFINITY, DVec2::min);
        let high = hull.iter().map(across).fold(DVec2::NEG_INFINITY, DVec2::max);
        (axis, low, high)
    });
    let area = |&(_, low, high): &(DVec2, DVec2, DVec2)| (high - low).element_product();
    let (axis, low, high) = boxes.min_by(|a, b| area(a).total_cmp(&area(b)))?;
    let least = DVec2::splat(thinnest * (high - low).max_element());
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low).max(least));
    let corner = |x: f64, y: f64| axis.rotate(middle + half * DVec2::new(x, y));
    Some([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)])
}

/// Corners of the convex hull, counter-clockwise.
fn convex_hull(points: &[DVec2]) -> Vec<DVec2> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|p, q| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)));
    sorted.dedup();
    let mut hull: Vec<DVec2> = Vec::new();
    for side in 0..2 {
        let start = hull.len();
        for &p in &sorted {
            while let [.., a, b] = hull[start..] {
                if (b - a).perp_dot(p - a) > 0.0 {
                    break;
                }
                hull.pop();
            }
            hull.push(p);
        }
        // The last corner of one side is the first of the other.
        if side == 0 || hull.len() > start + 1 {
            hull.pop();
        }
        sorted.reverse();
    }
    hull
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_rectangle_is_found_again() {
        let turn = DVec2::from_angle(0.6);
        let points: Vec<DVec2> = (0..60)
            .map(|i| turn.rotate(DVec2::new((i % 10) as f64, 0.5 * (i / 10) as f64)))
            .collect();
        let corners = smallest_rectangle(&points, 1e-4).unwrap();
        let area = (corners[1] - corners[0]).perp_dot(corners[3] - corners[0]);
        assert!((area - 9.0 * 2.5).abs() < 1e-9);
    }

    #[test]
    fn points_on_a_line_get_a_thin_rectangle_and_a_single_point_none() {
        let line: Vec<DVec2> = (0..5).map(|i| DVec2::splat(f64::from(i))).collect();
        let corners = smallest_rectangle(&line, 1e-3).unwrap();
        let length = 4.0 * 2f64.sqrt();
        assert!((corners[0].distance(corners[1]) - length).abs() < 1e-12);
        assert!((corners[1].distance(corners[2]) - 1e-3 * length).abs() < 1e-12);
        assert!(smallest_rectangle(&[DVec2::ONE; 3], 1e-3).is_none());
        assert!(smallest_rectangle(&[], 1e-3).is_none());
    }
}
