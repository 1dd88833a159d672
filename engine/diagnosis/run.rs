//! The diagnosis from start to finish.

use std::ops::Range;

use crate::EngineError;
use crate::bicycle::{Axle, Bike, PerAxle};
use crate::diagnosis::dataset::Scene;
use crate::diagnosis::dataset::dither::{dither, lay_over};
use crate::diagnosis::explain::detectable::detectable;
use crate::diagnosis::explain::free_form::free_form;
use crate::diagnosis::explain::{input_noise, locate, next_ride, show, words};
use crate::diagnosis::fit::estimate::estimate;
use crate::diagnosis::fit::model::stable_substeps;
use crate::diagnosis::fit::physical::is_physical;
use crate::diagnosis::fit::polish::polish;
use crate::diagnosis::fit::refine::finer;
use crate::diagnosis::fit::{Effort, FINE, Fitter, Model, Motion, Point, Term, Unit, motions};
use crate::diagnosis::search::criteria::ADEQUATE;
use crate::diagnosis::search::extend::candidates;
use crate::diagnosis::search::null::FINEST;
use crate::diagnosis::search::{Named, Round, Search};
use crate::diagnosis::verdict::carries::{has_size, why_not};
use crate::diagnosis::verdict::general_laws::{dominates, is_curve, is_outgrown};
use crate::diagnosis::verdict::judge::{Judged, held_rms, judge};
use crate::diagnosis::verdict::partly::partly;
use crate::finite::finite;
use crate::numerics::autoregressive::Colour;
use crate::numerics::spectrum;
use crate::output_error::start::starts_from;
use crate::output_error::{self, Split, rms_valid};
use crate::progress::Progress;
use crate::report::Estimate;
use crate::report::diagnosis::{
    Diagnosis, EffectReport, Evidence, Excerpt, HeldOut, Location, ResidualSpectrum, Rest, Surface,
    Verdict,
};
use crate::report::stages::Conclusion;
use crate::ride::{AxleRecord, Ride, decimated};
use crate::settings::Settings;

/// A model explains a ride as well as another if it is behind by no more than this in log likelihood.
const TIE: f64 = 4.0;
/// A model stands in for one outside its physical ranges if it is behind by no more than this in log
/// likelihood.
const NEARLY: f64 = 70.0;

