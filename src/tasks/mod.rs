//! How work is divided among threads: a *fork* is a place where it divides into *tasks* that threads may take at
//! the same time, and that is over when all of them are. Rayon does the work; what goes through here can be
//! recorded besides, so that it is known what many threads would gain ([`record`], [`Schedule`]).
//!
//! What comes out of a fork never depends on the order in which its tasks end.

mod ahead;
mod blocks;
mod disturb;
mod fork;
mod record;
mod schedule;
mod threads;

pub use ahead::beside;
pub use blocks::{blocks, fill, sum};
pub use disturb::disturb;
pub use fork::{Fork, even, join, map, map_by_size};
pub use record::{Node, Recorded, link, mark, record};
pub use schedule::{Link, Schedule};
pub use threads::{available, start, threads};
