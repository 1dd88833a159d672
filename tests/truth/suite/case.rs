//! One planned ride.

use super::circumstance::Circumstance;
use crate::chance::Chance;
use crate::simulate::effect::{Axle, Kind};
use crate::simulate::outside::Strange;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    Clean,
    Single,
    Two,
    Outside,
    /// A listed effect on one axle, strange physics on the other.
    Beside,
    Three,
}

impl Class {
    pub fn name(self) -> &'static str {
        match self {
            Class::Clean => "clean",
            Class::Single => "single",
            Class::Two => "two",
            Class::Outside => "outside",
            Class::Beside => "beside",
            Class::Three => "three",
        }
    }
}

/// What moves the bicycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    Road,
    /// Shaker plates move the ground under each wheel; no speed.
    Plate,
    /// Shakers push the axle masses; the ground rests.
    Shaker,
    /// Released from a deflection.
    Decay,
}

impl Setting {
    pub fn name(self) -> &'static str {
        match self {
            Setting::Road => "road",
            Setting::Plate => "plate",
            Setting::Shaker => "shaker",
            Setting::Decay => "decay",
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Noise {
    White,
    Coloured,
    Quantised,
    Road,
    Jitter,
}

impl Noise {
    pub const ALL: [Noise; 5] = [
        Noise::White,
        Noise::Coloured,
        Noise::Quantised,
        Noise::Road,
        Noise::Jitter,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Noise::White => "white",
            Noise::Coloured => "coloured",
            Noise::Quantised => "quantised",
            Noise::Road => "road",
            Noise::Jitter => "jitter",
        }
    }
}

/// One planned ride.
#[derive(Clone, Debug)]
pub struct Case {
    pub class: Class,
    pub effects: Vec<(Kind, Axle)>,
    pub strange: Option<(Strange, usize)>,
    /// 0 small, 1 medium, 2 large.
    pub size: usize,
    pub setting: Setting,
    pub noise: Noise,
    pub circumstance: Option<Circumstance>,
    pub duration_s: f64,
    pub rate_hz: f64,
}

impl Case {
    pub fn new(class: Class, setting: Setting, noise: Noise, chance: &mut Chance) -> Self {
        let duration_s = match setting {
            Setting::Decay => 12.0,
            _ if chance.happens(0.12) => 120.0,
            _ => 60.0,
        };
        let rate_hz = if setting == Setting::Decay || chance.happens(0.12) {
            200.0
        } else {
            100.0
        };
        Self {
            class,
            effects: Vec::new(),
            strange: None,
            size: 1,
            setting,
            noise,
            circumstance: None,
            duration_s,
            rate_hz,
        }
    }

    /// The same ride under a circumstance, with the rate and length that go with it.
    pub fn under(self, circumstance: Circumstance) -> Self {
        let (rate_hz, duration_s) = match circumstance {
            Circumstance::Slow => (20.0, self.duration_s),
            Circumstance::Fast => (500.0, self.duration_s),
            Circumstance::Short => (self.rate_hz, 10.0),
            Circumstance::Long => (100.0, 600.0),
            _ => (self.rate_hz, self.duration_s),
        };
        Self {
            circumstance: Some(circumstance),
            rate_hz,
            duration_s,
            ..self
        }
    }

    /// The fastest that a road moves an axle (Hz): what the log carries.
    pub fn fastest_hz(&self) -> f64 {
        match self.circumstance {
            Some(Circumstance::Rough) => 0.45 * self.rate_hz,
            _ => (0.45 * self.rate_hz).min(22.0),
        }
    }
}
