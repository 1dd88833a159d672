//! Which of a model's effects act although something else is left. No likelihood is asked, since that rests on a model that
//! is complete: models are compared by the squares of their errors on contiguous blocks, those held out among them,
//! and by what loud and quiet blocks say of the same parameter.

use std::ops::Range;

use rayon::prelude::*;

use veloid_core::bicycle::{Axle, PerAxle};
use veloid_core::numerics::autoregressive::NoiseModel;
use veloid_core::numerics::finite::finite;
use veloid_core::plant::Coefficient;

use super::general_laws::generalised;
use crate::policy;
use crate::search::Search;
use crate::search::extend::Reach;
use crate::search::refit::SOME;
use veloid_model::dataset::Dataset;
use veloid_model::fit::polish::reduce;
use veloid_model::fit::{Effort, FINE, Fitted, Fitter, Model, Term};
use veloid_model::law::Family;
use veloid_report::diagnosis::Support;

/// An effect of a model with the evidence for it, and whether that is enough.
pub struct Claim {
    pub term: Term,
    pub support: Support,
    pub holds: bool,
    /// The same whatever a wider law, of which this is a limit, may take off beyond it.
    pub holds_as_limit: bool,
}

/// Examines every effect of `model`, which is fitted to the plain squares; `tried` are other models that were fitted, and `outgrown` is the
/// share of the model's held-out squares that a wider law must leave.
pub fn examine(search: &Search, model: &Model, tried: &[Model], outgrown: f64) -> Vec<Claim> {
    let terms = model.terms.iter();
    terms
        .filter_map(|term| claim(search, model, *term, tried, outgrown))
        .collect()
}

fn claim(
    search: &Search,
    model: &Model,
    term: Term,
    tried: &[Model],
    outgrown: f64,
) -> Option<Claim> {
    let fitter = &search.fitter;
    let rest: Vec<Term> = (model.terms.iter().copied())
        .filter(|t| *t != term)
        .collect();
    // The best model without the effect, from wherever it comes.
    let own = reduce(fitter, model, &rest, effort(fitter, model, 20));
    let known = tried.iter().chain([&search.plain]);
    let known = known.filter(|m| m.terms == rest).cloned();
    let less: Vec<Model> = (own.into_iter().chain(known))
        .filter_map(|m| unweighted(fitter, &m))
        .collect();
    let least = |axle: Axle| {
        let errors = less.iter().map(|m| (m, Errors::of(search, m, axle)));
        errors.min_by(|a, b| a.1.held.total_cmp(&b.1.held))
    };
    let with = |axle: Axle| Errors::of(search, model, axle);
    let (axle, (less, without), with) = acted(search, term)
        .filter_map(|axle| Some((axle, least(axle)?, with(axle))))
        .min_by(|a, b| (a.2.held / a.1.1.held).total_cmp(&(b.2.held / b.1.1.held)))?;
    let (led, speaking) = leads(&with.blocks, &without.blocks);
    let (led_unfitted, unfitted) = leads(with.unfitted(fitter), without.unfitted(fitter));
    let rivals = rivals(search, model, term, less, tried, axle);
    // A law that is a limit of this one, or of which this is one, says no other thing.
    let others = (rivals.iter()).filter(|(r, _)| !is_limit(term, *r) && !is_limit(*r, term));
    let rival = others.min_by(|a, b| a.1.total_cmp(&b.1)).copied();
    let general = generalised(search, model, term)
        .iter()
        .filter_map(|m| unweighted(fitter, m))
        .map(|m| Errors::of(search, &m, axle).held)
        .fold(f64::INFINITY, f64::min);
    let disagreement = disagreement(search, model, term, axle);
    let removed = 1.0 - with.held / without.held;
    let ratio = rival.as_ref().map(|(_, held)| held / with.held);
    let holds_as_limit = is_material(removed, ratio, term)
        && leads_in_most(led, speaking)
        && disagreement.is_some_and(agrees);
    let left = [general, with.held, without.held];
    let dataset = fitter.dataset;
    let ridden = (dataset.tracks.iter()).any(|t| t.axle == axle && dataset.is_ridden(t));
    Some(Claim {
        term,
        holds: holds_as_limit && !is_outgrown(left, outgrown, ridden),
        holds_as_limit,
        support: Support {
            removed_share: finite(removed)?,
            blocks: unfitted,
            blocks_led: led_unfitted,
            selected_apart: false,
            rival: rival.map(|(term, _)| term.id(search.fitter.dataset).to_owned()),
            rival_ratio: ratio.and_then(finite),
            disagreement: disagreement.and_then(finite),
            window_s: None,
        },
    })
}

