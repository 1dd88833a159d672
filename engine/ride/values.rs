//! The values of a channel.

use super::channel::Channel;
use crate::document::format_number::significant;

pub(super) fn is_constant(values: &[f64]) -> bool {
    values.iter().all(|v| *v == values[0])
}

/// A value with its unit, lengths in mm.
pub(super) fn size(channel: Channel, value: f64) -> String {
    match channel.dimension().si_name() {
        "m" if value.abs() < 1.0 => format!("{:.4} mm", value * 1e3),
        unit => format!("{} {unit}", significant(value, 5)),
    }
}
