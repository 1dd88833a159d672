//! Whether the search has explained the ride.

pub mod affirm;
pub mod by_windows;
pub mod carries;
pub mod choose;
pub mod general_laws;
pub mod judge;
pub mod partly;
pub mod windows;
