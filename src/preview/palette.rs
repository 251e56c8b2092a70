//! Colours of parts: twelve hues that stay apart under the common forms of colour blindness, also by
//! their lightness. Chosen from Okabe and Ito, "Color universal design", 2008, and from the "muted"
//! scheme of Tol, "Colour schemes", SRON/EPS/TN/09-002, 2021.

use std::sync::LazyLock;

/// Parts beyond the twelfth take the hues again, lighter.
const HUES: [[u8; 3]; 12] = [
    [0x00, 0x72, 0xB2],
    [0xE6, 0x9F, 0x00],
    [0x44, 0xAA, 0x99],
    [0xCC, 0x66, 0x77],
    [0x99, 0x99, 0x33],
    [0xAA, 0x44, 0x99],
    [0x56, 0xB4, 0xE9],
    [0xD5, 0x5E, 0x00],
    [0x11, 0x77, 0x33],
    [0xDD, 0xCC, 0x77],
    [0x33, 0x22, 0x88],
    [0x88, 0x22, 0x55],
];

/// Colour of what is in no part.
const NONE_COLOR: [u8; 3] = [0x9A, 0x9A, 0x9A];

/// Colour of part `id`, sRGB.
pub fn part_color(id: u32) -> [u8; 3] {
    if id == crate::mesh::NONE {
        return NONE_COLOR;
    }
    let hue = HUES[id as usize % HUES.len()];
    let lighter = [0, 2, 4][id as usize / HUES.len() % 3];
    hue.map(|c| (u32::from(c) + (255 - u32::from(c)) * lighter / 10) as u8)
}

/// As `#rrggbb`.
pub(super) fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Linear light of an sRGB colour (IEC 61966-2-1).
pub(super) fn linear(color: [u8; 3]) -> glam::Vec3 {
    let component = |c: u8| {
        let c = f32::from(c) / 255.0;
        if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    };
    glam::Vec3::from_array(color.map(component))
}

/// The sRGB value of linear light in one channel.
fn encode_channel(c: f32) -> u8 {
    let c = c.clamp(0.0, 1.0);
    let c = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    (c * 255.0 + 0.5) as u8
}

/// The least light of each value but 0: to look it up costs a tenth of the power.
static LEAST_LIGHT: LazyLock<[f32; 255]> = LazyLock::new(|| {
    std::array::from_fn(|below| {
        // Positive numbers order as their bits do.
        let (mut under, mut reached) = (0, 1f32.to_bits());
        while reached - under > 1 {
            let middle = under + (reached - under) / 2;
            if usize::from(encode_channel(f32::from_bits(middle))) > below {
                reached = middle;
            } else {
                under = middle;
            }
        }
        f32::from_bits(reached)
    })
});

/// Steps of linear light for each of which the least value is known.
const STEPS: usize = 4096;

/// The value at the start of each step: from there the one sought is at most a few further.
static VALUE_AT: LazyLock<[u8; STEPS + 1]> = LazyLock::new(|| {
    std::array::from_fn(|step| {
        let light = step as f32 / STEPS as f32;
        LEAST_LIGHT.partition_point(|&least| least <= light) as u8
    })
});

/// The sRGB colour of linear light.
pub(super) fn encode(light: glam::Vec3) -> [u8; 3] {
    let (least, value_at) = (&*LEAST_LIGHT, &*VALUE_AT);
    light.to_array().map(|c| {
        // NaN and what is below 0 become 0.
        let mut value = value_at[((c * STEPS as f32) as usize).min(STEPS)];
        while least.get(usize::from(value)).is_some_and(|&least| least <= c) {
            value += 1;
        }
        value
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_thirty_six_colours_differ() {
        let mut colors: Vec<[u8; 3]> = (0..36).map(part_color).collect();
        colors.sort_unstable();
        colors.dedup();
        assert_eq!(colors.len(), 36);
    }

    #[test]
    fn what_is_looked_up_is_what_the_formula_says() {
        for i in -10..=20_010 {
            let c = i as f32 / 20_000.0;
            assert_eq!(encode(glam::Vec3::splat(c)), [encode_channel(c); 3], "{c}");
        }
        assert_eq!(encode(glam::Vec3::new(f32::NAN, f32::INFINITY, 0.0)), [0, 255, 0]);
    }

    #[test]
    fn encoding_undoes_linear() {
        for c in 0..=255 {
            assert_eq!(encode(linear([c, 0, 255])), [c, 0, 255]);
        }
    }
}
