//! The report's `diagnosis` section.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;

use super::Estimate;
pub use super::parameter::{ParameterReport, Place};
use super::simulation::Simulation;
use super::tried::Tried;
use super::validation::Validation;
use super::windows::{Rule, Support, Windows, of_this_form};
use veloid_core::bicycle::PerAxle;
use veloid_core::document::format_number::significant;

/// Verdict of the diagnosis on physics beyond the plain spring and damper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The plain model explains the ride to within its noise.
    NothingMissing,
    /// One set of effects explains the ride, and no other does.
    Named,
    /// Every affirmed effect acts, and something else that has no name is left beside them.
    NamedInPart,
    /// Several sets explain it equally.
    Ambiguous,
    /// Something is left out that is not in the library.
    Unnamed,
    /// The record does not carry a verdict.
    CannotTell,
}

impl Verdict {
    /// Whether it speaks of effects by name, so that they are in the model of the result.
    pub fn names_effects(self) -> bool {
        matches!(self, Self::Named | Self::NamedInPart | Self::Ambiguous)
    }

    /// Every verdict by its name in reports.
    pub const NAMES: [&str; 6] = [
        "nothing_missing",
        "named",
        "named_in_part",
        "ambiguous",
        "unnamed",
        "cannot_tell",
    ];
}

/// Elements of the plain model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Base {
    /// k (u - z) + B (u' - z'): both act on the axle.
    #[default]
    SpringAndDamper,
    /// A mass on guides that a force moves and no spring brings back.
    Damper,
}

/// The report's `diagnosis` section.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(remote = "Self")]
pub struct Diagnosis {
    /// Whether something is missing, and whether it has a name.
    pub verdict: Verdict,
    /// The rule that gave the verdict; null in reports of earlier versions and where nothing was judged.
    #[serde(default)]
    pub rule: Option<Rule>,
    /// The verdict in plain words.
    pub sentence: String,
    /// Elements of the plain model to which effects were added: without a spring where that explains more.
    #[serde(default)]
    pub base: Base,
    /// Effects in the extended model; empty where the plain model is enough. Those with `affirmed` are part of the
    /// verdict, the others are only the nearest shapes.
    pub effects: Vec<EffectReport>,
    /// What remains with the affirmed effects of `named_in_part` in the model.
    #[serde(default)]
    pub rest: Option<PerAxle<Rest>>,
    /// Other sets of effects that explain the ride as well, simplest first, at most two.
    pub alternatives: Vec<Vec<EffectName>>,
    /// k and B with the effects in the model.
    pub extended: PerAxle<Estimate>,
    /// The model whose error is `held_out.<axle>.extended_rms_m`, with all that its simulation needs. Its numbers are the fit's,
    /// without the correction for noise of the road that `extended` and `effects` have. Absent with the verdict `cannot_tell`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<Simulation>,
    /// Limitations of the verdict, one sentence each.
    pub warnings: Vec<String>,
    /// Where along the ride, in which frequencies and in which states the plain model fails.
    #[serde(rename = "where")]
    pub location: PerAxle<Location>,
    /// Errors on the part of the ride that was not fitted.
    pub held_out: PerAxle<HeldOut>,
    /// What sets of effects leave of held-out parts of the record, from which the verdict is read; null where the likelihood alone
    /// decides.
    #[serde(default, deserialize_with = "windows")]
    pub windows: PerAxle<Windows>,
    /// What was fitted to the end, the answer first, at most 40; an entry for each place of a custom law is always among it.
    #[serde(default)]
    pub tried: Vec<Tried>,
    /// The ride that would distinguish the effects from the alternatives; null where there is nothing to distinguish or no
    /// planned ride would do it.
    pub next_ride: Option<NextRide>,
    /// Effects that this ride would have shown, with the smallest detectable size.
    pub detectable: Vec<Detectable>,
    /// Effects that this ride cannot show, with the missing channel.
    pub switched_off: Vec<SwitchedOff>,
    /// Free-form estimate of the missing force, where the verdict is `unnamed`.
    pub free_form: PerAxle<FreeForm>,
    /// Effect of the omission on peak load, resonance, k and B.
    pub consequences: PerAxle<Consequences>,
    /// The data of the verdict's figures.
    pub evidence: PerAxle<Evidence>,
    /// Cost of the search.
    #[serde(default)]
    pub search_cost: SearchCost,
    /// The models beside the record, until the report takes it as its own section.
    #[serde(default, skip_serializing_if = "PerAxle::is_empty")]
    #[cfg_attr(feature = "openapi", schema(ignore))]
    pub validation: PerAxle<Validation>,
}

