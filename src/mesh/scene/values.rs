//! Lists of vectors of numbers of one type: views into the source's bytes, or lists of their own. A copy
//! shares them.

use std::sync::Arc;

use super::view::{Component, View};

/// Vectors, all of one type and width.
#[derive(Debug, Clone)]
pub enum Values {
    /// As they stand in the source.
    View(Arc<View>),
    /// Single precision.
    Floats {
        /// Numbers in each vector.
        width: usize,
        /// The numbers of all.
        list: Arc<Vec<f32>>,
    },
    /// Double precision.
    Doubles {
        /// Numbers in each vector.
        width: usize,
        /// The numbers of all.
        list: Arc<Vec<f64>>,
    },
}

impl Default for Values {
    /// No points.
    fn default() -> Self {
        Self::floats::<3>(Vec::new())
    }
}

impl Values {
    /// Vectors of their own, in single precision.
    pub fn floats<const N: usize>(vectors: Vec<[f32; N]>) -> Self {
        Self::Floats { width: N, list: Arc::new(vectors.into_flattened()) }
    }

    /// Vectors of their own, in double precision.
    pub fn doubles<const N: usize>(vectors: Vec<[f64; N]>) -> Self {
        Self::Doubles { width: N, list: Arc::new(vectors.into_flattened()) }
    }

    /// How many vectors.
    pub fn count(&self) -> usize {
        match self {
            Self::View(view) => view.count,
            Self::Floats { width, list } => list.len() / width,
            Self::Doubles { width, list } => list.len() / width,
        }
    }

    /// Numbers in each vector.
    pub fn width(&self) -> usize {
        match self {
            Self::View(view) => view.width,
            Self::Floats { width, .. } | Self::Doubles { width, .. } => *width,
        }
    }

    /// The type of the numbers.
    pub fn component(&self) -> Component {
        match self {
            Self::View(view) => view.component,
            Self::Floats { .. } => Component::F32,
            Self::Doubles { .. } => Component::F64,
        }
    }

    /// Whether integers stand for numbers up to 1.
    pub fn is_normalized(&self) -> bool {
        matches!(self, Self::View(view) if view.normalized)
    }

    /// Number `k` of vector `i`, normalized where it is to be.
    pub fn value(&self, i: usize, k: usize) -> f64 {
        match self {
            Self::View(view) => view.value(i, k),
            Self::Floats { width, list } => f64::from(list[i * width + k]),
            Self::Doubles { width, list } => list[i * width + k],
        }
    }

    /// The first `N` numbers of vector `i`.
    pub fn vector<const N: usize>(&self, i: usize) -> [f64; N] {
        match self {
            Self::View(view) => view.vector(i),
            Self::Floats { width, list } => {
                let numbers = &list[i * width..][..N];
                std::array::from_fn(|k| f64::from(numbers[k]))
            }
            Self::Doubles { width, list } => {
                let numbers = &list[i * width..][..N];
                std::array::from_fn(|k| numbers[k])
            }
        }
    }
}
