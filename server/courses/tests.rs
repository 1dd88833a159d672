//! Simulated seasons whose truth is known.
#![allow(clippy::unwrap_used)]

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::{Development, Ride, Rides};

/// Rides of four a week with a scatter of 1 % in all, of which `change` makes what happens (in %, by ride and day).
fn season(seed: u64, rides: usize, change: impl Fn(usize, f64) -> f64) -> Vec<Ride> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let season = rides as f64 * 7.0 / 4.0;
    let mut days: Vec<f64> = (0..rides)
        .map(|_| season * random.random::<f64>())
        .collect();
    days.sort_by(f64::total_cmp);
    let normal =
        |random: &mut ChaCha8Rng| (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
    let ride = |(i, day): (usize, f64)| {
        let std_error = 0.3 + 0.6 * random.random::<f64>();
        let noise = 0.8 * normal(&mut random) + std_error * normal(&mut random);
        Ride {
            day,
            value: 100.0 + noise + change(i, day),
            std_error,
        }
    };
    days.into_iter().enumerate().map(ride).collect()
}

/// Of 100 seasons of 100 rides: those with so many steps and drifts.
fn right(change: impl Fn(usize, f64) -> f64, is_right: impl Fn(&Development) -> bool) -> usize {
    let one = |seed: u64| {
        let rides = season(seed, 100, &change);
        let found = Development::of(Rides {
            rides: &rides,
            facts: &[],
        });
        is_right(&found.unwrap())
    };
    (0..100).filter(|seed| one(*seed)).count()
}

#[test]
fn seasons_are_reported_as_what_they_are() {
    let nothing = |found: &Development| found.steps.is_empty() && found.drifts.is_empty();
    let unchanged = right(|_, _| 0.0, nothing);
    assert!(unchanged >= 98, "{unchanged}");
    let leak = right(
        |_, day| -(day - 60.0).max(0.0) / 7.0,
        |found| found.steps.is_empty() && found.drifts.len() == 1 && found.drifts[0].to.is_none(),
    );
    assert!(leak >= 95, "{leak}");
    let tyre = right(
        |i, _| if i < 40 { 0.0 } else { 4.0 },
        |found| {
            found.drifts.is_empty()
                && found.steps.len() == 1
                && found.steps[0].ride.abs_diff(40) < 3
        },
    );
    assert!(tyre >= 95, "{tyre}");
    let service = right(
        |i, day| match i {
            60.. => 0.0,
            _ => -(day - 50.0).max(0.0) / 7.0,
        },
        |found| found.drifts.len() == 1 && found.drifts[0].to.is_some() && found.steps.len() == 1,
    );
    assert!(service >= 80, "{service}");
}

/// Sizes are within their 95 % intervals in 88 to 100 of 100 seasons.
#[test]
fn sizes_are_within_their_intervals() {
    let within = right(
        |i, _| if i < 50 { 0.0 } else { -5.0 },
        |found| {
            let [step] = found.steps[..] else {
                return false;
            };
            (step.size.value + 5.0).abs() < step.size.margin
        },
    );
    assert!(within >= 88, "{within}");
    let now = right(
        |_, day| 0.1 * day,
        |found| (found.now.value - 117.0).abs() < 2.0 + found.now.margin,
    );
    assert!(now >= 95, "{now}");
}

/// A warm summer does not pass for a drift where the temperature is known, and does where it is not.
#[test]
fn what_is_known_of_rides_does_not_pass_for_a_change() {
    let warmth = |day: f64| 15.0 * (std::f64::consts::PI * day / 175.0).sin();
    let found = |known: bool| {
        let one = |seed: u64| {
            let rides = season(seed, 100, |_, day| -0.4 * warmth(day));
            let facts = [rides.iter().map(|ride| warmth(ride.day)).collect()];
            let facts = if known { &facts[..] } else { &[] };
            let found = Development::of(Rides {
                rides: &rides,
                facts,
            });
            let found = found.unwrap();
            found.steps.is_empty() && found.drifts.is_empty()
        };
        (0..40).filter(|seed| one(*seed)).count()
    };
    assert!(found(true) >= 39);
    assert!(found(false) <= 2);
}

#[test]
fn one_wrong_ride_is_no_change() {
    let mut rides = season(3, 60, |_, _| 0.0);
    for (at, off) in [(5, 30.0), (30, -40.0), (59, 25.0)] {
        rides[at].value += off;
    }
    let found = Development::of(Rides {
        rides: &rides,
        facts: &[],
    });
    let found = found.unwrap();
    assert_eq!((found.steps.len(), found.drifts.len()), (0, 0), "{found:?}");
    assert!((found.now.value - 100.0).abs() < 3.0 * found.now.std_error);
}

/// Looks are independent of how often they are taken: what was reported after some rides is reported after more.
#[test]
fn reports_do_not_depend_on_rides_to_come() {
    let rides = season(7, 100, |i, _| if i < 60 { 0.0 } else { 6.0 });
    let reported = |n: usize| {
        let rides = &rides[..n];
        Development::of(Rides { rides, facts: &[] })
            .unwrap()
            .reported
    };
    let all = reported(100);
    assert_eq!(all.len(), 1, "{all:?}");
    assert!((60..70).contains(&all[0]), "{all:?}");
    assert_eq!(reported(all[0]), []);
    assert_eq!(reported(all[0] + 1), all);
}
