#![allow(clippy::unwrap_used)]
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::*;

const DAY: i64 = 86_400_000;

/// 40 rides in 180 days, k = 100 kN/m, scatter 1 %, with a drift over the whole and steps at random places, at least 8 rides apart, all
/// in %. The rides, and the first one after each step.
fn season(seed: u64, drift: f64, steps: &[f64]) -> (Vec<(i64, f64, f64)>, Vec<usize>) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut days: Vec<f64> = (0..40).map(|_| 180.0 * random.random::<f64>()).collect();
    days.sort_by(f64::total_cmp);
    let mut at: Vec<usize> = Vec::new();
    while at.len() < steps.len() {
        let place = random.random_range(8..32);
        if at.iter().all(|other: &usize| other.abs_diff(place) >= 8) {
            at.push(place);
        }
    }
    at.sort_unstable();
    let ride = |(i, day): (usize, &f64)| {
        let noise: f64 = (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
        let passed = at.iter().zip(steps).filter(|(at, _)| i >= **at);
        let stepped: f64 = passed.map(|(_, step)| step).sum();
        let value = 100.0 + noise + drift * day / 180.0 + stepped;
        ((day * DAY as f64) as i64, 1e3 * value, 1e3)
    };
    (days.iter().enumerate().map(ride).collect(), at)
}

#[test]
fn two_hundred_seasons_are_reported_for_what_they_are() {
    for (drift, steps, kind, least) in [
        (0.0, [].as_slice(), Kind::None, 196),
        (-6.0, &[], Kind::Drift, 190),
        (0.0, &[4.0], Kind::Step, 190),
        (-8.0, &[8.0], Kind::Both, 190),
        // A new tyre, and one that is stiffer again; one that is taken off again.
        (0.0, &[4.0, 4.0], Kind::Step, 186),
        (0.0, &[5.0, -5.0], Kind::Step, 190),
        (-8.0, &[8.0, 8.0], Kind::Both, 180),
    ] {
        let right = |seed: &u64| {
            let found = Development::of(&season(*seed, drift, steps).0).unwrap();
            found.kind == kind && found.steps.len() == steps.len()
        };
        let count = (0..200).filter(right).count();
        assert!(count >= least, "{drift} {steps:?}: {count} of 200");
    }
}

#[test]
fn steps_are_placed_and_sized_within_their_errors_as_often_as_they_should() {
    let (mut placed, mut covered, mut all) = (0, 0, 0);
    for seed in 0..200 {
        let truth = [6.0, -6.0];
        let (rides, at) = season(seed, 0.0, &truth);
        let found = Development::of(&rides).unwrap();
        for ((step, at), truth) in found.steps.iter().zip(&at).zip(truth) {
            all += 1;
            placed += usize::from(step.at == time::text(rides[*at].0));
            covered += usize::from((step.size / 1e3 - truth).abs() < step.margin / 1e3);
            assert!(step.since < step.at);
        }
    }
    assert!(all >= 390 && 100 * placed >= 95 * all, "{placed} of {all}");
    assert!(
        100 * covered >= 92 * all && 100 * covered <= 99 * all,
        "{covered} of {all}"
    );
}

#[test]
fn drift_and_step_are_sized_beside_each_other() {
    let found = Development::of(&season(3, -8.0, &[8.0]).0).unwrap();
    assert!((found.per_day * 180.0 / 1e3 + 8.0).abs() < 2.0, "{found:?}");
    assert!(found.per_day_std_error > 0.0 && found.drifts());
    assert!(
        (found.step / 1e3 - 8.0).abs() < 1.5 && found.at.is_some(),
        "{found:?}"
    );
    assert_eq!(Development::of(&season(3, 0.0, &[9.0]).0[..7]), None);
    assert_eq!(Development::of(&[(7, 1.0, 1.0); 20]), None);
    let same_day: Vec<_> = (0..20).map(|i| (0, f64::from(i % 2), 1.0)).collect();
    assert_eq!(Development::of(&same_day).unwrap().kind, Kind::None);
}

/// Least squares by hand: two levels of four rides, without a drift.
#[test]
fn the_error_of_a_step_is_that_of_a_difference_of_means() {
    let value = |i: i64| if i < 4 { 10.0 } else { 20.0 } + [0.1, -0.1][(i % 2) as usize];
    let rides: Vec<_> = (0..8).map(|i| (i * DAY, value(i), 0.5)).collect();
    let found = Development::of(&rides).unwrap();
    // Eight squares of 0.1 over six degrees of freedom, a quarter of it for each mean.
    let error = (0.08 / 6.0 * 0.5f64).sqrt();
    assert_eq!(found.kind, Kind::Step);
    assert!((found.step - 10.0).abs() < 1e-9);
    assert!(
        (found.steps[0].std_error / error - 1.0).abs() < 1e-9,
        "{found:?}"
    );
    // Student's t of six degrees of freedom.
    assert!((found.steps[0].margin / error / 2.4469 - 1.0).abs() < 1e-4);
}

#[test]
fn a_history_of_five_levels_has_four_steps() {
    let level = |i: i64| [0.0, 6.0, 2.0, 9.0, 4.0][(i / 12) as usize];
    let rides: Vec<_> = (0..60)
        .map(|i| {
            (
                i * DAY,
                100.0 + level(i) + 0.3 * f64::from((i * 7 % 5) as u8),
                1.0,
            )
        })
        .collect();
    let found = Development::of(&rides).unwrap();
    let at: Vec<&str> = found.steps.iter().map(|step| step.at.as_str()).collect();
    let expected = [12, 24, 36, 48].map(|i| time::text(i * DAY));
    assert_eq!(at, expected);
    assert_eq!(found.at.as_ref(), expected.last());
}
