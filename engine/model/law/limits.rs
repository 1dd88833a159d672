//! How much an effect may have.

use veloid_core::numerics::lanes::Lanes;

/// Parameters that an effect may have at most.
pub const MAX_PARAMETERS: usize = 4;
/// States that an effect may have at most.
pub const MAX_STATES: usize = 2;

/// One effect's parameters, for one parameter set.
pub type Values = [f64; MAX_PARAMETERS];
/// One effect's parameters and its states, for eight parameter sets.
pub type LaneValues = [Lanes; MAX_PARAMETERS];
pub type States = [Lanes; MAX_STATES];
