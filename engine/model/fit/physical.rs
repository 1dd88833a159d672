//! Whether a bicycle can be what a model says it is.

use super::estimate::estimate;
use super::model::Model;
use super::unit::{Point, Term, Unit};
use crate::dataset::Dataset;
use crate::law::Reported;
use crate::policy;
use veloid_report::Estimate;

/// Whether the effects are physical and what is left of the plain spring and damper on their axles is one: between stops lies a
/// spring, and no damper pushes.
pub fn is_physical(dataset: &Dataset, plain: &Model, model: &Model) -> bool {
    let effects = (model.fits.iter()).all(|f| has_physical_effects(dataset, &f.unit, &f.point));
    let spring = (0..dataset.tracks.len()).all(|t| {
        let track = &dataset.tracks[t];
        if !model.terms.iter().any(|term| term.acts_on(track.axle)) {
            return true;
        }
        let (before, after) = (estimate(dataset, plain, t), estimate(dataset, model, t));
        let replaced =
            (model.terms.iter()).any(|t| t.kind.spec().replaces_spring && t.acts_on(track.axle));
        (!replaced || spring_stays(&before, &after)) && is_damper(&before, &after)
    });
    effects && spring
}

/// Whether a spring is left beside an effect that takes its place.
fn spring_stays(before: &Estimate, after: &Estimate) -> bool {
    after.k_n_m > policy::SPRING_STAYS * before.k_n_m.abs()
}

/// Whether a damper does not push, but for its error and a little.
fn is_damper(before: &Estimate, after: &Estimate) -> bool {
    let error = policy::PUSHES * after.b_std_n_s_m.unwrap_or(0.0);
    let little = policy::PUSHES_A_LITTLE * before.b_n_s_m.abs();
    after.b_n_s_m > -error - little
}

/// Whether the effects' parameters lie in their physical ranges, and what resonates does so where the record holds anything; a tyre does not
/// relax to nothing.
pub fn has_physical_effects(dataset: &Dataset, unit: &Unit, point: &Point) -> bool {
    let is_physical = |(i, term): (usize, &Term)| {
        let values = &point.values[i];
        let reported = (term.kind.spec().report)(values, unit.scale(dataset, i));
        let relaxes = term.kind.spec().relaxes;
        let own = unit.tracks.iter().zip(&point.base);
        let mut own = own.filter(|(t, _)| term.acts_on(dataset.tracks[**t].axle));
        reported.iter().all(|r| r.physical)
            && own.all(|(t, base)| {
                let band = dataset.tracks[*t].band;
                let least = policy::PERIODS_SHOWN / (dataset.samples as f64 * dataset.step);
                let shown = |r: &Reported| {
                    r.unit != "Hz" || r.value >= least && band.is_none_or(|b| b.contains(r.value))
                };
                reported.iter().all(shown)
                    && (!relaxes || base.kappa >= policy::STATIC * values[0] * base.per_mass)
            })
    };
    unit.terms.iter().enumerate().all(is_physical)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Kind;
    use crate::example;
    use crate::law::padded;
    use veloid_core::bicycle::Axle;
    use veloid_ride::Band;

    fn estimate(k: f64, b: f64, b_std: Option<f64>) -> Estimate {
        Estimate {
            k_n_m: k,
            b_n_s_m: b,
            b_std_n_s_m: b_std,
            ..Estimate::default()
        }
    }

    #[test]
    fn a_part_of_the_spring_stays_beside_what_takes_its_place() {
        let before = estimate(2e4, 0.0, None);
        let stays = |share: f64| spring_stays(&before, &estimate(share * 2e4, 0.0, None));
        assert!(stays(1.01 * policy::SPRING_STAYS) && !stays(0.99 * policy::SPRING_STAYS));
    }

    #[test]
    fn a_damper_pushes_by_no_more_than_its_error_and_a_little() {
        let before = estimate(0.0, 300.0, None);
        let damps = |b: f64, std| is_damper(&before, &estimate(0.0, b, std));
        let little = policy::PUSHES_A_LITTLE * 300.0;
        assert!(damps(-0.99 * little, None) && !damps(-1.01 * little, None));
        let both = little + policy::PUSHES * 40.0;
        assert!(damps(-0.999 * both, Some(40.0)) && !damps(-1.001 * both, Some(40.0)));
    }

    #[test]
    fn a_tyre_keeps_a_part_of_its_stiffness_that_does_not_relax() {
        let dataset = example::dataset();
        let relaxing = example::term(Kind::ViscoelasticTyre, Axle::Front);
        let is_tyre = |branch: f64| {
            let unit = Unit {
                tracks: vec![0],
                terms: vec![relaxing],
            };
            let point = example::point(&dataset, &unit, vec![padded([branch, 0.05])]);
            has_physical_effects(&dataset, &unit, &point)
        };
        let most = example::K / policy::STATIC;
        assert!(is_tyre(0.99 * most) && !is_tyre(1.01 * most));
    }

    #[test]
    fn what_resonates_shows_some_periods() {
        let dataset = example::dataset();
        let unit = Unit {
            tracks: vec![0],
            terms: vec![example::term(Kind::SprungMass, Axle::Front)],
        };
        let seconds = dataset.samples as f64 * dataset.step;
        let is_one = |times: f64| {
            let hz = times * policy::PERIODS_SHOWN / seconds;
            let point = example::point(&dataset, &unit, vec![padded([0.1, hz, 0.3])]);
            has_physical_effects(&dataset, &unit, &point)
        };
        assert!(is_one(1.01) && !is_one(0.99));
    }

    #[test]
    fn what_resonates_beyond_what_the_record_holds_is_none() {
        let mut dataset = example::dataset();
        let unit = Unit {
            tracks: vec![0],
            terms: vec![example::term(Kind::SprungMass, Axle::Front)],
        };
        let point = example::point(&dataset, &unit, vec![padded([0.1, 9.0, 0.3])]);
        let mut is_one = |high_hz| {
            let low_hz = None;
            dataset.tracks[0].band = Some(Band { low_hz, high_hz });
            has_physical_effects(&dataset, &unit, &point)
        };
        assert!(is_one(None) && is_one(Some(9.01)) && !is_one(Some(8.99)));
    }

    #[test]
    fn an_effect_beyond_its_range_is_no_bicycles() {
        let dataset = example::dataset();
        let plain = example::model(&dataset, &[]);
        let friction = example::term(Kind::CoulombFriction, Axle::Rear);
        let is_bicycles = |force| {
            let model = example::model(&dataset, &[(friction, force)]);
            is_physical(&dataset, &plain, &model)
        };
        assert!(is_bicycles(1.0) && !is_bicycles(-1.0));
    }
}
