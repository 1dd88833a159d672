//! The report's `diagnosis.windows` section: what short windows of an axle's record say, each simulated from a starting state of its own.

use serde::{Deserialize, Serialize};

/// Results of an axle's windows of one length. Errors are those on the second halves of the windows, to which a model was not
/// fitted; shares are of their squares.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Windows {
    /// Period (s) that divides the motion's power into halves.
    pub period_s: f64,
    /// Length of a window (s); models are fitted to the first halves and evaluated on the second halves.
    pub length_s: f64,
    /// Number of windows.
    pub count: usize,
    /// RMS error (m) of the plain model, in N where `held_out.predicted` is a force; null where it diverges.
    pub plain_rms_m: Option<f64>,
    /// RMS error (m) of the model with `effects`, in N where `held_out.predicted` is a force; null where it diverges.
    pub extended_rms_m: Option<f64>,
    /// The model that these windows lead to, whether the verdict follows or not.
    pub effects: Vec<WindowEffect>,
    /// Share of the plain model's squares that remains with single effects, the best first, at most eight.
    pub single: Vec<SingleEffect>,
    /// Each window as predicted by the reported model, in order of time; empty where windows affirm nothing, and for the second
    /// length.
    pub starts: Vec<WindowStart>,
}

/// An effect of the model that windows lead to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct WindowEffect {
    /// Id of the effect in the library.
    pub id: String,
    /// Share (0 to 1) of the squared error of the model without it that it removes.
    pub removed_share: f64,
    /// Blocks of neighbouring windows in which it has any influence.
    pub blocks: usize,
    /// Number of `blocks` that the model predicts with a smaller error with it than without it.
    pub blocks_led: usize,
    /// The same of windows that neither the fits nor the selection saw (outer folds): blocks, and those it leads in; absent where the
    /// record has too few windows, or the effect was not affirmed by both lengths.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unseen_blocks: Option<usize>,
    /// How many of `unseen_blocks` the model with the effect predicts with a smaller error than the one without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unseen_blocks_led: Option<usize>,
    /// Id of the effect with as few parameters that comes nearest as a replacement.
    pub rival: Option<String>,
    /// Squared error with the rival, divided by that with this effect.
    pub rival_ratio: Option<f64>,
    /// Whether windows of this length support it.
    pub holds: bool,
}

/// Remaining error of the plain model with one effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct SingleEffect {
    /// Id of the effect in the library.
    pub id: String,
    /// Share of the plain model's squares that remains; null where the model diverges.
    pub left_share: Option<f64>,
}

/// A window's initial state, estimated from its first half, and the reported model's error on its second half.
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
    /// States of the effects, in the effects' order, each in its own unit.
    pub hidden: Vec<f64>,
    /// Sensor reading minus simulated height (m).
    pub zero_m: f64,
    /// RMS (m, or N); null where the model diverges.
    pub rms_m: Option<f64>,
}
