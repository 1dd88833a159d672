//! Rides that conceal nothing.

use crate::chance::Chance;
use crate::suite::case::{Case, Class, Noise, Setting};
use crate::suite::circumstance::Circumstance;

/// Clean rides of all noise kinds and settings, in turn.
pub fn clean(count: usize, chance: &mut Chance) -> Vec<Case> {
    let settings = [
        Setting::Road,
        Setting::Road,
        Setting::Road,
        Setting::Plate,
        Setting::Road,
        Setting::Shaker,
        Setting::Road,
        Setting::Road,
        Setting::Decay,
        Setting::Road,
        Setting::Shaker,
    ];
    (0..count)
        .map(|i| {
            Case::new(
                Class::Clean,
                settings[i % settings.len()],
                Noise::ALL[i % 5],
                chance,
            )
        })
        .collect()
}

/// Clean rides at walking pace, of slow logs, on stiff axles and without noise, in turn.
pub fn quiet(count: usize, chance: &mut Chance) -> Vec<Case> {
    let circumstances = [
        Circumstance::Walking,
        Circumstance::Slow,
        Circumstance::Stiff,
        Circumstance::Noiseless,
    ];
    (0..count)
        .map(|i| {
            let noise = Noise::ALL[(i / circumstances.len()) % Noise::ALL.len()];
            Case::new(Class::Clean, Setting::Road, noise, chance)
                .under(circumstances[i % circumstances.len()])
        })
        .collect()
}
