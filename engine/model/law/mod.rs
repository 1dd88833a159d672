//! What an effect may ask of a ride, and what it says of itself.

mod effect;
mod formula;
mod limits;
mod need;
pub mod own;
mod scale;
mod spec;

pub use effect::{Crank, Effect, Motion, Pickup, STABLE, Spot, Tap, as_reported};
pub use formula::{Formula, SIZES};
pub use limits::{
    AT_REST, Initial, LaneValues, MAX_OWN_STATES, MAX_PARAMETERS, MAX_STATES, States, Values,
    padded,
};
pub use need::Need;
pub use own::OwnLaw;
pub use scale::Scale;
pub use spec::{Acts, Family, Parameter, Reported, Spec, reported};

pub use veloid_core::numerics::lanes::Lanes;
pub use veloid_report::diagnosis::Stronger;
