//! The blind proof: an independent simulator of rides with concealed effects, the scorer, and the baselines.
//!
//! Nothing here is shared with the engine. The force laws are written again from `effects.md`, with another integrator,
//! other roads and other sensors, so that a mistake in the engine cannot hide behind the same mistake in its test.

pub mod baselines;
pub mod calibrate;
pub mod chance;
pub mod files;
pub mod misread;
pub mod no_road;
pub mod outcome;
pub mod power;
pub mod prove;
pub mod refit;
pub mod simulate;
pub mod studies;
pub mod suite;
pub mod trial;
