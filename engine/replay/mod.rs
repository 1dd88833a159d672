//! Measurement and identified models beside each other, sample by sample, and how far they lie apart.

pub(crate) mod comparison;
mod motion;
mod observer_accuracy;
mod series;
mod wheel_load;

pub(crate) use observer_accuracy::accuracy;
pub use series::{Curve, Quantity, Series, Window};
