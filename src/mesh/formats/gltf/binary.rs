//! The binary chunk: new vertex data in one buffer view a kind, and of the old buffers what is
//! still referred to.

use gltf::json::accessor::ComponentType;
use serde_json::{Map, Value, json};

use super::extensions::COMPRESSED;
use super::view::GltfView;
use crate::mesh::export::ExportError;

/// What a buffer view holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::mesh) enum Kind {
    /// Indices of this many bytes.
    Indices(usize),
    /// Vertex attributes, one element every so many bytes.
    Vertices(usize),
    /// Indices and values of sparse accessors.
    Sparse,
}

/// Where new data stands.
#[derive(Debug, Clone, Copy)]
pub(in crate::mesh) struct Place {
    pub view: usize,
    pub offset: usize,
}

/// New data, one stream a kind; each becomes a buffer view.
pub(in crate::mesh) struct Streams {
    /// Index of the first stream's view.
    first: usize,
    list: Vec<(Kind, Vec<u8>)>,
}

impl Streams {
    /// No data yet; the views will stand behind `views` others.
    pub fn new(views: usize) -> Self {
        Self { first: views, list: Vec::new() }
    }

    /// Append elements to the stream of their kind, each padded to the stride.
    pub fn append<E: AsRef<[u8]>>(
        &mut self,
        kind: Kind,
        elements: impl IntoIterator<Item = E>,
    ) -> Place {
        let number = self.list.iter().position(|(k, _)| *k == kind).unwrap_or_else(|| {
            self.list.push((kind, Vec::new()));
            self.list.len() - 1
        });
        let bytes = &mut self.list[number].1;
        if kind == Kind::Sparse {
            bytes.resize(bytes.len().next_multiple_of(4), 0);
        }
        let offset = bytes.len();
        for element in elements {
            bytes.extend_from_slice(element.as_ref());
            if let Kind::Vertices(stride) = kind {
                bytes.resize(bytes.len().next_multiple_of(stride), 0);
            }
        }
        Place { view: self.first + number, offset }
    }

    /// Append the indices of triangles over `vertices` vertices, in the narrower type that holds
    /// them, and describe them as an accessor.
    pub fn append_indices(&mut self, corners: &[u32], vertices: usize) -> Value {
        // The highest value of each type is kept free: it restarts primitives.
        let narrow = vertices <= usize::from(u16::MAX);
        let (place, component) = match narrow {
            true => {
                let narrow = corners.iter().map(|&i| (i as u16).to_le_bytes());
                (self.append(Kind::Indices(2), narrow), ComponentType::U16)
            }
            false => {
                let wide = corners.iter().map(|&i| i.to_le_bytes());
                (self.append(Kind::Indices(4), wide), ComponentType::U32)
            }
        };
        Value::Object(accessor(place, component, "SCALAR", corners.len()))
    }

    /// Append vectors of floats, and describe them as an accessor.
    pub fn append_floats<const N: usize>(
        &mut self,
        vectors: impl ExactSizeIterator<Item = [f32; N]>,
    ) -> Map<String, Value> {
        let count = vectors.len();
        let elements = vectors.map(|vector| {
            let mut bytes = [0; 16];
            for (out, number) in bytes.chunks_exact_mut(4).zip(vector) {
                out.copy_from_slice(&number.to_le_bytes());
            }
            Bytes(bytes, 4 * N)
        });
        let place = self.append(Kind::Vertices(4 * N), elements);
        let shape = if N == 1 { "SCALAR".to_owned() } else { format!("VEC{N}") };
        accessor(place, ComponentType::F32, &shape, count)
    }

    /// The buffer views, their offsets still to be set.
    pub fn views(&self) -> impl Iterator<Item = Value> {
        self.list.iter().map(|(kind, bytes)| {
            let length = bytes.len();
            match kind {
                Kind::Indices(_) => json!({"buffer": 0, "byteLength": length, "target": 34963}),
                Kind::Vertices(stride) => {
                    json!({"buffer": 0, "byteLength": length, "byteStride": stride, "target": 34962})
                }
                Kind::Sparse => json!({"buffer": 0, "byteLength": length}),
            }
        })
    }
}

/// Up to four floats, as bytes.
struct Bytes([u8; 16], usize);

impl AsRef<[u8]> for Bytes {
    fn as_ref(&self) -> &[u8] {
        &self.0[..self.1]
    }
}

