//! UVSegNet: UV unwrapping with seams that follow an object's parts.
//!
//! The modules, in the order in which data flows. Each may import only what stands to its left on
//! its line (docs/architecture.md has the picture, tests/contract.rs holds it):
//!
//! `contract ← tasks ← device ← mesh ← flatten ← sampling ← segmentation ← charts ← coarse_to_fine ←
//! parameterization ← atlas ← metrics ← preview ← pipeline`
//!
//! `contract ← mesh ← synth`, `synth, segmentation, preview ← training`,
//! `contract ← config, telemetry ← jobs ← http`,
//! `contract, config, telemetry, jobs, tasks, device, pipeline ← worker`, everything `← cli`.

#![warn(missing_docs)]

pub mod contract;

pub mod tasks;

pub mod device;

pub mod mesh;

pub mod flatten;

pub mod sampling;

pub mod segmentation;

pub mod charts;

pub mod coarse_to_fine;

pub mod parameterization;

pub mod atlas;

pub mod metrics;

pub mod preview;

pub mod pipeline;

pub mod synth;

pub mod training;

pub mod config;
pub mod telemetry;

pub mod jobs;

pub mod http;

pub mod worker;

pub mod cli;
