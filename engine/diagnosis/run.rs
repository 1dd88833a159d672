//! The diagnosis from start to finish.

use crate::bicycle::{Axle, Bike, PerAxle};
use crate::identify::{Conclusion, Progress};
use crate::output_error::{self, Split, colour::Colour, rms_valid};
use crate::report::Estimate;
use crate::ride::Ride;
use crate::settings::Settings;
use crate::{EngineError, identify};

use super::adequacy::{Leftover, Motion, leftover, motions};
use super::effects::Kind;
use super::evidence::{Evidence, Excerpt, ResidualSpectrum, Surface};
use super::extend::{Model, candidates};
use super::fit::{Effort, Fitter, ORDER};
use super::foil::is_curve;
use super::model::{Point, Unit};
use super::name::{FINE, Named, Search};
use super::scene::Scene;
use super::spectrum::resonance;
use super::{Diagnosis, FreeForm, HeldOut, Location, Verdict, locate, next_ride, show, words};

/// A model explains a ride as well as another if it is behind by no more than this in log
/// likelihood, fitted and held-out part together.
const TIE: f64 = 8.0;
/// The same for a model that stands in for one outside its physical ranges.
const NEARLY: f64 = 70.0;
/// Gain in held-out log score that the free form must make before something counts as left.
const LEFT: f64 = 6.0;
/// Gain in log likelihood by forces in the residual's spectrum from which a force counts as left.
const RESONANT: f64 = 30.0;
/// Share of the residual's power that these forces must have where nothing is named: the noise of a
/// jittering clock comes in bursts, and its spectrum scatters more than Whittle's likelihood knows.
const MATTERS: f64 = 0.27;
/// Share of the explainable held-out variance beyond which an extension is adequate anyway.
const ADEQUATE: f64 = 0.98;

/// Judges one track: is anything left, and what was the noise.
struct Judged {
    leftover: Leftover,
    remains: bool,
    held_out: HeldOut,
}

