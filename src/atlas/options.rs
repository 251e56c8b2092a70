//! What packing is told.

use super::quantise::Grid;
use crate::contract::{Quality, Rotation, UnwrapOptions};

/// How to pack.
#[derive(Debug, Clone, PartialEq)]
pub struct PackOptions {
    /// Side of the square page, texels.
    pub page_size: u32,
    /// Least gutter between two charts, texels.
    pub padding: u32,
    /// How charts may be turned.
    pub rotation: Rotation,
    /// Whether no block of 4 × 4 texels may be touched by two charts.
    pub block_align: bool,
    /// How long to search.
    pub quality: Quality,
    /// Most pages; more are used only where the charts fit on so many at no density.
    pub pages: u32,
    /// The lattice that coordinates are put on afterwards.
    pub grid: Grid,
    /// Texel density of each chart relative to the others; empty: all alike.
    pub weights: Vec<f64>,
}

impl From<&UnwrapOptions> for PackOptions {
    fn from(options: &UnwrapOptions) -> Self {
        Self {
            page_size: options.page_size,
            padding: options.padding,
            rotation: options.rotation,
            block_align: options.block_align,
            quality: options.quality,
            pages: options.pages,
            grid: if options.udim { Grid::Tiles } else { Grid::Page },
            weights: Vec::new(),
        }
    }
}
