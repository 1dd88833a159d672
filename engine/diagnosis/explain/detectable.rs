//! What a ride would have shown: for each effect the weakest size that it could not have hidden.

use rayon::prelude::*;

use crate::search::Search;
use crate::search::criteria::to_repeat;
use crate::search::offered::Offered;
use crate::search::score_test::{Prediction, Signatures};
use veloid_core::numerics::lanes::LANES;
use veloid_core::numerics::statistics::normal_tail;
use veloid_model::fit::tangent::Tangent;
use veloid_model::fit::{COARSE, Model};
use veloid_model::law::{Scale, Spec, Values};
use veloid_report::diagnosis::{Detectable, Place, Stronger};

/// Share of rides that show an effect of the size that is reported.
pub const POWER: f64 = 0.9;
/// Deviations above the bound of significance at which an effect shows on nearly every ride, and halvings of that range.
const MOST_ABOVE: f64 = 20.0;
const HALVINGS: usize = 40;
/// Deviations to either side of what is expected, and steps of that range, over which a normal density is summed.
const REACH: f64 = 6.0;
const STEPS: usize = 240;
/// Sizes that one simulation tries.
const RUNGS: usize = LANES;
/// Ratio of the strongest to the weakest size of a ladder that knows nothing.
const SPAN: f64 = 1e4;
/// Factor to either side of the size that a linear start predicts.
const NEAR: f64 = 16.0;
/// Ratio of neighbouring sizes between which the crossing is interpolated.
const CLOSE: f64 = 1.5;
/// Ladders that are climbed for one size, each within two rungs of the one before or beside it.
const LADDERS: usize = 5;
/// Starts that are tried, clearest first: the clearest may be one that no integrator can follow.
const STARTS: usize = 3;

/// The weakest detectable size of every effect that the model does not hold.
pub fn detectable(search: &Search, model: &Model, offered: &Offered) -> Vec<Detectable> {
    let bound = offered.score_bound();
    let share = search.held.len() as f64 / search.fitter.samples as f64;
    // What the samples hide is the axles' own. Gains of the log likelihood are half of squared scores.
    let need = |place: Place| {
        let hidden = 2.0 * search.unresolved(place);
        (place, needed((bound * bound + hidden).sqrt(), share))
    };
    let needs: Vec<(Place, f64)> = offered.places().map(need).collect();
    let of_offer = |offer: &Signatures| {
        let tangent = offered.tangent(offer.term.place)?;
        let (_, need) = needs.iter().find(|(p, _)| *p == offer.term.place)?;
        Some(weakest(search, model, tangent, offer, *need))
    };
    offered.offers.par_iter().filter_map(of_offer).collect()
}

/// Score (deviations of the noise) that must be expected on the fitted part, so that it passes `bound` there and the held-out part, which is a
/// `share` of it, repeats it, both in [`POWER`] of such rides.
fn needed(bound: f64, share: f64) -> f64 {
    let (mut low, mut high) = (bound, bound + MOST_ABOVE);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        match power(middle, bound, share) < POWER {
            true => low = middle,
            false => high = middle,
        }
    }
    high
}

/// Share of rides, of which an effect's score is expected at `expected`, on which it passes `bound` and the held-out part repeats it. The effect has
/// the size there that the fitted part estimates: with a score s on the fitted part and h on the held-out one, the log score
/// rises by s h sqrt(share) - s^2 share / 2.
fn power(expected: f64, bound: f64, share: f64) -> f64 {
    let least = (bound - expected).clamp(-REACH, REACH);
    let step = (REACH - least) / STEPS as f64;
    let at = |i: usize| {
        let deviation = least + (i as f64 + 0.5) * step;
        let score = expected + deviation;
        let wanted = to_repeat(0.5 * score * score, share) + 0.5 * score * score * share;
        let held = wanted / (score * share.sqrt());
        let density = (-0.5 * deviation * deviation).exp() / std::f64::consts::TAU.sqrt();
        density * normal_tail(held - expected * share.sqrt())
    };
    step * (0..STEPS).map(at).sum::<f64>()
}

