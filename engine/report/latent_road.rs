//! The report's `latent_road` section: the method that needs no road.

use serde::{Deserialize, Serialize};

use super::Estimate;
use crate::bicycle::PerAxle;

/// k and B from sensors on the axles and the speed, the road being unknown.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct LatentRoad {
    pub front: Option<Estimate>,
    pub rear: Option<Estimate>,
    /// Why nothing was identified; null where something was.
    pub reason: Option<String>,
    pub road: Option<RoadSpectrum>,
    /// Share by which the speed, or the wheelbase's inverse, reads too little; null where the ride does not determine it.
    pub speed: Option<Correction>,
    pub sensors: Vec<SensorFound>,
    /// Lowest and highest frequency used (Hz).
    pub band_hz: [f64; 2],
    /// Windows used, and their length (s).
    pub windows: usize,
    pub window_s: f64,
    /// Where the model does not explain the sensors.
    pub notes: Vec<String>,
}

/// A correction with its standard error.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Correction {
    pub value: f64,
    pub std_error: f64,
}

/// What was found out about one sensor, beside the first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct SensorFound {
    /// Canonical channel name, e.g. `a_r`.
    pub channel: String,
    /// Factor by which it reads too much beside the first sensor, and time (s) by which its clock is late beside the accelerometer on
    /// its axle, or else the first sensor, in the middle of the ride; null for that one and where the ride does not determine it. What
    /// the reader set right of it already (`ride.clocks`) is counted in.
    pub gain: Option<Correction>,
    pub delay_s: Option<Correction>,
    /// Parts per million by which a laser's clock runs fast.
    #[serde(default)]
    pub drift_ppm: Option<Correction>,
    /// Standard deviation of its noise, taken as white.
    pub noise: f64,
    pub unit: String,
}

/// The road's estimated spectrum.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct RoadSpectrum {
    /// Nearest class of ISO 8608, A to H.
    pub class: String,
    /// Density Gd(n0) (m^3) at n0 = 0.1 cycles/m of the line of slope -2 through the spectrum up to 2.83 cycles/m.
    pub psd_m3: f64,
    /// Band in which the spectrum was seen (cycles/m): outside of it the class is extrapolated.
    pub band_cycles_per_m: [f64; 2],
    /// One-sided density (m^3) at spatial frequencies (cycles/m).
    pub cycles_per_m: Vec<f64>,
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

    pub fn axles(&self) -> PerAxle<Estimate> {
        PerAxle {
            front: self.front.clone(),
            rear: self.rear.clone(),
        }
    }
}