/// Cost of the search for missing physics, in steps of the integrator, each for eight parameter sets on one axle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct SearchCost {
    /// Steps taken.
    pub steps: u64,
    /// Upper limit: the setting `search_budget` times the samples of all axles.
    pub budget: u64,
    /// Whether the search stopped at the limit, before it had tried everything.
    pub is_spent: bool,
}

impl Serialize for Diagnosis {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Diagnosis::serialize(self, serializer)
    }
}

impl<'de> Deserialize<'de> for Diagnosis {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut read = Diagnosis::deserialize(deserializer)?;
        if read.verdict == Verdict::Named {
            // Reports of versions that affirmed all or nothing do not say so of each effect.
            read.effects.iter_mut().for_each(|e| e.affirmed = true);
        }
        Ok(read)
    }
}

/// An effect and where it acts.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct EffectName {
    /// Id in the library, such as `coulomb_friction`, or that of the custom law.
    pub id: String,
    /// The axle or axles that it acts on.
    pub axle: Place,
}

/// An effect of the extended model with its fitted parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct EffectReport {
    /// Id in the library, such as `coulomb_friction`, or that of the custom law.
    pub id: String,
    /// The axle or axles that it acts on.
    pub axle: Place,
    /// Fitted parameters by name; docs/effects.md lists the names of each effect.
    pub parameters: BTreeMap<String, ParameterReport>,
    /// Probability (0 to 1) of a gain this large if the effect did not act; null where it cannot be computed.
    pub p_value: Option<f64>,
    /// Loss in log likelihood without this effect; null where no model without it could be fitted.
    pub separation: Option<f64>,
    /// Whether the verdict affirms the effect.
    #[serde(default)]
    pub affirmed: bool,
    /// Evidence for the effect although something else remains unexplained; absent where this was not evaluated.
    #[serde(
        default,
        deserialize_with = "of_this_form",
        skip_serializing_if = "Option::is_none"
    )]
    pub support: Option<Support>,
    /// False where the effect is only the nearest shape.
    pub adequate: bool,
    /// Whether the held-out error on an axle that it acts on would be larger by the materiality threshold without it.
    pub material: bool,
    /// The effect with its size and place, in words.
    pub sentence: String,
}

fn windows<'de, D: Deserializer<'de>>(deserializer: D) -> Result<PerAxle<Windows>, D::Error> {
    Ok(of_this_form(deserializer)?.unwrap_or_default())
}

impl Diagnosis {
    /// That a record carries no verdict, and why.
    pub fn without_verdict(why: String) -> Self {
        Self {
            verdict: Verdict::CannotTell,
            rule: None,
            sentence: why,
            base: Base::default(),
            effects: Vec::new(),
            rest: None,
            alternatives: Vec::new(),
            extended: PerAxle::default(),
            model: None,
            warnings: Vec::new(),
            location: PerAxle::default(),
            held_out: PerAxle::default(),
            windows: PerAxle::default(),
            tried: Vec::new(),
            next_ride: None,
            detectable: Vec::new(),
            switched_off: Vec::new(),
            free_form: PerAxle::default(),
            consequences: PerAxle::default(),
            evidence: PerAxle::default(),
            search_cost: SearchCost::default(),
            validation: PerAxle::default(),
        }
    }
}

impl Diagnosis {
    /// SI unit of errors on the held-out part.
    pub fn held_out_unit(&self) -> &'static str {
        let axle = self.held_out.iter().next();
        axle.map_or("m", |(_, held)| held.errors().1)
    }
}

impl EffectReport {
    /// The id and the place, without the numbers.
    pub fn name(&self) -> EffectName {
        EffectName {
            id: self.id.clone(),
            axle: self.axle,
        }
    }
}