/// Says what physics the plain model leaves out of a ride.
pub fn diagnose(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    conclusion: &Conclusion,
    progress: &dyn Progress,
) -> Result<Diagnosis, EngineError> {
    let slower = decimated(ride, fastest(ride));
    let ride = slower.as_ref().unwrap_or(ride);
    let split = Split::of(ride, settings);
    // Every axle for itself: what one pair for both cannot say is not missing physics.
    let separate = Bike {
        equal_axles: false,
        ..bike.clone()
    };
    let starts = [
        starts_from(&conclusion.output_error),
        starts_from(&conclusion.instrumental),
    ];
    let recorded = output_error::fit(ride, &separate, settings, &starts)?;
    let dither = dither(ride, &separate, &recorded, split.train.end, settings.seed);
    let dithered = lay_over(ride, &dither);
    let refitted = (dithered.as_ref())
        .map(|ride| output_error::fit(ride, &separate, settings, &starts))
        .transpose()?;
    let fits = refitted.as_ref().unwrap_or(&recorded);
    let ride = dithered.as_ref().unwrap_or(ride);
    let scene = Scene::new(ride, &separate, fits, split.train.end);
    let fitter = Fitter {
        scene: &scene,
        samples: split.train.end,
    };
    let plain = plain_model(&fitter, fits)?;
    let (terms, switched_off) = candidates(&scene);
    let search = Search {
        fitter: Fitter {
            scene: &scene,
            samples: split.train.end,
        },
        plain: plain.clone(),
        held: split.held.clone(),
        candidates: terms,
        alpha: settings.alpha,
        seed: settings.seed,
        progress,
    };
    let Named {
        model: found,
        rounds,
        rivals,
        ..
    } = search.run()?;
    let mut rivals = rivals;
    if !is_physical(&scene, &plain, &found) && found.terms.len() > 1 {
        rivals.extend(search.without_each(&found));
        rivals.sort_by(|a, b| b.likelihood.total_cmp(&a.likelihood));
    }
    let physical: Vec<&Model> = rivals
        .iter()
        .filter(|r| is_physical(&scene, &plain, r))
        .collect();
    // A model that no bicycle can have gives way to one that explains the ride nearly as well.
    let model = if is_physical(&scene, &plain, &found) {
        found
    } else {
        let near = physical.iter().find(|r| ties(&search, &found, r, NEARLY));
        near.map_or(found, |r| (*r).clone())
    };
    let tied: Vec<&Model> = physical
        .into_iter()
        .filter(|r| r.terms != model.terms && ties(&search, &model, r, TIE))
        .take(2)
        .collect();
    let finest = finer(&fitter, &model);
    let mut model = if search.held_score(&finest).is_finite() {
        finest
    } else {
        model
    };
    // What was found is measured on the record itself.
    let undithered = dithered.as_ref().map(|_| scene.without(&dither));
    let record = undithered.as_ref().unwrap_or(&scene);
    let on_record = Fitter {
        scene: record,
        samples: split.train.end,
    };
    let (mut shown_plain, mut shown) = if dithered.is_some() {
        let settled = polish(&on_record, &model, search.thorough(&model));
        let mut shown = finer(&on_record, settled.as_ref().unwrap_or(&model));
        // What lies between the samples is no noise: how far it may lead, the dithered fit tells.
        for (shown, dithered) in shown.fits.iter_mut().zip(&model.fits) {
            shown.covariance = dithered.covariance.clone();
        }
        (plain_model(&on_record, &recorded)?, shown)
    } else {
        (plain.clone(), model.clone())
    };
    let judging = |model: &Model, motions: &[Motion], shown: &Model| -> Vec<Judged> {
        (0..scene.tracks.len())
            .map(|t| {
                let shown = undithered.as_ref().map(|record| (record, shown));
                judge(
                    &fitter,
                    &recorded,
                    (model, motions),
                    shown,
                    t,
                    &split,
                    settings,
                )
            })
            .collect()
    };
    let plain_motions = motions(&scene, &plain);
    let mut model_motions = motions(&scene, &model);
    let mut judged = judging(&model, &model_motions, &shown);
    let adequate = judged.iter().all(|j| !j.remains || j.share >= ADEQUATE);
    let physical = is_physical(&scene, &plain, &model);
    let explains = !model.terms.is_empty() && adequate && physical;
    let wider = explains && (is_curve(&search, &model) || is_outgrown(&search, &model));
    let small = wider && dominates(&search, &model);
    let mut verdict = match (model.terms.is_empty(), explains) {
        (true, _) if judged.iter().all(|j| !j.remains) => Verdict::NothingMissing,
        (true, _) | (false, false) => Verdict::Unnamed,
        (false, true) if wider && !small => Verdict::Unnamed,
        (false, true) if tied.is_empty() => Verdict::Named,
        (false, true) => Verdict::Ambiguous,
    };
    let tied: Vec<Model> = tied.into_iter().cloned().collect();
    let mut rounds = rounds;
    let mut corrected = input_noise::corrected(&on_record, &shown, settings.seed);
    let (mut claims, mut errors) = (Vec::new(), PerAxle::default());
    let swallowed = is_swallowed(&search, &model, &corrected, record);
    if swallowed {
        verdict = Verdict::Unnamed;
    }
    if verdict == Verdict::Unnamed
        && let Some(partly) = partly(&search, record, &remains(&judged, swallowed))?
    {
        verdict = Verdict::NamedInPart;
        model_motions = motions(&scene, &partly.model);
        judged = judging(&partly.model, &model_motions, &partly.model);
        corrected = partly.model.clone();
        (model, shown, shown_plain) = (partly.model.clone(), partly.model, partly.plain);
        (claims, errors) = (partly.claims, partly.errors);
        rounds.clear();
    }
    let worse = |judged: &Judged| {
        let held = &judged.held_out;
        held.extended_rms_m
            .is_none_or(|e| held.plain_rms_m.is_some_and(|p| e > p))
    };
    if verdict == Verdict::Unnamed && !model.terms.is_empty() && judged.iter().any(worse) {
        // A shape that errs more than none where nothing was fitted is not near.
        (model, shown, corrected) = (plain.clone(), shown_plain.clone(), shown_plain.clone());
        model_motions = motions(&scene, &model);
        judged = judging(&model, &model_motions, &shown);
        rounds.clear();
    }
    let mut effects = match verdict {
        Verdict::NamedInPart => claims
            .iter()
            .filter_map(|claim| show::supported(record, &corrected, claim))
            .collect(),
        _ => effects(
            &search,
            record,
            (&model, &corrected),
            &rounds,
            &split,
            settings,
        ),
    };
    for effect in &mut effects {
        effect.affirmed |= verdict == Verdict::Named;
        effect.adequate = effect.affirmed || verdict == Verdict::Ambiguous;
    }
    let mut diagnosis = Diagnosis {
        verdict,
        sentence: String::new(),
        effects,
        rest: (verdict == Verdict::NamedInPart).then(PerAxle::default),
        alternatives: match verdict {
            Verdict::Ambiguous => tied
                .iter()
                .map(|m| m.terms.iter().map(show::name).collect())
                .collect(),
            _ => Vec::new(),
        },
        extended: PerAxle::default(),
        warnings: warnings(ride, record, &shown),
        location: PerAxle::default(),
        held_out: PerAxle::default(),
        next_ride: match verdict {
            Verdict::Ambiguous => {
                next_ride::propose(&search, &model, &tied.iter().collect::<Vec<_>>())
            }
            _ => None,
        },
        detectable: detectable(&search, &model),
        switched_off,
        free_form: PerAxle::default(),
        consequences: PerAxle::default(),
        evidence: PerAxle::default(),
    };
    for (t, (track, judged)) in scene.tracks.iter().zip(judged).enumerate() {
        let axle = track.axle;
        let extended = model.terms.iter().any(|term| term.acts_on(axle));
        let before = estimate(record, &shown_plain, t);
        let mut after = show::told_estimate(record, &corrected, t);
        if let Some([k, b]) = errors.get(axle) {
            after.k_std_n_m = after.k_std_n_m.map(|std| std.max(*k));
            after.b_std_n_s_m = after.b_std_n_s_m.map(|std| std.max(*b));
        }
        let changes = match recorded.get(axle).filter(|_| !extended) {
            // Where nothing is added the extended model is the plain one, and that is output error's: the noise
            // under which names are sought may leave little of the record to measure by.
            Some(fit) => {
                after = fit.estimate(bike.mass(axle).is_some());
                let motion = Motion::of_fit(&record.tracks[t], fit);
                show::consequences(record, t, (&after, &motion), (&after, &motion))
            }
            None => show::consequences(
                &scene,
                t,
                (&before, &plain_motions[t]),
                (&after, &model_motions[t]),
            ),
        };
        diagnosis.consequences.set(axle, changes);
        diagnosis.evidence.set(
            axle,
            evidence(
                record,
                (&shown_plain, &plain_motions[t], &before),
                &shown,
                t,
            ),
        );
        let found = location(
            &scene,
            fits,
            &model,
            &rounds,
            &model_motions[t],
            &judged,
            t,
            settings,
        );
        if let Some(rest) = diagnosis
            .rest
            .as_mut()
            .filter(|_| judged.remains || extended)
        {
            rest.set(axle, rest_of(&found, &judged.held_out));
        }
        diagnosis.location.set(axle, found);
        if matches!(verdict, Verdict::Unnamed | Verdict::NamedInPart) && judged.remains {
            diagnosis.free_form.set(
                axle,
                free_form(&scene, &model_motions[t], &judged.leftover, t),
            );
        }
        diagnosis.held_out.set(axle, judged.held_out);
        if after.is_finite() {
            let told = after.told();
            for (name, why) in [
                ("B", &told.b_not_identifiable),
                ("k", &told.k_not_identifiable),
            ] {
                if let Some(why) = why {
                    let warning =
                        format!("{axle} axle: {name} is not identifiable on this ride: {why}");
                    diagnosis.warnings.push(warning);
                }
            }
            diagnosis.extended.set(axle, told);
        } else {
            diagnosis.warnings.push(format!(
                "{axle} axle: the extended model's k and B leave the numbers' range"
            ));
        }
    }
    if small {
        let left = "a wider law, which is not in the library, explains the ride better than what is named; \
                    what it adds is small beside that";
        diagnosis.warnings.push(left.to_owned());
    }
    let moves = |axle: Axle| {
        let track = scene.tracks.iter().find(|t| t.axle == axle);
        track.map_or(0.0, |t| spread(&t.measured, &t.valid, split.held.clone()))
    };
    if let Some(why) = why_not(&diagnosis, &moves) {
        diagnosis = without_verdict(diagnosis, why);
    }
    diagnosis.sentence = words::sentence(&diagnosis);
    Ok(diagnosis)
}

