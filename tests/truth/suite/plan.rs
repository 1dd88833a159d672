//! The plans of the suites: which ride conceals what. Drawn before anything is simulated.

mod beside;
mod clean;
mod conditions;
mod groups;
mod standard;
mod strange;

pub use beside::beside;
pub use clean::{clean, quiet};
pub use conditions::conditions;
pub use standard::{standard, timing};
pub use strange::strange;

use super::case::{Noise, Setting};
use crate::chance::Chance;

fn any_noise(chance: &mut Chance) -> Noise {
    chance.pick(&[
        Noise::White,
        Noise::White,
        Noise::White,
        Noise::Coloured,
        Noise::Coloured,
        Noise::Quantised,
        Noise::Quantised,
        Noise::Road,
        Noise::Road,
        Noise::Jitter,
    ])
}

/// A road, or in a fifth of the rides that need none, a plate.
fn road_or_plate(needs_road: bool, chance: &mut Chance) -> Setting {
    if needs_road || chance.happens(0.8) {
        Setting::Road
    } else {
        Setting::Plate
    }
}
