//! Which parts lie in which charts. Charts end where parts do, but for specks and for borders that gave way to
//! `max_charts`.

use std::collections::BTreeMap;

use super::maps::Mapped;
use super::parts::Found;
use crate::mesh::NONE;

/// Parts and charts of a result.
pub struct Membership {
    /// Area that each chart has of each part, by chart and part.
    areas: BTreeMap<(u32, u32), f64>,
}

impl Membership {
    /// Of these charts.
    pub fn new(found: &Found, charts: &[Mapped]) -> Self {
        let (surface, parts) = (&found.surface, &found.parts.labels);
        let mut areas = BTreeMap::new();
        for (c, mapped) in (0u32..).zip(charts) {
            let faces = mapped.chart.faces.iter().map(|&f| f as usize);
            for f in faces.filter(|&f| parts[f] != NONE) {
                *areas.entry((c, parts[f])).or_default() += surface.areas[f];
            }
        }
        Self { areas }
    }

    /// The parts that a chart's faces are of, that of most area first.
    pub fn parts(&self, chart: u32) -> Vec<u32> {
        let own = self.areas.range((chart, 0)..=(chart, u32::MAX));
        let mut own: Vec<(u32, f64)> = own.map(|(&(_, part), &area)| (part, area)).collect();
        own.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        own.into_iter().map(|(part, _)| part).collect()
    }

    /// The charts that a part's faces lie in.
    pub fn charts(&self, part: u32) -> Vec<u32> {
        self.areas.keys().filter(|key| key.1 == part).map(|key| key.0).collect()
    }

    /// Chart, part, and the area that the one has of the other.
    pub fn areas(&self) -> impl Iterator<Item = (u32, u32, f64)> {
        self.areas.iter().map(|(&(chart, part), &area)| (chart, part, area))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::{Run, UnwrapOptions};
    use crate::pipeline::{maps, scenes};

    fn of(text: &str, options: &UnwrapOptions, labels: &[u32]) -> Membership {
        let (mut found, _, cut) = scenes::cut(text, options, &Run::quiet());
        found.parts.labels = labels.to_vec();
        Membership::new(&found, &maps::untrained(cut.charts))
    }

    #[test]
    fn a_chart_has_all_parts_of_its_faces_and_a_part_all_their_charts() {
        // Two squares, a chart each: half of the first is part 3, and a face of the second.
        let both = of(&scenes::squares(2), &scenes::options(), &[1, 3, 3, NONE]);
        assert_eq!((both.parts(0), both.parts(1)), (vec![1, 3], vec![3]));
        assert_eq!((both.charts(1), both.charts(3), both.charts(0)), (vec![0], vec![0, 1], vec![]));
        assert_eq!(both.areas().collect::<Vec<_>>(), [(0, 1, 0.5), (0, 3, 0.5), (1, 3, 0.5)]);
    }
}
