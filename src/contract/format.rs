//! Every mesh format, in one table: its word, its name, its file endings, its media types, what it can
//! carry, and how its first bytes are told; never a file's name decides. What reads and writes the formats
//! stands in `mesh::formats`. A format more is a row here and a folder there.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// What a format can carry besides triangles, as far as it is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Carry {
    /// A tree of nodes with transforms.
    Hierarchy,
    /// Names of objects, groups or nodes.
    Names,
    /// Materials.
    Materials,
    /// Faces of more than three corners.
    Polygons,
    /// Normals.
    Normals,
    /// Colours of vertices.
    Colors,
    /// One set of texture coordinates.
    Texcoords,
    /// Any number of sets of texture coordinates.
    TexcoordSets,
    /// A part a face, in the vertex attribute `_PART`.
    Parts,
}

impl Carry {
    /// In words.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Hierarchy => "node hierarchy",
            Self::Names => "names",
            Self::Materials => "materials",
            Self::Polygons => "polygons",
            Self::Normals => "normals",
            Self::Colors => "vertex colours",
            Self::Texcoords => "one UV set",
            Self::TexcoordSets => "several UV sets",
            Self::Parts => "parts (`_PART`)",
        }
    }
}

macro_rules! formats {
    ($(
        $variant:ident $doc:literal $name:literal $(note $note:literal)?
        endings [$($ending:literal),+]
        types [$($media_type:literal),+]
        told by $told:path,
        written $written:literal,
        carries [$($carry:ident),*];
    )*) => {
        /// The formats that can be read.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum MeshKind {
            $(#[doc = $doc] $variant,)*
        }

        impl MeshKind {
            /// Every format, in the table's order, in which first bytes are told too.
            pub const ALL: &'static [MeshKind] = &[$(MeshKind::$variant),*];

            /// What people call it.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// Which files of the format can be read, behind its name: "with data URIs", or empty.
            pub fn note(self) -> &'static str {
                match self { $(Self::$variant => concat!($($note)?),)* }
            }

            /// How the names of its files end, in lower case, without the dot.
            pub fn endings(self) -> &'static [&'static str] {
                match self { $(Self::$variant => &[$($ending),+],)* }
            }

            /// The media types that mean it; the first is its own.
            pub fn media_types(self) -> &'static [&'static str] {
                match self { $(Self::$variant => &[$($media_type),+],)* }
            }

            /// Whether results can be written in it.
            pub fn is_written(self) -> bool {
                match self { $(Self::$variant => $written,)* }
            }

            /// What it can carry besides triangles, as far as it is read.
            pub fn carries(self) -> &'static [Carry] {
                match self { $(Self::$variant => &[$(Carry::$carry),*],)* }
            }

            /// Whether a file that starts with these bytes is of this format.
            fn is_told_by(self, head: &[u8]) -> bool {
                match self { $(Self::$variant => $told(head),)* }
            }
        }
    };
}

formats! {
    Glb "Binary glTF 2.0." "GLB"
        endings ["glb"] types ["model/gltf-binary"] told by is_glb, written true,
        carries [Hierarchy, Names, Materials, Normals, Colors, TexcoordSets, Parts];
    Gltf "glTF 2.0 as JSON; its buffers are data URIs." "glTF" note "with data URIs"
        endings ["gltf"] types ["model/gltf+json"] told by is_json, written false,
        carries [Hierarchy, Names, Materials, Normals, Colors, TexcoordSets, Parts];
    Obj "Wavefront OBJ." "OBJ"
        endings ["obj"] types ["model/obj"] told by is_obj, written false,
        carries [Names, Materials, Polygons, Normals, Colors, Texcoords];
}

fn is_glb(head: &[u8]) -> bool {
    head.starts_with(b"glTF")
}

/// The only JSON that is a mesh is glTF.
fn is_json(head: &[u8]) -> bool {
    let text = head.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(head);
    text.iter().find(|b| !b.is_ascii_whitespace()) == Some(&b'{')
}

/// An OBJ file is lines that start with one of a few words; the first that is no comment decides.
fn is_obj(head: &[u8]) -> bool {
    const WORDS: [&[u8]; 14] = [
        b"v", b"vt", b"vn", b"vp", b"f", b"l", b"p", b"o", b"g", b"s", b"mtllib", b"usemtl",
        b"cstype", b"mg",
    ];
    if head.contains(&0) {
        return false;
    }
    let mut comment = false;
    for line in head.split(|&b| b == b'\n' || b == b'\r') {
        let line = line.trim_ascii();
        if line.is_empty() {
            continue;
        }
        if line[0] == b'#' {
            comment = true;
            continue;
        }
        let mut words = line.split(|b| b.is_ascii_whitespace());
        let word = words.next().unwrap_or_default();
        return WORDS.contains(&word) && words.next().is_some();
    }
    comment
}

