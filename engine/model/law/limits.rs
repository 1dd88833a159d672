//! How much an effect may have.

use veloid_core::numerics::lanes::Lanes;

/// Parameters that an effect may have at most; a law of the user's own alone has more than four.
pub const MAX_PARAMETERS: usize = 12;
/// States that an effect of the library may have at most: they are copied in every step.
pub const MAX_STATES: usize = 2;
/// States that a law of the user's own may have at most.
pub const MAX_OWN_STATES: usize = 6;

/// One effect's parameters, for one parameter set.
pub type Values = [f64; MAX_PARAMETERS];
/// One effect's parameters, for eight parameter sets.
pub type LaneValues = [Lanes; MAX_PARAMETERS];
/// The states of an effect of the library, for eight parameter sets.
pub type States = [Lanes; MAX_STATES];

/// Where an effect's own states start, relative to the mass for a mass's height and velocity.
pub type Initial = [f64; MAX_OWN_STATES];
/// At rest, or with the mass.
pub const AT_REST: Initial = [0.0; MAX_OWN_STATES];

/// The values of an effect that has no more than these parameters: zeros follow.
pub const fn padded<const N: usize>(first: [f64; N]) -> Values {
    let mut all = [0.0; MAX_PARAMETERS];
    let mut i = 0;
    while i < N {
        all[i] = first[i];
        i += 1;
    }
    all
}
