//! The service as its clients see it: the real program on a port of its own, real HTTP, real workers.

mod app;
mod artifacts;
mod bad_input;
mod demo;
mod events;
#[path = "../shared/glb.rs"]
mod glb;
mod jobs;
mod meshes;
mod same_bytes;
mod service;
