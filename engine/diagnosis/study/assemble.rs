//! What was found over several rides as a report.

use std::collections::BTreeMap;

use crate::explain::show;
use crate::search::null::FINEST;
use crate::study::acting::{Support, acting, effort, of_tracks};
use crate::study::ready::Ready;
use crate::study::rounds::{Found, Joint, Rides, settled, sum};
use crate::verdict::effect_report;
use veloid_core::EngineError;
use veloid_core::bicycle::{Axle, PerAxle};
use veloid_core::document::format_number::WIDE;
use veloid_core::numerics::finite::finite;
use veloid_core::numerics::statistics::chi_square_tail;
use veloid_core::plant::Coefficient;
use veloid_core::settings::Settings;
use veloid_model::fit::together::Common;
use veloid_model::fit::{Effort, Model, Slot};
use veloid_report::diagnosis::{EffectName, EffectReport, ParameterReport, Verdict};
use veloid_report::study::{LeftAside, StudyAxle, StudyEffect, StudyReport, StudyRide};
use veloid_report::{Estimate, Parameters};

/// The report of a study.
pub fn assemble(
    study: &Rides,
    rides: &[Ready],
    found: Found,
    left_aside: Vec<LeftAside>,
    settings: &Settings,
) -> Result<StudyReport, EngineError> {
    let alone: Vec<&[EffectReport]> = rides.iter().map(|r| &r.alone.effects[..]).collect();
    let (own, supports) = acting(study, found.joint, &alone);
    let (own, whole, differs) = as_one(study, own);
    let dataset = study.searches[0].fitter.dataset;
    let mut axles = PerAxle::default();
    for (t, track) in dataset.tracks.iter().enumerate() {
        let common = differs[t].is_some_and(|p| p >= settings.alpha);
        let rms = |joint: Option<&Joint>| held_rms(study, joint, t);
        axles.set(
            track.axle,
            StudyAxle {
                estimate: common.then(|| pooled(rides, &own, &whole, t)),
                differs_p_value: differs[t].and_then(finite),
                plain_held_out_m: rms(None),
                held_out_m: rms(Some(&whole)),
            },
        );
    }
    let effects: Vec<StudyEffect> = (supports.iter())
        .filter_map(|s| effect(study, rides, &own, &whole, s, !found.tied.is_empty()))
        .collect();
    let alternatives: Vec<Vec<EffectName>> = (found.tied.iter())
        .map(|joint| {
            joint
                .terms()
                .iter()
                .map(|t| show::name(dataset, t))
                .collect()
        })
        .collect();
    let common: Vec<EffectName> = (effects.iter())
        .filter(|e| e.only_in.is_none())
        .map(|e| e.effect.name())
        .chain(alternatives.iter().flatten().cloned())
        .collect();
    let reported = |(r, ride): (usize, &Ready)| reported_ride(ride, &own.models[r], &common);
    let reported: Vec<StudyRide> = rides.iter().enumerate().map(reported).collect();
    let verdict = verdict(&effects, &reported);
    let report = StudyReport {
        veloid: env!("CARGO_PKG_VERSION").to_owned(),
        settings: settings.clone(),
        verdict,
        sentence: String::new(),
        effects,
        alternatives,
        axles,
        rides: reported,
        left_aside,
        single_rides: study.candidates().1,
    };
    Ok(StudyReport {
        sentence: sentence(&report),
        ..report
    })
}

/// k and B of all rides, with what moves them alike on all rides, which more rides do not average out, and what moves them on each, which
/// they do.
fn pooled(rides: &[Ready], own: &Joint, whole: &Joint, t: usize) -> Estimate {
    let dataset = &rides[0].dataset;
    let model = &whole.models[0];
    let axle = dataset.tracks[t].axle;
    let n = rides.len() as f64;
    let sizes = |of: &dyn Fn(&Ready) -> &PerAxle<Parameters>| -> Vec<Parameters> {
        let sizes = rides.iter().filter_map(|ride| of(ride).get(axle));
        sizes.cloned().collect()
    };
    let mean = |by: &[Parameters]| Parameters {
        k_n_m: by.iter().map(|by| by.k_n_m).sum::<f64>() / n,
        b_n_s_m: by.iter().map(|by| by.b_n_s_m).sum::<f64>() / n,
    };
    let averaged = |by: &[Parameters]| Parameters {
        k_n_m: by.iter().map(|by| by.k_n_m.powi(2)).sum::<f64>().sqrt() / n,
        b_n_s_m: by.iter().map(|by| by.b_n_s_m.powi(2)).sum::<f64>().sqrt() / n,
    };
    let mut found = show::reported_estimate(dataset, model, t);
    if is_plain(model, axle) {
        let each = rides.iter().zip(&own.models);
        let errors: Vec<[[f64; 2]; 2]> = each.filter_map(|(r, m)| errors(r, m, t)).collect();
        let [k, b] = [0, 1].map(|i| excess(errors.iter().map(|e| e[i])));
        found.k_std_n_m = found.k_std_n_m.map(|std| k * std);
        found.b_std_n_s_m = found.b_std_n_s_m.map(|std| b * std);
    }
    let found = found
        .widened(&mean(&sizes(&|ride| &ride.interpolation)))
        .widened(&mean(&sizes(&|ride| &ride.mass)))
        .widened(&averaged(&sizes(&|ride| &ride.laser)));
    match is_plain(model, axle) {
        true => found.widened(&averaged(&sizes(&|ride| &ride.road_noise))),
        false => found,
    }
}

