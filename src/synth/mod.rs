//! Procedural man-made objects with known parts: samples, tests and, later, training. An object is
//! drawn from a seed; its resolution is then chosen so that it has about the wanted number of
//! triangles. Units are metres, y points up, surfaces are closed and wound outwards.

mod airplane;
mod appliance;
mod bearing;
mod bed;
pub mod body;
mod bottle;
mod bucket;
mod chair;
mod embellish;
mod faucet;
mod fuse;
mod glasses;
mod glb;
mod knife;
mod lamp;
mod laptop;
mod mug;
mod outline;
mod profile;
pub mod samples;
mod scissors;
mod shading;
mod skateboard;
mod solid;
mod storage;
mod suitcase;
mod table;
mod toaster;
mod vase;

use clap::ValueEnum;
use glam::DVec3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

pub use body::{Body, BodyKind, BodyStyle, NoiseKind};
pub use embellish::embellished;
pub use fuse::FusedBody;
use solid::{Detail, Solid};

/// What can be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, ValueEnum)]
pub enum SynthKind {
    /// Turned legs, stretchers, a shell seat; a back of spindles, slats or one shell.
    Chair,
    /// A bevelled top on an apron; legs tapered or turned.
    Table,
    /// Blade, bolster, handle and rivets.
    Knife,
    /// Base and screen frames, screen, keyboard, touchpad, buttons, camera, shaft.
    Laptop,
    /// Deck, trucks, wheels and bolts.
    Skateboard,
    /// Foot, pole, shade.
    Lamp,
    /// A cup, mug or goblet: body, handles, foot.
    Mug,
    /// Body, neck, cap, sometimes a grip.
    Bottle,
    /// A turned body, foot, handles.
    Vase,
    /// Scissors or pliers: blades or jaws, shanks, handles, screw.
    Scissors,
    /// A cabinet or shelf: boards, drawers or doors, handles, legs.
    Storage,
    /// Frame, mattress, pillows, boards, legs.
    Bed,
    /// Base, spout, stems, handles.
    Faucet,
    /// Rims, lenses, bridge, hinges, temples.
    Glasses,
    /// Fuselage, wings, tail, engines.
    Airplane,
    /// Body, rim, ears, bail.
    Bucket,
    /// A machine part: hub, flanges, bolts, shaft, base.
    Bearing,
    /// A small appliance: body, slots or door, knobs, feet.
    Toaster,
    /// Base, lid, handle, latches, wheels.
    Suitcase,
    /// A safe, oven or washing machine: body, door, window, handles, knobs, hinges, feet.
    Appliance,
}

impl SynthKind {
    /// Every kind.
    pub const ALL: [SynthKind; 20] = [
        Self::Chair,
        Self::Table,
        Self::Knife,
        Self::Laptop,
        Self::Skateboard,
        Self::Lamp,
        Self::Mug,
        Self::Bottle,
        Self::Vase,
        Self::Scissors,
        Self::Storage,
        Self::Bed,
        Self::Faucet,
        Self::Glasses,
        Self::Airplane,
        Self::Bucket,
        Self::Bearing,
        Self::Toaster,
        Self::Suitcase,
        Self::Appliance,
    ];

    /// Its name in lower case.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Chair => "chair",
            Self::Table => "table",
            Self::Knife => "knife",
            Self::Laptop => "laptop",
            Self::Skateboard => "skateboard",
            Self::Lamp => "lamp",
            Self::Mug => "mug",
            Self::Bottle => "bottle",
            Self::Vase => "vase",
            Self::Scissors => "scissors",
            Self::Storage => "storage",
            Self::Bed => "bed",
            Self::Faucet => "faucet",
            Self::Glasses => "glasses",
            Self::Airplane => "airplane",
            Self::Bucket => "bucket",
            Self::Bearing => "bearing",
            Self::Toaster => "toaster",
            Self::Suitcase => "suitcase",
            Self::Appliance => "appliance",
        }
    }
}

/// How the parts stand in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum SynthVariant {
    /// A node and a mesh for each part, named.
    #[default]
    MultiNode,
    /// One mesh of one primitive; the vertex attribute `_PART` tells the parts.
    SingleMesh,
    /// One closed manifold body, the union of the parts; labels stand beside the file.
    Fused,
}

/// How an object is to be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SynthStyle {
    /// How the parts stand in the file.
    pub variant: SynthVariant,
    /// About how many triangles. A fused body has as many as its thin parts need.
    pub triangles: usize,
}

impl Default for SynthStyle {
    fn default() -> Self {
        Self { variant: SynthVariant::MultiNode, triangles: 1000 }
    }
}

/// One part: a closed solid, wound outwards.
#[derive(Debug, Clone, PartialEq)]
pub struct SynthPart {
    /// Name of the instance, such as `leg_1`.
    pub name: String,
    /// Vertex positions, metres.
    pub positions: Vec<DVec3>,
    /// Vertex triples.
    pub triangles: Vec<[u32; 3]>,
}

