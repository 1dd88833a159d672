//! What several rides of one bicycle say together.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::{Deserialize, Serialize};

use super::Estimate;
use super::diagnosis::{EffectName, EffectReport, ParameterReport, SwitchedOff, Verdict};
use veloid_core::bicycle::{Axle, PerAxle};
use veloid_core::document::format_number::{Number, significant};
use veloid_core::settings::Settings;

/// Everything that one joint identification found out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct StudyReport {
    /// Version of veloid that made this report.
    pub veloid: String,
    /// Settings of every ride's identification; ride i searched with `seed + i`.
    pub settings: Settings,
    /// What all rides together say is missing, or that nothing is.
    pub verdict: Verdict,
    /// The verdict in plain words.
    pub sentence: String,
    /// Effects that the rides have in common, the same numbers in all of them.
    pub effects: Vec<StudyEffect>,
    /// Other sets that explain the rides as well, best first.
    pub alternatives: Vec<Vec<EffectName>>,
    /// k and B over all rides, and the errors that are left.
    pub axles: PerAxle<StudyAxle>,
    /// In the order in which they were given, without those left aside.
    pub rides: Vec<StudyRide>,
    /// Rides that could not take part.
    pub left_aside: Vec<LeftAside>,
    /// What a study does not look for, since it is a single ride's affair.
    pub single_rides: Vec<SwitchedOff>,
}

/// An effect that several rides have in common.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct StudyEffect {
    /// As all rides together measure it. `affirmed` is false where only a single ride shows it, or where others explain the rides
    /// as well.
    pub effect: EffectReport,
    /// The same parameters as each ride alone measures them beside the others' model, in the order of `rides`.
    pub by_ride: Vec<BTreeMap<String, ParameterReport>>,
    /// Gain in log likelihood of each ride by the common effect, in the order of `rides`.
    pub gain_by_ride: Vec<f64>,
    /// How often rides with the same effect differ by as much as these do (chi-square); null where they cannot be compared.
    pub differs_p_value: Option<f64>,
    /// The rides on which it acts; the others are modelled without it. Where the rides differ in it (`differs_p_value` below alpha),
    /// each has its own parameters (`by_ride`), and `effect` is that of the ride that shows most.
    pub acts_in: Vec<String>,
    /// The ride that alone shows it.
    pub only_in: Option<String>,
}

/// One axle over all rides.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct StudyAxle {
    /// k and B of all rides as one; null where the rides differ by more than chance.
    pub estimate: Option<Estimate>,
    /// How often rides with the same k and B differ by as much as these do (chi-square).
    pub differs_p_value: Option<f64>,
    /// RMS (m) of what the plain model leaves of the rides' parts that were not fitted.
    pub plain_held_out_m: f64,
    /// RMS (m) of what the common model leaves of them.
    pub held_out_m: f64,
}

/// One ride of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct StudyRide {
    /// As the caller named it.
    pub name: String,
    /// k and B of this ride alone, beside the common effects.
    pub axles: PerAxle<Estimate>,
    /// What this ride alone says.
    pub alone: Verdict,
    /// That verdict in plain words.
    pub alone_sentence: String,
    /// Whether that is more than the rides have in common: identify it by itself.
    pub shows_more: bool,
    /// What weakens what this ride says, one sentence each.
    pub warnings: Vec<String>,
}

/// A ride that does not take part, and why.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct LeftAside {
    /// As the caller named it.
    pub name: String,
    /// The reason, in a sentence.
    pub why: String,
}

impl StudyReport {
    /// The report for a person at a terminal.
    pub fn summary(&self) -> String {
        let mut text = String::new();
        // Writing to a String cannot fail.
        let _ = self.write(&mut text);
        text
    }

    fn write(&self, out: &mut String) -> std::fmt::Result {
        writeln!(out, "{}\n", self.sentence)?;
        writeln!(
            out,
            "{:<24}{:<7}{:>28}{:>28}",
            "ride", "axle", "k (N/m)", "B (N s/m)"
        )?;
        for ride in &self.rides {
            for (axle, e) in ride.axles.iter() {
                row(out, &ride.name, axle, e)?;
            }
        }
        for (axle, on) in self.axles.iter() {
            match &on.estimate {
                Some(e) => row(out, "all together", axle, e)?,
                None => writeln!(
                    out,
                    "{axle} axle: k and B differ from ride to ride by more than chance"
                )?,
            }
        }
        writeln!(out, "\n± is the 95 % interval.")?;
        for (axle, on) in self.axles.iter() {
            let [before, after] =
                [on.plain_held_out_m, on.held_out_m].map(|x| significant(1e3 * x, 3));
            writeln!(
                out,
                "{axle} axle: RMS on the held-out parts {before} mm with the plain model, {after} mm with the common model"
            )?;
        }
        for found in &self.effects {
            for (name, parameter) in &found.effect.parameters {
                writeln!(
                    out,
                    "  {} ({name}): {}",
                    found.effect.id,
                    parameter.quantity(name)
                )?;
            }
        }
        for ride in self.rides.iter().filter(|r| r.shows_more) {
            writeln!(
                out,
                "{} alone shows more: {}",
                ride.name, ride.alone_sentence
            )?;
        }
        let mut aside = self.left_aside.iter();
        aside.try_for_each(|a| writeln!(out, "excluded: {}: {}", a.name, a.why))
    }
}

fn row(out: &mut String, name: &str, axle: Axle, e: &Estimate) -> std::fmt::Result {
    let k = Number::measured(e.k_n_m, e.k_std_n_m);
    let b = Number::measured(e.b_n_s_m, e.b_std_n_s_m);
    writeln!(out, "{name:<24}{:<7}{k:>28}{b:>28}", axle.name())
}
