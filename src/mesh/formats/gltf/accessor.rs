//! The reader of glTF accessors (glTF 2.0 specification, section 3.6): every bound is checked in
//! 64 bits, against what the file really holds, before anything is allocated.

use gltf::json::accessor::{ComponentType, GenericComponentType, IndexComponentType, Type};
use gltf::json::validation::Checked;

use super::view::GltfView;
use crate::mesh::import::ImportError;

/// What an accessor reads without a buffer view: zeros, as many as the largest element (MAT4 of
/// f32) has bytes.
const ZEROS: [u8; 64] = [0; 64];

/// The elements of an accessor. Every element that `get` can be asked for is inside the file.
#[derive(Debug, Clone)]
pub(in crate::mesh) struct Elements<'a> {
    /// How many.
    pub count: usize,
    /// Bytes of one, padding of matrix columns included.
    pub size: usize,
    pub component: ComponentType,
    pub shape: Type,
    pub normalized: bool,
    base: Option<&'a [u8]>,
    stride: usize,
    /// Elements that replace those of the base, by ascending index.
    replaced: Vec<(u32, &'a [u8])>,
}

impl<'a> Elements<'a> {
    /// The bytes of element `i`.
    pub fn get(&self, i: usize) -> &'a [u8] {
        if let Some(bytes) = self.replacement(i) {
            return bytes;
        }
        match self.base {
            Some(base) => &base[i * self.stride..][..self.size],
            None => &ZEROS[..self.size],
        }
    }

    /// Whether there is nothing but replacements of zeros.
    pub fn is_sparse(&self) -> bool {
        self.base.is_none()
    }

    /// How many elements a sparse accessor replaces.
    pub fn replaced_count(&self) -> usize {
        self.replaced.len()
    }

    /// The bytes that replace element `i` in a sparse accessor.
    pub fn replacement(&self, i: usize) -> Option<&'a [u8]> {
        if self.replaced.is_empty() {
            return None;
        }
        let found = self.replaced.binary_search_by_key(&(i as u64), |&(at, _)| u64::from(at));
        found.ok().map(|at| self.replaced[at].1)
    }

    /// Component `k` of element `i` as it is stored, not normalized.
    pub fn stored(&self, i: usize, k: usize) -> f64 {
        let bytes = &self.get(i)[k * self.component.size()..];
        match self.component {
            ComponentType::I8 => f64::from(bytes[0] as i8),
            ComponentType::U8 => f64::from(bytes[0]),
            ComponentType::I16 => f64::from(i16::from_le_bytes([bytes[0], bytes[1]])),
            ComponentType::U16 => f64::from(u16::from_le_bytes([bytes[0], bytes[1]])),
            ComponentType::U32 => {
                f64::from(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
            }
            ComponentType::F32 => {
                f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
            }
        }
    }

    /// Component `k` of element `i`, normalized where the accessor says so.
    pub fn value(&self, i: usize, k: usize) -> f64 {
        let stored = self.stored(i, k);
        match self.component {
            _ if !self.normalized => stored,
            ComponentType::I8 => (stored / 127.0).max(-1.0),
            ComponentType::U8 => stored / 255.0,
            ComponentType::I16 => (stored / 32767.0).max(-1.0),
            ComponentType::U16 => stored / 65535.0,
            ComponentType::U32 | ComponentType::F32 => stored,
        }
    }

    /// Element `i` of unsigned integers, as an index.
    pub fn index(&self, i: usize) -> u32 {
        match *self.get(i) {
            [a] => u32::from(a),
            [a, b] => u32::from(u16::from_le_bytes([a, b])),
            [a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
            _ => u32::MAX,
        }
    }
}

/// Bytes of one element: each column of a matrix starts at a multiple of four bytes.
fn element_size(component: ComponentType, shape: Type) -> usize {
    let (columns, rows) = match shape {
        Type::Mat2 => (2, 2),
        Type::Mat3 => (3, 3),
        Type::Mat4 => (4, 4),
        vector => return component.size() * vector.multiplicity(),
    };
    columns * (rows * component.size()).next_multiple_of(4)
}

impl<'a> GltfView<'a> {
    /// The elements of an accessor, checked. `place` says in errors who reads it.
    pub fn elements(&self, index: usize, place: &str) -> Result<Elements<'a>, ImportError> {
        let wrong = |what: String| Err(ImportError::invalid(format!("{place}: {what}")));
        let Some(accessor) = self.accessors.get(index) else {
            let held = self.accessors.len();
            return wrong(format!("accessor {index} does not exist: there are {held}"));
        };
        let Checked::Valid(GenericComponentType(component)) = accessor.component_type else {
            return wrong(format!("accessor {index} has an unknown componentType"));
        };
        let Checked::Valid(shape) = accessor.type_ else {
            return wrong(format!("accessor {index} has an unknown type"));
        };
        let count = accessor.count.0;
        if count >= u64::from(u32::MAX) {
            return wrong(format!(
                "accessor {index} declares {count} elements, more than 2^32 - 2"
            ));
        }
        let mut elements = Elements {
            count: count as usize,
            size: element_size(component, shape),
            component,
            shape,
            normalized: accessor.normalized,
            base: None,
            stride: 0,
            replaced: Vec::new(),
        };
        if let Some(view) = accessor.buffer_view {
            let offset = accessor.byte_offset.unwrap_or_default().0;
            let name = format!("{place}: accessor {index}");
            let (base, stride) = self.array(view.value(), offset, count, elements.size, &name)?;
            (elements.base, elements.stride) = (Some(base), stride);
        }
        if let Some(sparse) = &accessor.sparse {
            let name = format!("{place}: sparse part of accessor {index}");
            let Checked::Valid(IndexComponentType(kind)) = sparse.indices.component_type else {
                return wrong(format!("accessor {index} has sparse indices of an unknown type"));
            };
            let (listed, size) = (sparse.count.0, elements.size);
            if listed > count {
                return wrong(format!(
                    "accessor {index} replaces {listed} of its {count} elements"
                ));
            }
            let at = sparse.indices.buffer_view.value();
            let (keys, key_stride) =
                self.array(at, sparse.indices.byte_offset.0, listed, kind.size(), &name)?;
            let at = sparse.values.buffer_view.value();
            let (values, value_stride) =
                self.array(at, sparse.values.byte_offset.0, listed, size, &name)?;
            for i in 0..listed as usize {
                let mut word = [0; 4];
                word[..kind.size()].copy_from_slice(&keys[i * key_stride..][..kind.size()]);
                let key = u32::from_le_bytes(word);
                if u64::from(key) >= count {
                    return wrong(format!(
                        "accessor {index} replaces element {key} and has only {count}"
                    ));
                }
                elements.replaced.push((key, &values[i * value_stride..][..size]));
            }
            elements.replaced.sort_by_key(|&(key, _)| key);
            elements.replaced.dedup_by_key(|&mut (key, _)| key);
        }
        Ok(elements)
    }

    /// An array of `count` elements of `size` bytes at `offset` of a buffer view: its bytes and its
    /// stride.
    fn array(
        &self,
        view: usize,
        offset: u64,
        count: u64,
        size: usize,
        name: &str,
    ) -> Result<(&'a [u8], usize), ImportError> {
        let bytes = self.view_bytes(view)?;
        let stride = self.views[view].byte_stride.map_or(size, |stride| stride.0);
        if stride < size || stride > 252.max(size) {
            return Err(ImportError::invalid(format!(
                "{name}: buffer view {view} has byteStride {stride}; elements of {size} bytes need \
                 {size} to 252"
            )));
        }
        let span = match count {
            0 => Some(0),
            _ => (count - 1).checked_mul(stride as u64).and_then(|n| n.checked_add(size as u64)),
        };
        let end = span.and_then(|span| offset.checked_add(span));
        match end.filter(|&end| end <= bytes.len() as u64) {
            Some(end) => Ok((&bytes[offset as usize..end as usize], stride)),
            None => Err(ImportError::invalid(format!(
                "{name}: {count} elements of {size} bytes at offset {offset}, stride {stride}, run \
                 past the end of buffer view {view} ({} bytes)",
                bytes.len()
            ))),
        }
    }
}
