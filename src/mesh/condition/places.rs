//! One face a place: faces of the file on the same three vertices, of one material, one given label and one
//! solid, are instances of one face of the surface. Places stand in the order of their vertices, the least first.

use rayon::prelude::*;

use super::file::FileFaces;
use crate::contract::Winding;
use crate::tasks;

/// What faces at one place must have in common to be one: material, given label, and solid (0 where that is
/// not known yet).
pub type Class = (u32, i32, u32);

/// A face of the file at its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Instance {
    /// Its vertices in ascending order.
    pub vertices: [u32; 3],
    /// Material, given label, and solid.
    pub class: Class,
    /// Whether the file's winding runs through them in descending order; false where windings do not part
    /// places.
    parted: bool,
    /// Its number in the file.
    pub face: u32,
    /// Whether the file's winding runs through them in ascending order.
    pub ascending: bool,
}

/// The places of a file.
pub struct Places {
    instances: Vec<Instance>,
    starts: Vec<u32>,
}

impl Places {
    /// Sort the faces of which `usable` says that they have an area.
    pub fn of(file: &FileFaces, usable: &[bool], labels: Option<&[i32]>, winding: Winding) -> Self {
        let instance = |f: usize| {
            let t = file.welded[f];
            let least = (0..3).min_by_key(|&k| t[k]).unwrap_or(0);
            let [a, b, c] = [t[least], t[(least + 1) % 3], t[(least + 2) % 3]];
            Instance {
                vertices: [a, b.min(c), b.max(c)],
                class: (file.origins[f].material, labels.map_or(-1, |labels| labels[f]), 0),
                parted: winding == Winding::File && b > c,
                face: f as u32,
                ascending: b < c,
            }
        };
        let faces = (0..file.welded.len()).into_par_iter().filter(|&f| usable[f]);
        Self::sorted(faces.map(instance).collect())
    }

    fn sorted(mut instances: Vec<Instance>) -> Self {
        tasks::even("places", instances.len(), || instances.par_sort_unstable());
        let place = |i: &Instance| (i.vertices, i.class, i.parted);
        let mut starts = vec![0];
        for i in 1..=instances.len() {
            if i == instances.len() || place(&instances[i]) != place(&instances[i - 1]) {
                starts.push(i as u32);
            }
        }
        if instances.is_empty() {
            starts.truncate(1);
        }
        Self { instances, starts }
    }

    /// The same with the solid of each face of the file.
    pub fn by_solid(self, solid: &[u32]) -> Self {
        let is_one =
            |i: &[Instance]| i.iter().all(|j| solid[j.face as usize] == solid[i[0].face as usize]);
        let same = self.iter().all(is_one);
        let mut instances = self.instances;
        instances.iter_mut().for_each(|i| i.class.2 = solid[i.face as usize]);
        match same {
            true => Self { instances, starts: self.starts },
            false => Self::sorted(instances),
        }
    }

    /// How many places there are.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// The instances of a place, in the order of the file.
    pub fn instances(&self, place: usize) -> &[Instance] {
        &self.instances[self.starts[place] as usize..self.starts[place + 1] as usize]
    }

    /// The instances of each place.
    pub fn iter(&self) -> impl Iterator<Item = &[Instance]> {
        (0..self.len()).map(|place| self.instances(place))
    }
}
