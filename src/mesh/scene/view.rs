//! Vectors as they stand in a source's bytes: interleaved or not, of any type of number, little-endian,
//! and some of them replaced by others. Nothing is copied.

use bytes::Bytes;

/// What a view reads where the source has no bytes: zeros, as many as the largest vector (a matrix of 4 × 4
/// floats) has.
const ZEROS: [u8; 64] = [0; 64];

/// Types of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Component {
    /// Integers of 8 bits with a sign.
    I8,
    /// Integers of 8 bits.
    U8,
    /// Integers of 16 bits with a sign.
    I16,
    /// Integers of 16 bits.
    U16,
    /// Integers of 32 bits.
    U32,
    /// Single precision.
    F32,
    /// Double precision.
    F64,
}

impl Component {
    /// Bytes of a number.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// Vectors in bytes. Who makes one has checked that every vector that it can be asked for is inside.
#[derive(Debug, Clone)]
pub struct View {
    /// How many.
    pub(in crate::mesh) count: usize,
    /// Bytes of one, padding of matrix columns included.
    pub(in crate::mesh) size: usize,
    pub(in crate::mesh) component: Component,
    /// Numbers in each.
    pub(in crate::mesh) width: usize,
    pub(in crate::mesh) normalized: bool,
    /// The bytes from the first vector on; zeros if there are none.
    pub(in crate::mesh) base: Option<Bytes>,
    /// Bytes from one vector to the next.
    pub(in crate::mesh) stride: usize,
    pub(in crate::mesh) replaced: Replaced,
}

/// Vectors that replace those of the base.
#[derive(Debug, Clone, Default)]
pub struct Replaced {
    /// Which vector each replaces, ascending, and its row.
    pub(in crate::mesh) rows: Vec<(u32, u32)>,
    /// The bytes from row 0 on.
    pub(in crate::mesh) bytes: Bytes,
    /// Bytes from one row to the next.
    pub(in crate::mesh) stride: usize,
}

impl View {
    /// The bytes of vector `i`.
    pub(in crate::mesh) fn get(&self, i: usize) -> &[u8] {
        if let Some(bytes) = self.replacement(i) {
            return bytes;
        }
        match &self.base {
            Some(base) => &base[i * self.stride..][..self.size],
            None => &ZEROS[..self.size],
        }
    }

    /// Whether there is nothing but replacements of zeros.
    pub(in crate::mesh) fn is_sparse(&self) -> bool {
        self.base.is_none()
    }

    /// How many vectors are replaced.
    pub(in crate::mesh) fn replaced_count(&self) -> usize {
        self.replaced.rows.len()
    }

    /// The bytes that replace vector `i`.
    pub(in crate::mesh) fn replacement(&self, i: usize) -> Option<&[u8]> {
        let Replaced { rows, bytes, stride } = &self.replaced;
        if rows.is_empty() {
            return None;
        }
        let found = rows.binary_search_by_key(&(i as u64), |&(at, _)| u64::from(at)).ok()?;
        Some(&bytes[rows[found].1 as usize * stride..][..self.size])
    }

    /// Number `k` of vector `i` as it is stored, not normalized.
    pub(in crate::mesh) fn stored(&self, i: usize, k: usize) -> f64 {
        self.number(self.get(i), k)
    }

    /// Number `k` of vector `i`, normalized where it is to be.
    pub(in crate::mesh) fn value(&self, i: usize, k: usize) -> f64 {
        self.normal(self.stored(i, k))
    }

    /// The first `N` numbers of vector `i`, normalized where they are to be.
    pub(in crate::mesh) fn vector<const N: usize>(&self, i: usize) -> [f64; N] {
        let bytes = self.get(i);
        std::array::from_fn(|k| self.normal(self.number(bytes, k)))
    }

    /// Number `k` of a vector's bytes.
    fn number(&self, bytes: &[u8], k: usize) -> f64 {
        let bytes = &bytes[k * self.component.size()..];
        let four = || [bytes[0], bytes[1], bytes[2], bytes[3]];
        match self.component {
            Component::I8 => f64::from(bytes[0] as i8),
            Component::U8 => f64::from(bytes[0]),
            Component::I16 => f64::from(i16::from_le_bytes([bytes[0], bytes[1]])),
            Component::U16 => f64::from(u16::from_le_bytes([bytes[0], bytes[1]])),
            Component::U32 => f64::from(u32::from_le_bytes(four())),
            Component::F32 => f64::from(f32::from_le_bytes(four())),
            Component::F64 => {
                let mut eight = [0; 8];
                eight.copy_from_slice(&bytes[..8]);
                f64::from_le_bytes(eight)
            }
        }
    }

    fn normal(&self, stored: f64) -> f64 {
        match self.component {
            _ if !self.normalized => stored,
            Component::I8 => (stored / 127.0).max(-1.0),
            Component::U8 => stored / 255.0,
            Component::I16 => (stored / 32767.0).max(-1.0),
            Component::U16 => stored / 65535.0,
            Component::U32 | Component::F32 | Component::F64 => stored,
        }
    }

    /// Vector `i` of one unsigned integer, as an index.
    pub(in crate::mesh) fn index(&self, i: usize) -> u32 {
        match *self.get(i) {
            [a] => u32::from(a),
            [a, b] => u32::from(u16::from_le_bytes([a, b])),
            [a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
            _ => u32::MAX,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_view_reads_over_strides_and_replacements() {
        let numbers = [1.0f64, -2.0, 3.0, 4.0, 5.0, 6.0];
        let bytes = Bytes::from_iter(numbers.iter().flat_map(|x| x.to_le_bytes()));
        let replaced = Replaced { rows: vec![(1, 1)], bytes: bytes.slice(16..), stride: 16 };
        let view = View {
            count: 2,
            size: 8,
            component: Component::F64,
            width: 1,
            normalized: false,
            base: Some(bytes.slice(8..)),
            stride: 16,
            replaced: Replaced::default(),
        };
        assert_eq!([view.value(0, 0), view.value(1, 0)], [-2.0, 4.0]);
        let view = View { replaced, ..view };
        assert_eq!([view.value(0, 0), view.value(1, 0)], [-2.0, 5.0]);
        let view = View { base: None, ..view };
        assert_eq!([view.value(0, 0), view.value(1, 0)], [0.0, 5.0]);
    }
}
