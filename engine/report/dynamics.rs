//! The report's `dynamics` section: the identified spring, damper and mass as an oscillator.

use serde::{Deserialize, Serialize};

use super::Method;

/// Poles, step response and errors of an axle's k, B and m, by the method of `result`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Dynamics {
    /// The method whose k, B and m these are, as in `result`.
    pub method: Method,
    /// Whether the model also contains effects, which are not among these numbers: poles and step response are then those of its linear
    /// part.
    pub linear_part: bool,
    /// Roots of m s^2 + B s + k; empty for a reason in `why`.
    pub poles: Vec<Pole>,
    /// Errors of k, B and an estimated mass; null for a reason in `why`.
    pub parameters: Option<ParameterErrors>,
    /// Displacement after a step of the input; null for a reason in `why`.
    pub step_response: Option<StepResponse>,
    /// Why something is absent.
    pub why: Vec<String>,
}

/// A root of the characteristic polynomial.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Pole {
    /// Real part (1/s): negative where a motion decays.
    pub re_1_s: f64,
    /// Imaginary part (rad/s).
    pub im_rad_s: f64,
}

/// Joint errors of the parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ParameterErrors {
    /// `k`, `B` and, where it is estimated, `mass`.
    pub names: Vec<String>,
    /// Their units, in the same order.
    pub units: Vec<String>,
    /// Covariance as the fit gives it, before anything widens the standard errors.
    pub covariance: Vec<Vec<f64>>,
    /// Its correlations.
    pub correlation: Vec<Vec<f64>>,
    /// Standard errors as reported, with what comes to those of the fit: road noise, an uncertain mass, a laser's clock.
    pub widened: Vec<f64>,
    /// Condition number of the information matrix scaled to a unit diagonal of its inverse; null where it is singular.
    pub condition: Option<f64>,
    /// What the record determines least, in words.
    pub least_known: String,
}

/// Displacement of the axle after a step at t = 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct StepResponse {
    /// What steps.
    pub input: StepInput,
    /// Time after the step (s).
    pub t_s: Vec<f64>,
    /// Displacement (m) for 1 m of the road or 1 N of the force.
    pub displacement_m: Vec<f64>,
}

/// What drives an axle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum StepInput {
    /// The road rises by 1 m.
    Road,
    /// A force of 1 N sets in.
    Force,
}
