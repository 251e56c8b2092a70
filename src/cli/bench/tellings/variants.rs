//! The ways to tell an object: each a function of a mesh, and of a seed where it draws.

use std::collections::BTreeMap;

use clap::ValueEnum;
use glam::{DMat3, DVec3, EulerRot};

use super::mesh::PlainMesh;
use super::remade::{in_four, islands, noisy, places, slivers, split, t_junctions};
use crate::device::Seeded;
use crate::mesh::DisjointSets;

/// A way to tell an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum Variant {
    /// As it is.
    AsIs,
    /// Turned about three axes.
    Turned,
    /// Mirrored.
    Mirrored,
    /// A thousandth of its size.
    Small,
    /// A thousand times its size.
    Large,
    /// A hundred diagonals from the origin, in single precision.
    Far,
    /// Faces in another order.
    Shuffled,
    /// Vertices in another order.
    Permuted,
    /// Each face with vertices of its own.
    Soup,
    /// Half of the faces wound the other way.
    HalfWindings,
    /// All faces wound the other way.
    AllWindings,
    /// A tenth of the faces twice, with the same winding.
    Copies,
    /// A tenth of the faces twice, with the other winding.
    OtherCopies,
    /// Each face in four.
    Four,
    /// Vertices moved by 1e-4 of the diagonal, but no more than a twentieth of the edges around them.
    Noise,
    /// Vertices moved by 1e-4 of the diagonal, however short edges are.
    PlainNoise,
    /// Vertices split at hard edges, with normals.
    Split,
    /// One primitive for all.
    Merged,
    /// One primitive a connected component.
    Apart,
    /// A tenth of the inner edges divided on one side only.
    TJunctions,
    /// A face without area along a tenth of the edges.
    Slivers,
    /// Ten tiny triangles beside it.
    Islands,
}

impl Variant {
    /// Its name as an argument.
    pub fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

    /// Whether the division of the faces is to be the very same.
    pub fn is_exact(self) -> bool {
        use Variant::{
            AllWindings, AsIs, Copies, HalfWindings, OtherCopies, Permuted, Shuffled, Soup,
        };
        matches!(
            self,
            AsIs | Shuffled | Permuted | Soup | HalfWindings | AllWindings | Copies | OtherCopies
        )
    }

    /// Tell a mesh so.
    pub fn tell(self, mesh: &PlainMesh, seed: u64) -> PlainMesh {
        let mut random = Seeded::new(seed, 0);
        let moved = |by: &dyn Fn(DVec3) -> DVec3| PlainMesh {
            positions: mesh.positions.iter().map(|p| by(*p)).collect(),
            ..mesh.clone()
        };
        let wound = |turn: &mut dyn FnMut(u32) -> bool| {
            let way = |(f, &[a, b, c]): (u32, &[u32; 3])| {
                (f, if turn(f) { [a, c, b] } else { [a, b, c] })
            };
            mesh.with((0u32..).zip(&mesh.triangles).map(way).collect::<Vec<_>>().into_iter())
        };
        match self {
            Self::AsIs => mesh.clone(),
            Self::Turned => {
                let turn = DMat3::from_euler(EulerRot::XYZ, 0.7, 0.4, 1.1);
                moved(&|p| turn * p)
            }
            Self::Mirrored => {
                let mirrored = moved(&|p| DVec3::new(-p.x, p.y, p.z));
                Self::AllWindings.tell(&mirrored, seed)
            }
            Self::Small => moved(&|p| p * 1e-3),
            Self::Large => moved(&|p| p * 1e3),
            Self::Far => {
                let by = DVec3::new(1.0, -1.0, 0.5).normalize() * 100.0 * mesh.diagonal();
                moved(&|p| (p + by).as_vec3().as_dvec3())
            }
            Self::Shuffled => shuffled(mesh, &mut random),
            Self::Permuted => permuted(mesh, &mut random),
            Self::Soup => soup(mesh),
            Self::HalfWindings => wound(&mut |_| random.unit_f64() < 0.5),
            Self::AllWindings => wound(&mut |_| true),
            Self::Copies => twice(mesh, false, &mut random),
            Self::OtherCopies => twice(mesh, true, &mut random),
            Self::Four => in_four(mesh),
            Self::Noise => noisy(mesh, 0.05, &mut random),
            Self::PlainNoise => noisy(mesh, f64::INFINITY, &mut random),
            Self::Split => split(mesh),
            Self::Merged => PlainMesh { primitive: vec![0; mesh.triangles.len()], ..mesh.clone() },
            Self::Apart => apart(mesh),
            Self::TJunctions => t_junctions(mesh, &mut random),
            Self::Slivers => slivers(mesh, &mut random),
            Self::Islands => islands(mesh, &mut random),
        }
    }
}

/// The numbers below `count` in an order that is drawn.
fn drawn(count: usize, random: &mut Seeded) -> Vec<u32> {
    let mut order: Vec<u32> = (0..count as u32).collect();
    for i in (1..count).rev() {
        order.swap(i, (random.unit_f64() * (i + 1) as f64) as usize % (i + 1));
    }
    order
}

fn shuffled(mesh: &PlainMesh, random: &mut Seeded) -> PlainMesh {
    let order = drawn(mesh.triangles.len(), random);
    mesh.with(order.into_iter().map(|f| (f, mesh.triangles[f as usize])))
}

fn permuted(mesh: &PlainMesh, random: &mut Seeded) -> PlainMesh {
    let place = drawn(mesh.positions.len(), random);
    let mut positions = mesh.positions.clone();
    place.iter().zip(&mesh.positions).for_each(|(&to, p)| positions[to as usize] = *p);
    let triangles = mesh.triangles.iter().map(|t| t.map(|v| place[v as usize])).collect();
    PlainMesh { positions, triangles, ..mesh.clone() }
}

