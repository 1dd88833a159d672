//! What an effect may ask of a ride, and what it says of itself.

mod effect;
mod scale;
mod spec;

pub use effect::{Effect, LaneValues, MAX_STATES, Motion, Pickup, STABLE, Spot, States, Tap};
pub use scale::Scale;
pub use spec::{Acts, MAX_PARAMETERS, Need, Parameter, Reported, Spec, Values, reported};

pub use crate::numerics::lanes::Lanes;
pub use crate::report::diagnosis::Stronger;
