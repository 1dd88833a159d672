//! What widens an interval beyond the fit's own: masses, the road's noise, a laser's clock; and what is withheld.

pub mod identifiable;
pub mod interpolation;
pub mod laser;
pub(crate) mod laser_clock;
pub(crate) mod mass;
pub(crate) mod road_noise;
mod road_variant;