/// Errors of k and of B on one ride, each whitened and as output error has it, which is not less, for as many ring-downs as the ride has.
fn errors(ride: &Ready, model: &Model, t: usize) -> Option<[[f64; 2]; 2]> {
    let whitened = show::reported_estimate(&ride.dataset, model, t);
    let plain = ride.output_error.get(ride.dataset.tracks[t].axle)?;
    let duration_s = ride.dataset.samples as f64 * ride.dataset.step;
    let few = few_pieces(duration_s * plain.b_n_s_m.abs() / (2.0 * plain.mass_kg));
    let pair = |own: Option<f64>, plain: Option<f64>| Some([own?, few * own?.max(plain?)]);
    Some([
        pair(whitened.k_std_n_m, plain.k_std_n_m)?,
        pair(whitened.b_std_n_s_m, plain.b_std_n_s_m)?,
    ])
}

/// How much wider an interval is where the residual has only so many independent pieces, one for each time in which the axle's free motion
/// decays by e: Student's t with as many degrees of freedom less the four numbers that are fitted (k, B, position and velocity at the
/// start), by its expansion about the normal quantile (Abramowitz and Stegun 26.7.5). An axle that no mass moves on has no such time.
fn few_pieces(pieces: f64) -> f64 {
    const FITTED: f64 = 4.0;
    if !pieces.is_finite() {
        return 1.0;
    }
    let freedom = (pieces - FITTED).max(1.0);
    let z = WIDE;
    let quantile = z
        + (z.powi(3) + z) / (4.0 * freedom)
        + (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * freedom.powi(2));
    quantile / z * ((freedom + FITTED) / freedom).sqrt()
}

/// How much larger the error of a mean is that weighs rides by their whitened errors, where their errors are the others.
fn excess(errors: impl Iterator<Item = [f64; 2]> + Clone) -> f64 {
    let weights: f64 = errors.clone().map(|[own, _]| own.powi(-2)).sum();
    let squares: f64 = errors.map(|[own, all]| (all / own.powi(2)).powi(2)).sum();
    match weights > 0.0 && weights.is_finite() {
        true => (squares / weights).sqrt().max(1.0),
        false => 1.0,
    }
}

/// k and B of one ride beside what is common.
fn on_ride(ride: &Ready, model: &Model, t: usize) -> Estimate {
    let axle = ride.dataset.tracks[t].axle;
    let noise = is_plain(model, axle).then_some(&ride.road_noise);
    let moved = [&ride.interpolation, &ride.mass, &ride.laser];
    let moved = moved.into_iter().chain(noise);
    let mut found = show::reported_estimate(&ride.dataset, model, t);
    if let Some([[_, k], [_, b]]) = errors(ride, model, t).filter(|_| is_plain(model, axle)) {
        (found.k_std_n_m, found.b_std_n_s_m) = (Some(k), Some(b));
    }
    moved
        .filter_map(|by| by.get(axle))
        .fold(found.reportable(), |found, by| found.widened(by))
}

/// Whether no effect acts on an axle; effects that do are corrected for noise of the road.
fn is_plain(model: &Model, axle: Axle) -> bool {
    !model.terms.iter().any(|term| term.acts_on(axle))
}

