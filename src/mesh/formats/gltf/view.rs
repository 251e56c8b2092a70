//! A checked view of a glTF document: the parts of the JSON that are read, through the types of
//! `gltf::json`, and the buffers behind them. The document itself stays a `serde_json::Value`,
//! because those types drop what they do not know.

use bytes::Bytes;
use gltf::json::mesh::Mode;
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Mesh, Node, buffer};
use serde::Deserialize;
use serde_json::Value;

use crate::mesh::import::ImportError;

/// A document, read.
pub(in crate::mesh) struct GltfView<'a> {
    pub json: &'a Value,
    pub buffers: &'a [Bytes],
    pub accessors: Vec<Accessor>,
    pub views: Vec<buffer::View>,
    pub meshes: Vec<Mesh>,
    pub nodes: Vec<Node>,
}

/// What a triangle primitive says of itself.
pub(in crate::mesh) struct PrimitiveView<'a> {
    /// Attribute names and their accessors, in file order.
    pub attributes: Vec<(&'a str, usize)>,
    /// The same for each morph target.
    pub targets: Vec<Vec<(&'a str, usize)>>,
    /// Accessor of the indices.
    pub indices: Option<usize>,
    /// Material.
    pub material: Option<usize>,
    /// Triangles, strip or fan; `None` for points and lines.
    pub mode: Option<Mode>,
    /// The primitive as it stands in the file.
    pub json: &'a Value,
}

impl PrimitiveView<'_> {
    /// The accessor of one attribute.
    pub fn attribute(&self, name: &str) -> Option<usize> {
        self.attributes.iter().find(|(n, _)| *n == name).map(|&(_, accessor)| accessor)
    }
}

impl<'a> GltfView<'a> {
    /// Read what is needed, each element on its own so that an error says where it stands, and
    /// check that every buffer view lies inside its buffer.
    pub fn new(json: &'a Value, buffers: &'a [Bytes]) -> Result<Self, ImportError> {
        let view = Self {
            json,
            buffers,
            accessors: list(json, "accessors")?,
            views: list(json, "bufferViews")?,
            meshes: list(json, "meshes")?,
            nodes: list(json, "nodes")?,
        };
        for i in 0..view.views.len() {
            view.view_slice(i)?;
        }
        Ok(view)
    }

    /// The bytes of a buffer view.
    pub fn view_slice(&self, index: usize) -> Result<Bytes, ImportError> {
        let view = self.views.get(index).ok_or_else(|| {
            ImportError::invalid(format!(
                "buffer view {index} does not exist: there are {}",
                self.views.len()
            ))
        })?;
        let number = view.buffer.value();
        let buffer = self.buffers.get(number).ok_or_else(|| {
            ImportError::invalid(format!(
                "buffer view {index} lies in buffer {number}, which does not exist: there are {}",
                self.buffers.len()
            ))
        })?;
        let (start, length) = (view.byte_offset.unwrap_or_default().0, view.byte_length.0);
        let end = start.checked_add(length).filter(|&end| end <= buffer.len() as u64);
        match end {
            Some(end) => Ok(buffer.slice(start as usize..end as usize)),
            None => Err(ImportError::invalid(format!(
                "buffer view {index} (offset {start}, {length} bytes) runs past the end of buffer \
                 {number} ({} bytes)",
                buffer.len()
            ))),
        }
    }

    /// One primitive of a mesh. `place` names it in errors.
    pub fn primitive(
        &self,
        mesh: usize,
        number: usize,
        place: &str,
    ) -> Result<PrimitiveView<'a>, ImportError> {
        let missing = || ImportError::invalid(format!("{place}: there is no such primitive"));
        let typed = self.meshes.get(mesh).and_then(|m| m.primitives.get(number));
        let typed = typed.ok_or_else(missing)?;
        let path = format!("/meshes/{mesh}/primitives/{number}");
        let json = self.json.pointer(&path).ok_or_else(missing)?;
        let mode = match typed.mode {
            Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => {
                Some(mode)
            }
            Checked::Valid(_) => None,
            Checked::Invalid => {
                return Err(ImportError::invalid(format!("{place}: its mode is none of 0 to 6")));
            }
        };
        let targets = json.get("targets").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
        Ok(PrimitiveView {
            attributes: semantics(json.get("attributes"), place)?,
            targets: targets.iter().map(|t| semantics(Some(t), place)).collect::<Result<_, _>>()?,
            indices: typed.indices.map(|i| i.value()),
            material: typed.material.map(|i| i.value()),
            mode,
            json,
        })
    }

    /// The name of an element of one of the document's lists, or nothing.
    pub fn name(&self, list: &str, index: usize) -> Option<&'a str> {
        self.json.get(list)?.get(index)?.get("name")?.as_str().filter(|name| !name.is_empty())
    }
}

/// Read the elements of one of the document's lists.
fn list<'a, T: Deserialize<'a>>(json: &'a Value, key: &str) -> Result<Vec<T>, ImportError> {
    let items = match json.get(key) {
        None => return Ok(Vec::new()),
        Some(Value::Array(items)) => items,
        Some(_) => return Err(ImportError::invalid(format!("`{key}` must be an array"))),
    };
    let read = |(i, item): (usize, &'a Value)| {
        T::deserialize(item).map_err(|error| ImportError::invalid(format!("{key}[{i}]: {error}")))
    };
    items.iter().enumerate().map(read).collect()
}

/// Attribute names and their accessors.
fn semantics<'a>(
    map: Option<&'a Value>,
    place: &str,
) -> Result<Vec<(&'a str, usize)>, ImportError> {
    let wrong = || {
        ImportError::invalid(format!("{place}: attributes must be an object of accessor indices"))
    };
    let map = map.and_then(Value::as_object).ok_or_else(wrong)?;
    map.iter()
        .map(|(name, value)| {
            let index = value.as_u64().and_then(|i| usize::try_from(i).ok()).ok_or_else(wrong)?;
            Ok((name.as_str(), index))
        })
        .collect()
}