/// Whether the noise that was estimated from what the plain model leaves has swallowed what an effect takes off: half of the
/// held-out squares and more, at a gain in likelihood of a hundredth of what that is in white noise. Such a likelihood
/// tells little of what the effect is.
fn is_swallowed(search: &Search, model: &Model, told: &Model, record: &Scene) -> bool {
    let removes = |axle: Axle| 1.0 - search.left(axle, model);
    let tracks = search.fitter.scene.tracks.iter();
    let white: f64 = tracks
        .map(|t| removes(t.axle))
        .filter(|removed| *removed > 0.5)
        .map(|removed| -0.5 * search.fitter.samples as f64 * (1.0 - removed).ln())
        .sum();
    let sized = |t: &Term| {
        let effect = show::effect(record, told, t, None, None);
        effect.is_some_and(|e| has_size(&e))
    };
    !model.terms.is_empty()
        && (model.likelihood - search.plain.likelihood < 0.01 * white
            || !model.terms.iter().any(sized))
}

/// On which tracks something is left: on all where the likelihood is not to be trusted.
fn remains(judged: &[Judged], swallowed: bool) -> Vec<bool> {
    judged.iter().map(|j| j.remains || swallowed).collect()
}

/// The diagnosis of a record that carries no verdict: nothing that pretends otherwise is left in it.
fn without_verdict(diagnosis: Diagnosis, why: String) -> Diagnosis {
    let unknown = |estimate: &Estimate| Estimate {
        k_std_n_m: None,
        b_std_n_s_m: None,
        k_not_identifiable: Some(NO_VERDICT.to_owned()),
        b_not_identifiable: Some(NO_VERDICT.to_owned()),
        ..estimate.clone()
    };
    Diagnosis {
        verdict: Verdict::CannotTell,
        sentence: why,
        effects: Vec::new(),
        alternatives: Vec::new(),
        extended: diagnosis.extended.map(|_, e| unknown(e)),
        next_ride: None,
        detectable: Vec::new(),
        free_form: PerAxle::default(),
        ..diagnosis
    }
}