/// Whether an effect leads in enough of the blocks that say something.
pub fn leads_in_most(led: usize, speaking: usize) -> bool {
    led as f64 >= policy::LEAD * speaking as f64
}

/// Whether loud and quiet blocks agree on a size from which they differ by that share.
fn agrees(disagreement: f64) -> bool {
    disagreement <= policy::AGREES
}

/// Whether a general law in the place of an effect takes a good part off what that leaves, which on a bench is more than a trifle of what
/// was there without it. Squares that the general law, the effect and the model without it leave.
pub fn is_outgrown([general, with, without]: [f64; 3], outgrown: f64, ridden: bool) -> bool {
    general < outgrown * with && (ridden || with - general > policy::OUTGROWS * without)
}

/// Whether an effect takes off so much, beside what the next one leaves in its place, that it acts whatever else is missing.
pub fn is_material(removed: f64, ratio: Option<f64>, term: Term) -> bool {
    let ratio = ratio.unwrap_or(f64::INFINITY);
    let leaves = match term.kind.spec().on_sensor {
        true => 1.0 - policy::MATERIAL,
        false => ((1.0 - policy::MATERIAL) * ratio / policy::AHEAD).min(policy::MOST_LEFT),
    };
    ratio >= policy::AHEAD && 1.0 - removed <= leaves
}

/// In how many blocks a model errs less than one without an effect, and how many have anything to say: where both err little
/// the effect is hardly at work, and what leads there is chance. All have where hardly half of them err by more.
fn leads(with: &[f64], without: &[f64]) -> (usize, usize) {
    let mean = without.iter().sum::<f64>() / without.len().max(1) as f64;
    let pairs = with.iter().zip(without);
    let loud = |(with, without): &(&f64, &f64)| with.max(**without) > policy::SILENT * mean;
    let most = 2 * pairs.clone().filter(loud).count() > with.len();
    let speaking = pairs.filter(|pair| !most || loud(pair));
    let led = speaking.clone().filter(|(with, without)| with < without);
    (led.count(), speaking.count())
}

/// Other effects in the place of one that are fitted already, so that no more are.
const ENOUGH: usize = 3;

/// Whether an effect is one of several laws of one variable and axle that are alike in both directions: together they draw a curve that
/// has no name. One of them beside a law that differs between the directions does not, since a curve has one odd and one even part.
pub fn is_part_of_a_curve(term: Term, all: &[Term], family: Family) -> bool {
    let is_one =
        |t: &Term| t.place == term.place && t.kind.is_named(family) && t.kind.spec().is_odd;
    is_one(&term) && all.iter().filter(|t| is_one(t)).count() > 1
}

/// Whether a law is a limit of another on the same axle.
pub fn is_limit(narrow: Term, wide: Term) -> bool {
    narrow.place == wide.place && narrow.kind.spec().limit_of.contains(&wide.kind.id())
}

/// What other effects leave of the held-out squares of an axle in the place of `term`, or sets no larger without it.
fn rivals(
    search: &Search,
    model: &Model,
    term: Term,
    less: &Model,
    tried: &[Model],
    axle: Axle,
) -> Vec<(Term, f64)> {
    let others = tried
        .iter()
        .filter(|m| m.terms.len() <= model.terms.len() && !m.terms.contains(&term));
    let beside = |m: &&Model| {
        less.terms.iter().all(|t| m.terms.contains(t)) && m.terms.len() == model.terms.len()
    };
    let refitted = match others.clone().filter(beside).count() {
        0..ENOUGH => search.refits(less, &search.offers(less, &model.terms), Reach::Near, SOME),
        _ => Vec::new(),
    };
    let left = |m: &Model| {
        let new = m.terms.iter().find(|t| !less.terms.contains(t))?;
        let held = Errors::of(search, m, axle).held;
        (new.acts_on(axle)).then_some((*new, held))
    };
    others.chain(&refitted).filter_map(left).collect()
}

fn acted<'s>(search: &'s Search, term: Term) -> impl Iterator<Item = Axle> + 's {
    let tracks = search.fitter.dataset.tracks.iter();
    tracks.map(|t| t.axle).filter(move |a| term.acts_on(*a))
}

/// Squares of a model's errors on one axle: by block of the whole ride, and on the held-out part.
struct Errors {
    blocks: Vec<f64>,
    held: f64,
}