/// Says what physics the plain model leaves out of a ride.
pub fn diagnose(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    conclusion: &Conclusion,
    progress: &dyn Progress,
) -> Result<Diagnosis, EngineError> {
    let split = Split::of(ride, settings);
    // Every axle for itself: what one pair for both cannot say is not missing physics.
    let separate = Bike {
        equal_axles: false,
        ..bike.clone()
    };
    let starts = [
        identify::starts_from(&conclusion.output_error),
        identify::starts_from(&conclusion.instrumental),
    ];
    let fits = output_error::fit(ride, &separate, settings, &starts)?;
    let scene = Scene::new(ride, &separate, &fits, split.train.end);
    let fitter = Fitter {
        scene: &scene,
        samples: split.train.end,
    };
    let plain = plain_model(&fitter, &fits)?;
    let (terms, switched_off) = candidates(&scene);
    let search = Search {
        fitter: Fitter {
            scene: &scene,
            samples: split.train.end,
        },
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
    } = search.run(plain.clone())?;
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
    let plain_motions = motions(&scene, &plain);
    let model_motions = motions(&scene, &model);
    let judged: Vec<Judged> = (0..scene.tracks.len())
        .map(|t| judge(&fitter, &fits, &model, &model_motions, t, &split, settings))
        .collect();
    let effects: Vec<_> = {
        let without = search.without_each(&model);
        model
            .terms
            .iter()
            .filter_map(|term| {
                let less = without.iter().find(|m| !m.terms.contains(term));
                let p = rounds
                    .iter()
                    .find(|r| r.term == *term && r.accepted)
                    .map_or(settings.alpha, |r| r.p_value);
                show::effect(&scene, &model, term, less, p)
            })
            .collect()
    };
    let adequate = judged
        .iter()
        .all(|j| !j.remains || j.held_out.explained_share >= ADEQUATE);
    let physical = is_physical(&scene, &plain, &model);
    let verdict = match (model.terms.is_empty(), adequate && physical) {
        (true, _) if judged.iter().all(|j| !j.remains) => Verdict::NothingMissing,
        (true, _) | (false, false) => Verdict::Unnamed,
        (false, true) if is_curve(&search, &model) => Verdict::Unnamed,
        (false, true) if tied.is_empty() => Verdict::Named,
        (false, true) => Verdict::Ambiguous,
    };
    let effects = effects
        .into_iter()
        .map(|mut e| {
            e.adequate = verdict != Verdict::Unnamed;
            e.material = judged.iter().any(|j| {
                j.held_out.extended_rms_m < (1.0 - settings.materiality) * j.held_out.plain_rms_m
            });
            e
        })
        .collect::<Vec<_>>();
    let offers = search.offers(&model, &model.terms);
    let bound = search.score_bound(&offers);
    let mut diagnosis = Diagnosis {
        verdict,
        sentence: String::new(),
        effects,
        alternatives: match verdict {
            Verdict::Ambiguous => tied
                .iter()
                .map(|m| m.terms.iter().map(show::name).collect())
                .collect(),
            _ => Vec::new(),
        },
        extended: PerAxle::default(),
        warnings: warnings(ride, &scene, &model),
        location: PerAxle::default(),
        held_out: PerAxle::default(),
        next_ride: match verdict {
            Verdict::Ambiguous => next_ride::propose(&search, &model, &tied),
            _ => None,
        },
        detectable: show::detectable(&scene, &offers, bound),
        switched_off,
        free_form: PerAxle::default(),
        consequences: PerAxle::default(),
        evidence: PerAxle::default(),
    };
    for (t, (track, judged)) in scene.tracks.iter().zip(judged).enumerate() {
        let axle = track.axle;
        let before = show::estimate(&scene, &plain, t);
        let after = show::estimate(&scene, &model, t);
        let changes = show::consequences(
            &scene,
            t,
            (&before, &plain_motions[t]),
            (&after, &model_motions[t]),
        );
        diagnosis.consequences.set(axle, changes);
        diagnosis.evidence.set(
            axle,
            evidence(&scene, (&plain, &plain_motions[t], &before), &model, t),
        );
        let found = location(
            &scene,
            &fits,
            &model,
            &rounds,
            &model_motions[t],
            &judged,
            t,
            settings,
        );
        diagnosis.location.set(axle, found);
        if verdict == Verdict::Unnamed && judged.remains {
            diagnosis
                .free_form
                .set(axle, free_form(&scene, &model_motions[t], &judged, t));
        }
        diagnosis.held_out.set(axle, judged.held_out);
        diagnosis.extended.set(axle, Estimate { ..after });
    }
    diagnosis.sentence = words::sentence(&diagnosis);
    Ok(diagnosis)
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
        let colours = [Colour::of_order(&masked, ORDER)];
        let first = Model::new(Vec::new(), Vec::new());
        let substeps = first
            .substeps(scene, FINE)
            .max(plain_substeps(scene, unit.tracks[0]));
        let effort = Effort {
            iterations: 20,
            gain: 1e-3,
            substeps,
        };
        found.push(
            fitter
                .fit(&unit, point, &colours, effort)
                .ok_or_else(diverged)?,
        );
    }
    Ok(Model::new(Vec::new(), found))
}

fn plain_substeps(scene: &Scene, track: usize) -> usize {
    let s = &scene.tracks[track].scale;
    (((s.k.abs() / s.mass).sqrt() * scene.step / FINE).ceil() as usize).clamp(1, 20)
}

