//! What each axle has of the recorded columns: road, displacement, force, what they share, and what follows from them.

pub mod axles;
pub mod checks;
pub mod clock_notes;
pub mod common;
pub mod decay;
pub mod decimate;
pub mod delay;
pub mod prescribed;
pub mod sensed;
