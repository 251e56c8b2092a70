//! The faces that places become, and which of them go together: one a place, the second sides of walls, and the
//! caps of T-junctions, paired.

use glam::DVec3;

use super::junctions::Junctions;
use super::pairing::{EdgeGroups, Wings, pair};
use super::places::{Class, Instance, Places};
use super::walls::Walls;
use crate::mesh::NONE;

/// Faces and their twins.
pub struct Complex {
    /// Vertex positions, those of caps off the edges that they are on.
    pub positions: Vec<DVec3>,
    /// Vertex triples, the least vertex first; in ascending order unless windings count.
    pub triangles: Vec<[u32; 3]>,
    /// The place that each comes from.
    pub places: Vec<u32>,
    /// Of a cap, the face whose edge it closes, else [`NONE`]; empty where there is no cap.
    pub closes: Vec<u32>,
    /// Which of them are second sides.
    pub walls: Walls,
    /// Twin of each half-edge, or [`NONE`].
    pub twin: Vec<u32>,
}

impl Complex {
    /// The faces of places. `groups`: the edges of those, if they are known. `directed`: whether windings count.
    pub fn of(
        places: &Places,
        groups: Option<EdgeGroups>,
        mut positions: Vec<DVec3>,
        diagonal: f64,
        directed: bool,
    ) -> Self {
        let triangle = |i: &Instance| match (i.vertices, i.ascending || !directed) {
            (abc, true) => abc,
            ([a, b, c], false) => [a, c, b],
        };
        let mut triangles: Vec<[u32; 3]> = places.iter().map(|i| triangle(&i[0])).collect();
        let mut class: Vec<Class> = places.iter().map(|i| i[0].class).collect();
        let mut groups = groups.unwrap_or_else(|| EdgeGroups::new(&triangles));
        let twice: Vec<bool> = places.iter().map(|i| i.len() > 1).collect();
        let walls = Walls::find(&groups, &twice);
        if !walls.faces.is_empty() {
            add(&mut triangles, &walls.faces);
            add(&mut class, &walls.faces);
            groups = EdgeGroups::new(&triangles);
        }
        let mut place_of = walls.places(places.len());
        let ascending = |place: &u32| directed || places.instances(*place as usize)[0].ascending;
        let mut winds_up: Vec<bool> = place_of.iter().map(ascending).collect();
        let Junctions { caps, closes: closed, raised } = Junctions::find(
            &Wings {
                positions: &positions,
                triangles: &triangles,
                class: &class,
                ascending: &winds_up,
                directed,
            },
            &groups,
            diagonal,
        );
        let mut closes = Vec::new();
        if !caps.is_empty() {
            closes = vec![NONE; triangles.len()];
            closes.extend(&closed);
            triangles.extend(caps.into_iter().map(|cap| least_first(cap, directed)));
            add(&mut class, &closed);
            add(&mut place_of, &closed);
            add(&mut winds_up, &closed);
            groups = EdgeGroups::new(&triangles);
            raised.into_iter().for_each(|(v, p)| positions[v as usize] = p);
        }
        let twin = pair(
            &Wings {
                positions: &positions,
                triangles: &triangles,
                class: &class,
                ascending: &winds_up,
                directed,
            },
            &groups,
            &walls,
        );
        Self { positions, triangles, places: place_of, closes, walls, twin }
    }
}

/// Add what these have to a list.
fn add<T: Copy>(list: &mut Vec<T>, of: &[u32]) {
    list.extend(of.iter().map(|&f| list[f as usize]).collect::<Vec<_>>());
}

/// A triple with its least vertex first, and, unless windings count, in ascending order.
fn least_first(mut t: [u32; 3], directed: bool) -> [u32; 3] {
    let least = (0..3).min_by_key(|&k| t[k]).unwrap_or(0);
    t.rotate_left(least);
    if !directed {
        t.sort_unstable();
    }
    t
}
