//! What a result has of caps, the faces that close T-junctions and that no file has (docs/method.md, 1).

use std::collections::HashMap;

use super::maps::Mapped;
use crate::mesh::{DisjointSets, Surface};

/// The charts that have a face of the file.
pub fn of_the_file(surface: &Surface, mut charts: Vec<Mapped>) -> Vec<Mapped> {
    charts.retain(|m| m.chart.faces.iter().any(|&f| !surface.is_cap(f)));
    charts
}

/// How many charts there are where only a common edge of the file's own faces joins them: a chart counts once for
/// each of its pieces that hang together by T-junctions alone.
pub fn edge_charts(surface: &Surface, charts: &[Mapped]) -> usize {
    charts.iter().map(|m| pieces(surface, m)).sum()
}

fn pieces(surface: &Surface, m: &Mapped) -> usize {
    let faces = &m.chart.faces;
    let own: Vec<bool> = faces.iter().map(|&f| !surface.is_cap(f)).collect();
    if own.iter().all(|own| *own) {
        return 1;
    }
    let mut sets = DisjointSets::new(faces.len());
    let mut edges: HashMap<(u32, u32), u32> = HashMap::new();
    let mut count = 0;
    for (i, t) in (0u32..).zip(&m.chart.disk.triangles).filter(|(i, _)| own[*i as usize]) {
        count += 1;
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            if let Some(j) = edges.insert((a.min(b), a.max(b)), i) {
                count -= usize::from(sets.join(i, j));
            }
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::Run;
    use crate::pipeline::scenes;

    /// A quad beside two, one above the other, whose common corner lies on its edge.
    const BESIDE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 .5 0\nv 2 0 0\nv 2 .5 0\nv 2 1 0\n\
                          f 1 2 3 4\nf 2 6 7 5\nf 5 7 8 3\n";

    #[test]
    fn what_only_a_junction_joins_is_one_chart_and_two_by_edges() {
        let (found, _, atlas) = scenes::atlas(BESIDE, &scenes::options(), &Run::quiet());
        assert_eq!((atlas.charts.len(), found.surface.face_count()), (1, 7));
        assert_eq!(edge_charts(&found.surface, &atlas.charts), 2);
        assert!(atlas.certificates.atlas.valid);
    }

    #[test]
    fn a_chart_of_caps_alone_is_none_of_the_file() {
        let (found, _, atlas) = scenes::atlas(BESIDE, &scenes::options(), &Run::quiet());
        let surface = &found.surface;
        let mut alone = atlas.charts[0].clone();
        alone.chart.faces.retain(|&f| surface.is_cap(f));
        assert_eq!(alone.chart.faces.len(), 1);
        assert_eq!(of_the_file(surface, vec![alone, atlas.charts[0].clone()]).len(), 1);
    }
}