/// What remains on one axle with the affirmed effects in the model.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Rest {
    /// Share of the plain model's squared held-out error that remains; null where a model diverges.
    pub share: Option<f64>,
    /// Stretches of time, from and to (s from the first sample), with a significant remainder.
    pub windows_s: Vec<[f64; 2]>,
    /// Frequency bands, from and to (Hz), with a significant remainder.
    pub bands_hz: Vec<[f64; 2]>,
    /// Regions of deflection, rate, speed, wheel and crank angle that contain most of the remainder, in words.
    pub states: Vec<String>,
}

/// Where the plain model fails on one axle.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Location {
    /// Whether the plain model misses more than noise explains, at the significance level `alpha` and confirmed by the held-out part.
    pub mismatch: bool,
    /// Probability (0 to 1), at most, of a mismatch as large as this one by noise alone: what a record cannot show between its samples
    /// counts as noise. Null where it cannot be computed, or where a mismatch is shown by something else, such as a resonance of what
    /// is left. Below `alpha` without a `mismatch`, the held-out part did not confirm what the search found, or next to no force is missing.
    pub p_value: Option<f64>,
    /// Stretches of time, from and to (s from the first sample), where the error is significantly larger than the
    /// extended model's.
    pub windows_s: Vec<[f64; 2]>,
    /// Frequency bands, from and to (Hz), where the error's spectrum is significantly above the extended model's.
    pub bands_hz: Vec<[f64; 2]>,
    /// Regions of deflection, rate, speed, wheel and crank angle, in words.
    pub states: Vec<String>,
}

impl Location {
    /// Whether there is a mismatch, in words, beside what its probability at the significance level `alpha` suggests.
    pub fn in_words(&self, alpha: f64) -> String {
        let p = |p: f64| format!("p = {}", significant(p, 2));
        let suggested = self.p_value.filter(|p| *p < alpha);
        match (self.mismatch, suggested) {
            (true, Some(small)) => format!("yes ({})", p(small)),
            (true, None) => {
                "yes, although no test of noise alone gives a small probability".to_owned()
            }
            (false, Some(small)) => format!(
                "not confirmed: noise alone would rarely show as much ({}), but the held-out part does not confirm it or next to no force \
                 is missing",
                p(small)
            ),
            (false, None) => match self.p_value {
                Some(large) => format!("none ({})", p(large)),
                None => "none".to_owned(),
            },
        }
    }
}

/// Errors of the plain and the extended model on the part of one axle's record to which neither was fitted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct HeldOut {
    /// RMS error (m) of the best plain model; null where it diverges.
    pub plain_rms_m: Option<f64>,
    /// RMS error (m) of the model with the effects; null where it diverges.
    pub extended_rms_m: Option<f64>,
    /// RMS of the displacement sensor's noise: declared in the bike file, or measured where the record contains nothing else.
    /// Never a model's residual; null where unknown.
    pub noise_floor_m: Option<f64>,
    /// Why `noise_floor_m` is null.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_floor_why: Option<String>,
    /// Quantity of these errors: where it is a force or an acceleration, they are in N or m/s^2, whatever the names of the fields.
    #[serde(default)]
    pub predicted: Predicted,
    /// Share of the explainable held-out variance that the effects remove; null where the noise floor is null or nothing could
    /// be explained.
    pub explained_share: Option<f64>,
    /// The held-out part of the ride, from and to (s).
    pub window_s: [f64; 2],
    /// If set, the errors are those of predictions over this time (s), each with its own initial state, in windows of the whole
    /// ride to which the models were not fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub horizon_s: Option<f64>,
}

impl HeldOut {
    /// Errors of the plain and the extended model, the sensor's noise, and the unit of all three.
    pub fn errors(&self) -> ([Option<f64>; 3], &'static str) {
        let errors = [self.plain_rms_m, self.extended_rms_m, self.noise_floor_m];
        (errors, self.predicted.unit())
    }
}

/// Quantity that a model predicts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Predicted {
    /// The displacement z of the axle (m).
    #[default]
    Displacement,
    /// The force (N) that answers to a prescribed motion.
    Force,
    /// The acceleration (m/s^2) of an axle on the road that the other axle's acceleration gives.
    Acceleration,
}

