//! What the cores benchmark unwraps: bodies, made-up objects side by side, or files.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use glam::DVec3;

use super::{Args, SIZES};
use crate::synth::body::{self, BodyStyle};
use crate::synth::{self, BodyKind, SynthKind, SynthObject, SynthPart, SynthStyle};

/// Triangles of each of the objects that stand side by side, about.
const EACH: usize = 5_000;

/// An object.
pub enum Object {
    File(PathBuf),
    Body(BodyKind, u32),
    /// So many parts.
    Parts(usize),
}

impl Object {
    /// What is asked for.
    pub fn all(args: &Args) -> Vec<Self> {
        if !args.meshes.is_empty() {
            return args.meshes.iter().cloned().map(Self::File).collect();
        }
        let sizes = if args.triangles.is_empty() { &SIZES[..] } else { &args.triangles };
        let parts = (args.parts > 0).then_some(Self::Parts(args.parts));
        sizes.iter().map(|&n| Self::Body(args.body, n)).chain(parts).collect()
    }

    pub fn name(&self) -> String {
        match self {
            Self::File(path) => super::super::files::stem(path),
            Self::Body(kind, triangles) => format!("{} {triangles}", kind.as_str()),
            Self::Parts(parts) => format!("{parts} parts"),
        }
    }

    /// The mesh as a file: its own, or one in `folder`.
    pub fn write(&self, folder: &Path) -> Result<PathBuf> {
        let bytes = match self {
            Self::File(path) => return Ok(path.clone()),
            Self::Body(kind, triangles) => {
                let triangles = *triangles as usize;
                let style = BodyStyle { triangles, copies: 1, seed: 1, ..BodyStyle::default() };
                body::make(*kind, style).glb(kind.as_str())
            }
            Self::Parts(parts) => assembly(*parts).glb(),
        };
        let path = folder.join("mesh.glb");
        std::fs::write(&path, bytes).with_context(|| format!("cannot write {}", path.display()))?;
        Ok(path)
    }
}

/// Objects of every kind in a row, until they have so many parts together.
fn assembly(count: usize) -> SynthObject {
    let style = SynthStyle { triangles: EACH, ..SynthStyle::default() };
    let mut parts: Vec<SynthPart> = Vec::new();
    let mut end = 0.0;
    for (seed, kind) in (1..).zip(SynthKind::ALL.iter().cycle()) {
        let made = synth::make(*kind, seed, style).parts;
        let across = |p: &SynthPart| p.positions.iter().map(|p| p.x).collect::<Vec<_>>();
        let xs: Vec<f64> = made.iter().flat_map(across).collect();
        let low = xs.iter().copied().fold(f64::INFINITY, f64::min);
        let high = xs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let shift = DVec3::X * (end - low);
        end += 1.1 * (high - low);
        for (i, mut part) in made.into_iter().enumerate() {
            if parts.len() == count {
                let kind = SynthKind::Chair;
                return SynthObject { kind, variant: style.variant, parts, fused: None };
            }
            part.positions.iter_mut().for_each(|p| *p += shift);
            part.name = format!("{}_{seed}_{i}_{}", kind.as_str(), part.name);
            parts.push(part);
        }
    }
    unreachable!("there are kinds without end")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_assembly_has_as_many_parts_as_asked_and_none_lies_in_another_object() {
        let made = assembly(40);
        assert_eq!(made.parts.len(), 40);
        let names: std::collections::BTreeSet<_> = made.parts.iter().map(|p| &p.name).collect();
        assert_eq!(names.len(), 40);
        let ends = |object: &str| {
            let of = made.parts.iter().filter(|p| p.name.starts_with(object));
            let xs = of.flat_map(|p| p.positions.iter().map(|p| p.x));
            xs.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)])
        };
        assert!(ends("chair_1_")[1] < ends("table_2_")[0]);
    }
}
