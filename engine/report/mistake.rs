use serde::{Deserialize, Serialize};

/// Kind of mistake in the record or its bicycle, as far as the record shows it.
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
    /// The accelerometers of front and rear axle stand in each other's place.
    SwappedAccelerometers,
    /// Road and displacement of an axle stand in each other's place.
    SwappedRoad,
    /// A channel is late relative to the others.
    LateChannel,
    /// The speed is in another unit than was said.
    SpeedUnit,
    /// Masses, lengths and static loads of the bicycle contradict each other.
    Bicycle,
}

/// A mistake and how to fix it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Mistake {
    /// Kind of mistake.
    pub kind: MistakeKind,
    /// What shows it and how to fix it.
    pub sentence: String,
    /// Whether it must be fixed before there can be a verdict.
    pub takes_the_verdict: bool,
}