impl Predicted {
    /// SI unit of the predicted quantity.
    pub fn unit(self) -> &'static str {
        match self {
            Predicted::Displacement => "m",
            Predicted::Force => "N",
            Predicted::Acceleration => "m/s^2",
        }
    }
}

/// Of a list of planned rides, the one that takes the least time to distinguish sets of effects that explain this ride equally.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct NextRide {
    /// What this ride does not decide, in words.
    pub why: String,
    /// What to ride and how often, in words.
    pub what: String,
    /// Gain in log likelihood by which the planned rides are predicted to favour the right set.
    pub predicted_separation: f64,
    /// The same in numbers; absent from reports of versions that did not write them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plan: Option<RidePlan>,
}

/// A planned ride in numbers, relative to the ride that proposes it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct RidePlan {
    /// Times that it has to be recorded.
    pub times: u32,
    /// Duration of all of them together (s).
    pub duration_s: f64,
    /// Factor on the road's height, the force or the deflection of a release.
    pub rougher: f64,
    /// Factor on the speed, or on how fast a shaker runs.
    pub faster: f64,
    /// Share of the mean speed by which the speed swings to both sides; 0 for a steady one.
    pub swing: f64,
    /// Whether the cranks rest.
    pub coasting: bool,
}

/// Direction in which an effect is stronger: a stiffer spring has a larger k3, a wheel leaves the ground sooner under a smaller
/// load.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Stronger {
    /// When its parameter is larger.
    #[default]
    Larger,
    /// When its parameter is smaller.
    Smaller,
}

/// The smallest size of one effect that this ride would have shown.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Detectable {
    /// Id of the effect in the library.
    pub id: String,
    /// The axle or axles that it would act on.
    pub axle: Place,
    /// Name of the parameter that measures its size.
    pub parameter: String,
    /// The smallest detectable size (in `unit`), relative to no effect; null where no size is detectable.
    pub smallest_detectable: Option<f64>,
    /// Whether the effect is stronger when the parameter is larger or smaller.
    #[serde(default)]
    pub stronger: Stronger,
    /// Why no size is detectable.
    pub reason: Option<String>,
    /// SI unit of `smallest_detectable`.
    pub unit: String,
}

/// An effect that is not tested.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct SwitchedOff {
    /// Id of the effect in the library.
    pub id: String,
    /// What is missing, in words.
    pub why: String,
}

/// The missing force, estimated without a named effect. Empty where the model diverges.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct FreeForm {
    /// The coordinate that explains most: `deflection and rate`, `time`, `wheel angle` or `crank angle`.
    pub against: String,
    /// Grid of the deflection u - z (m): the columns of `force_n`.
    pub deflection_m: Vec<f64>,
    /// Grid of the deflection's rate (m/s): the rows of `force_n`.
    pub rate_m_s: Vec<f64>,
    /// Missing force (N) on the grid, one row for each rate.
    pub force_n: Vec<Vec<f64>>,
    /// Time from the first sample (s) of `force_along_n`, thinned for plotting.
    pub t_s: Vec<f64>,
    /// Missing force (N) along the ride.
    pub force_along_n: Vec<f64>,
    /// RMS error (m) on the held-out part with the free-form force in the model; null where the model diverges.
    pub held_out_rms_m: Option<f64>,
}

/// What the effects change for one axle; each value is null where a model diverges or does not define it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Consequences {
    /// Change of the stiffness k (%) when the effects are in the model.
    pub k_change_percent: Option<f64>,
    /// Change of the damping B (%) when the effects are in the model.
    pub b_change_percent: Option<f64>,
    /// Largest wheel load (N) along the ride by the plain model.
    pub peak_load_plain_n: Option<f64>,
    /// Largest wheel load (N) along the ride by the extended model.
    pub peak_load_extended_n: Option<f64>,
    /// Share (0 to 1) of the time that the wheel carries no load, by the extended model.
    pub airborne_share: Option<f64>,
    /// Undamped resonance sqrt(k/m)/2pi (Hz) by the plain model.
    pub resonance_plain_hz: Option<f64>,
    /// Undamped resonance sqrt(k/m)/2pi (Hz) by the extended model.
    pub resonance_extended_hz: Option<f64>,
}