impl Errors {
    fn of(search: &Search, model: &Model, axle: Axle) -> Self {
        let dataset = search.fitter.dataset;
        let whole = dataset.samples;
        let track = dataset.tracks.iter().position(|t| t.axle == axle);
        let (fit, a) = model.of_track(track.unwrap_or_default());
        let substeps = model.substeps(dataset, FINE);
        let mut residuals = (search.fitter).residuals_to(&fit.unit, &fit.point, substeps, whole);
        let residual = residuals.swap_remove(a);
        let sum = |range: Range<usize>| {
            let sum: f64 = residual[range].iter().map(|r| r * r).sum();
            if sum.is_finite() { sum } else { f64::INFINITY }
        };
        Self {
            blocks: blocks(whole, policy::BLOCKS).map(sum).collect(),
            held: sum(search.held.clone()).max(f64::MIN_POSITIVE),
        }
    }

    /// Those of the blocks to which the model was not fitted.
    fn unfitted(&self, fitter: &Fitter) -> &[f64] {
        let mut ranges = blocks(fitter.dataset.samples, policy::BLOCKS);
        let first = ranges.position(|range| range.start >= fitter.samples);
        &self.blocks[first.unwrap_or(self.blocks.len())..]
    }
}

pub fn blocks(samples: usize, count: usize) -> impl Iterator<Item = Range<usize>> {
    (0..count).map(move |b| b * samples / count..(b + 1) * samples / count)
}

fn effort(fitter: &Fitter, model: &Model, iterations: usize) -> Effort {
    Effort {
        iterations,
        gain: 1e-2,
        substeps: model.substeps(fitter.dataset, FINE),
    }
}

/// The model fitted to the plain squares: noise that is estimated from what an incomplete model leaves takes weight off the
/// very frequencies that show.
pub fn unweighted(fitter: &Fitter, model: &Model) -> Option<Model> {
    let effort = effort(fitter, model, 15);
    let refitted = |fit: &Fitted| {
        let white: Vec<NoiseModel> = (fit.noise_models.iter())
            .map(NoiseModel::bleached)
            .collect();
        fitter.fit(&fit.unit, fit.point.clone(), &white, effort)
    };
    let fits = model.fits.iter().map(refitted).collect::<Option<_>>()?;
    Some(Model::new(model.terms.clone(), fits))
}

/// Difference between what loud and quiet halves of the fitted part say of an effect's size, beside what all of it says.
fn disagreement(search: &Search, model: &Model, term: Term, axle: Axle) -> Option<f64> {
    let fitter = &search.fitter;
    let fit = model.fits.iter().find(|f| f.unit.terms.contains(&term))?;
    let size = |fit: &Fitted| {
        let all = reported(fitter.dataset, fit, term)?;
        all.get(term.kind.spec().size_parameter).copied()
    };
    let [loud, quiet] = halves(fitter, axle).map(|half| size(&refitted(fitter, fit, &half)?));
    Some((loud? - quiet?).abs() / size(fit)?.abs().max(f64::MIN_POSITIVE))
}

/// What is reported of an effect.
pub fn reported(dataset: &Dataset, fit: &Fitted, term: Term) -> Option<Vec<f64>> {
    let at = fit.unit.terms.iter().position(|t| *t == term)?;
    let scale = fit.unit.scale(dataset, at);
    let reported = (term.kind.spec().report)(&fit.point.values[at], scale);
    Some(reported.into_iter().map(|r| r.value).collect())
}

/// The fit once more without some samples.
fn refitted(fitter: &Fitter, fit: &Fitted, without: &[Range<usize>]) -> Option<Fitted> {
    let mut dataset = fitter.dataset.clone();
    for t in &fit.unit.tracks {
        for range in without {
            dataset.tracks[*t].valid[range.clone()].fill(false);
        }
    }
    let part = Fitter {
        dataset: &dataset,
        samples: fitter.samples,
    };
    let alone = Model::new(fit.unit.terms.clone(), vec![fit.clone()]);
    let effort = effort(&part, &alone, 8);
    part.fit(&fit.unit, fit.point.clone(), &fit.noise_models, effort)
}

/// The quiet blocks of the fitted part, to leave the loud ones, and the other way round.
fn halves(fitter: &Fitter, axle: Axle) -> [Vec<Range<usize>>; 2] {
    let mut blocks: Vec<Range<usize>> = blocks(fitter.samples, policy::BLOCKS).collect();
    let track = fitter.dataset.tracks.iter().find(|t| t.axle == axle);
    let measured = track.map_or(&[][..], |t| &t.measured);
    let mean = measured.iter().sum::<f64>() / measured.len().max(1) as f64;
    let loudness = |range: &Range<usize>| -> f64 {
        let some = measured.get(range.clone()).unwrap_or_default();
        some.iter().map(|z| (z - mean).powi(2)).sum()
    };
    blocks.sort_by(|a, b| loudness(a).total_cmp(&loudness(b)));
    let loud = blocks.split_off(policy::BLOCKS / 2);
    [blocks, loud]
}

