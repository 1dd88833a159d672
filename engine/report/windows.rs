//! The report's `diagnosis.windows` section: what short windows of an axle's record say, each simulated from a starting state of its own.

use serde::{Deserialize, Serialize};

/// What windows of one length say of an axle. Errors are those on the second halves of windows that a model was not fitted to;
/// shares are of their squares.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Windows {
    /// Period (s) above and below which half of the motion's power lies.
    pub period_s: f64,
    /// Length of a window (s); models are fitted to first halves and judged on second ones.
    pub length_s: f64,
    /// Number of windows.
    pub count: usize,
    /// RMS error (m) of the plain model, in N where `held_out.predicted` is a force; null where it runs away.
    pub plain_rms_m: Option<f64>,
    /// RMS error (m) of the model with `effects`, in N where `held_out.predicted` is a force; null where it runs away.
    pub extended_rms_m: Option<f64>,
    /// The model that these windows lead to, whether the verdict follows or not.
    pub effects: Vec<WindowEffect>,
    /// What single effects leave of the plain model's squares, the best first, at most eight.
    pub single: Vec<SingleEffect>,
    /// Each window as the reported model predicts it, in the order of time; empty where windows affirm nothing, and for the second length.
    pub starts: Vec<WindowStart>,
}

/// An effect of the model that windows lead to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct WindowEffect {
    /// Id of the effect in the library.
    pub id: String,
    /// Share (0 to 1) that it takes off the model without it.
    pub removed_share: f64,
    /// Blocks of neighbouring windows in which it does anything.
    pub blocks: usize,
    /// How many of `blocks` the model predicts with a smaller error with it than without it.
    pub blocks_led: usize,
    /// Id of the effect with as few parameters that comes nearest in its place.
    pub rival: Option<String>,
    /// Squares that the rival leaves, divided by those that this effect leaves.
    pub rival_ratio: Option<f64>,
    /// Whether windows of this length support it.
    pub holds: bool,
}

/// What the plain model with one effect leaves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct SingleEffect {
    /// Id of the effect in the library.
    pub id: String,
    /// Share of the plain model's squares that is left; null where the model runs away.
    pub left_share: Option<f64>,
}

/// A window's starting state as its first half says, and what the reported model leaves of its second half.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct WindowStart {
    /// Its first sample, counted from the ride's first (0).
    pub first_sample: usize,
    /// Number of its samples.
    pub samples: usize,
    /// Height (m) of the axle at its first sample; null where the motion is prescribed.
    pub height_m: Option<f64>,
    /// Velocity (m/s) of the axle at its first sample; null where the motion is prescribed.
    pub velocity_m_s: Option<f64>,
    /// States of the effects, in the effects' order, in units of their own.
    pub hidden: Vec<f64>,
    /// What the sensor reads beside the simulated height (m).
    pub zero_m: f64,
    /// RMS (m, or N); null where the model runs away.
    pub rms_m: Option<f64>,
}
