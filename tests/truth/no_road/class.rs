//! Classes of rides: how many there are of each, how far apart their tracks run, and what is demanded.

use super::demand::Demand;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// One effect; both wheels within 1 cm of the same track.
    Effect,
    /// One effect; 1 to 3 cm.
    EffectApart,
    Clean,
    CleanApart,
    /// One effect that an unknown road absorbs for the most part.
    Absorbed,
    /// A law that is in no library.
    Outside,
    /// Axles with the same k/m and B/m.
    Equal,
    /// Wheels that leave the ground.
    Lift,
    /// Tracks as far apart as those of a car's axles.
    Car,
}

impl Class {
    pub const ALL: [Class; 9] = [
        Class::Effect,
        Class::EffectApart,
        Class::Clean,
        Class::CleanApart,
        Class::Absorbed,
        Class::Outside,
        Class::Equal,
        Class::Lift,
        Class::Car,
    ];

    pub fn words(self) -> &'static str {
        match self {
            Class::Effect => "an effect, tracks within 1 cm",
            Class::EffectApart => "an effect, tracks 1 to 3 cm apart",
            Class::Clean => "clean, tracks within 1 cm",
            Class::CleanApart => "clean, tracks 1 to 3 cm apart",
            Class::Absorbed => "relaxing tyre, or a sprung mass in front",
            Class::Outside => "a law outside the library",
            Class::Equal => "equal axles",
            Class::Lift => "wheels that lift",
            Class::Car => "clean, tracks 30 to 60 cm apart",
        }
    }

    pub fn rides(self) -> usize {
        match self {
            Class::Effect => 120,
            Class::EffectApart | Class::Clean => 60,
            Class::CleanApart => 30,
            Class::Absorbed => 20,
            Class::Outside | Class::Equal => 12,
            Class::Lift | Class::Car => 8,
        }
    }

    /// Distance (m) of the rear wheel's track from the front wheel's.
    pub fn offset_m(self) -> [f64; 2] {
        match self {
            Class::EffectApart | Class::CleanApart => [0.01, 0.03],
            Class::Car => [0.3, 0.6],
            _ => [0.0, 0.01],
        }
    }

    pub fn demand(self) -> Demand {
        let (right, wrong) = match self {
            Class::Effect => (Some(0.8), Some(0.02)),
            Class::EffectApart => (Some(0.4), Some(0.02)),
            Class::Clean | Class::CleanApart | Class::Car => (Some(0.97), None),
            Class::Absorbed => (Some(0.9), None),
            Class::Outside => (None, Some(0.1)),
            Class::Equal | Class::Lift => (None, None),
        };
        Demand { right, wrong }
    }

    pub fn has_one_effect(self) -> bool {
        matches!(self, Class::Effect | Class::EffectApart)
    }

    pub fn is_clean_bicycle(self) -> bool {
        matches!(self, Class::Clean | Class::CleanApart)
    }
}
