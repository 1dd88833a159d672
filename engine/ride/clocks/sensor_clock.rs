//! A sensor's clock beside the accelerometer's on its axle, and its time stamps set right.

use serde::{Deserialize, Serialize};

use crate::clocks::clock::Grid;
use veloid_core::document::format_number::Quantity;

/// Offsets (s) and drifts (ppm) within which the clocks of two files are found, where the road is rough enough.
const PROMISED_S: f64 = 1e-3;
const PROMISED_PPM: f64 = 5.0;

/// The clock of a sensor relative to that of the accelerometer on its axle: at time t of the latter it reads
/// t + offset + drift (t - at).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct SensorClock {
    /// Canonical name of its channel, e.g. `d_r`.
    pub channel: String,
    /// The channel with which it is compared.
    pub beside: String,
    /// The file of `channel`, where the two channels are in different files; the clock then applies to everything in this file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The file of `beside`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub beside_file: Option<String>,
    /// Null where the ride does not determine it; `reason` states why.
    pub found: Option<ClockOffset>,
    /// Why nothing was found.
    pub reason: Option<String>,
    /// Whether the time stamps were corrected; a small or uncertain offset is left in and included in full in the intervals.
    pub applied: bool,
}

/// How late a clock is and how much it runs fast, with standard errors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ClockOffset {
    /// Time (s) for which the offset is reported, on the clock of `beside`: its first sample.
    pub at_s: f64,
    /// How late the clock is (s).
    pub offset_s: f64,
    /// Standard error of the offset (s).
    pub offset_std_s: f64,
    /// How much it runs fast (parts per million).
    pub drift_ppm: f64,
    /// Standard error of the drift (parts per million).
    pub drift_std_ppm: f64,
    /// Time (s) of the middle of the ride, where the offset is known best.
    pub middle_s: f64,
    /// How late the clock is then (s).
    pub middle_offset_s: f64,
    /// Standard error of that (s).
    pub middle_offset_std_s: f64,
}

impl ClockOffset {
    /// From what is known in the middle of a ride; drifts are shares. Offset in the middle and drift err independently, as the
    /// windows lie evenly about the middle.
    pub fn about_the_middle(
        at_s: f64,
        middle_s: f64,
        [offset_s, offset_std_s]: [f64; 2],
        [drift, drift_std]: [f64; 2],
    ) -> Self {
        let half = middle_s - at_s;
        Self {
            at_s,
            offset_s: offset_s - drift * half,
            offset_std_s: offset_std_s.hypot(drift_std * half),
            drift_ppm: 1e6 * drift,
            drift_std_ppm: 1e6 * drift_std,
            middle_s,
            middle_offset_s: offset_s,
            middle_offset_std_s: offset_std_s,
        }
    }

    /// What two sensors on one clock say of it, each counting as it is sure.
    pub fn together(&self, other: &Self) -> Self {
        let mean = |[a, a_std]: [f64; 2], [b, b_std]: [f64; 2]| {
            let [wa, wb] = [a_std, b_std].map(|std| 1.0 / (std * std).max(f64::MIN_POSITIVE));
            [(wa * a + wb * b) / (wa + wb), (1.0 / (wa + wb)).sqrt()]
        };
        let offset = |c: &Self| [c.middle_offset_s, c.middle_offset_std_s];
        let drift = |c: &Self| [1e-6 * c.drift_ppm, 1e-6 * c.drift_std_ppm];
        Self::about_the_middle(
            self.at_s,
            self.middle_s,
            mean(offset(self), offset(other)),
            mean(drift(self), drift(other)),
        )
    }

    /// What the clock beside read when this one read `stamp_s`.
    pub fn set_right(&self, stamp_s: f64) -> f64 {
        let late = stamp_s - self.middle_s - self.middle_offset_s;
        self.middle_s + late / (1.0 + 1e-6 * self.drift_ppm)
    }

    pub fn set_grid_right(&self, grid: Grid) -> Grid {
        let start_s = self.set_right(grid.start_s);
        let steps = grid.count.saturating_sub(1).max(1) as f64;
        Grid {
            start_s,
            step_s: (self.set_right(grid.at(grid.count.saturating_sub(1).max(1))) - start_s)
                / steps,
            ..grid
        }
    }
}

impl SensorClock {
    /// The correction of the channel's time stamps, where there is one.
    pub fn correction(&self) -> Option<&ClockOffset> {
        self.found.as_ref().filter(|_| self.applied)
    }