fn judge(
    fitter: &Fitter,
    fits: &PerAxle<output_error::AxleFit>,
    model: &Model,
    motions: &[Motion],
    t: usize,
    split: &Split,
    settings: &Settings,
) -> Judged {
    let scene = fitter.scene;
    let track = &scene.tracks[t];
    let found = leftover(fitter, model, motions, t, &split.held);
    let named = model.terms.iter().any(|term| term.acts_on(track.axle));
    let plain = fits.get(track.axle).map_or(0.0, |f| f.held_rms);
    let extended = if named { found.held_before } else { plain };
    let (fit, a) = model.of_track(t);
    // What springs named effects add is part of how the axle resonates: on the whole as the plain
    // model's, whose stiffness is the mean one.
    let mean = fits.get(track.axle).map(|f| (f.plain.kappa, f.plain.beta));
    let [kappa, beta, ..] = fit.point.base[a];
    let resonance = [Some((kappa, beta)), mean]
        .into_iter()
        .flatten()
        .map(|(k, b)| resonance(&found.residual, scene.step, k, b, track.road_floor))
        .min_by(|a, b| a.gain.total_cmp(&b.gain))
        .unwrap_or_default();
    let structured = found.p_value < 0.5 * settings.alpha
        && found.held_gain > LEFT
        && found.held_after < found.held_before;
    let remains = structured || resonance.gain > RESONANT && (named || resonance.share > MATTERS);
    let floor = if remains {
        (extended * (1.0 - resonance.share).max(0.0).sqrt())
            .min(found.held_after)
            .max((0.5 * track.sensor_floor / scene.step).sqrt())
            .min(extended)
    } else {
        extended
    };
    let explainable = plain * plain - floor * floor;
    let removed = plain * plain - extended * extended;
    let share = if explainable > 1e-4 * plain * plain {
        (removed / explainable).clamp(-1.0, 1.0)
    } else {
        0.0
    };
    let at = |i: usize| scene.step * i as f64;
    Judged {
        remains,
        held_out: HeldOut {
            plain_rms_m: plain,
            extended_rms_m: extended,
            noise_floor_m: floor,
            explained_share: share,
            window_s: [at(split.held.start), at(split.held.end)],
        },
        leftover: found,
    }
}

/// Whether a rival explains the ride as well with no more effects.
fn ties(search: &Search, model: &Model, rival: &Model, within: f64) -> bool {
    if rival.terms.len() > model.terms.len() || rival.likelihood < model.likelihood - within {
        return false;
    }
    let behind =
        model.likelihood - rival.likelihood + search.held_score(model) - search.held_score(rival);
    behind < within
}

/// Whether the effects' parameters lie in their physical ranges and what is left of the plain spring
/// and damper on their axles is one: between stops lies a spring, and no damper pushes.
fn is_physical(scene: &Scene, plain: &Model, model: &Model) -> bool {
    let effects = model.fits.iter().all(|f| {
        f.unit.terms.iter().enumerate().all(|(i, term)| {
            (term.kind.spec().report)(&f.point.values[i], f.unit.scale(scene, i))
                .iter()
                .all(|r| r.physical)
        })
    });
    let spring = (0..scene.tracks.len()).all(|t| {
        let track = &scene.tracks[t];
        if !model.terms.iter().any(|term| term.acts_on(track.axle)) {
            return true;
        }
        let (before, after) = (
            show::estimate(scene, plain, t),
            show::estimate(scene, model, t),
        );
        let stopped = model
            .terms
            .iter()
            .any(|term| term.kind == Kind::BumpStop && term.acts_on(track.axle));
        (!stopped || after.k_n_m > 0.15 * before.k_n_m)
            && after.b_n_s_m > -3.0 * after.b_std_n_s_m - 0.02 * before.b_n_s_m.abs()
    });
    effects && spring
}

