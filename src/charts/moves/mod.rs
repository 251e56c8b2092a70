//! Step three: seams moved between the charts that are left, and charts divided that fill a page badly.

pub mod compact;
pub mod straighten;
