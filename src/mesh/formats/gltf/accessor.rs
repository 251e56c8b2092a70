//! The reader of glTF accessors (glTF 2.0 specification, section 3.6): every bound is checked in
//! 64 bits, against what the file really holds, before anything is allocated.

use std::ops::Deref;
use std::sync::Arc;

use bytes::Bytes;
use gltf::json::accessor::{ComponentType, GenericComponentType, IndexComponentType, Type};
use gltf::json::validation::Checked;

use super::view::GltfView;
use crate::mesh::import::ImportError;
use crate::mesh::scene::{Component, Replaced, Values, View};

/// The elements of an accessor. Every element that can be asked for is inside the file.
#[derive(Debug, Clone)]
pub(in crate::mesh) struct Elements {
    pub shape: Type,
    view: Arc<View>,
}

impl Deref for Elements {
    type Target = View;

    fn deref(&self) -> &View {
        &self.view
    }
}

impl Elements {
    /// The same as values of a scene; nothing where they are matrices.
    pub fn values(&self) -> Option<Values> {
        let vectors = matches!(self.shape, Type::Scalar | Type::Vec2 | Type::Vec3 | Type::Vec4);
        vectors.then(|| Values::View(Arc::clone(&self.view)))
    }
}

fn component(stored: ComponentType) -> Component {
    match stored {
        ComponentType::I8 => Component::I8,
        ComponentType::U8 => Component::U8,
        ComponentType::I16 => Component::I16,
        ComponentType::U16 => Component::U16,
        ComponentType::U32 => Component::U32,
        ComponentType::F32 => Component::F32,
    }
}

/// Bytes of one element: each column of a matrix starts at a multiple of four bytes.
fn element_size(component: Component, shape: Type) -> usize {
    let (columns, rows) = match shape {
        Type::Mat2 => (2, 2),
        Type::Mat3 => (3, 3),
        Type::Mat4 => (4, 4),
        vector => return component.size() * vector.multiplicity(),
    };
    columns * (rows * component.size()).next_multiple_of(4)
}

impl GltfView<'_> {
    /// The elements of an accessor, checked. `place` says in errors who reads it.
    pub fn elements(&self, index: usize, place: &str) -> Result<Elements, ImportError> {
        let wrong = |what: String| Err(ImportError::invalid(format!("{place}: {what}")));
        let Some(accessor) = self.accessors.get(index) else {
            let held = self.accessors.len();
            return wrong(format!("accessor {index} does not exist: there are {held}"));
        };
        let Checked::Valid(GenericComponentType(stored)) = accessor.component_type else {
            return wrong(format!("accessor {index} has an unknown componentType"));
        };
        let component = component(stored);
        let Checked::Valid(shape) = accessor.type_ else {
            return wrong(format!("accessor {index} has an unknown type"));
        };
        let count = accessor.count.0;
        if count >= u64::from(u32::MAX) {
            return wrong(format!(
                "accessor {index} declares {count} elements, more than 2^32 - 2"
            ));
        }
        let mut view = View {
            count: count as usize,
            size: element_size(component, shape),
            component,
            width: shape.multiplicity(),
            normalized: accessor.normalized,
            base: None,
            stride: 0,
            replaced: Replaced::default(),
        };
        if let Some(number) = accessor.buffer_view {
            let offset = accessor.byte_offset.unwrap_or_default().0;
            let name = format!("{place}: accessor {index}");
            let (base, stride) = self.array(number.value(), offset, count, view.size, &name)?;
            (view.base, view.stride) = (Some(base), stride);
        }
        if let Some(sparse) = &accessor.sparse {
            let name = format!("{place}: sparse part of accessor {index}");
            let Checked::Valid(IndexComponentType(kind)) = sparse.indices.component_type else {
                return wrong(format!("accessor {index} has sparse indices of an unknown type"));
            };
            let (listed, size) = (sparse.count.0, view.size);
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
            let mut rows = Vec::with_capacity(listed as usize);
            for i in 0..listed as usize {
                let mut word = [0; 4];
                word[..kind.size()].copy_from_slice(&keys[i * key_stride..][..kind.size()]);
                let key = u32::from_le_bytes(word);
                if u64::from(key) >= count {
                    return wrong(format!(
                        "accessor {index} replaces element {key} and has only {count}"
                    ));
                }
                rows.push((key, i as u32));
            }
            rows.sort_by_key(|&(key, _)| key);
            rows.dedup_by_key(|&mut (key, _)| key);
            view.replaced = Replaced { rows, bytes: values, stride: value_stride };
        }
        Ok(Elements { shape, view: Arc::new(view) })
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
    ) -> Result<(Bytes, usize), ImportError> {
        let bytes = self.view_slice(view)?;
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
            Some(end) => Ok((bytes.slice(offset as usize..end as usize), stride)),
            None => Err(ImportError::invalid(format!(
                "{name}: {count} elements of {size} bytes at offset {offset}, stride {stride}, run \
                 past the end of buffer view {view} ({} bytes)",
                bytes.len()
            ))),
        }
    }
}
