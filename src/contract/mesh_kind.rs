//! Which kind of mesh a file is, told from its bytes and never from its name.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The formats that can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum MeshKind {
    /// Binary glTF 2.0.
    Glb,
    /// glTF 2.0 as JSON; its buffers are data URIs.
    Gltf,
    /// Wavefront OBJ.
    Obj,
}

impl MeshKind {
    /// How many leading bytes [`MeshKind::detect`] wants to see.
    pub const PREFIX: usize = 4096;

    /// The kind of mesh that starts with these bytes, or `None` for a format that is not known.
    pub fn detect(head: &[u8]) -> Option<Self> {
        if head.starts_with(b"glTF") {
            return Some(Self::Glb);
        }
        let text = head.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(head);
        let first = text.iter().position(|b| !b.is_ascii_whitespace())?;
        if text[first] == b'{' {
            return Some(Self::Gltf);
        }
        let head = &head[..head.len().min(Self::PREFIX)];
        if head.contains(&0) {
            return None;
        }
        // An OBJ file is lines that start with one of a few words; the first that is no comment
        // decides.
        const WORDS: [&[u8]; 14] = [
            b"v", b"vt", b"vn", b"vp", b"f", b"l", b"p", b"o", b"g", b"s", b"mtllib", b"usemtl",
            b"cstype", b"mg",
        ];
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
            return (WORDS.contains(&word) && words.next().is_some()).then_some(Self::Obj);
        }
        comment.then_some(Self::Obj)
    }

    /// The media type of this kind.
    pub fn media_type(self) -> &'static str {
        match self {
            Self::Glb => "model/gltf-binary",
            Self::Gltf => "model/gltf+json",
            Self::Obj => "model/obj",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::MeshKind;

    #[test]
    fn bytes_decide() {
        assert_eq!(MeshKind::detect(b"glTF\x02\0\0\0"), Some(MeshKind::Glb));
        assert_eq!(MeshKind::detect(b" \n{\"asset\":{}}"), Some(MeshKind::Gltf));
        assert_eq!(MeshKind::detect(b"# made\nv 0 0 0\n"), Some(MeshKind::Obj));
        assert_eq!(MeshKind::detect(b"v 0 0 0\n"), Some(MeshKind::Obj));
        assert_eq!(MeshKind::detect(b"solid cube\n"), None);
        assert_eq!(MeshKind::detect(b"\x89PNG\r\n\x1a\n"), None);
        assert_eq!(MeshKind::detect(b"hello world"), None);
        assert_eq!(MeshKind::detect(b""), None);
    }
}