const NO_VERDICT: &str = "the record carries no verdict on what is missing beside it";

/// The fastest that anything in the record moves (Hz).
fn fastest(ride: &Ride) -> f64 {
    let of = |record: &AxleRecord| {
        let road = Some(&record.road).filter(|_| record.has_road());
        let channels = [Some(&record.displacement), road, record.force.as_ref()];
        let driven = record.has_road() || record.force.is_some();
        let fastest = |x: &Vec<f64>| spectrum::fastest(x, driven, ride.step_s);
        channels
            .into_iter()
            .flatten()
            .map(fastest)
            .fold(0.0, f64::max)
    };
    ride.axles
        .iter()
        .map(|(_, record)| of(record))
        .fold(0.0, f64::max)
}

/// The model's effects as they are reported, by what is `told` of them.
fn effects(
    search: &Search,
    record: &Scene,
    (model, told): (&Model, &Model),
    rounds: &[Round],
    split: &Split,
    settings: &Settings,
) -> Vec<EffectReport> {
    let without = search.without_each(model);
    let report = |term: &Term| {
        let less = without.iter().find(|m| !m.terms.contains(term));
        // What came in the place of another was never tested by itself.
        let round = rounds.iter().find(|r| r.term == *term && r.accepted);
        let p = round.and_then(|r| finite(r.p_value.max(FINEST)));
        let separation = less.map(|less| model.likelihood - less.likelihood);
        let mut effect = show::effect(record, told, term, separation, p)?;
        let less = less.unwrap_or(&search.plain);
        effect.material = is_material(record, term, model, less, split, settings);
        Some(effect)
    };
    model.terms.iter().filter_map(report).collect()
}