impl SynthPart {
    fn new(name: impl Into<String>, solid: Solid) -> Self {
        Self { name: name.into(), positions: solid.positions, triangles: solid.triangles }
    }

    /// Name of the kind of part: `leg` for `leg_1`.
    pub fn coarse_name(&self) -> &str {
        let stem = self.name.trim_end_matches(|c: char| c.is_ascii_digit());
        match stem.strip_suffix('_') {
            Some(coarse) if stem.len() < self.name.len() => coarse,
            _ => &self.name,
        }
    }
}

/// An object and its parts.
#[derive(Debug, Clone, PartialEq)]
pub struct SynthObject {
    /// What it is.
    pub kind: SynthKind,
    /// How the parts stand in the file.
    pub variant: SynthVariant,
    /// Its parts; label `i` is part `i`.
    pub parts: Vec<SynthPart>,
    /// The union of the parts, where the variant is [`SynthVariant::Fused`].
    pub fused: Option<FusedBody>,
}

impl SynthObject {
    /// Triangles of the file.
    pub fn triangle_count(&self) -> usize {
        match &self.fused {
            Some(body) => body.triangles.len(),
            None => self.parts.iter().map(|p| p.triangles.len()).sum(),
        }
    }

    /// The part of each face, in the file's face order.
    pub fn labels(&self) -> Vec<u32> {
        match &self.fused {
            Some(body) => body.labels.clone(),
            None => (0u32..)
                .zip(&self.parts)
                .flat_map(|(i, p)| std::iter::repeat_n(i, p.triangles.len()))
                .collect(),
        }
    }

    /// The labels as text, one a line.
    pub fn labels_text(&self) -> String {
        self.labels().iter().map(|l| format!("{l}\n")).collect()
    }

    /// The object as a GLB file.
    pub fn glb(&self) -> Vec<u8> {
        glb::write(self)
    }
}

/// Make an object. The same arguments always give the same object.
pub fn make(kind: SynthKind, seed: u64, style: SynthStyle) -> SynthObject {
    let variant = style.variant;
    if variant == SynthVariant::Fused {
        // The source is finer than the union, so that the union takes its shape from it.
        let parts = with_triangles(kind, seed, style.triangles.max(4000) * 2);
        let fused = Some(fuse::fuse(&parts, style.triangles));
        return SynthObject { kind, variant, parts, fused };
    }
    SynthObject { kind, variant, parts: with_triangles(kind, seed, style.triangles), fused: None }
}

/// The parts of an object as one closed body of about `triangles` triangles.
pub fn fused(object: SynthObject, triangles: usize) -> SynthObject {
    let body = fuse::fuse(&object.parts, triangles);
    SynthObject { variant: SynthVariant::Fused, fused: Some(body), ..object }
}

/// The parts at the resolution whose triangle count is nearest to the wanted one.
fn with_triangles(kind: SynthKind, seed: u64, wanted: usize) -> Vec<SynthPart> {
    let count = |parts: &[SynthPart]| parts.iter().map(|p| p.triangles.len()).sum::<usize>();
    let (mut low, mut high) = (0.05_f64, 60.0_f64);
    let mut best = parts(kind, seed, Detail(low));
    for _ in 0..24 {
        let middle = (low * high).sqrt();
        let made = parts(kind, seed, Detail(middle));
        let n = count(&made);
        if n > wanted {
            high = middle
        } else {
            low = middle
        }
        if n.abs_diff(wanted) < count(&best).abs_diff(wanted) {
            best = made;
        }
    }
    best
}

fn parts(kind: SynthKind, seed: u64, detail: Detail) -> Vec<SynthPart> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    match kind {
        SynthKind::Chair => chair::parts(&mut rng, detail),
        SynthKind::Table => table::parts(&mut rng, detail),
        SynthKind::Knife => knife::parts(&mut rng, detail),
        SynthKind::Laptop => laptop::parts(&mut rng, detail),
        SynthKind::Skateboard => skateboard::parts(&mut rng, detail),
        SynthKind::Lamp => lamp::parts(&mut rng, detail),
        SynthKind::Mug => mug::parts(&mut rng, detail),
        SynthKind::Bottle => bottle::parts(&mut rng, detail),
        SynthKind::Vase => vase::parts(&mut rng, detail),
        SynthKind::Scissors => scissors::parts(&mut rng, detail),
        SynthKind::Storage => storage::parts(&mut rng, detail),
        SynthKind::Bed => bed::parts(&mut rng, detail),
        SynthKind::Faucet => faucet::parts(&mut rng, detail),
        SynthKind::Glasses => glasses::parts(&mut rng, detail),
        SynthKind::Airplane => airplane::parts(&mut rng, detail),
        SynthKind::Bucket => bucket::parts(&mut rng, detail),
        SynthKind::Bearing => bearing::parts(&mut rng, detail),
        SynthKind::Toaster => toaster::parts(&mut rng, detail),
        SynthKind::Suitcase => suitcase::parts(&mut rng, detail),
        SynthKind::Appliance => appliance::parts(&mut rng, detail),
    }
}

#[cfg(test)]
mod tests;