fn weakest(
    search: &Search,
    model: &Model,
    tangent: &Tangent,
    offer: &Signatures,
    need: f64,
) -> Detectable {
    let (fitter, term) = (&search.fitter, offer.term);
    let spec = term.kind.spec();
    let (unit, at, _) = tangent.with(term);
    let scale = unit.scale(fitter.dataset, at);
    let substeps = model.substeps(fitter.dataset, COARSE);
    let mut starts: Vec<&Prediction> = offer.starts.iter().collect();
    starts.sort_by(|a, b| b.size.total_cmp(&a.size));
    starts.truncate(STARTS);
    let lengths = |rungs: &[Values]| tangent.lengths(fitter, term, rungs, substeps);
    let ladders = starts.iter().map(|s| Ladder::new(spec, scale, s, need));
    let size = ladders
        .filter_map(|ladder| ladder.climb(need, &lengths))
        .find_map(|values| reported_size(spec, scale, &values));
    let reported = starts.first().map(|s| (spec.report)(&s.unit, scale));
    let reported = reported.and_then(|r| r.into_iter().nth(spec.size_parameter));
    Detectable {
        id: term.kind.id_on(scale).to_owned(),
        axle: term.place,
        parameter: reported.as_ref().map_or("", |r| &r.name).to_owned(),
        smallest_detectable: size,
        stronger: spec.stronger,
        reason: (size.is_none()).then(|| {
            "not on this ride: no size in the search range would be detectable".to_owned()
        }),
        unit: reported.as_ref().map_or("", |r| &r.unit).to_owned(),
    }
}

/// How much of an effect these values are: the parameter that shows it, counted from what it is without the effect.
fn reported_size(spec: &Spec, scale: &Scale, values: &Values) -> Option<f64> {
    let reported = |values: &Values| {
        let reported = (spec.report)(values, scale);
        reported.get(spec.size_parameter).map(|r| r.value)
    };
    let mut none = *values;
    none[spec.size_parameter] = 0.0;
    let neutral = match spec.amplitudes {
        [] => 0.0,
        _ => reported(&none)?,
    };
    let size = (reported(values)? - neutral).abs();
    (size.is_finite() && size > 0.0).then_some(size)
}

/// Sizes of an effect within the limits of its fit.
struct Ladder {
    base: Values,
    /// Which of the values shows the size.
    size_parameter: usize,
    /// Its weakest and its strongest value to try first, and the strongest of all.
    first: [f64; 2],
    end: f64,
    /// Whether it may be as weak as one likes.
    amplitude: bool,
}

impl Ladder {
    fn new(spec: &Spec, scale: &Scale, start: &Prediction, need: f64) -> Self {
        let size_parameter = spec.size_parameter;
        let [low, high] = (spec.parameters[size_parameter].limits)(scale);
        let amplitude = !spec.amplitudes.is_empty();
        let (first, end) = match spec.stronger {
            _ if amplitude => {
                let guess = start.unit[size_parameter] * need / start.size;
                let end = if guess > 0.0 { high } else { low };
                let strong = if (NEAR * guess).abs() < end.abs() {
                    NEAR * guess
                } else {
                    end
                };
                ([guess / NEAR, strong], end)
            }
            Stronger::Larger => ([low.max(high / SPAN), high], high),
            Stronger::Smaller => ([high, low.max(high / SPAN)], low.max(high / SPAN)),
        };
        Self {
            base: start.unit,
            size_parameter,
            first,
            end,
            amplitude,
        }
    }

