//! The library as people look things up in it.

use super::{ALL, Kind};
use crate::law::{Acts, MAX_PARAMETERS, Need, Scale};
use veloid_report::simulation::Law;

/// One effect, as docs/effects.md and the pages show it.
pub struct Entry {
    /// Id in reports, such as `coulomb_friction`.
    pub id: &'static str,
    /// What happens, as a clause for sentences.
    pub words: &'static str,
    /// Its formula: d is the deflection (m), w its rate (m/s), other names are parameters.
    pub law: &'static str,
    /// The same as exports have it, in the parameters that the fit moves; nothing of `pitch_coupling`, which couples whole axles.
    pub written: Law,
    /// Where it can act.
    pub acts: &'static str,
    /// What a ride must have for it to be spoken about.
    pub needs: Vec<&'static str>,
    /// Name and unit of what is reported, and the limits of the fit for a typical bicycle where that is fitted as it is reported.
    pub parameters: Vec<(String, String, Option<[f64; 2]>)>,
    /// Ids of effects whose records look alike.
    pub confused_with: &'static [&'static str],
    /// Where the law comes from.
    pub source: &'static str,
    /// False for general laws, which are never named.
    pub is_named: bool,
}

/// All effects, by name, general laws last.
pub fn catalogue() -> Vec<Entry> {
    let mut all: Vec<Entry> = ALL.iter().copied().map(entry).collect();
    all.sort_by_key(|entry| (!entry.is_named, entry.id));
    all
}

/// The bicycle for which limits are given.
pub fn typical() -> String {
    let s = Scale::TYPICAL;
    format!(
        "{} kg on k = {} N/m and B = {} N s/m, {} s at {} Hz of which {} s are fitted, deflections of {} mm and rates of {} m/s (RMS)",
        s.mass,
        s.k,
        s.b,
        s.duration,
        1.0 / s.step,
        s.train_s,
        1e3 * s.d_rms,
        s.w_rms
    )
}

fn entry(kind: Kind) -> Entry {
    let spec = kind.spec();
    let scale = &Scale::TYPICAL;
    let limits = |name: &str| {
        let fitted = spec.parameters.iter().find(|fitted| fitted.name == name);
        fitted.map(|fitted| (fitted.limits)(scale))
    };
    let [reported, turned] =
        [1.0, -1.0].map(|value| (spec.report)(&[value; MAX_PARAMETERS], scale));
    // A choice shows in its unit what it is.
    let unit = |one: &str, other: &str| match one == other {
        true => one.to_owned(),
        false => format!("{one} or {other}"),
    };
    Entry {
        id: spec.id,
        words: spec.words,
        law: spec.law,
        written: kind.law(scale),
        acts: match spec.acts {
            Acts::OneAxle => "front or rear axle",
            Acts::Front => "front axle",
            Acts::Rear => "rear axle",
            Acts::Both => "both axles",
        },
        needs: spec.needs.iter().map(|need| words(*need)).collect(),
        parameters: (reported.iter().zip(&turned))
            .map(|(r, turned)| {
                (
                    r.name.to_string(),
                    unit(&r.unit, &turned.unit),
                    limits(&r.name),
                )
            })
            .collect(),
        confused_with: spec.confused_with,
        source: spec.source,
        is_named: !kind.spec().is_general,
    }
}

fn words(need: Need) -> &'static str {
    match need {
        Need::Road => "a road that moves",
        Need::Speed => "a speed",
        Need::VaryingSpeed => "a speed that varies",
        Need::Cadence => "a cadence",
        Need::Geometry => "both masses and l_F, l_R",
        Need::WheelRadius => "the wheel's radius",
        Need::StaticLoad => "the static load",
        Need::PrescribedMotion => "a rig that prescribes the motion",
        Need::Mass => "a mass that moves",
        Need::Drive => "a road or a force that drives the axle",
        Need::Hold => "a spring that holds the mass in its place",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_says_what_it_is_and_names_only_others() {
        for entry in catalogue() {
            assert!(!entry.law.is_empty() && !entry.words.is_empty() && !entry.source.is_empty());
            for other in entry.confused_with {
                assert!(Kind::by_id(other).is_some(), "{}: {other}", entry.id);
            }
            let noun = Kind::by_id(entry.id).map_or("", |kind| kind.spec().noun);
            assert_eq!(noun.is_empty(), !entry.is_named, "{}", entry.id);
            for (name, ..) in entry.parameters.iter().filter(|_| entry.is_named) {
                let times = noun.matches(&format!("{{{name}}}")).count();
                assert_eq!(times, 1, "{}: {name} in {noun}", entry.id);
            }
            // The law speaks of every parameter that is reported.
            for (name, ..) in &entry.parameters {
                assert!(
                    entry.law.contains(name) || !entry.is_named,
                    "{}: {name} in {}",
                    entry.id,
                    entry.law
                );
            }
        }
    }
}
