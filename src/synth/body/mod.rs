//! Bodies of any size, smooth or rough, without parts. Scanned ones, as scans and sculptures are: closed
//! manifolds of one piece, a signed distance each (`field`, `shapes`), meshed by marching cubes
//! (`marching_cubes`) at the spacing that gives the wanted number of triangles. Modelled ones, as people
//! make them, are loops of quads (`modelled`). Both are then roughened (`noise`). The same bytes on any number
//! of threads.

mod field;
mod marching_cubes;
mod modelled;
mod noise;
mod shapes;

use clap::ValueEnum;
use glam::DVec3;

use super::glb;
use field::{Field, Group};
use marching_cubes::{Grid, Table};
use modelled::Maker;
pub use noise::NoiseKind;

/// What body can be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, ValueEnum)]
pub enum BodyKind {
    /// A wrist, a palm, five fingers with joints.
    Hand,
    /// Body, four legs, neck, head, ears, tail.
    Animal,
    /// An open vessel with a wall.
    Vase,
    /// A tube along a trefoil: one handle.
    Knot,
    /// Three rings grown together: three handles.
    Genus3,
    /// Seat, legs, stretchers and back of a chair as one solid: four handles.
    #[value(name = "fused_chair")]
    FusedChair,
    /// A vessel with a handle: one handle.
    Mug,
    /// Six turns of a wire with flat ends.
    Spring,
    /// A tube along a winding curve, open at both ends.
    Hose,
    /// A closed tube round a circle.
    Rim,
    /// A wavy strip: an open sheet.
    Cloth,
    /// Hills over a square: an open sheet.
    Terrain,
    /// A shaft with a thread and a hexagonal head.
    Bolt,
    /// A spur wheel with a bore.
    Gear,
    /// Rim, hub and spokes that touch: eighteen pieces.
    Wheel,
    /// A person of capsules that run into each other: fifteen pieces.
    Figure,
    /// The frame of a picture, a moulding with mitred corners.
    Frame,
}

impl BodyKind {
    /// What is scanned: closed manifolds of one piece, of even triangles.
    pub const SCANNED: [BodyKind; 7] = [
        Self::Hand,
        Self::Animal,
        Self::Vase,
        Self::Knot,
        Self::Genus3,
        Self::FusedChair,
        Self::Mug,
    ];

    /// What is modelled: loops of quads.
    pub const MODELLED: [BodyKind; 10] = [
        Self::Spring,
        Self::Hose,
        Self::Rim,
        Self::Cloth,
        Self::Terrain,
        Self::Bolt,
        Self::Gear,
        Self::Wheel,
        Self::Figure,
        Self::Frame,
    ];

    /// Every kind.
    pub fn all() -> impl Iterator<Item = BodyKind> {
        Self::SCANNED.into_iter().chain(Self::MODELLED)
    }

    /// Its name in lower case.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Hand => "hand",
            Self::Animal => "animal",
            Self::Vase => "vase",
            Self::Knot => "knot",
            Self::Genus3 => "genus3",
            Self::FusedChair => "fused_chair",
            Self::Mug => "mug",
            Self::Spring => "spring",
            Self::Hose => "hose",
            Self::Rim => "rim",
            Self::Cloth => "cloth",
            Self::Terrain => "terrain",
            Self::Bolt => "bolt",
            Self::Gear => "gear",
            Self::Wheel => "wheel",
            Self::Figure => "figure",
            Self::Frame => "frame",
        }
    }

    /// Fewest triangles of one body: with fewer, limbs break off and walls are pierced (measured), and
    /// sections lose their shape.
    pub fn fewest(self) -> usize {
        match self {
            Self::Hand => 1500,
            Self::Animal => 4000,
            Self::Vase => 3000,
            Self::Genus3 => 500,
            Self::FusedChair => 2000,
            Self::Mug => 4000,
            Self::Bolt | Self::Gear | Self::Wheel | Self::Figure => 4000,
            _ => 1000,
        }
    }
}

/// How a body is to be made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyStyle {
    /// Most triangles of the mesh; a scanned one has at most 3 % fewer, a modelled one a fifth.
    pub triangles: usize,
    /// Standard deviation of the noise, in mean edge lengths.
    pub noise: f64,
    /// Which way it moves a vertex.
    pub noise_kind: NoiseKind,
    /// Of the noise: the body itself is always the same.
    pub seed: u64,
    /// How many of the body stand side by side, noise and all; they share the triangles evenly.
    pub copies: usize,
}

impl Default for BodyStyle {
    fn default() -> Self {
        Self { triangles: 20_000, noise: 0.0, noise_kind: NoiseKind::Normal, seed: 1, copies: 1 }
    }
}

/// A manifold mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Vertex positions, metres.
    pub positions: Vec<DVec3>,
    /// Vertex triples, wound outwards.
    pub triangles: Vec<[u32; 3]>,
}

