//! What columns hold: channels, units, sensors, values that cannot be.

pub mod channel;
pub mod glimpse;
pub mod guess;
pub mod implausible;
pub mod sensor;
pub mod slower;
pub mod stuck;
pub mod table;
pub mod unit;
pub mod values;
mod words;