/// The rides fitted once more as accurately as they allow, the same with k and B in common on the axles where they bear that, and by
/// track how often chance makes them differ so.
fn as_one(study: &Rides, mut own: Joint) -> (Joint, Joint, Vec<Option<f64>>) {
    let usual = effort(study, &own);
    let mut differs = vec![None; study.searches[0].fitter.dataset.tracks.len()];
    let mut whole = own.clone();
    for fit in own.models[0].fits.clone() {
        let Some(fits) = of_tracks(&own, &fit.unit.tracks) else {
            continue;
        };
        let substeps = study.searches.iter().zip(&fits);
        let substeps =
            substeps.map(|(search, f)| f.unit.accurate_substeps(search.fitter.dataset, &f.point));
        let effort = Effort {
            substeps: substeps.fold(usual.substeps, usize::max),
            ..usual
        };
        let starts: Vec<_> = fits.iter().map(|f| f.point.clone()).collect();
        let noise_models: Vec<_> = fits.iter().map(|f| f.noise_models.clone()).collect();
        let fitted = |common: Common| {
            let units = fits.iter().map(|f| f.unit.clone()).collect();
            let together = study.together(units, common, &own.own);
            let fits = together.fit(&starts, &noise_models, effort)?;
            settled(&together, fits, effort)
        };
        let (Some(apart), Some(one)) = (fitted(Common::Effects), fitted(Common::EffectsAndAxles))
        else {
            continue;
        };
        let base = |s: &Slot| {
            matches!(
                s,
                Slot::Base(
                    _,
                    Coefficient::Kappa | Coefficient::Beta | Coefficient::PerMass
                )
            )
        };
        let slots = fit.unit.slots(study.searches[0].fitter.dataset);
        let freedom = slots.iter().filter(|s| base(s)).count() * (study.searches.len() - 1);
        let p = chi_square_tail(2.0 * (sum(&apart) - sum(&one)).max(0.0), freedom as f64);
        for t in &fit.unit.tracks {
            differs[*t] = Some(p);
        }
        whole = whole.with(match p >= study.alpha {
            true => one,
            false => apart.clone(),
        });
        own = own.with(apart);
    }
    (own, whole, differs)
}

/// RMS of what is left of all held-out parts on one track, of the plain models where none is given.
fn held_rms(study: &Rides, joint: Option<&Joint>, t: usize) -> f64 {
    let mut squares = 0.0;
    let mut samples = 0;
    for (r, search) in study.searches.iter().enumerate() {
        let model = joint.map_or(&search.plain, |joint| &joint.models[r]);
        squares += search.held_squares(model)[t];
        let valid = &search.fitter.dataset.tracks[t].valid[search.held.clone()];
        samples += valid.iter().filter(|v| **v).count();
    }
    (squares / samples.max(1) as f64).sqrt()
}

/// One effect over all rides.
fn effect(
    study: &Rides,
    rides: &[Ready],
    own: &Joint,
    whole: &Joint,
    support: &Support,
    is_tied: bool,
) -> Option<StudyEffect> {
    let term = support.term;
    let found = own.p_values.iter().find(|(t, _)| *t == term);
    let p_value = found.and_then(|(_, p)| finite(p.max(FINEST)));
    let acting: Vec<usize> = (0..rides.len()).filter(|r| support.acts[*r]).collect();
    let gains = &support.gains;
    // Where rides differ in it, that of the ride that shows it most.
    let shown = match support.differs {
        Some(p) if p >= study.alpha => 0,
        _ => *(acting.iter()).max_by(|a, b| gains[**a].total_cmp(&gains[**b]))?,
    };
    let dataset = study.searches[shown].fitter.dataset;
    let total = gains.iter().sum();
    let mut reported =
        effect_report::effect(dataset, &whole.models[shown], &term, Some(total), p_value)?;
    reported.affirmed = !is_tied && acting.len() > 1;
    let parameters = |r: usize| -> BTreeMap<String, ParameterReport> {
        let dataset = study.searches[r].fitter.dataset;
        let found = support.alone[r].as_ref().and_then(|fit| {
            effect_report::effect(dataset, &own.models[r].with(fit.clone()), &term, None, None)
        });
        found.map_or_else(BTreeMap::new, |e| e.parameters)
    };
    Some(StudyEffect {
        effect: reported,
        by_ride: (0..rides.len()).map(parameters).collect(),
        gain_by_ride: gains.clone(),
        differs_p_value: support.differs.and_then(finite),
        acts_in: acting.iter().map(|r| rides[*r].name.clone()).collect(),
        only_in: match acting[..] {
            [only] => Some(rides[only].name.clone()),
            _ => None,
        },
    })
}

