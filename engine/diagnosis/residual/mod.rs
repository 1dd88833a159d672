//! Whether a model leaves anything but noise.

pub mod bursts;
pub mod coherence;
pub mod omnibus;
pub mod replicate;
pub mod resonance;