#[expect(clippy::too_many_arguments, reason = "one track's part of `diagnose`")]
fn location(
    scene: &Scene,
    fits: &PerAxle<output_error::AxleFit>,
    model: &Model,
    rounds: &[super::name::Round],
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
        (None, true) => judged.leftover.p_value,
        (None, false) => rounds
            .iter()
            .find(|r| r.term.acts_on(track.axle))
            .map_or(judged.leftover.p_value.max(settings.alpha), |r| {
                r.p_value.max(settings.alpha)
            }),
    };
    if !mismatch {
        return Location {
            mismatch,
            p_value,
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
        let noise = judged.held_out.noise_floor_m
            / rms_valid(&left, &track.valid, 0..left.len()).max(1e-300);
        left.iter_mut().for_each(|x| *x *= noise.min(1.0));
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
        p_value,
        windows_s: locate::windows(&plain, &left, &track.valid, scene, settings.alpha),
        bands_hz: locate::bands(&plain, &left, scene.step, settings.alpha),
        states: locate::states(&missing, motion, scene, 0..scene.samples),
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

/// The missing force without a name, on a grid of deflection and rate and along the ride.
fn free_form(scene: &Scene, m: &Motion, judged: &Judged, t: usize) -> FreeForm {
    const CELLS: usize = 11;
    const POINTS: usize = 400;
    let mass = scene.tracks[t].scale.mass;
    let force: Vec<f64> = (0..scene.samples)
        .map(|i| mass * (m.acceleration[i] - m.linear[i] + judged.leftover.force[i]))
        .collect();
    let rms = |x: &[f64]| (x.iter().map(|x| x * x).sum::<f64>() / x.len().max(1) as f64).sqrt();
    let axis = |x: &[f64]| -> Vec<f64> {
        let top = 2.5 * rms(x);
        (0..CELLS)
            .map(|i| top * (2.0 * i as f64 / (CELLS - 1) as f64 - 1.0))
            .collect()
    };
    let (deflection_m, rate_m_s) = (axis(&m.d), axis(&m.w));
    let cell = |grid: &[f64], x: f64| ((x - grid[0]) / (grid[1] - grid[0])).round();
    let mut sums = vec![vec![(0.0, 0_usize); CELLS]; CELLS];
    for (i, f) in force.iter().enumerate() {
        let (c, r) = (cell(&deflection_m, m.d[i]), cell(&rate_m_s, m.w[i]));
        let inside = |x: f64| (0.0..CELLS as f64).contains(&x);
        if inside(c) && inside(r) {
            let sum = &mut sums[r as usize][c as usize];
            sum.0 += f;
            sum.1 += 1;
        }
    }
    let total = force
        .iter()
        .map(|f| f * f)
        .sum::<f64>()
        .max(f64::MIN_POSITIVE);
    let explained: f64 = sums
        .iter()
        .flatten()
        .filter(|s| s.1 > 0)
        .map(|s| s.0 * s.0 / s.1 as f64)
        .sum();
    let thin = (scene.samples / POINTS).max(1);
    FreeForm {
        against: if explained > 0.5 * total {
            "deflection and rate"
        } else {
            "time"
        }
        .to_owned(),
        deflection_m,
        rate_m_s,
        force_n: sums
            .iter()
            .map(|r| {
                r.iter()
                    .map(|s| if s.1 > 0 { s.0 / s.1 as f64 } else { 0.0 })
                    .collect()
            })
            .collect(),
        t_s: (0..scene.samples)
            .step_by(thin)
            .map(|i| i as f64 * scene.step)
            .collect(),
        force_along_n: force.iter().copied().step_by(thin).collect(),
        held_out_rms_m: judged.leftover.held_after,
    }
}

/// Whether the recording is fit for a verdict.
fn warnings(ride: &Ride, scene: &Scene, model: &Model) -> Vec<String> {
    let mut warnings = ride.summary.warnings.clone();
    for (t, track) in scene.tracks.iter().enumerate() {
        let e = show::estimate(scene, model, t);
        if e.b_std_n_s_m > 0.5 * e.b_n_s_m.abs() {
            warnings.push(format!(
                "{} axle: B is not identifiable on this ride ({:.0} +- {:.0} N s/m)",
                track.axle, e.b_n_s_m, e.b_std_n_s_m
            ));
        }
        if e.k_std_n_m > 0.5 * e.k_n_m.abs() {
            warnings.push(format!(
                "{} axle: k is not identifiable on this ride ({:.0} +- {:.0} N/m)",
                track.axle, e.k_n_m, e.k_std_n_m
            ));
        }
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
