//! A model on a ride that it was not identified from.

use serde::{Deserialize, Serialize};

use super::diagnosis::{EffectName, Predicted};
use veloid_core::bicycle::PerAxle;

/// How well a model predicts another ride.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ModelOnRide {
    /// Version of veloid that compared them.
    pub veloid: String,
    /// The answer in plain words.
    pub sentence: String,
    /// What the ride's file, sensors or times have that makes the comparison doubtful, one sentence each.
    #[serde(default)]
    pub warnings: Vec<String>,
    /// Each axle that both the model and the ride have.
    pub axles: PerAxle<AxleOnRide>,
    /// What was not compared, and why, one sentence each.
    pub left_out: Vec<String>,
}

/// One axle of the model beside the ride's measurement.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct AxleOnRide {
    /// Quantity that is compared: errors are in its unit.
    pub predicted: Predicted,
    /// Effects in the model of this axle.
    pub effects: Vec<EffectName>,
    /// Part of the ride (s from its first sample) on which the starting state, and the rest point where there is one, were fitted.
    pub start_s: [f64; 2],
    /// Part of the ride (s from its first sample) that is compared.
    pub compared_s: [f64; 2],
    /// Standard deviation of the measurement there.
    pub spread: f64,
    /// The model with its effects.
    pub model: FitOnRide,
    /// The plain model of the same job, without effects; null where the model has no effects on this axle.
    pub plain: Option<FitOnRide>,
    /// The same model with its numbers fitted to this ride; null where that diverges.
    pub refitted: Option<FitOnRide>,
    /// RMS of the displacement sensor's noise: declared in the bike file or measured on this ride; null where unknown.
    pub noise: Option<f64>,
    /// Every number of the model beside what it is on this ride.
    pub parameters: Vec<ParameterOnRide>,
    /// Whether any of them differs by more than the intervals allow; null where none has an interval on both sides.
    pub differs: Option<bool>,
    /// Stretches of time (s from the first sample) where the model leaves significantly more than the refitted one.
    pub windows_s: Vec<[f64; 2]>,
    /// Bands of frequency (Hz) where it does.
    pub bands_hz: Vec<[f64; 2]>,
    /// The same in plain words.
    pub sentence: String,
    /// The stretch of the ride where the model is worst.
    pub worst: SeriesOnRide,
    /// Spectrum of what is left.
    pub spectrum: SpectrumOnRide,
}

/// Errors of one model on the compared part of the ride.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct FitOnRide {
    /// RMS of measured minus predicted.
    pub rms: f64,
    /// Largest absolute difference.
    pub largest: f64,
    /// 100 (1 - |y - predicted| / |y - mean of y|) (%), as `compare` of MATLAB's System Identification Toolbox: 100 is perfect, 0 no
    /// better than a constant.
    pub fit_percent: f64,
    /// Share of the measurement's variance that is explained (%).
    pub explained_percent: f64,
}

/// A number of the model and what it is on the ride.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ParameterOnRide {
    /// `k`, `B`, or the effect's id and its parameter's name, as in `coulomb_friction.friction`.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Value in the model.
    pub model: f64,
    /// Its standard error; null where it has none.
    pub model_std_error: Option<f64>,
    /// Value of the same model fitted to this ride.
    pub ride: f64,
    /// Its standard error.
    pub ride_std_error: Option<f64>,
    /// Difference (ride minus model) over the standard error of the difference; null where one of them has no standard error.
    pub difference_in_errors: Option<f64>,
    /// Whether it is larger than chance allows, all parameters of the axle together, at the level alpha; null like the difference.
    pub differs: Option<bool>,
}

/// Curves for a plot.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct SeriesOnRide {
    /// Time from the first sample (s).
    pub t_s: Vec<f64>,
    /// Measurement; null where it is not trusted.
    pub measured: Vec<Option<f64>>,
    /// Prediction of the model.
    pub model: Vec<Option<f64>>,
    /// Prediction of the model fitted to this ride.
    pub refitted: Vec<Option<f64>>,
}

/// Power spectral density of measured minus predicted, on the compared part.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct SpectrumOnRide {
    /// Centres of the bands (Hz), ascending, in nearly equal ratios.
    pub frequency_hz: Vec<f64>,
    /// Density of what the model leaves (unit squared for each Hz).
    pub model: Vec<Option<f64>>,
    /// Density of what the model fitted to this ride leaves.
    pub refitted: Vec<Option<f64>>,
}