impl MeshKind {
    /// How many leading bytes [`MeshKind::detect`] looks at.
    pub const PREFIX: usize = 4096;

    /// The format of a file that starts with these bytes, or `None` for one that is not known.
    pub fn detect(head: &[u8]) -> Option<Self> {
        let head = &head[..head.len().min(Self::PREFIX)];
        Self::ALL.iter().copied().find(|kind| kind.is_told_by(head))
    }

    /// The format that a media type means.
    pub fn of_media_type(media_type: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.media_types().contains(&media_type))
    }

    /// The format whose files' names end so, in any case, without the dot. Only for looking a folder
    /// through: what a file is, its bytes tell.
    pub fn of_ending(ending: &str) -> Option<Self> {
        let ending = ending.to_ascii_lowercase();
        Self::ALL.iter().copied().find(|kind| kind.endings().contains(&ending.as_str()))
    }

    /// Its own media type.
    pub fn media_type(self) -> &'static str {
        self.media_types()[0]
    }

    /// Every format in a sentence: "GLB, glTF or OBJ".
    pub fn names() -> String {
        listed(Self::ALL.iter().map(|kind| kind.name()), " or ")
    }

    /// Every format with which of its files can be read: "GLB, glTF with data URIs, or OBJ".
    pub fn inputs() -> String {
        let input = |kind: &Self| format!("{} {}", kind.name(), kind.note()).trim_end().to_owned();
        listed(Self::ALL.iter().map(input), ", or ")
    }

    /// Every media type: "model/gltf-binary, model/gltf+json, model/obj".
    pub fn all_media_types() -> String {
        listed(Self::ALL.iter().flat_map(|kind| kind.media_types()), ", ")
    }

    /// Every file ending in a sentence: ".glb, .gltf or .obj".
    pub fn all_endings() -> String {
        let endings = Self::ALL.iter().flat_map(|kind| kind.endings());
        listed(endings.map(|ending| format!(".{ending}")), " or ")
    }
}

/// A list in a sentence.
fn listed(items: impl Iterator<Item = impl AsRef<str>>, last: &str) -> String {
    let mut items = items.peekable();
    let mut text = String::new();
    while let Some(item) = items.next() {
        let between = if items.peek().is_some() { ", " } else { last };
        let between = if text.is_empty() { "" } else { between };
        text.push_str(between);
        text.push_str(item.as_ref());
    }
    text
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::MeshKind;

    #[test]
    fn bytes_decide() {
        assert_eq!(MeshKind::detect(b"glTF\x02\0\0\0"), Some(MeshKind::Glb));
        assert_eq!(MeshKind::detect(b" \n{\"asset\":{}}"), Some(MeshKind::Gltf));
        assert_eq!(MeshKind::detect(b"# made\nv 0 0 0\n"), Some(MeshKind::Obj));
        assert_eq!(MeshKind::detect(b"v 0 0 0\n"), Some(MeshKind::Obj));
        assert_eq!(MeshKind::detect(b"\x89PNG\r\n\x1a\n"), None);
        assert_eq!(MeshKind::detect(b"hello world"), None);
        assert_eq!(MeshKind::detect(b""), None);
    }

    #[test]
    fn nothing_in_the_table_means_two_formats() {
        let mut seen = BTreeSet::new();
        for kind in MeshKind::ALL {
            let own = kind.endings().iter().chain(kind.media_types());
            for text in own.copied().chain([kind.name()]) {
                assert!(seen.insert(text), "{text} stands twice in the table");
            }
            for ending in kind.endings() {
                assert_eq!(MeshKind::of_ending(&ending.to_uppercase()), Some(*kind));
            }
            for media_type in kind.media_types() {
                assert_eq!(MeshKind::of_media_type(media_type), Some(*kind));
                assert_eq!(media_type.to_lowercase(), **media_type);
            }
        }
        assert!(MeshKind::ALL.iter().any(|kind| kind.is_written()));
    }

    #[test]
    fn sentences_name_every_format() {
        let sentences = [MeshKind::names(), MeshKind::inputs()];
        for sentence in sentences {
            assert!(MeshKind::ALL.iter().all(|kind| sentence.contains(kind.name())), "{sentence}");
        }
        assert!(MeshKind::names().starts_with("GLB, glTF"));
        assert!(MeshKind::inputs().contains("glTF with data URIs, "));
        assert!(MeshKind::all_endings().starts_with(".glb, .gltf"));
        assert!(MeshKind::all_media_types().starts_with("model/gltf-binary, model/gltf+json"));
    }
}
