//! What a source says: candidate parts, and which of them each face or point speaks for.

use crate::contract::SegmentationSource;

/// A part that a source proposes.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Its name; connected components of one candidate are numbered.
    pub name: String,
    /// Who proposes it.
    pub source: SegmentationSource,
    /// How sure it is that this is a part, 0 to 1.
    pub confidence: f64,
    /// How sure the network is of the name, 0 to 1; `None` where the name is not the network's.
    pub name_confidence: Option<f64>,
}

/// The scores of one source. A face that is `fixed` keeps its label. The others get the label that
/// the graph cut finds best for the votes of their points.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PartScores {
    /// The candidates; labels are indices into these.
    pub candidates: Vec<Candidate>,
    /// Label of each face that is certain, −1 where the votes decide. Length: faces.
    pub fixed: Vec<i32>,
    /// Label that each point of the dense cloud votes for, −1 for none. Length: points, or empty.
    pub votes: Vec<i32>,
    /// Weight of each point's vote, 0 to 1. Length: as `votes`.
    pub weights: Vec<f32>,
    /// Pairs of faces of welded components that touch and are of one part: such a part is not connected by
    /// edges.
    pub bridges: Vec<(u32, u32)>,
    /// Candidates that would be joined next, in order, each pair with the probability that a part ends
    /// between them: the hierarchy above these parts.
    pub joins: Vec<(u32, u32, f64)>,
}