/// Blocks that the jackknife leaves out in turn.
const FOLDS: usize = 5;

/// Standard error of what each fold says of one number; infinite where a fold has no fit (Efron & Tibshirani 1993, eq. 11.5).
fn jackknife(values: &[f64]) -> f64 {
    if values.len() < FOLDS {
        return f64::INFINITY;
    }
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
    ((count - 1.0) / count * squares).sqrt()
}

/// Whether a size is away from none, by what each fold says of it.
fn is_away(size: f64, folds: &[f64]) -> bool {
    size.abs() > policy::AWAY * jackknife(folds)
}

/// A model fitted without each of some contiguous blocks in turn, by its fits.
pub struct Jackknife(Vec<Vec<Fitted>>);

impl Jackknife {
    pub fn new(fitter: &Fitter, model: &Model) -> Self {
        let folds: Vec<Range<usize>> = blocks(fitter.samples, FOLDS).collect();
        let of_fit = |fit: &Fitted| {
            let fold = |f: &Range<usize>| refitted(fitter, fit, std::slice::from_ref(f));
            folds.par_iter().filter_map(fold).collect()
        };
        Self(model.fits.iter().map(of_fit).collect())
    }

    /// Whether the folds agree that an effect has a size at all.
    pub fn determines(&self, model: &Model, term: Term) -> bool {
        let sizes = term.kind.spec().size_parameter;
        let size = |fit: &Fitted| -> Option<f64> {
            let at = fit.unit.terms.iter().position(|t| *t == term)?;
            Some(fit.point.values[at][sizes])
        };
        let of_all = model.fits.iter().zip(&self.0);
        of_all
            .filter_map(|(fit, folds)| Some((size(fit)?, folds)))
            .any(|(all, folds)| {
                let sizes: Vec<f64> = folds.iter().filter_map(size).collect();
                is_away(all, &sizes)
            })
    }

    /// Standard errors of what is reported of an effect.
    pub fn effect(&self, dataset: &Dataset, term: Term) -> Vec<f64> {
        let all = |folds: &Vec<Fitted>| -> Vec<Vec<f64>> {
            let sizes = folds.iter().filter_map(|f| reported(dataset, f, term));
            sizes.collect()
        };
        let mut sizes = self.0.iter().map(all);
        let sizes = sizes.find(|sizes| !sizes.is_empty()).unwrap_or_default();
        let count = sizes.first().map_or(0, Vec::len);
        let error = |r: usize| jackknife(&sizes.iter().map(|t| t[r]).collect::<Vec<_>>());
        (0..count).map(error).collect()
    }

