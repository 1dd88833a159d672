//! The report's `latent_road` section: the method that needs no road.

use serde::{Deserialize, Serialize};

use super::Estimate;
use veloid_core::bicycle::PerAxle;
use veloid_core::document::format_number::significant;

/// k and B from sensors on the axles and the speed, with an unknown road.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct LatentRoad {
    /// k and B of the front axle; null where the sensors do not determine them.
    pub front: Option<Estimate>,
    /// k and B of the rear axle; null where the sensors do not determine them.
    pub rear: Option<Estimate>,
    /// Why nothing was identified; null where something was.
    pub reason: Option<String>,
    /// Spectrum of the road, estimated together with k and B.
    pub road: Option<RoadSpectrum>,
    /// Share by which the speed, or the inverse of the wheelbase, reads low; null where the ride does not determine it.
    pub speed: Option<Correction>,
    /// Noise, gain and clock of every sensor that was used.
    pub sensors: Vec<SensorFound>,
    /// Lowest and highest frequency used (Hz).
    pub band_hz: [f64; 2],
    /// Number of windows of the ride whose spectra were used.
    pub windows: usize,
    /// Length of a window (s).
    pub window_s: f64,
    /// Where the model does not explain the sensors.
    pub notes: Vec<String>,
}

/// A correction with its standard error.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Correction {
    /// Estimate, in the unit of the field that contains it.
    pub value: f64,
    /// Standard error in the same unit.
    pub std_error: f64,
}

/// Corrections of one sensor relative to the first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct SensorFound {
    /// Canonical channel name, e.g. `a_r`.
    pub channel: String,
    /// Factor by which it reads high relative to the first sensor; null for that one and where the ride does not determine it.
    pub gain: Option<Correction>,
    /// Time (s) by which its clock is late in the middle of the ride, relative to the accelerometer on its axle or else the
    /// first sensor; null for that one and where the ride does not determine it. Includes what the reader already corrected
    /// (`ride.clocks`).
    pub delay_s: Option<Correction>,
    /// Parts per million by which a laser's clock runs fast.
    #[serde(default)]
    pub drift_ppm: Option<Correction>,
    /// Standard deviation of its noise, assumed white, in `unit`; null where the road hides it.
    #[serde(default)]
    pub noise: Option<f64>,
    /// Lower and upper end of its 95 % interval; null with `noise`.
    #[serde(default)]
    pub noise_interval: Option<[f64; 2]>,
    /// Unit of `noise`: m/s^2 for an accelerometer, m for a laser.
    pub unit: String,
    /// Frequencies (Hz) of `density`.
    #[serde(default)]
    pub frequency_hz: Vec<f64>,
    /// One-sided density (square of `unit` per Hz) of what it showed, noise included, over all windows that were used.
    #[serde(default)]
    pub density: Vec<f64>,
}

impl SensorFound {
    /// Its noise with its interval, in words.
    pub fn noise_in_words(&self) -> String {
        match (self.noise, self.noise_interval) {
            (Some(noise), Some(interval)) => {
                let [noise, low, high] =
                    [noise, interval[0], interval[1]].map(|x| significant(x, 2));
                format!("noise {noise} ({low} to {high}) {}", self.unit)
            }
            (Some(noise), None) => format!("noise {} {}", significant(noise, 2), self.unit),
            (None, _) => "noise hidden by the road".to_owned(),
        }
    }
}

/// The road's estimated spectrum.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct RoadSpectrum {
    /// Nearest class of ISO 8608, A to H.
    pub class: String,
    /// Density Gd(n0) (m^3) at n0 = 0.1 cycles/m of the line of slope -2 through the spectrum up to 2.83 cycles/m.
    pub psd_m3: f64,
    /// Band in which the spectrum was observed (cycles/m); the class is extrapolated outside it.
    pub band_cycles_per_m: [f64; 2],
    /// Spatial frequencies (cycles/m) of `density_m3`.
    pub cycles_per_m: Vec<f64>,
    /// One-sided density (m^3) of the road's height.
    pub density_m3: Vec<f64>,
}

impl LatentRoad {
    /// Nothing identified, and why.
    pub fn without(reason: String) -> Self {
        Self {
            reason: Some(reason),
            ..Self::default()
        }
    }

    /// The estimates of both axles side by side.
    pub fn axles(&self) -> PerAxle<Estimate> {
        PerAxle {
            front: self.front.clone(),
            rear: self.rear.clone(),
        }
    }
}
