//! Sizes of the network. `paper` is Point-MAE's own (Pang et al. 2022, arXiv 2203.06604, Table 1 and
//! its part-segmentation set-up); `small` ships.

use serde::{Deserialize, Serialize};

/// Which network.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Default, Hash, Serialize, Deserialize, clap::ValueEnum,
)]
#[serde(rename_all = "snake_case")]
pub enum ModelSize {
    /// About 2.9 million parameters, sees normals and thickness: the one that ships.
    #[default]
    Small,
    /// Point-MAE's 384 × 12, sees positions only, so that its published encoders can be loaded.
    Paper,
}

/// The sizes behind a [`ModelSize`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct PointMaeConfig {
    /// Channels of a point: 3 (position), or 7 (position, normal, thickness).
    pub channels: usize,
    /// Groups of a cloud: the transformer's tokens.
    pub groups: usize,
    /// Points of a group.
    pub group_size: usize,
    /// Channels of the mini-PointNet: after its first and second layer, and after its third.
    pub embedding: [usize; 3],
    /// Whether the mini-PointNet normalises over the batch, as the published one does.
    pub batch_norm: bool,
    /// Channels of a token.
    pub width: usize,
    /// Blocks of the encoder.
    pub depth: usize,
    /// Heads of a block.
    pub heads: usize,
    /// The blocks whose outputs are propagated to the points (counted from 1).
    pub taps: [usize; 3],
    /// Blocks of the decoder of the masked autoencoder.
    pub decoder_depth: usize,
    /// Channels of the head.
    pub head: usize,
    /// Channels of the part embedding.
    pub part: usize,
}

/// Names that the semantic head tells apart: coarse PartNet names (Mo et al. 2019, arXiv 1812.02713)
/// over several categories. A name that is none of these is not learned. Only ever append.
pub const NAMES: [&str; 32] = [
    "leg",
    "seat",
    "back",
    "arm",
    "top",
    "shelf",
    "drawer",
    "door",
    "handle",
    "base",
    "body",
    "lid",
    "spout",
    "blade",
    "screen",
    "keyboard",
    "wheel",
    "wing",
    "tail",
    "engine",
    "frame",
    "lens",
    "temple",
    "neck",
    "shade",
    "stem",
    "foot",
    "stretcher",
    "cushion",
    "panel",
    "rim",
    "pole",
];

impl ModelSize {
    /// The sizes.
    pub fn config(self) -> PointMaeConfig {
        match self {
            Self::Small => PointMaeConfig {
                channels: 7,
                groups: 128,
                group_size: 32,
                embedding: [64, 96, 128],
                batch_norm: false,
                width: 192,
                depth: 6,
                heads: 6,
                taps: [2, 4, 6],
                decoder_depth: 2,
                head: 128,
                part: 24,
            },
            Self::Paper => PointMaeConfig {
                channels: 3,
                groups: 128,
                group_size: 32,
                embedding: [128, 256, 512],
                batch_norm: true,
                width: 384,
                depth: 12,
                heads: 6,
                taps: [4, 8, 12],
                decoder_depth: 4,
                head: 256,
                part: 24,
            },
        }
    }
}
