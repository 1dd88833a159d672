use std::ops::Range;

use veloid_core::settings::Settings;
use veloid_ride::Ride;

/// Samples to fit on and samples to judge on, with a gap between them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Split {
    /// Samples that models are fitted to.
    pub train: Range<usize>,
    /// Samples that they are judged on.
    pub held: Range<usize>,
}

impl Split {
    /// The last `settings.held_out` of the ride is held out; before it a gap of 3 % of the ride belongs to neither part.
    pub fn of(ride: &Ride, settings: &Settings) -> Self {
        let n = ride.samples;
        let held = ((1.0 - settings.held_out) * n as f64).round() as usize;
        let gap = (0.03 * n as f64) as usize;
        Self {
            train: 0..held.saturating_sub(gap),
            held: held..n,
        }
    }
}
