//! Measurement and identified models beside each other, sample by sample, and how far they lie apart.

mod comparison;
mod observer_accuracy;
mod series;

pub(crate) use observer_accuracy::accuracy;
pub use series::{Curve, Quantity, Series, Window};
