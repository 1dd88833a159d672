//! Whether the search has explained the ride.

pub mod by_parts;
pub mod carries;
pub mod choose;
pub mod effect_report;
pub mod general_laws;
pub mod input_noise;
pub mod judge;
