//! A ride on one uniform clock, as every later step uses it.

mod axles;
mod band;
mod channel;
mod checks;
mod clock;
mod common;
mod csv;
mod decimate;
mod delay;
mod dialect;
mod error;
mod header;
mod mat;
mod options;
#[cfg(test)]
mod properties;
mod rates;
mod read;
mod recording;
mod resample;
mod source;
mod spectrum;
mod table;
#[cfg(test)]
mod tests;
mod unit;
mod values;
mod wild;

use serde::{Deserialize, Serialize};

pub use decimate::decimated;
pub use error::{Problem, ReadError};
pub use options::{Limits, ReadOptions};
pub use rates::RATES_HZ;
pub use read::{Preview, PreviewGap, parse_only, preview, read};

use crate::EngineError;
use crate::bicycle::{Bike, PerAxle};

/// A ride after reading: SI units, one clock, no blanks.
#[derive(Clone, Debug, PartialEq)]
pub struct Ride {
    /// Time of the first sample (s) and sample interval (s).
    pub start_s: f64,
    pub step_s: f64,
    /// Number of samples; every channel has as many.
    pub samples: usize,
    pub axles: PerAxle<AxleRecord>,
    /// Speed (m/s) and crank rate (revolutions per minute).
    pub speed: Option<Vec<f64>>,
    pub cadence: Option<Vec<f64>>,
    /// Roll angle, steering angle (rad), yaw rate (rad/s), lateral speed (m/s).
    pub roll: Option<Vec<f64>>,
    pub steer: Option<Vec<f64>>,
    pub yaw_rate: Option<Vec<f64>>,
    pub lateral_speed: Option<Vec<f64>>,
    pub summary: RideSummary,
}

/// What was recorded on one axle.
#[derive(Clone, Debug, PartialEq)]
pub struct AxleRecord {
    /// Road height u under the wheel (m); all zero where the ground is at rest.
    pub road: Vec<f64>,
    /// Force applied to the axle mass (N, up), on rides with a shaker.
    pub force: Option<Vec<f64>>,
    /// Vertical displacement z (m).
    pub displacement: Vec<f64>,
    /// Measured vertical acceleration (m/s^2).
    pub acceleration: Option<Vec<f64>>,
    /// Samples to trust: false where z is clipped, missing or bridged over a gap.
    pub valid: Vec<bool>,
}

/// First samples that must be alike for a record to start at rest.
const STILL: usize = 3;
/// Part of the motion (standard deviation) below which samples are alike, whatever the resolution.
const ALIKE: f64 = 1e-4;

impl AxleRecord {
    /// How far height (m) and velocity (m/s) may be from the first sample's height and from none, where the record starts at
    /// rest: its first samples are alike, to within its resolution.
    pub fn at_rest(&self, step_s: f64) -> Option<[f64; 2]> {
        let z = &self.displacement;
        let finest = z.windows(2).map(|p| (p[1] - p[0]).abs());
        let finest = finest.filter(|d| *d > 0.0).fold(f64::INFINITY, f64::min);
        let mean = z.iter().sum::<f64>() / z.len().max(1) as f64;
        let variance = z.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / z.len().max(1) as f64;
        let alike = ALIKE * variance.sqrt();
        let still = z.iter().take_while(|x| (*x - z[0]).abs() <= alike).count();
        let width = alike.max(finest);
        (still >= STILL && width.is_finite()).then(|| [width, width / (still as f64 * step_s)])
    }

    /// Whether the road moves at all.
    pub fn has_road(&self) -> bool {
        self.road.iter().any(|u| *u != self.road[0])
    }
}

impl Ride {
    /// Whether `bike` tells the masses that this ride does not.
    pub fn fits(&self, bike: &Bike) -> Result<(), EngineError> {
        for (axle, record) in self.axles.iter() {
            bike.mass_or_force(axle, record.force.is_some())?;
        }
        Ok(())
    }

    pub fn duration_s(&self) -> f64 {
        self.samples.saturating_sub(1) as f64 * self.step_s
    }

    pub fn time_s(&self, sample: usize) -> f64 {
        self.start_s + sample as f64 * self.step_s
    }
}

/// What the reader understood of the file: the report's `ride` section.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct RideSummary {
    /// SHA-256 of the file's bytes (hex).
    pub sha256: String,
    /// Rows of the file that were used.
    pub rows: usize,
    /// Samples on the common clock.
    pub samples: usize,
    pub duration_s: f64,
    pub rate_hz: f64,
    pub columns: Vec<Column>,
    /// Header texts of columns that no channel was recognised in.
    pub ignored: Vec<String>,
    /// What was met and bridged, clipped, resampled or doubted.
    pub warnings: Vec<String>,
}

/// One recognised column.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Column {
    /// Header text as in the file.
    pub header: String,
    /// Canonical channel name, e.g. `z_f`.
    pub channel: String,
    /// Unit in the file, and the factor that makes it SI.
    pub unit: String,
    pub scale: f64,
    /// Samples that were not blank, and their mean rate (Hz).
    pub samples: usize,
    pub rate_hz: f64,
}
