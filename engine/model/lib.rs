//! What a plain axle leaves out: laws, the catalogue of effects, and their fits to records.

pub mod dataset;
pub mod effects;
#[doc(hidden)]
pub mod example;
pub mod fit;
pub mod law;
pub mod policy;
