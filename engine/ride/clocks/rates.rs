//! Sampling rates that a ride may have.

use std::ops::RangeInclusive;

/// Sampling rates (Hz) that any clock may have, from a time column or from `rate_hz`. Lengths that follow
/// from a time in seconds stay within reach of the number of samples by it.
pub const RATES_HZ: RangeInclusive<f64> = 1e-3..=1e6;
/// [`RATES_HZ`] in words.
pub const RATES: &str = "0.001 Hz to 1000000 Hz";

/// Rates (Hz) that a ride is logged at, beyond which a time unit is doubted: a bicycle's slowest vertical mode, the
/// rider's near 2.5 Hz, has two samples a swing at 5 Hz, and vibration recorders end at 51.2 kHz.
pub const USUAL_HZ: RangeInclusive<f64> = 5.0..=52e3;
