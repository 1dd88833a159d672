//! When samples were taken: time stamps, rates, several clocks, one uniform grid.

pub mod clock;
pub mod rates;
pub mod resample;
pub mod sensor_clock;
