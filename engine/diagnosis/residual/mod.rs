//! Whether a model leaves anything but noise.

pub mod bursts;
pub mod coherence;
mod features;
pub mod omnibus;
pub mod replicate;
pub mod resonance;
