//! The values of a channel.

use crate::channels::channel::Channel;
use veloid_core::document::format_number::significant;

pub fn is_constant(values: &[f64]) -> bool {
    values.iter().all(|v| *v == values[0])
}

/// A value with its unit, lengths in mm.
pub fn size(channel: Channel, value: f64) -> String {
    match channel.dimension().si_name() {
        "m" if value.abs() < 1.0 => format!("{:.4} mm", value * 1e3),
        unit => format!("{} {unit}", significant(value, 5)),
    }
}
