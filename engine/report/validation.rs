//! The report's `validation` section: the identified models beside the record that they come from.

use serde::{Deserialize, Serialize};

use super::Method;

/// How the models of one axle stand beside its record.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Validation {
    /// Whether what is left of the fitted part looks like noise; null for a reason in `why`.
    pub residual: Option<ResidualTests>,
    /// Frequency response, measured and of the models; null for a reason in `why`.
    pub response: Option<FrequencyResponse>,
    /// Restoring force over deflection and rate, measured and of the models; null for a reason in `why`.
    pub restoring: Option<Restoring>,
    /// Why something is absent.
    pub why: Vec<String>,
}

impl Validation {
    /// The same without the intervals of the models.
    pub fn without_intervals(mut self) -> Self {
        if let Some(response) = &mut self.response {
            response.plain.magnitude_low.clear();
            response.plain.magnitude_high.clear();
        }
        if let Some(restoring) = &mut self.restoring {
            restoring.over_deflection.plain_margin_n.clear();
            restoring.over_rate.plain_margin_n.clear();
        }
        self
    }
}

/// Correlations of the whitened residual on the fitted part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ResidualTests {
    /// Whose residual: `output_error` or `extended`.
    pub model: Method,
    /// Whitened samples that count.
    pub samples: usize,
    /// Order of the autoregressive noise model that whitens.
    pub noise_order: usize,
    /// Lags (s) of all correlations below, from 0.
    pub lag_s: Vec<f64>,
    /// With itself; the lag 0 is 1 and not counted.
    pub autocorrelation: CorrelationTest,
    /// With the input at earlier times, which the same filter has passed; null where nothing drives the axle.
    pub cross_correlation: Option<CorrelationTest>,
    /// That input; null where nothing drives the axle.
    pub input: Option<TestedInput>,
}

/// What drives the axle in a test of its residual.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum TestedInput {
    /// Slope of the road u' (m/s).
    RoadSlope,
    /// The applied force (N).
    Force,
    /// Rate of the prescribed deflection d' (m/s).
    DeflectionRate,
}

/// Correlations at some lags with what white noise would keep within.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct CorrelationTest {
    /// From -1 to 1.
    pub values: Vec<f64>,
    /// White noise stays within plus and minus these at 99 % of the lags. Smaller where the fit has already taken off what goes with the
    /// input so.
    pub bounds: Vec<f64>,
    /// Lags that leave it.
    pub outside: usize,
    /// Lags that are counted.
    pub lags: usize,
    /// The first over the second.
    pub share_outside: f64,
    /// What that means, in words.
    pub sentence: String,
}

/// Frequency response from input to output by Welch's method, along the whole record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct FrequencyResponse {
    /// Output over input: `z/u` (road), `z/F` (receptance) or `F/d` (a rig that prescribes the motion).
    pub of: String,
    /// Unit of the magnitudes.
    pub unit: String,
    /// Segments that were averaged.
    pub segments: usize,
    /// Length of a segment (s).
    pub segment_s: f64,
    /// Window of each segment.
    pub window: String,
    /// Share by which neighbouring segments overlap.
    pub overlap: f64,
    /// What was taken off each segment.
    pub detrend: String,
    /// Independent averages that the segments are worth.
    pub averages: f64,
    /// Frequencies (Hz) of everything below, ascending.
    pub frequency_hz: Vec<f64>,
    /// Measured magnitude.
    pub magnitude: Vec<f64>,
    /// Lower end of its 95 % interval; null where it is not known to within itself.
    pub magnitude_low: Vec<Option<f64>>,
    /// Upper end of its 95 % interval.
    pub magnitude_high: Vec<Option<f64>>,
    /// Measured phase (rad): negative where the output is late.
    pub phase_rad: Vec<f64>,
    /// Coherence, 0 to 1.
    pub coherence: Vec<f64>,
    /// Coherence above which a frequency belongs to `coherent_hz`.
    pub coherent_above: f64,
    /// Bands (Hz), from and to, whose coherence is above that.
    pub coherent_hz: Vec<[f64; 2]>,
    /// The plain model's own response.
    pub plain: ModelResponse,
    /// That of the model with the effects, as its simulated motion shows it by the same method; null where no effect acts.
    pub extended: Option<ModelResponse>,
    /// What a periodic input brings about at frequencies that it does not hold; null for the reason in `distortion_why`.
    pub distortion: Option<Distortion>,
    /// Why there is no distortion.
    pub distortion_why: Option<String>,
}

/// A model's frequency response.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ModelResponse {
    /// Magnitude.
    pub magnitude: Vec<f64>,
    /// Lower end of its 95 % interval from the covariance of the fit; empty of the model with effects, and where the result withholds k or B.
    pub magnitude_low: Vec<f64>,
    /// Upper end of the interval.
    pub magnitude_high: Vec<f64>,
    /// Phase (rad).
    pub phase_rad: Vec<f64>,
}

/// Output at frequencies that a periodic input does not hold, as shares of the output (RMS) at those that it does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Distortion {
    /// Period of the input (s).
    pub period_s: f64,
    /// Periods that were averaged.
    pub periods: usize,
    /// At odd multiples of the lowest common frequency: what an odd nonlinearity brings about, such as a cubic spring; null where the
    /// input holds all of them.
    pub odd: Option<f64>,
    /// At even multiples: what differs between compression and rebound.
    pub even: Option<f64>,
    /// The same of noise alone, by how the periods differ.
    pub noise: f64,
}

/// Force of everything between ground and mass but one part: m z'' - F less B w over the deflection d, and less k d over its rate w.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Restoring {
    /// Whose k and B were taken off the measurement: `output_error` or `extended`.
    pub less_by: Method,
    /// Frequency (Hz) above which the measurement was filtered out before it was differentiated; null where a force was measured.
    pub below_hz: Option<f64>,
    /// Over the deflection u - z (m).
    pub over_deflection: ForceCurve,
    /// Over the deflection's rate (m/s).
    pub over_rate: ForceCurve,
}

/// Forces (N) in bins of a coordinate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ForceCurve {
    /// Means of the coordinate in the bins (m or m/s), ascending.
    pub at: Vec<f64>,
    /// Mean measured force (N).
    pub measured_n: Vec<f64>,
    /// Its standard error (N), as of independent samples.
    pub std_error_n: Vec<f64>,
    /// Samples in each bin.
    pub samples: Vec<usize>,
    /// The plain model's force (N).
    pub plain_n: Vec<f64>,
    /// Half of the width of its 95 % interval (N), from the standard error of k or B; empty where the result withholds these.
    pub plain_margin_n: Vec<f64>,
    /// Mean force (N) of the model with the effects in the same bins; null where it does not come there, empty where no effect acts.
    pub extended_n: Vec<Option<f64>>,
}
