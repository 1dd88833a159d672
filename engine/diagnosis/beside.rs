//! The plain model, and the one with effects that the result comes from, beside the record.

use crate::decide::Decision;
use crate::prepare::Prepared;
use veloid_core::bicycle::PerAxle;
use veloid_inside::{Extended, Models, Record, validation};
use veloid_model::fit::{Model, motions};
use veloid_report::diagnosis::Verdict;
use veloid_report::validation::Validation;

/// Of every axle of the record itself.
pub fn validations(
    prepared: &Prepared,
    decision: &Decision,
    verdict: Verdict,
) -> PerAxle<Validation> {
    let record = prepared.record();
    let model =
        (Some(&decision.shown)).filter(|model| verdict.names_effects() && !model.terms.is_empty());
    let moved = model.map(|model| motions(record, model));
    let mut found = PerAxle::default();
    for (t, track) in record.tracks.iter().enumerate() {
        let Some(plain) = prepared.recorded.get(track.axle) else {
            continue;
        };
        let acts = |model: &&Model| model.terms.iter().any(|term| term.acts_on(track.axle));
        let extended = model
            .filter(acts)
            .zip(moved.as_ref())
            .map(|(model, moved)| {
                let (fit, a) = model.of_track(t);
                Extended {
                    base: fit.point.base[a],
                    residual: model.residual(record, t),
                    deflection: moved[t].d.clone(),
                    rate: moved[t].w.clone(),
                    acceleration: moved[t].acceleration.clone(),
                }
            });
        let record = Record {
            measured: &track.measured,
            valid: &track.valid,
            input: &track.input,
            has_road: track.has_road,
            train: prepared.split.train.clone(),
        };
        found.set(track.axle, validation(&record, &Models { plain, extended }));
    }
    found
}
