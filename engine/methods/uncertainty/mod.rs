//! What widens an interval beyond the fit's own: masses, the road's noise, a laser's clock; and what is withheld.

pub mod interpolation;
pub mod laser;
pub mod laser_clock;
pub mod mass;
pub mod road_noise;
mod road_variant;