/// An accessor of new data.
fn accessor(
    place: Place,
    component: ComponentType,
    shape: &str,
    count: usize,
) -> Map<String, Value> {
    let accessor = json!({
        "bufferView": place.view,
        "byteOffset": place.offset,
        "componentType": component.as_gl_enum(),
        "count": count,
        "type": shape,
    });
    match accessor {
        Value::Object(map) => map,
        _ => Map::new(),
    }
}

/// Lay out the binary chunk of a document whose buffer views are `kept`: indices of old views and,
/// behind those, of streams. Old bytes stay as they were; ranges that overlap are stored once.
pub(in crate::mesh) fn lay_out(
    json: &mut Value,
    kept: &[usize],
    old: Option<&GltfView>,
    streams: &Streams,
) -> Result<Vec<u8>, ExportError> {
    let ranges = old.map_or_else(Vec::new, |old| kept_ranges(old, kept));
    let total = ranges.iter().map(|r| r.end - r.start + 3).sum::<u64>()
        + streams.list.iter().map(|(_, bytes)| bytes.len() as u64 + 3).sum::<u64>();
    if u32::try_from(total).is_err() {
        return Err(ExportError::TooLarge(total));
    }
    let mut bin = Vec::with_capacity(total as usize);
    let mut starts = Vec::with_capacity(ranges.len());
    for range in &ranges {
        starts.push(align(&mut bin));
        if let Some(old) = old {
            let bytes = &old.buffers[range.buffer];
            bin.extend_from_slice(&bytes[range.start as usize..range.end as usize]);
        }
    }
    let mut stream_starts = Vec::with_capacity(streams.list.len());
    for (_, bytes) in &streams.list {
        stream_starts.push(align(&mut bin));
        bin.extend_from_slice(bytes);
    }
    let views = json.get_mut("bufferViews").and_then(Value::as_array_mut);
    for (view, &source) in views.into_iter().flatten().zip(kept) {
        let start = match (source.checked_sub(streams.first), old) {
            (Some(stream), _) => stream_starts[stream],
            (None, Some(old)) => {
                let (buffer, start) = origin(old, source);
                let after = ranges.partition_point(|r| (r.buffer, r.start) <= (buffer, start));
                let range = after.saturating_sub(1);
                starts[range] + (start - ranges[range].start) as usize
            }
            (None, None) => continue,
        };
        if let Some(view) = view.as_object_mut() {
            view.insert("buffer".into(), 0.into());
            view.insert("byteOffset".into(), start.into());
            drop_compressed(view);
        }
    }
    let mut buffer = match json.pointer_mut("/buffers/0").map(Value::take) {
        Some(Value::Object(first)) => first,
        _ => Map::new(),
    };
    drop_compressed(&mut buffer);
    buffer.insert("byteLength".into(), bin.len().into());
    json["buffers"] = json!([buffer]);
    Ok(bin)
}

/// Leave out compressed copies of data that stand beside the data themselves.
pub(in crate::mesh) fn drop_compressed(object: &mut Map<String, Value>) {
    let Some(extensions) = object.get_mut("extensions").and_then(Value::as_object_mut) else {
        return;
    };
    for name in COMPRESSED {
        extensions.shift_remove(name);
    }
    if extensions.is_empty() {
        object.shift_remove("extensions");
    }
}

fn align(bin: &mut Vec<u8>) -> usize {
    bin.resize(bin.len().next_multiple_of(4), 0);
    bin.len()
}

/// A range of an old buffer.
struct Range {
    buffer: usize,
    start: u64,
    end: u64,
}

/// Buffer and offset of an old view.
fn origin(old: &GltfView, view: usize) -> (usize, u64) {
    let view = &old.views[view];
    (view.buffer.value(), view.byte_offset.unwrap_or_default().0)
}

/// The ranges of the old buffers under the kept views, in order, apart from each other, and each
/// starting at a multiple of four so that alignment stays.
fn kept_ranges(old: &GltfView, kept: &[usize]) -> Vec<Range> {
    let old_views = kept.iter().filter(|&&view| view < old.views.len());
    let mut ranges: Vec<Range> = old_views
        .map(|&view| {
            let (buffer, start) = origin(old, view);
            Range { buffer, start: start & !3, end: start + old.views[view].byte_length.0 }
        })
        .collect();
    ranges.sort_by_key(|r| (r.buffer, r.start, r.end));
    ranges.dedup_by(|next, range| {
        let touch = next.buffer == range.buffer && next.start <= range.end;
        if touch {
            range.end = range.end.max(next.end);
        }
        touch
    });
    ranges
}
