use serde::{Deserialize, Serialize};

/// What was done wrong to a record or its bicycle before it came here, as far as the record shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum MistakeKind {
    /// A channel has the wrong sign.
    TurnedChannel,
    /// A channel is in another unit than was said.
    WrongUnit,
    /// The displacements of front and rear axle stand in each other's place.
    SwappedDisplacements,
    /// All channels of front and rear axle stand in each other's place.
    SwappedAxles,
    /// The speed is in another unit than was said.
    SpeedUnit,
    /// Masses, lengths and static loads of the bicycle contradict each other.
    Bicycle,
}

/// A mistake with its mend.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Mistake {
    /// What was mistaken.
    pub kind: MistakeKind,
    /// What shows it, and what to do about it.
    pub sentence: String,
    /// Whether no verdict can be had before it is mended.
    pub takes_the_verdict: bool,
}