impl Body {
    /// Of its bounding box.
    fn size(&self) -> DVec3 {
        let low = self.positions.iter().fold(DVec3::INFINITY, |low, p| low.min(*p));
        self.positions.iter().fold(DVec3::NEG_INFINITY, |high, p| high.max(*p)) - low
    }

    /// The body as a GLB file: one primitive with smooth normals.
    pub fn glb(&self, name: &str) -> Vec<u8> {
        let normals = noise::normals(&self.positions, &self.triangles);
        glb::write_body(name, &self.positions, normals, &self.triangles)
    }
}

/// What a body is made from.
enum Form {
    /// The shapes of its field.
    Scanned(Vec<Group>),
    /// Its loops of quads.
    Modelled(Maker),
}

fn form(kind: BodyKind) -> Form {
    match kind {
        BodyKind::Hand => Form::Scanned(shapes::hand()),
        BodyKind::Animal => Form::Scanned(shapes::animal()),
        BodyKind::Vase => Form::Scanned(shapes::vase()),
        BodyKind::Knot => Form::Scanned(shapes::knot()),
        BodyKind::Genus3 => Form::Scanned(shapes::genus3()),
        BodyKind::FusedChair => Form::Scanned(shapes::chair()),
        BodyKind::Mug => Form::Scanned(shapes::mug()),
        BodyKind::Spring => Form::Modelled(modelled::spring),
        BodyKind::Hose => Form::Modelled(modelled::hose),
        BodyKind::Rim => Form::Modelled(modelled::rim),
        BodyKind::Cloth => Form::Modelled(modelled::cloth),
        BodyKind::Terrain => Form::Modelled(modelled::terrain),
        BodyKind::Bolt => Form::Modelled(modelled::bolt),
        BodyKind::Gear => Form::Modelled(modelled::gear),
        BodyKind::Wheel => Form::Modelled(modelled::wheel),
        BodyKind::Figure => Form::Modelled(modelled::figure),
        BodyKind::Frame => Form::Modelled(modelled::frame),
    }
}

/// Make a body. The same arguments always give the same one.
pub fn make(kind: BodyKind, style: BodyStyle) -> Body {
    let copies = style.copies.max(1);
    let wanted = style.triangles / copies;
    let mut one = match form(kind) {
        Form::Scanned(groups) => {
            let (positions, triangles) = with_triangles(&Field::new(groups), wanted);
            Body { positions, triangles }
        }
        Form::Modelled(make) => modelled::with_triangles(make, wanted),
    };
    let size = one.size();
    noise::add(&mut one.positions, &one.triangles, style.noise_kind, style.noise, style.seed);
    if copies == 1 { one } else { side_by_side(&one, copies, size) }
}

/// Most spacings tried for the exact number.
const PASSES: usize = 40;

/// The surface at the widest spacing found that gives nearly, and never more than, the wanted number.
fn with_triangles(field: &Field, wanted: usize) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let table = Table::new();
    let aim = 0.987 * wanted as f64;
    let enough = (0.97 * wanted as f64).ceil() as usize..=wanted;
    let count = |spacing: f64| Grid::new(field, &table, spacing).count();
    // The number goes with the inverse square of the spacing; a coarse grid tells the factor cheaply.
    let scaled = |spacing: f64, n: usize, aim: f64| spacing * (n.max(8) as f64 / aim).sqrt();
    let mut spacing = field.low.distance(field.high) / 40.0;
    for rough in [5e3, 5e4] {
        if 4.0 * rough < aim {
            spacing = scaled(spacing, count(spacing), rough);
        }
    }
    spacing = scaled(spacing, count(spacing), aim);
    // Spacings known to give too many and not too many.
    let (mut many, mut few): (f64, f64) = (0.0, f64::INFINITY);
    let mut pass = 0;
    loop {
        let grid = Grid::new(field, &table, spacing);
        let n = grid.count();
        pass += 1;
        // The number is not quite monotone in the spacing: a small one may be missed.
        if enough.contains(&n) || pass > PASSES && n <= wanted {
            return grid.surface();
        }
        if pass > PASSES {
            spacing *= 1.002;
            continue;
        }
        if n > wanted {
            many = many.max(spacing);
        } else {
            few = few.min(spacing);
        }
        let secant = scaled(spacing, n, aim);
        let bracketed = many < secant && secant < few;
        spacing = if bracketed { secant } else { 0.5 * (many + few.min(2.0 * secant)) };
    }
}

/// Copies on a square grid, with room between.
fn side_by_side(body: &Body, copies: usize, size: DVec3) -> Body {
    let columns = (copies as f64).sqrt().ceil() as usize;
    let mut all = Body { positions: vec![], triangles: vec![] };
    for i in 0..copies {
        let place = DVec3::new((i % columns) as f64, 0.0, (i / columns) as f64);
        let base = all.positions.len() as u32;
        all.positions.extend(body.positions.iter().map(|p| p + 1.25 * size * place));
        all.triangles.extend(body.triangles.iter().map(|t| t.map(|v| v + base)));
    }
    all
}

#[cfg(test)]
mod tests;