/// One ride beside what is common, be it named alone or one of several sets.
fn reported_ride(ride: &Ready, model: &Model, common: &[EffectName]) -> StudyRide {
    let mut axles = PerAxle::default();
    for (t, track) in ride.dataset.tracks.iter().enumerate() {
        axles.set(track.axle, on_ride(ride, model, t));
    }
    let alone = &ride.alone;
    let is_common = |effects: &[EffectName]| effects.iter().all(|e| common.contains(e));
    let found: Vec<EffectName> = alone.effects.iter().map(EffectReport::name).collect();
    let shows_more = match alone.verdict {
        Verdict::NothingMissing | Verdict::CannotTell => false,
        Verdict::Named => !is_common(&found),
        // Which of several it is, the common model may have settled.
        Verdict::Ambiguous => {
            !is_common(&found) && !alone.alternatives.iter().any(|set| is_common(set))
        }
        Verdict::NamedInPart | Verdict::Unnamed => true,
    };
    StudyRide {
        name: ride.name.clone(),
        axles,
        alone: alone.verdict,
        alone_sentence: alone.sentence.clone(),
        shows_more,
        warnings: ride.warnings.clone(),
    }
}

/// Something is left without a name where more than half of the rides show more than is explained, be it by an effect of one ride's own.
fn verdict(effects: &[StudyEffect], rides: &[StudyRide]) -> Verdict {
    let has_its_own = |ride: &&StudyRide| {
        let mut own = effects.iter().filter_map(|e| e.only_in.as_ref());
        ride.alone == Verdict::Named && own.any(|only| *only == ride.name)
    };
    let more = rides
        .iter()
        .filter(|r| r.shows_more && !has_its_own(r))
        .count();
    let affirmed = effects.iter().any(|e| e.effect.affirmed);
    // What one ride alone shows is not in common, whatever else it might be.
    let in_common = effects.iter().any(|e| e.only_in.is_none());
    match (2 * more > rides.len(), affirmed, in_common) {
        (true, true, _) => Verdict::NamedInPart,
        (true, false, _) => Verdict::Unnamed,
        (false, true, _) => Verdict::Named,
        (false, false, true) => Verdict::Ambiguous,
        (false, false, false) => Verdict::NothingMissing,
    }
}