    /// Whether it is known less well than a ride in several files is predicted.
    pub fn is_weak(&self) -> bool {
        let weak = |found: &ClockOffset| {
            found.middle_offset_std_s > PROMISED_S || found.drift_std_ppm > PROMISED_PPM
        };
        self.found.as_ref().is_some_and(weak)
    }

    /// In a sentence without its end.
    pub fn summary(&self) -> String {
        let named = |channel: &String, file: &Option<String>| match file {
            Some(file) => format!("{file} ({channel})"),
            None => channel.clone(),
        };
        let channel = named(&self.channel, &self.file);
        let beside = named(&self.beside, &self.beside_file);
        let Some(found) = &self.found else {
            let reason = self
                .reason
                .as_deref()
                .unwrap_or("the ride does not determine it");
            return format!("the clock offset between {channel} and {beside} is unknown: {reason}");
        };
        let (offset, std) = (1e3 * found.offset_s, 1e3 * found.offset_std_s);
        let side = if offset < 0.0 { "early" } else { "late" };
        let offset = Quantity::new(offset.abs(), Some(std), "ms");
        let side_of_rate = if found.drift_ppm < 0.0 {
            "slow"
        } else {
            "fast"
        };
        let drift = Quantity::new(found.drift_ppm.abs(), Some(found.drift_std_ppm), "ppm");
        let summary = format!(
            "the clock of {channel} is {offset} {side} relative to {beside} at {:.2} s and runs {drift} {side_of_rate}",
            found.at_s
        );
        match self.applied {
            true => format!("{summary}; {channel} was corrected to the clock of {beside}"),
            false => format!(
                "{summary}: too small or too uncertain to correct the time stamps, so it is included in full in the intervals of k and B"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn clock(offset_s: f64, drift: f64, applied: bool) -> SensorClock {
        let about = ClockOffset::about_the_middle(10.0, 40.0, [offset_s, 1e-4], [drift, 2e-6]);
        SensorClock {
            channel: "d_r".to_owned(),
            beside: "a_r".to_owned(),
            file: None,
            beside_file: None,
            found: Some(about),
            reason: None,
            applied,
        }
    }

    #[test]
    fn stamps_are_set_right() {
        let found = clock(0.02, 200e-6, true).found.unwrap();
        assert!((found.offset_s - 0.014).abs() < 1e-12 && found.at_s == 10.0);
        assert!((found.offset_std_s - 1e-4_f64.hypot(6e-5)).abs() < 1e-12);
        let stamp = |t: f64| t + found.offset_s + 200e-6 * (t - found.at_s);
        for t in [-3.0, 10.0, 40.0, 75.0] {
            assert!((found.set_right(stamp(t)) - t).abs() < 1e-12, "{t}");
        }
        let truth = Grid {
            start_s: 9.0,
            step_s: 1.0 / 30.0,
            count: 1900,
        };
        let stamped = Grid {
            start_s: stamp(9.0),
            step_s: truth.step_s * (1.0 + 200e-6),
            ..truth
        };
        let right = found.set_grid_right(stamped);
        assert!((right.start_s - 9.0).abs() < 1e-12);
        assert!((right.end_s() - truth.end_s()).abs() < 1e-9);
        let one = Grid {
            count: 1,
            ..stamped
        };
        assert!((found.set_grid_right(one).step_s / truth.step_s - 1.0).abs() < 1e-9);
    }

    #[test]
    fn what_was_done_is_said() {
        let said = |offset_s: f64, drift: f64, applied| clock(offset_s, drift, applied).summary();
        let done = said(0.02, 0.0, true);
        assert!(
            done.contains("d_r is 20.00 ± 0.23")
                && done.contains("late relative to a_r at 10.00 s")
                && done.contains("corrected to the clock of a_r"),
            "{done}"
        );
        let left = said(-0.0001, -5e-6, false);
        assert!(
            left.contains("slow") && left.contains("included in full"),
            "{left}"
        );
        let unknown = SensorClock {
            found: None,
            reason: Some("nothing in common".to_owned()),
            ..clock(0.0, 0.0, false)
        };
        assert!(unknown.summary().ends_with("unknown: nothing in common"));
        assert!(unknown.correction().is_none() && clock(0.0, 0.0, false).correction().is_none());
    }
}
