//! The report's `diagnosis.windows` section: the table from which the verdict on an axle is read.

use serde::de::IgnoredAny;
use serde::{Deserialize, Deserializer, Serialize};

/// The row of the judge's table that gave a verdict (docs/diagnosis.md).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum Rule {
    /// The plain model misses hardly any force and hardly any motion.
    NothingMissed,
    /// The plain model leaves no more than noise, and no set of effects takes a share of that.
    NoiseLeft,
    /// Not even the best set of effects follows the motion.
    NotFollowed,
    /// A law without a name takes a share of what every set of named effects leaves.
    GeneralLaw,
    /// Sets that contain the named effects hold the support, and each of these takes its share.
    Supported,
    /// A few sets hold the support together.
    Tied,
    /// More sets than that share the support, or it lies with sets of which no effect takes its share.
    Unsupported,
    /// A measured road: the likelihood of the whole ride decides.
    Likelihood,
    /// The record determines neither stiffness nor damping.
    Undetermined,
    /// The record does not determine the size of any effect.
    Unsized,
}

/// What sets of effects leave of parts of an axle's record to which they were not fitted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Windows {
    pub rule: Rule,
    /// By length of the parts, the longer first.
    pub lengths: Vec<PartLength>,
    /// Sets of effects, the heaviest first, at most twelve; the plain model is the one without any.
    pub sets: Vec<SetScore>,
    /// The effects of `sets`.
    pub effects: Vec<EffectScore>,
}

/// Parts of one length.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct PartLength {
    /// Length (s) of a window, whose first half gives its initial state and whose second half is judged; the record's where
    /// one simulation of it is judged in blocks.
    pub length_s: f64,
    /// Number of windows or blocks.
    pub parts: usize,
    /// RMS error (m, or N where `held_out.predicted` is a force) of the plain model; null where it diverges.
    pub plain_rms_m: Option<f64>,
    /// RMS error of the set that leaves least.
    pub best_rms_m: Option<f64>,
}

/// A set of effects.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct SetScore {
    /// Ids of its effects.
    pub effects: Vec<String>,
    /// Its weight (0 to 1) among all sets; null where a parameter lies outside its physical range.
    pub weight: Option<f64>,
    /// Share of the plain model's squared error that it leaves, by length; null where it diverges.
    pub left_share: Vec<Option<f64>>,
}

/// An effect and what speaks for it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct EffectScore {
    /// Id of the effect in the library.
    pub id: String,
    #[serde(flatten)]
    pub support: Support,
    /// Why the verdict does not name it; absent where it does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why_not: Option<String>,
}

/// Evidence for one effect that does not require a complete model.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Support {
    /// Weight (0 to 1) of the sets that contain it.
    pub weight: f64,
    /// Share (0 to 1) of the squared held-out error above the noise that returns when it is taken out and the rest is fitted
    /// again, the least of all lengths; null where no set contains it.
    pub share: Option<f64>,
    /// Windows or blocks of the record that were judged, of all lengths.
    pub windows: usize,
    /// Id of the effect that comes nearest in its place.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub next: Option<String>,
}

/// A value of this version's form; nothing in the place of another's.
pub fn of_this_form<'de, D, T>(deserializer: D) -> Result<Option<T>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Form<T> {
        This(T),
        Other(IgnoredAny),
    }
    Ok(match Form::<T>::deserialize(deserializer)? {
        Form::This(value) => Some(value),
        Form::Other(_) => None,
    })
}
