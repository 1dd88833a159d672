//! What is reported of one axle: where the plain model fails, what is left, what the omission changes, k and B.

use crate::decide::Decision;
use crate::explain::free_form::free_form;
use crate::explain::{evidence, locate, show};
use crate::prepare::Prepared;
use crate::search::null::FINEST;
use crate::verdict::judge::Judged;
use veloid_core::bicycle::Axle;
use veloid_core::numerics::finite::finite;
use veloid_methods::output_error::rms_valid;
use veloid_model::dataset::Track;
use veloid_model::fit::Motion;
use veloid_model::fit::estimate::estimate;
use veloid_report::Estimate;
use veloid_report::diagnosis::{
    Consequences, Evidence, FreeForm, HeldOut, Location, Rest, Verdict,
};

/// Why a stiffness has no interval.
const NO_SPRING: &str = "a model without a spring explains the record at least as well";

pub struct OnAxle {
    /// k and B of the extended model, where they are numbers.
    pub extended: Option<Estimate>,
    pub location: Location,
    pub held_out: HeldOut,
    /// What is left beside affirmed effects.
    pub rest: Option<Rest>,
    pub free_form: Option<FreeForm>,
    pub consequences: Consequences,
    pub evidence: Evidence,
    pub warnings: Vec<String>,
}

/// What everything that is reported of an axle is made from.
pub struct AxleReporter<'a> {
    pub prepared: &'a Prepared,
    pub decision: &'a Decision,
    /// The plain model's motion, by track.
    pub plain_motions: &'a [Motion],
    /// Significance level.
    pub alpha: f64,
    /// How often noise scores as the best effect that the model does not hold does on an axle.
    pub chance: &'a dyn Fn(&Track) -> Option<f64>,
}

