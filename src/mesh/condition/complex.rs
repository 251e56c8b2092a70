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
        let mut faces = Faces::of(places, directed);
        let mut groups = groups.unwrap_or_else(|| EdgeGroups::new(&faces.triangles));
        let twice: Vec<bool> = places.iter().map(|i| i.len() > 1).collect();
        let walls = Walls::find(&groups, &twice);
        if !walls.faces.is_empty() {
            faces.add(&walls.faces);
            groups = EdgeGroups::new(&faces.triangles);
        }
        let Junctions { caps, closes: closed, raised } =
            Junctions::find(&faces.wings(&positions), &groups, diagonal);
        let mut closes = Vec::new();
        if !caps.is_empty() {
            closes = vec![NONE; faces.triangles.len()];
            closes.extend(&closed);
            // All that a cap has is its face's, but for its vertices.
            faces.add(&closed);
            faces.triangles.truncate(closes.len() - closed.len());
            faces.triangles.extend(caps.into_iter().map(|cap| least_first(cap, directed)));
            groups = EdgeGroups::new(&faces.triangles);
            raised.into_iter().for_each(|(v, p)| positions[v as usize] = p);
        }
        let twin = pair(&faces.wings(&positions), &groups, &walls);
        let Faces { triangles, places, .. } = faces;
        Self { positions, triangles, places, closes, walls, twin }
    }
}

/// What is known of each face before it is paired.
struct Faces {
    triangles: Vec<[u32; 3]>,
    class: Vec<Class>,
    places: Vec<u32>,
    /// Whether the file winds it through its vertices in ascending order.
    ascending: Vec<bool>,
    directed: bool,
}

impl Faces {
    /// One a place.
    fn of(places: &Places, directed: bool) -> Self {
        let triangle = |i: &Instance| match (i.vertices, i.ascending || !directed) {
            (abc, true) => abc,
            ([a, b, c], false) => [a, c, b],
        };
        Self {
            triangles: places.iter().map(|i| triangle(&i[0])).collect(),
            class: places.iter().map(|i| i[0].class).collect(),
            places: (0..places.len() as u32).collect(),
            ascending: places.iter().map(|i| directed || i[0].ascending).collect(),
            directed,
        }
    }

    /// Add the same as these once more.
    fn add(&mut self, faces: &[u32]) {
        for &f in faces {
            let f = f as usize;
            self.triangles.push(self.triangles[f]);
            self.class.push(self.class[f]);
            self.places.push(self.places[f]);
            self.ascending.push(self.ascending[f]);
        }
    }

    fn wings<'a>(&'a self, positions: &'a [DVec3]) -> Wings<'a> {
        Wings {
            positions,
            triangles: &self.triangles,
            class: &self.class,
            ascending: &self.ascending,
            directed: self.directed,
        }
    }
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