fn soup(mesh: &PlainMesh) -> PlainMesh {
    let corners = mesh.triangles.iter().flatten().map(|&v| mesh.positions[v as usize]);
    let faces = 0..mesh.triangles.len() as u32;
    PlainMesh {
        positions: corners.collect(),
        triangles: faces.map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect(),
        ..mesh.clone()
    }
}

fn twice(mesh: &PlainMesh, other: bool, random: &mut Seeded) -> PlainMesh {
    let first = (0u32..).zip(mesh.triangles.iter().copied());
    let again = first.clone().filter(|_| random.unit_f64() < 0.1);
    let again = again.map(|(f, [a, b, c])| (f, if other { [a, c, b] } else { [a, b, c] }));
    let again: Vec<_> = again.collect();
    mesh.with(first.chain(again))
}

fn apart(mesh: &PlainMesh) -> PlainMesh {
    let place = places(mesh);
    let mut sets = DisjointSets::new(mesh.positions.len());
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|v| place[v as usize]);
        sets.join(a, b);
        sets.join(b, c);
    }
    let mut number = BTreeMap::new();
    let component = mesh.triangles.iter().map(|t| {
        let next = number.len() as u32;
        *number.entry(sets.root(place[t[0] as usize])).or_insert(next)
    });
    let components = PlainMesh { primitive: component.collect(), ..mesh.clone() };
    components.with((0u32..).zip(components.triangles.iter().copied()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two unit cubes apart, in two primitives.
    fn cubes() -> PlainMesh {
        let mut mesh = PlainMesh::default();
        for (number, x) in [(0, 0.0), (1, 3.0)] {
            let base = mesh.positions.len() as u32;
            let corner =
                |i: u32| DVec3::new(x + f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
            mesh.positions.extend((0..8).map(corner));
            let quads = [
                [0, 4, 6, 2],
                [1, 3, 7, 5],
                [0, 1, 5, 4],
                [2, 6, 7, 3],
                [0, 2, 3, 1],
                [4, 5, 7, 6],
            ];
            let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
            mesh.triangles.extend(faces.map(|t| t.map(|v: u32| v + base)));
            mesh.primitive.resize(mesh.triangles.len(), number);
        }
        mesh.source = (0..24).map(Some).collect();
        mesh
    }

    fn volume(mesh: &PlainMesh) -> f64 {
        let six = |f| {
            let [a, b, c]: [DVec3; 3] = mesh.corners(f);
            a.dot(b.cross(c)) / 6.0
        };
        (0..mesh.triangles.len()).map(six).sum()
    }

    fn area(mesh: &PlainMesh) -> f64 {
        (0..mesh.triangles.len()).map(|f| mesh.area(f)).sum()
    }

    #[test]
    fn each_telling_is_of_the_same_object() {
        let mesh = cubes();
        for &variant in Variant::value_variants() {
            let told = variant.tell(&mesh, 1);
            assert_eq!(told, variant.tell(&mesh, 1), "{variant:?} is drawn from its seed");
            assert_eq!(told.primitive.len(), told.triangles.len());
            assert_eq!(told.source.len(), told.triangles.len());
            assert!(told.primitive.is_sorted());
            let scale = match variant {
                Variant::Small => 1e-3,
                Variant::Large => 1e3,
                _ => 1.0,
            };
            let more = match variant {
                Variant::Copies | Variant::OtherCopies => continue,
                Variant::Noise | Variant::PlainNoise | Variant::Far => 1e-2,
                Variant::Islands => 1e-6,
                Variant::Large => 1e-3,
                _ => 1e-9,
            };
            assert!((area(&told) - area(&mesh) * scale * scale).abs() < more, "{variant:?}");
        }
    }

    #[test]
    fn what_each_changes_is_changed() {
        let mesh = cubes();
        let of = |variant: Variant| variant.tell(&mesh, 1);
        let faces = |variant| of(variant).triangles.len();
        assert_eq!((faces(Variant::Four), faces(Variant::Soup)), (96, 24));
        assert_eq!(of(Variant::Soup).positions.len(), 72);
        assert!((24..36).contains(&faces(Variant::Copies)));
        assert!(faces(Variant::Slivers) > 24 && faces(Variant::TJunctions) > 24);
        assert_eq!(faces(Variant::Islands), 34);
        assert!(
            (volume(&of(Variant::Mirrored)) - volume(&mesh)).abs() < 1e-9,
            "wound outward still"
        );
        assert!((volume(&of(Variant::AllWindings)) + volume(&mesh)).abs() < 1e-9);
        assert!((volume(&of(Variant::HalfWindings)) - volume(&mesh)).abs() > 1e-3);
        let split = of(Variant::Split);
        assert_eq!(split.positions.len(), 48, "three a corner");
        assert!(split.normals.as_flattened().iter().all(|n| n.abs().max_element() > 0.999));
        assert_eq!(of(Variant::Merged).primitive, [0; 24]);
        assert_eq!(of(Variant::Apart).primitive, mesh.primitive);
        assert!(of(Variant::Far).positions[0].length() > 50.0 * mesh.diagonal());
        let shuffled = of(Variant::Shuffled);
        assert!(shuffled.source != mesh.source && shuffled.positions == mesh.positions);
        assert_ne!(of(Variant::Permuted).positions, mesh.positions);
    }

    #[test]
    fn a_file_has_what_is_told() {
        let text = Variant::Split.tell(&cubes(), 1).obj();
        let count = |what: &str| text.lines().filter(|line| line.starts_with(what)).count();
        assert_eq!((count("v "), count("vn "), count("f "), count("o ")), (48, 72, 24, 2));
        assert!(text.contains("//"));
    }
}