/// Data for the figures that support the verdict.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Evidence {
    /// Quantity of `worst` and `spectrum`: in N and N^2/Hz where it is a force, in m/s^2 and their square for each Hz where it is an
    /// acceleration.
    #[serde(default)]
    pub predicted: Predicted,
    /// Measurement and models where the plain model's error is largest.
    pub worst: Excerpt,
    /// Spectra of the residuals of the plain and the extended model.
    pub spectrum: ResidualSpectrum,
    /// The force missing from the plain model, over deflection and rate.
    pub surface: Surface,
}

/// Measured and simulated displacement in the window where the plain model's error is largest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Excerpt {
    /// Time from the first sample (s).
    pub t_s: Vec<f64>,
    /// Measured displacement (m); null where the measurement is not trusted.
    pub measured_m: Vec<Option<f64>>,
    /// Displacement (m) of the plain model; null where it diverges.
    pub plain_m: Vec<Option<f64>>,
    /// Displacement (m) of the extended model; null where it diverges.
    pub extended_m: Vec<Option<f64>>,
}

/// Power spectral density of measured minus simulated displacement, along the whole ride.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ResidualSpectrum {
    /// Centres of the bands (Hz), ascending, in nearly equal ratios.
    pub frequency_hz: Vec<f64>,
    /// Density (m^2/Hz) of the plain model's residual; null where it diverges.
    pub plain_m2_hz: Vec<Option<f64>>,
    /// Density (m^2/Hz) of the extended model's residual; null where it diverges.
    pub extended_m2_hz: Vec<Option<f64>>,
}

/// The force missing from the plain spring and damper, m r'' + B r' + k r with r measured minus simulated, against the measured
/// deflection u - z and its rate. A cell contains the mean of its samples.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Surface {
    /// Centres of the cells along the deflection (m): the columns of the grids.
    pub deflection_m: Vec<f64>,
    /// Centres of the cells along the rate (m/s): the rows of the grids.
    pub rate_m_s: Vec<f64>,
    /// Missing force (N), row by row of rate; null in cells with fewer than three samples.
    pub lacking_n: Vec<Vec<Option<f64>>>,
    /// k d + B w of the plain model at the cells' centres (N).
    pub plain_n: Vec<Vec<f64>>,
    /// Number of samples in each cell, row by row of rate.
    pub samples: Vec<Vec<usize>>,
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Also of reports that earlier versions stored with numbers that did not agree.
    #[test]
    fn a_mismatch_is_worded_as_its_probability_is() {
        let said = |mismatch, p_value, alpha| {
            let place = Location {
                mismatch,
                p_value,
                ..Location::default()
            };
            place.in_words(alpha)
        };
        assert_eq!(said(true, Some(5e-4), 0.01), "yes (p = 5.0e-4)");
        for unshown in [Some(0.53), None] {
            let words = said(true, unshown, 0.01);
            assert!(words.starts_with("yes, although") && !words.contains("0.53"));
        }
        assert_eq!(said(false, Some(0.53), 0.01), "none (p = 0.53)");
        assert!(said(false, Some(5e-4), 0.01).starts_with("not confirmed"));
        assert_eq!(said(false, Some(5e-4), 1e-4), "none (p = 5.0e-4)");
    }

    #[test]
    fn a_report_from_before_effects_were_affirmed_one_by_one_still_affirms_what_it_names() {
        for (verdict, affirmed) in [(Verdict::Named, true), (Verdict::Unnamed, false)] {
            let effect = serde_json::json!({
                "id": "cubic_stiffness", "axle": "front", "parameters": {}, "p_value": null, "separation": null,
                "adequate": affirmed, "material": true, "sentence": "",
            });
            let mut old = serde_json::to_value(Diagnosis::without_verdict(String::new())).unwrap();
            old["verdict"] = serde_json::to_value(verdict).unwrap();
            old["effects"] = serde_json::json!([effect]);
            old.as_object_mut().unwrap().remove("rest");
            let read: Diagnosis = serde_json::from_value(old).unwrap();
            assert_eq!(read.effects[0].affirmed, affirmed, "{verdict:?}");
        }
    }
}