    /// The weakest values whose `lengths` (deviations of the noise) reach what is needed.
    fn climb(&self, need: f64, lengths: &dyn Fn(&[Values]) -> Vec<f64>) -> Option<Values> {
        let with = |x: f64| {
            let mut values = self.base;
            values[self.size_parameter] = x;
            values
        };
        let [mut weak, mut strong] = self.first;
        for _ in 0..LADDERS {
            let ratio = strong / weak;
            if !(ratio.is_finite() && ratio > 0.0)
                || (weak.abs() > self.end.abs()) && self.amplitude
            {
                return None;
            }
            let rung = |i: usize| weak * ratio.powf(i as f64 / (RUNGS - 1) as f64);
            let rungs: Vec<Values> = (0..RUNGS).map(|i| with(rung(i))).collect();
            let lengths = lengths(&rungs);
            // Where weaker ones do more, the integrator does not follow.
            let least = (0..RUNGS).min_by(|a, b| lengths[*a].total_cmp(&lengths[*b]))?;
            let shown = (least..RUNGS).find(|i| lengths[*i] >= need);
            match shown {
                Some(i) if i > least => {
                    let step = ratio.powf(1.0 / (RUNGS - 1) as f64);
                    if step.max(1.0 / step) < CLOSE {
                        let part =
                            (need / lengths[i - 1]).ln() / (lengths[i] / lengths[i - 1]).ln();
                        return part
                            .is_finite()
                            .then(|| with(rung(i - 1) * step.powf(part)));
                    }
                    (weak, strong) = (rung(i - 1), rung(i));
                }
                Some(i) if !self.amplitude => return Some(rungs[i]),
                Some(_) => (weak, strong) = (weak / SPAN, weak),
                None if self.amplitude && strong.abs() < self.end.abs() => {
                    let further = strong * SPAN;
                    let most = if further.abs() < self.end.abs() {
                        further
                    } else {
                        self.end
                    };
                    (weak, strong) = (strong, most);
                }
                None => return None,
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;
    use crate::example;
    use veloid_core::bicycle::Axle;
    use veloid_core::numerics::random::normal;
    use veloid_model::effects::Kind;
    use veloid_model::law::MAX_PARAMETERS;

    fn ladder(first: [f64; 2], end: f64, amplitude: bool) -> Ladder {
        Ladder {
            base: [0.0; MAX_PARAMETERS],
            size_parameter: 0,
            first,
            end,
            amplitude,
        }
    }

    fn climbed(ladder: &Ladder, need: f64, does: impl Fn(f64) -> f64) -> Option<f64> {
        let lengths = |rungs: &[Values]| rungs.iter().map(|v| does(v[0])).collect();
        ladder.climb(need, &lengths).map(|v| v[0])
    }

    #[test]
    fn val_the_needed_score_shows_on_nine_rides_of_ten() {
        let (bound, share) = (4.4, 0.7);
        let need = needed(bound, share);
        assert!((power(need, bound, share) - POWER).abs() < 1e-6);
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
        let shows = |rng: &mut rand_chacha::ChaCha8Rng| {
            let fitted = need + normal(rng);
            let held = need * share.sqrt() + normal(rng);
            let rise = fitted * held * share.sqrt() - 0.5 * fitted * fitted * share;
            fitted > bound && rise > to_repeat(0.5 * fitted * fitted, share)
        };
        let shown = (0..10_000).filter(|_| shows(&mut rng)).count();
        assert!((8900..9100).contains(&shown), "{shown} of 10000");
        // Where nothing has to be repeated, the bound decides.
        assert!(need > bound + 1.28);
    }

    #[test]
    fn the_crossing_is_found_wherever_the_guess_lies() {
        for guess in [1e-6, 0.3, 1.0, 40.0] {
            let ladder = ladder([guess / NEAR, guess * NEAR], 1e6, true);
            let found = climbed(&ladder, 5.0, |x| x * x).unwrap_or_default();
            assert!(
                (found / 5_f64.sqrt() - 1.0).abs() < 0.01,
                "{guess}: {found}"
            );
        }
        let down = ladder([-0.1, -10.0], -100.0, true);
        let found = climbed(&down, 5.0, f64::abs).unwrap_or_default();
        assert!((found + 5.0).abs() < 0.05, "{found}");
    }

    #[test]
    fn where_smaller_is_stronger_the_largest_is_reported() {
        let ladder = ladder([1e4, 1.0], 1.0, false);
        let found = climbed(&ladder, 5.0, |x| 500.0 / x).unwrap_or_default();
        assert!((found / 100.0 - 1.0).abs() < 0.01, "{found}");
    }

    #[test]
    fn what_never_shows_has_no_size() {
        assert_eq!(
            climbed(&ladder([0.1, 10.0], 20.0, true), 5.0, |x| 0.1 * x),
            None
        );
        assert_eq!(climbed(&ladder([1e4, 1.0], 1.0, false), 5.0, |_| 0.1), None);
        assert_eq!(
            climbed(&ladder([1e-4, 1.0], 1.0, false), 5.0, |_| f64::INFINITY),
            Some(1e-4)
        );
    }

    /// A stiff wheel makes an integrator blow up; that is no effect to be seen.
    #[test]
    fn what_no_integrator_follows_does_not_count_as_seen() {
        let ladder = ladder([1e4, 1.0], 1.0, false);
        let does = |x: f64| if x > 3e3 { f64::INFINITY } else { 500.0 / x };
        let found = climbed(&ladder, 5.0, does).unwrap_or_default();
        assert!((found / 100.0 - 1.0).abs() < 0.01, "{found}");
    }

    /// What lies between the samples takes its part of a gain, so that an effect must be larger to be seen.
    #[test]
    fn what_samples_hide_makes_the_detectable_size_larger() {
        let size = |unresolved: f64| {
            let mut dataset = example::dataset();
            dataset.tracks[0].unresolved = unresolved;
            let cubic = example::term(Kind::CubicStiffness, Axle::Front);
            let search = Search {
                candidates: vec![cubic],
                ..example::search(&dataset)
            };
            let model = search.plain.clone();
            let found = detectable(&search, &model, &Offered::of(&search, &model));
            found[0].smallest_detectable.unwrap_or_default()
        };
        let (clear, hidden) = (size(0.0), size(200.0));
        // Twenty deviations of the noise are hidden, beside the few that are always needed.
        assert!(hidden > 2.0 * clear && clear > 0.0, "{hidden}, {clear}");
    }
}