impl AxleReporter<'_> {
    /// What is reported of the axle of track `t`; `has_mass`: whether its mass is known.
    pub fn axle(&self, t: usize, has_mass: bool) -> OnAxle {
        let decision = self.decision;
        let (axle, judged) = (self.name(t), &decision.judged[t]);
        let named = decision.model.terms.iter().any(|term| term.acts_on(axle));
        let (reported, consequences) = match named {
            true => self.extended(t),
            false => self.unchanged(t, has_mass),
        };
        let location = self.location(t);
        let is_certain = decision.certain.iter().any(|term| term.acts_on(axle));
        let has_rest =
            decision.verdict == Verdict::NamedInPart && (judged.remains || named && !is_certain);
        let unexplained = matches!(decision.verdict, Verdict::Unnamed | Verdict::NamedInPart);
        let (extended, warnings) = self.identified(t, reported);
        OnAxle {
            extended,
            warnings,
            rest: has_rest.then(|| rest(&location, &judged.held_out)),
            location,
            free_form: (unexplained && judged.remains).then(|| {
                free_form(
                    &self.prepared.dataset,
                    &decision.motions[t],
                    &judged.remainder,
                    t,
                )
            }),
            held_out: judged.held_out.clone(),
            consequences,
            evidence: self.evidence(t),
        }
    }

    fn name(&self, t: usize) -> Axle {
        self.prepared.dataset.tracks[t].axle
    }

    /// k and B beside the effects, and what the effects change.
    fn extended(&self, t: usize) -> (Estimate, Consequences) {
        let (record, decision) = (self.prepared.record(), self.decision);
        let before = estimate(record, &decision.shown_plain, t);
        let mut after = show::reported_estimate(record, &decision.corrected, t);
        if let Some([k, b]) = decision.base_errors.get(self.name(t)) {
            after.k_std_n_m = after.k_std_n_m.map(|std| std.max(*k));
            after.b_std_n_s_m = after.b_std_n_s_m.map(|std| std.max(*b));
        }
        let changes = show::consequences(
            &self.prepared.dataset,
            t,
            (&before, &self.plain_motions[t]),
            (&after, &decision.motions[t]),
        );
        (after, changes)
    }

    /// Where nothing is added the extended model is the plain one, and that is output error's: the noise under which names
    /// are sought may leave little of the record to measure by.
    fn unchanged(&self, t: usize, has_mass: bool) -> (Estimate, Consequences) {
        let Some(fit) = self.prepared.recorded.get(self.name(t)) else {
            return self.extended(t);
        };
        let record = self.prepared.record();
        let after = fit.estimate(has_mass);
        let motion = Motion::of_fit(&record.tracks[t], fit);
        let changes = show::consequences(record, t, (&after, &motion), (&after, &motion));
        (after, changes)
    }

    /// The estimate without intervals that would only pretend, and what there is to warn of.
    fn identified(&self, t: usize, estimate: Estimate) -> (Option<Estimate>, Vec<String>) {
        let axle = self.name(t);
        if !estimate.is_finite() {
            let warning = format!("{axle} axle: k and B of the extended model are not finite");
            return (None, vec![warning]);
        }
        let track = &self.prepared.dataset.tracks[t];
        let reported = match (track.input.prescribed, track.plant.has_spring()) {
            (true, _) => estimate.reportable_beside(track.scale.as_good_as_none()),
            (false, true) => estimate.reportable(),
            (false, false) => Estimate {
                k_std_n_m: None,
                k_not_identifiable: Some(NO_SPRING.to_owned()),
                ..estimate.reportable()
            },
        };
        let unknown = [
            ("B", &reported.b_not_identifiable),
            ("k", &reported.k_not_identifiable),
        ];
        let warning = |(name, why): (&str, &Option<String>)| {
            let why = why.as_ref()?;
            Some(format!(
                "{axle} axle: {name} is not identifiable on this ride: {why}"
            ))
        };
        let warnings = unknown.into_iter().filter_map(warning).collect();
        (Some(reported), warnings)
    }

    /// Where in the ride, at which frequencies and in which states the plain model fails.
    fn location(&self, t: usize) -> Location {
        let (decision, axle) = (self.decision, self.name(t));
        let judged = &decision.judged[t];
        let mut rounds = decision.rounds.iter().filter(|r| r.term.acts_on(axle));
        let accepted = rounds.find(|r| r.accepted);
        // What has no name lies at least where its nearest shape acts, and somewhere in any case.
        let nowhere = decision.model.terms.is_empty() && !decision.judged.iter().any(|j| j.remains);
        let shape = decision.verdict == Verdict::Unnamed
            && (nowhere || decision.model.terms.iter().any(|term| term.acts_on(axle)));
        let mismatch = accepted.is_some() || judged.remains || shape;
        let p_value = match (accepted, mismatch) {
            (Some(round), _) => round.p_value,
            (None, true) => judged.p_value,
            (None, false) => {
                (self.chance)(&self.prepared.dataset.tracks[t]).unwrap_or(judged.p_value)
            }
        };
        let found = Location {
            mismatch,
            p_value: finite(p_value.max(FINEST)).filter(|p| !mismatch || *p < self.alpha),
            ..Location::default()
        };
        if !found.mismatch {
            return found;
        }
        let dataset = &self.prepared.dataset;
        let track = &dataset.tracks[t];
        let fit = self.prepared.fits().get(axle);
        let plain = fit.map(|f| f.residual.clone()).unwrap_or_default();
        let left = self.noise(t);
        let (motion, alpha) = (&decision.motions[t], self.alpha);
        Location {
            windows_s: locate::windows(&plain, &left, &track.valid, dataset, alpha),
            bands_hz: locate::bands(&plain, &left, dataset.step, alpha),
            states: locate::states(
                &missing(judged, motion),
                motion,
                dataset,
                0..dataset.samples,
            ),
            ..found
        }
    }

    /// What a complete model would leave: the model's residual, brought down to the noise where something is left.
    fn noise(&self, t: usize) -> Vec<f64> {
        let track = &self.prepared.dataset.tracks[t];
        let judged = &self.decision.judged[t];
        let mut left = (self.decision.model).residual(&self.prepared.dataset, t);
        if judged.remains {
            let rms = rms_valid(&left, &track.valid, 0..left.len()).max(1e-300);
            let noise = (judged.floor / rms).min(1.0);
            left.iter_mut().for_each(|x| *x *= noise);
        }
        left
    }

    fn evidence(&self, t: usize) -> Evidence {
        let (record, decision) = (self.prepared.record(), self.decision);
        let track = &record.tracks[t];
        let [plain, left] =
            [&decision.shown_plain, &decision.shown].map(|model| model.residual(record, t));
        let estimate = estimate(record, &decision.shown_plain, t);
        Evidence {
            predicted: track.predicted(),
            worst: evidence::excerpt(track, &plain, &left),
            spectrum: evidence::residual_spectrum(track, &plain, &left),
            surface: evidence::surface(track, &self.plain_motions[t], &plain, &estimate),
        }
    }
}

/// What the plain model lacks, over the mass: what is named, and what is left.
fn missing(judged: &Judged, motion: &Motion) -> Vec<f64> {
    let named = motion.acceleration.iter().zip(&motion.linear);
    let named = named.map(|(a, linear)| a - linear);
    match judged.remains {
        true => (named.zip(&judged.remainder.force))
            .map(|(named, left)| named + left)
            .collect(),
        false => named.collect(),
    }
}

/// What is left on an axle, at the places in `found`.
fn rest(found: &Location, held_out: &HeldOut) -> Rest {
    let share = (held_out.extended_rms_m.zip(held_out.plain_rms_m))
        .and_then(|(extended, plain)| finite((extended / plain).powi(2)));
    Rest {
        share,
        windows_s: found.windows_s.clone(),
        bands_hz: found.bands_hz.clone(),
        states: found.states.clone(),
    }
}