/// Whether the held-out error of an axle that `term` acts on is larger by the threshold in the model without it.
fn is_material(
    record: &Scene,
    term: &Term,
    model: &Model,
    less: &Model,
    split: &Split,
    settings: &Settings,
) -> bool {
    let tracks = 0..record.tracks.len();
    let mut acted = tracks.filter(|t| term.acts_on(record.tracks[*t].axle));
    acted.any(|t| {
        let [with, without] = [model, less].map(|m| held_rms((record, m), t, split));
        with < (1.0 - settings.materiality) * without
    })
}

/// Standard deviation of the valid samples of a range.
fn spread(x: &[f64], valid: &[bool], range: Range<usize>) -> f64 {
    let known = || range.clone().filter(|i| valid[*i]).map(|i| x[i]);
    let count = known().count().max(1) as f64;
    let mean = known().sum::<f64>() / count;
    (known().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt()
}

/// The plain model of every track under its own noise.
fn plain_model(
    fitter: &Fitter,
    fits: &PerAxle<output_error::AxleFit>,
) -> Result<Model, EngineError> {
    let scene = fitter.scene;
    let mut found = Vec::new();
    for unit in Unit::all(scene, &[]) {
        let track = &scene.tracks[unit.tracks[0]];
        let diverged = || EngineError::Diverged {
            stage: "diagnosis",
            problem: format!(
                "the plain model of the {} axle has no finite fit",
                track.axle
            ),
        };
        let fit = fits.get(track.axle).ok_or_else(diverged)?;
        let p = &fit.plain;
        let base = [
            p.kappa,
            p.beta,
            p.per_mass,
            p.constant,
            p.initial[0],
            p.initial[1],
        ];
        let point = Point {
            base: vec![base],
            values: Vec::new(),
            initial: Vec::new(),
        };
        let masked: Vec<f64> = (0..fitter.samples)
            .map(|i| if track.valid[i] { fit.residual[i] } else { 0.0 })
            .collect();
        let colours = [Colour::of_order(&masked, scene.noise_order)];
        let effort = Effort {
            iterations: 20,
            gain: 1e-3,
            substeps: plain_substeps(scene, unit.tracks[0], p.beta),
        };
        found.push(
            fitter
                .fit(&unit, point, &colours, effort)
                .ok_or_else(diverged)?,
        );
    }
    Ok(Model::new(Vec::new(), found))
}

fn plain_substeps(scene: &Scene, track: usize, beta: f64) -> usize {
    let s = &scene.tracks[track].scale;
    let turns = (s.k.abs() / s.mass).sqrt() * scene.step / FINE;
    (turns.ceil() as usize)
        .max(stable_substeps(scene, beta))
        .clamp(1, 20)
}

/// Whether a rival explains the ride as well with no more effects, by fitted and held-out part together
/// and with what its parameters cost.
fn ties(search: &Search, model: &Model, rival: &Model, within: f64) -> bool {
    if rival.terms.len() > model.terms.len() || rival.likelihood < model.likelihood - 2.0 * within {
        return false;
    }
    let behind = search.merit(model) - search.merit(rival) + search.held_score(model)
        - search.held_score(rival);
    behind < within
}

#[expect(clippy::too_many_arguments, reason = "one track's part of `diagnose`")]
fn location(
    scene: &Scene,
    fits: &PerAxle<output_error::AxleFit>,
    model: &Model,
    rounds: &[Round],
    motion: &Motion,
    judged: &Judged,
    t: usize,
    settings: &Settings,
) -> Location {
    let track = &scene.tracks[t];
    let round = rounds
        .iter()
        .find(|r| r.accepted && r.term.acts_on(track.axle));
    let mismatch = round.is_some() || judged.remains;
    let p_value = match (round, judged.remains) {
        (Some(r), _) => r.p_value,
        (None, true) => judged.p_value,
        (None, false) => rounds
            .iter()
            .find(|r| r.term.acts_on(track.axle))
            .map_or(judged.leftover.p_value, |r| r.p_value),
    };
    if !mismatch {
        return Location {
            mismatch,
            p_value: finite(p_value.max(FINEST)),
            ..Location::default()
        };
    }
    let plain = fits
        .get(track.axle)
        .map(|f| f.residual.clone())
        .unwrap_or_default();
    let (fit, a) = model.of_track(t);
    let fitter = Fitter {
        scene,
        samples: scene.samples,
    };
    let mut left = fitter
        .residuals(&fit.unit, &fit.point, model.substeps(scene, FINE))
        .swap_remove(a);
    if judged.remains {
        let rms = rms_valid(&left, &track.valid, 0..left.len()).max(1e-300);
        let noise = (judged.floor / rms).min(1.0);
        left.iter_mut().for_each(|x| *x *= noise);
    }
    let missing: Vec<f64> = if judged.remains {
        let named = motion
            .acceleration
            .iter()
            .zip(&motion.linear)
            .map(|(a, l)| a - l);
        named
            .zip(&judged.leftover.force)
            .map(|(a, b)| a + b)
            .collect()
    } else {
        motion
            .acceleration
            .iter()
            .zip(&motion.linear)
            .map(|(a, l)| a - l)
            .collect()
    };
    Location {
        mismatch,
        p_value: finite(p_value.max(FINEST)),
        windows_s: locate::windows(&plain, &left, &track.valid, scene, settings.alpha),
        bands_hz: locate::bands(&plain, &left, scene.step, settings.alpha),
        states: locate::states(&missing, motion, scene, 0..scene.samples),
    }
}

/// What is left on an axle, where `found` tells of that.
fn rest_of(found: &Location, held_out: &HeldOut) -> Rest {
    let share = (held_out.extended_rms_m.zip(held_out.plain_rms_m))
        .and_then(|(extended, plain)| finite((extended / plain).powi(2)));
    Rest {
        share,
        windows_s: found.windows_s.clone(),
        bands_hz: found.bands_hz.clone(),
        states: found.states.clone(),
    }
}

fn evidence(
    scene: &Scene,
    (plain, motion, estimate): (&Model, &Motion, &Estimate),
    model: &Model,
    t: usize,
) -> Evidence {
    let track = &scene.tracks[t];
    let fitter = Fitter {
        scene,
        samples: scene.samples,
    };
    let residual = |model: &Model| {
        let (fit, a) = model.of_track(t);
        fitter
            .residuals(&fit.unit, &fit.point, model.substeps(scene, FINE))
            .swap_remove(a)
    };
    let (plain, left) = (residual(plain), residual(model));
    Evidence {
        worst: Excerpt::of(track, &plain, &left),
        spectrum: ResidualSpectrum::of(track, &plain, &left),
        surface: Surface::of(track, motion, &plain, estimate),
    }
}

/// Whether the recording is fit for a verdict.
fn warnings(ride: &Ride, scene: &Scene, model: &Model) -> Vec<String> {
    let mut warnings = ride.summary.warnings.clone();
    for fit in &model.fits {
        for (term, name, value, deviation) in show::unlearned(scene, fit) {
            warnings.push(format!(
                "{} ({}): {name} is not identifiable beyond what is expected of any bicycle, {value} ± {:.1} (95 %); k, B and \
                 the effect's other parameters rest on that and have no intervals",
                term.kind.id(),
                term.place.name(),
                1.96 * deviation
            ));
        }
    }
    for track in &scene.tracks {
        let lost = track.valid.iter().filter(|v| !**v).count();
        if lost as f64 > 0.1 * ride.samples as f64 {
            let share = 100.0 * lost as f64 / ride.samples as f64;
            warnings.push(format!(
                "{} axle: {share:.0} % of the samples are clipped, missing or before the fit",
                track.axle
            ));
        }
    }
    if ride.axles.get(Axle::Front).is_none() || ride.axles.get(Axle::Rear).is_none() {
        warnings
            .push("only one axle was recorded: effects that need both are switched off".to_owned());
    }
    warnings
}
