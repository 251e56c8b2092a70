//! A proxy's chart that could not be carried over, divided in two where that failed. Both have a share of its
//! map, which is as good as it was.

use std::collections::{BTreeMap, VecDeque};

use crate::charts::{Chart, ChartShape};
use crate::flatten::Disk;
use crate::mesh::NONE;

/// Faces of trouble that are fewer steps apart do not tell where to divide.
const APART: u32 = 3;

/// The two charts, each connected; the chart itself where it has one face. `trouble`: faces of the surface.
pub fn divide(chart: &Chart, trouble: &[u32]) -> Vec<Chart> {
    let neighbours = neighbours(&chart.disk);
    let steps = |from: &[usize]| steps(&neighbours, from);
    let farthest = |steps: &[(u32, usize)], of: &mut dyn Iterator<Item = usize>| {
        of.filter(|&f| steps[f].0 != NONE).max_by_key(|&f| (steps[f].0, std::cmp::Reverse(f)))
    };
    let mut at = trouble.iter().filter_map(|f| chart.faces.binary_search(f).ok());
    let first = at.next().unwrap_or(0);
    let from_first = steps(&[first]);
    // The two ends of the trouble, so that each gets its own; else those of the chart.
    let second = farthest(&from_first, &mut at).filter(|&f| from_first[f].0 >= APART);
    let all = || 0..chart.faces.len();
    let ends = second.map(|second| [first, second]).or_else(|| {
        let one = farthest(&from_first, &mut all())?;
        let other = farthest(&steps(&[one]), &mut all())?;
        Some([one, other])
    });
    let Some(ends) = ends.filter(|[a, b]| a != b) else { return vec![chart.clone()] };
    let nearest = steps(&ends);
    let half = |end: usize| share(chart, |f| nearest[f].1 == end);
    vec![half(ends[0]), half(ends[1])]
}

/// Faces across the three edges of each face, [`NONE`] at the border.
fn neighbours(disk: &Disk) -> Vec<[u32; 3]> {
    let mut beside: BTreeMap<(u32, u32), (u32, usize)> = BTreeMap::new();
    let mut neighbours = vec![[NONE; 3]; disk.triangles.len()];
    for (f, t) in disk.triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            if let Some(&(g, j)) = beside.get(&(b, a)) {
                neighbours[f][k] = g;
                neighbours[g as usize][j] = f as u32;
            }
            beside.insert((a, b), (f as u32, k));
        }
    }
    neighbours
}

/// Steps over edges from the nearest of some faces, [`NONE`] where there is no way, and which that is.
fn steps(neighbours: &[[u32; 3]], from: &[usize]) -> Vec<(u32, usize)> {
    let mut steps = vec![(NONE, from[0]); neighbours.len()];
    let mut queue: VecDeque<usize> = from.iter().copied().collect();
    from.iter().for_each(|&f| steps[f] = (0, f));
    while let Some(f) = queue.pop_front() {
        let (step, end) = steps[f];
        for g in neighbours[f].into_iter().filter(|&g| g != NONE).map(|g| g as usize) {
            if steps[g].0 == NONE {
                steps[g] = (step + 1, end);
                queue.push_back(g);
            }
        }
    }
    steps
}

/// Some faces of a chart as a chart.
fn share(chart: &Chart, of: impl Fn(usize) -> bool) -> Chart {
    let own: Vec<usize> = (0..chart.faces.len()).filter(|&f| of(f)).collect();
    let mut number = vec![NONE; chart.vertices.len()];
    let mut kept: Vec<usize> = Vec::new();
    let mut place = |v: u32| {
        if number[v as usize] == NONE {
            number[v as usize] = kept.len() as u32;
            kept.push(v as usize);
        }
        number[v as usize]
    };
    let triangles: Vec<[u32; 3]> =
        own.iter().map(|&f| chart.disk.triangles[f].map(&mut place)).collect();
    Chart {
        faces: own.iter().map(|&f| chart.faces[f]).collect(),
        vertices: kept.iter().map(|&v| chart.vertices[v]).collect(),
        disk: Disk::new(kept.iter().map(|&v| chart.disk.positions[v]).collect(), triangles),
        start: kept.iter().map(|&v| chart.start[v]).collect(),
        cut_map: kept.iter().map(|&v| chart.cut_map[v]).collect(),
        shape: ChartShape::General,
        ..chart.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::{count_flips, samples};

    fn sheet() -> Chart {
        let (disk, flat) = samples::plane(8, 2, 4.0, 1.0);
        Chart {
            faces: (0..disk.triangles.len() as u32).map(|f| 3 * f).collect(),
            vertices: (0..flat.len() as u32).collect(),
            start: flat.clone(),
            cut_map: flat,
            disk,
            ..Chart::default()
        }
    }

    #[test]
    fn halves_share_the_faces_and_the_map() {
        let chart = sheet();
        let halves = divide(&chart, &[]);
        let mut faces: Vec<u32> = halves.iter().flat_map(|half| half.faces.clone()).collect();
        faces.sort_unstable();
        assert_eq!(faces, chart.faces);
        for half in &halves {
            assert!(half.faces.len() >= 12, "{} faces", half.faces.len());
            assert!(crate::flatten::is_disk(&half.disk));
            assert_eq!(count_flips(&half.disk, &half.cut_map), 0);
            let moved = half.vertices.iter().zip(&half.cut_map);
            assert!(moved.into_iter().all(|(&v, p)| *p == chart.cut_map[v as usize]));
        }
    }

    #[test]
    fn the_ends_of_the_trouble_are_parted() {
        let chart = sheet();
        // Near one end of the sheet, four steps and more from each other.
        let trouble = [chart.faces[0], chart.faces[6]];
        let halves = divide(&chart, &trouble);
        let of = |face: u32| halves.iter().position(|half| half.faces.contains(&face));
        assert_ne!(of(trouble[0]), of(trouble[1]));
        assert!(halves.iter().any(|half| half.faces.len() < 12));
    }

    #[test]
    fn one_face_stays() {
        let chart = share(&sheet(), |f| f == 3);
        assert_eq!(divide(&chart, &[]), [chart]);
    }
}
