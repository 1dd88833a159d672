//! What the further trials share: rides as prescribed, a bench that keeps outcomes, shares with their limits.

pub mod bench;
pub mod coverage;
pub mod plan;
pub mod share;
