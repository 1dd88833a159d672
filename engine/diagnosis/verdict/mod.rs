//! Whether the search has explained the ride.

pub mod general_laws;
pub mod judge;
