//! Curves over steps, as a picture: what a training run shows for itself.

use glam::{Vec2, Vec3};

use super::canvas::Canvas;
use super::lines::LineMask;
use super::palette::part_color;
use super::picture::{PreviewError, encode_png};
use super::text;

const WIDTH: usize = 960;
const HEIGHT: usize = 360;
/// Room left of and below a panel for its numbers.
const MARGIN: usize = 72;

/// One line of a panel.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Curve {
    /// Its name.
    pub name: String,
    /// (step, or whatever is counted from left to right, value), in its order.
    pub points: Vec<(f64, f64)>,
}

/// Panels one below the other, each with its title and curves, values from 0; `along` says what is counted from
/// left to right.
pub fn curves_png(panels: &[(String, Vec<Curve>)], along: &str) -> Result<Vec<u8>, PreviewError> {
    let paper = Vec3::splat(0.95);
    let mut page = Canvas::gradient(WIDTH, HEIGHT * panels.len().max(1), paper, paper);
    for (i, (title, curves)) in panels.iter().enumerate() {
        panel(&mut page, i * HEIGHT, title, curves, along);
    }
    Ok(encode_png(&page, png::Compression::Balanced)?)
}

fn panel(page: &mut Canvas, top: usize, title: &str, curves: &[Curve], along: &str) {
    let ink = Vec3::splat(0.05);
    let points = || curves.iter().flat_map(|c| &c.points).filter(|p| p.1.is_finite());
    let steps = points().map(|p| p.0).fold(1.0, f64::max);
    // A first value far above the rest would press the rest flat.
    let mut values: Vec<f64> = points().map(|p| p.1).collect();
    values.sort_by(f64::total_cmp);
    let most = values.get(values.len().saturating_sub(1) * 98 / 100).copied().unwrap_or(1.0);
    let most = if most > 0.0 { 1.05 * most } else { 1.0 };
    let (left, right) = (MARGIN as f32, (WIDTH - 16) as f32);
    let (high, low) = ((top + 40) as f32, (top + HEIGHT - 40) as f32);
    let at = |step: f64, value: f64| {
        let (x, y) = ((step / steps) as f32, (value / most).clamp(0.0, 1.0) as f32);
        Vec2::new(left + x * (right - left), low + y * (high - low))
    };
    let mut frame = LineMask::new(page.width, page.height);
    for k in 0..=4 {
        let value = most * f64::from(k) / 4.0;
        frame.draw(at(0.0, value), at(steps, value), 1.0, |_, _| true);
        let y = at(0.0, value).y as usize - text::LINE / 2;
        text::write(page, &format!("{value:.3}"), [8, y], MARGIN, ink);
    }
    page.lay(&frame.scaled(0.25), ink);
    text::write(page, title, [MARGIN, top + 8], WIDTH / 3, ink);
    let steps_text = format!("{steps:.0} {along}");
    text::write(page, &steps_text, [WIDTH - 140, top + HEIGHT - 30], 140, ink);
    for (i, curve) in (0u32..).zip(curves) {
        let color = Vec3::from(part_color(i + 1).map(|c| (f32::from(c) / 255.0).powf(2.2) * 0.7));
        let mut mask = LineMask::new(page.width, page.height);
        for pair in curve.points.windows(2) {
            mask.draw(at(pair[0].0, pair[0].1), at(pair[1].0, pair[1].1), 1.5, |_, _| true);
        }
        page.lay(&mask.scaled(1.0), color);
        let x = WIDTH / 3 + 16 + i as usize * 200;
        if x + 190 < WIDTH {
            text::write(page, &curve.name, [x, top + 8], 190, color);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_falling_curve_leaves_its_color_high_on_the_left_and_low_on_the_right() {
        let points = (0..50).map(|i| (f64::from(i), 1.0 / f64::from(1 + i))).collect();
        let curves = vec![Curve { name: "loss".into(), points }];
        let paper = Vec3::splat(0.95);
        let mut page = Canvas::gradient(WIDTH, HEIGHT, paper, paper);
        panel(&mut page, 0, "", &curves, "steps");
        let color = Vec3::from(part_color(1).map(|c| (f32::from(c) / 255.0).powf(2.2) * 0.7));
        // Where a column is nearest to the curve's color.
        let drawn = |x: usize| {
            let off = |y: usize| (page.pixels[y * WIDTH + x] - color).length();
            (44..HEIGHT - 36).min_by(|&a, &b| off(a).total_cmp(&off(b))).unwrap()
        };
        let (left, right) = (drawn(MARGIN + 8), drawn(WIDTH - 40));
        assert!(left + 100 < right, "{left} {right}");
        assert!(curves_png(&[("a".into(), curves)], "steps").unwrap().starts_with(b"\x89PNG"));
    }
}
