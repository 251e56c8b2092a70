//! Vertices in colours, no two neighbours of one: those of one colour can be moved at the same time, and what comes
//! out is as if they had been moved one after the other (multicolour Gauss–Seidel: Adams & Ortega 1982, "A
//! multi-color SOR method for parallel computation").

use super::Disk;
use super::fans::Fans;

/// The vertices of each colour, ascending: each vertex has the first colour that none of its lower neighbours has.
pub fn colors(disk: &Disk, fans: &Fans) -> Vec<Vec<u32>> {
    let count = disk.positions.len();
    let mut own = vec![u8::MAX; count];
    let mut colors: Vec<Vec<u32>> = Vec::new();
    for v in 0..count {
        let mut taken = [false; 255];
        for w in fans.at(v).iter().flat_map(|&c| disk.triangles[c as usize / 3]) {
            if let Some(taken) = taken.get_mut(own[w as usize] as usize) {
                *taken = true;
            }
        }
        // A vertex with more neighbours than there are colours would share the last one's; it stays out, and is
        // moved by none.
        let Some(color) = taken.iter().position(|taken| !taken) else { continue };
        own[v] = color as u8;
        if color == colors.len() {
            colors.push(Vec::new());
        }
        colors[color].push(v as u32);
    }
    colors
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::samples;

    #[test]
    fn neighbours_differ_and_each_vertex_has_a_color() {
        let (disk, _) = samples::plane(9, 7, 1.0, 1.0);
        let colors = colors(&disk, &Fans::of(&disk));
        assert!(colors.len() <= 7, "{}", colors.len());
        let mut of = vec![usize::MAX; disk.positions.len()];
        for (color, vertices) in colors.iter().enumerate() {
            vertices.iter().for_each(|&v| of[v as usize] = color);
        }
        assert!(of.iter().all(|&color| color != usize::MAX));
        for t in &disk.triangles {
            let [a, b, c] = t.map(|v| of[v as usize]);
            assert!(a != b && b != c && c != a);
        }
    }
}