    /// Standard errors of k (N/m) and B (N s/m) on every axle of the model.
    pub fn base(&self, dataset: &Dataset, model: &Model) -> PerAxle<[f64; 2]> {
        let mut errors = PerAxle::default();
        for (fit, folds) in model.fits.iter().zip(&self.0) {
            for (a, t) in fit.unit.tracks.iter().enumerate() {
                let error = |number: Coefficient| {
                    let base = folds.iter().map(|f| f.point.base[a]);
                    let all: Vec<f64> = base.map(|b| b.get(number) / b.per_mass).collect();
                    jackknife(&all)
                };
                let both = [error(Coefficient::Kappa), error(Coefficient::Beta)];
                errors.set(dataset.tracks[*t].axle, both);
            }
        }
        errors
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use veloid_model::effects::Kind;
    use veloid_report::diagnosis::Place;

    #[test]
    fn a_general_law_outgrows_only_by_more_than_a_trifle() {
        let outgrown = policy::OUTGROWN;
        let share = policy::OUTGROWS / (1.0 - 0.5 * outgrown);
        let grows =
            |left: f64, of: f64, ridden| is_outgrown([left * of, of, 1.0], outgrown, ridden);
        assert!(grows(0.5 * outgrown, 1.01 * share, false));
        assert!(!grows(1.01 * outgrown, 10.0 * share, false));
        assert!(!grows(0.5 * outgrown, 0.99 * share, false));
        assert!(grows(0.5 * outgrown, 0.99 * share, true));
    }

    #[test]
    fn the_jackknife_of_a_mean_is_its_standard_error() {
        // Means without each of five numbers: the jackknife gives s / sqrt(5).
        let x = [1.0, 4.0, 2.0, 8.0, 5.0];
        let sum: f64 = x.iter().sum();
        let without: Vec<f64> = x.iter().map(|x| (sum - x) / 4.0).collect();
        let mean = sum / 5.0;
        let variance = x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 4.0;
        assert!((jackknife(&without) - (variance / 5.0).sqrt()).abs() < 1e-12);
        assert_eq!(jackknife(&without[..4]), f64::INFINITY);
    }

    #[test]
    fn what_an_effect_leaves_may_grow_with_its_lead() {
        let term = |kind| Term {
            kind,
            place: Place::Front,
        };
        let friction =
            |left: f64, ratio| is_material(1.0 - left, ratio, term(Kind::CoulombFriction));
        let just = 1.0 - policy::MATERIAL;
        assert!(
            friction(0.99 * just, Some(policy::AHEAD))
                && !friction(1.01 * just, Some(policy::AHEAD))
        );
        assert!(!friction(0.0, Some(0.99 * policy::AHEAD)));
        assert!(
            friction(1.49 * just, Some(1.5 * policy::AHEAD))
                && !friction(1.51 * just, Some(1.5 * policy::AHEAD))
        );
        assert!(
            friction(0.99 * policy::MOST_LEFT, None) && !friction(1.01 * policy::MOST_LEFT, None)
        );
        assert!(!is_material(
            1.0 - 1.01 * just,
            None,
            term(Kind::SensorGain)
        ));
    }

    #[test]
    fn quiet_blocks_neither_lead_nor_follow() {
        let without = [100.0, 90.0, 110.0, 1.0];
        let silent = 0.999 * policy::SILENT * without.iter().sum::<f64>() / 4.0;
        assert_eq!(leads(&[10.0, 9.0, 120.0, silent], &without), (2, 3));
        assert_eq!(leads(&[10.0, 9.0, 120.0, 1.002 * silent], &without), (2, 4));
        // One loud block alone is no comparison.
        assert_eq!(
            leads(&[1.0, 2.0, 0.0, 0.0], &[100.0, 1.0, 1.0, 1.0]),
            (3, 4)
        );
    }

    #[test]
    fn blocks_hold_every_sample_once() {
        for samples in [10, 17, 4321] {
            let all: Vec<usize> = blocks(samples, policy::BLOCKS).flatten().collect();
            assert_eq!(all, (0..samples).collect::<Vec<_>>());
        }
    }

    #[test]
    fn an_effect_leads_in_most_of_the_blocks() {
        let speaking = 1000;
        let led = |times: f64| (times * policy::LEAD * 1000.0) as usize;
        assert!(leads_in_most(led(1.01), speaking) && !leads_in_most(led(0.99), speaking));
        assert!(!leads_in_most(led(1.01), 1020));
    }

    #[test]
    fn loud_and_quiet_blocks_agree_within_a_share() {
        assert!(agrees(0.99 * policy::AGREES) && !agrees(1.01 * policy::AGREES));
    }

    #[test]
    fn a_size_is_away_from_none_by_standard_errors_of_its_folds() {
        // Five folds about 3 whose jackknife error is sqrt(4/5 (1 + 1 + 4 + 4)).
        let folds = [2.0, 4.0, 1.0, 5.0, 3.0];
        let error = 8_f64.sqrt();
        let away = |times: f64| is_away(times * policy::AWAY * error, &folds);
        assert!(away(1.001) && away(-1.001) && !away(0.999));
        assert!(!is_away(1e9, &folds[..4]));
    }

    #[test]
    fn next_to_noise_a_wider_law_outgrows_by_less() {
        let grows = |left: f64| is_outgrown([left, 1.0, 1.0], policy::NEARLY_ALL, true);
        assert!(grows(0.999 * policy::NEARLY_ALL) && !grows(1.001 * policy::NEARLY_ALL));
    }

    #[test]
    fn each_half_of_the_blocks_is_left_out_in_turn() {
        let dataset = crate::example::dataset();
        let fitter = crate::example::fitter(&dataset);
        let [quiet, loud] = halves(&fitter, Axle::Front);
        assert_eq!(quiet.len() + loud.len(), policy::BLOCKS);
        assert_eq!(loud.len(), policy::BLOCKS - policy::BLOCKS / 2);
        let measured = &dataset.tracks[0].measured;
        let mean = measured.iter().sum::<f64>() / measured.len() as f64;
        let power = |range: &Range<usize>| -> f64 {
            let part = &measured[range.clone()];
            part.iter().map(|z| (z - mean).powi(2)).sum()
        };
        let most = quiet.iter().map(power).fold(0.0, f64::max);
        assert!(loud.iter().all(|range| power(range) >= most));
    }
}
