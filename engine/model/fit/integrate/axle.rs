//! Eight parameter sets of one axle, and how it moves with them.

use crate::effects::Kind;
use crate::law::{LaneValues, MAX_OWN_STATES, MAX_STATES, Values};
use veloid_core::numerics::lanes::Lanes;
use veloid_core::plant::Coefficients;

/// Effects on one axle at most.
pub const MAX_EFFECTS: usize = 6;
/// The mass's and those of the effects; room for a law of the user's own beside [`BESIDE_OWN`] effects of the library.
pub(super) const STATES: usize = 2 + MAX_EFFECTS * MAX_STATES;
/// Effects of the library beside a law of the user's own at most.
pub const BESIDE_OWN: usize = (STATES - 2 - MAX_OWN_STATES) / MAX_STATES;

#[derive(Clone, Debug)]
pub struct AxleLanes {
    /// Those of the base model.
    pub base: Coefficients<Lanes>,
    pub effects: Vec<EffectLanes>,
}

#[derive(Clone, Debug)]
pub struct EffectLanes {
    pub kind: Kind,
    pub values: LaneValues,
    /// Where the effect's own states start, relative to the mass for a mass's height and velocity.
    pub initial: [Lanes; MAX_OWN_STATES],
}

impl EffectLanes {
    pub(super) fn of_lane(&self, lane: usize) -> Values {
        self.values.map(|v| v.0[lane])
    }
}

/// Simulated motion of one axle at every sample.
#[derive(Clone, Debug, Default)]
pub struct Motions {
    pub z: Vec<Lanes>,
    /// Velocity and acceleration, where asked for.
    pub v: Vec<Lanes>,
    pub a: Vec<Lanes>,
}
