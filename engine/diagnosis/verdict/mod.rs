//! Whether the search has explained the ride.

pub mod affirm;
pub mod by_windows;
pub mod carries;
pub mod choose;
pub mod effect_report;
pub mod general_laws;
pub mod input_noise;
pub mod judge;
pub mod outer;
pub mod partly;
pub mod twice;
pub mod windows;