fn sentence(report: &StudyReport) -> String {
    let n = report.rides.len();
    let said: Vec<String> = (report.effects.iter())
        .map(|e| match &e.only_in {
            Some(ride) => format!(
                "{} (only {ride} shows it, so it is specific to that ride)",
                e.effect.sentence
            ),
            None if e.acts_in.len() < n => format!(
                "{} (it acts in {} of the rides: {})",
                e.effect.sentence,
                e.acts_in.len(),
                e.acts_in.join(", ")
            ),
            None => e.effect.sentence.clone(),
        })
        .collect();
    let said = said.join("; ");
    match report.verdict {
        Verdict::Named => {
            format!("{n} rides share physics that the plain model leaves out: {said}.")
        }
        Verdict::NamedInPart => format!(
            "{n} rides share physics that the plain model leaves out: {said}. Most of them show more, without a name."
        ),
        Verdict::Ambiguous => {
            let others = report.alternatives.iter().map(|set| {
                let each = set.iter().map(|e| format!("{} ({})", e.id, e.axle.name()));
                each.collect::<Vec<_>>().join(" with ")
            });
            let others = others.collect::<Vec<_>>().join("; or ");
            format!(
                "{n} rides share something that the plain model leaves out, and several sets of effects explain it equally well: {said}; or {others}."
            )
        }
        Verdict::Unnamed => format!(
            "Most of {n} rides show something that the plain model leaves out and that no common effect explains."
        ),
        Verdict::NothingMissing | Verdict::CannotTell if said.is_empty() => {
            format!("The plain model explains what {n} rides have in common; nothing is missing.")
        }
        Verdict::NothingMissing | Verdict::CannotTell => {
            format!("The plain model explains what {n} rides have in common. It leaves out {said}.")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use veloid_report::diagnosis::Place;

    #[test]
    fn few_ring_downs_widen_an_interval_as_students_t_does() {
        // Quantiles of Student's t at 97.5 % with 8, 20 and 146 degrees of freedom.
        for (pieces, quantile) in [(12.0, 2.306), (24.0, 2.086), (150.0, 1.976)] {
            let expected = quantile / WIDE * f64::sqrt(pieces / (pieces - 4.0));
            assert!(
                (few_pieces(pieces) / expected - 1.0).abs() < 4e-3,
                "{pieces}"
            );
        }
        assert_eq!(few_pieces(f64::INFINITY), 1.0);
        assert!(few_pieces(0.0) > 5.0);
    }

    #[test]
    fn an_error_that_all_rides_lack_widens_their_mean_by_as_much() {
        let alike = [[1.0, 2.0]; 4];
        assert!((excess(alike.into_iter()) - 2.0).abs() < 1e-12);
        assert_eq!(excess([[1.0, 1.0], [3.0, 3.0]].into_iter()), 1.0);
        // A ride of little weight adds little.
        let one = excess([[1.0, 1.0], [10.0, 20.0]].into_iter());
        assert!(one > 1.0 && one < 1.02, "{one}");
        assert_eq!(excess(std::iter::empty()), 1.0);
    }

    fn effect(affirmed: bool, only_in: Option<&str>) -> StudyEffect {
        StudyEffect {
            effect: EffectReport {
                id: "cubic_stiffness".to_owned(),
                axle: Place::Front,
                parameters: BTreeMap::new(),
                p_value: None,
                separation: None,
                affirmed,
                support: None,
                adequate: true,
                material: true,
                sentence: "the spring stiffens".to_owned(),
            },
            by_ride: Vec::new(),
            gain_by_ride: Vec::new(),
            differs_p_value: None,
            acts_in: match only_in {
                Some(only) => vec![only.to_owned()],
                None => (0..4).map(|i| format!("ride {i}")).collect(),
            },
            only_in: only_in.map(str::to_owned),
        }
    }

    /// So many rides, of which some show more than is explained.
    fn rides(all: usize, more: usize) -> Vec<StudyRide> {
        let ride = |r| StudyRide {
            name: format!("ride {r}"),
            axles: PerAxle::default(),
            alone: Verdict::Unnamed,
            alone_sentence: String::new(),
            shows_more: r < more,
            warnings: Vec::new(),
        };
        (0..all).map(ride).collect()
    }

    #[test]
    fn something_is_left_without_a_name_where_more_than_half_of_the_rides_show_it() {
        let named = [effect(true, None)];
        assert_eq!(verdict(&named, &rides(4, 2)), Verdict::Named);
        assert_eq!(verdict(&named, &rides(4, 3)), Verdict::NamedInPart);
        assert_eq!(verdict(&[], &rides(4, 2)), Verdict::NothingMissing);
        assert_eq!(verdict(&[], &rides(4, 3)), Verdict::Unnamed);
    }

    #[test]
    fn what_one_ride_alone_shows_is_not_in_common() {
        let own = [effect(false, Some("ride 2"))];
        assert_eq!(verdict(&own, &rides(4, 0)), Verdict::NothingMissing);
        let tied = [effect(false, None)];
        assert_eq!(verdict(&tied, &rides(4, 0)), Verdict::Ambiguous);
    }

    #[test]
    fn what_an_effect_of_its_own_explains_is_not_left_without_a_name() {
        let own = [effect(false, Some("ride 0")), effect(false, Some("ride 1"))];
        let mut three = rides(4, 3);
        assert_eq!(verdict(&own, &three), Verdict::Unnamed);
        for ride in &mut three[..2] {
            ride.alone = Verdict::Named;
        }
        assert_eq!(verdict(&own, &three), Verdict::NothingMissing);
        assert_eq!(verdict(&own[..1], &rides(4, 4)), Verdict::Unnamed);
    }

    #[test]
    fn a_sentence_says_how_many_rides_and_whose_affair_an_effect_is() {
        let said = |verdict, effects: Vec<StudyEffect>| {
            sentence(&StudyReport {
                veloid: String::new(),
                settings: Settings::default(),
                verdict,
                sentence: String::new(),
                effects,
                alternatives: vec![vec![EffectName {
                    id: "bump_stop".to_owned(),
                    axle: Place::Rear,
                }]],
                axles: PerAxle::default(),
                rides: rides(4, 0),
                left_aside: Vec::new(),
                single_rides: Vec::new(),
            })
        };
        let named = said(Verdict::Named, vec![effect(true, None)]);
        assert!(
            named.starts_with("4 rides") && named.contains("the spring stiffens."),
            "{named}"
        );
        let own = said(Verdict::NothingMissing, vec![effect(false, Some("ride 2"))]);
        assert!(own.contains("(only ride 2 shows it"), "{own}");
        let mut some = effect(true, None);
        some.acts_in.truncate(2);
        let some = said(Verdict::Named, vec![some]);
        assert!(
            some.contains("(it acts in 2 of the rides: ride 0, ride 1)"),
            "{some}"
        );
        let nothing = said(Verdict::NothingMissing, Vec::new());
        assert!(nothing.ends_with("nothing is missing."), "{nothing}");
        let tied = said(Verdict::Ambiguous, vec![effect(false, None)]);
        assert!(tied.contains("; or bump_stop (rear)"), "{tied}");
    }
}
