//! Simulated seasons whose dependence is known.
#![allow(clippy::unwrap_used)]

use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::{Coefficient, Data, Departure, Fit, with_departures};

const SEASONS: u64 = 200;
/// kN/m per bar, per degree, per day.
const TRUTH: [f64; 3] = [21.0, -0.12, -0.03];
const DAYS: f64 = 180.0;

/// What happens beside the dependence, as parts of the level: a drift over the season and a step in it.
#[derive(Clone, Copy)]
struct Fate {
    drift: bool,
    step: f64,
}

fn normal(random: &mut ChaCha8Rng) -> f64 {
    (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0
}

/// A season of `rides` rides of each of `bikes`: 110 kN/m on average, bicycles 4 kN/m apart, rides 1 kN/m, errors of 0.2 to
/// 1 kN/m. It is warm in the middle of the season, and pressure is kept badly.
fn season(seed: u64, bikes: usize, rides: usize, fate: Fate) -> Data {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let n = bikes * rides;
    let mut data = Data {
        bikes: (0..n).map(|i| i / rides).collect(),
        values: DVector::zeros(n),
        errors: DVector::zeros(n),
        dates: vec![0.0; n],
        facts: DMatrix::zeros(n, 3),
    };
    for bike in 0..bikes {
        let (level, usual) = (4.0 * normal(&mut random), 2.3 + 0.2 * normal(&mut random));
        let at = DAYS * (0.3 + 0.4 * random.random::<f64>());
        let mut days: Vec<f64> = (0..rides).map(|_| DAYS * random.random::<f64>()).collect();
        days.sort_by(f64::total_cmp);
        for (i, day) in (bike * rides..).zip(days) {
            let warmth = (std::f64::consts::PI * day / DAYS).sin();
            let facts = [
                usual + 0.25 * normal(&mut random),
                8.0 + 14.0 * warmth + 4.0 * normal(&mut random),
                day,
            ];
            let error = 0.2 + 0.8 * random.random::<f64>();
            let mut value = 110.0 + level + normal(&mut random) + error * normal(&mut random);
            value += TRUTH[0] * (facts[0] - 2.3) + TRUTH[1] * (facts[1] - 15.0);
            value += if fate.drift { TRUTH[2] * day } else { 0.0 };
            // One bicycle's new tyre is stiffer, another one's softer.
            let way = if bike % 2 == 0 { 1.0 } else { -1.0 };
            value += if day > at { way * fate.step } else { 0.0 };
            data.values[i] = value;
            data.errors[i] = error;
            data.dates[i] = day;
            for (j, fact) in facts.into_iter().enumerate() {
                data.facts[(i, j)] = fact;
            }
        }
    }
    data
}

/// Of 200 seasons, those in which each coefficient is within two standard errors of the truth.
fn within(bikes: usize, rides: usize, fate: Fate, facts: usize) -> Vec<usize> {
    let mut counts = vec![0; facts];
    for seed in 0..SEASONS {
        let mut data = season(seed, bikes, rides, fate);
        data.facts = data.facts.columns(0, facts).into_owned();
        let (data, _) = with_departures(data, &[0, 1, 2][..facts]);
        let fit = Fit::of(&data).unwrap();
        for (i, count) in counts.iter_mut().enumerate() {
            let truth = if i == 2 && !fate.drift { 0.0 } else { TRUTH[i] };
            let slope = fit.slopes[i];
            *count += usize::from((slope.value - truth).abs() < 2.0 * slope.std_error);
        }
    }
    counts
}

/// Each in at least 91 % of 200 seasons, and all together in 91 to 98 %.
#[test]
fn coefficients_are_within_two_standard_errors_as_often_as_they_should() {
    let steady = Fate {
        drift: false,
        step: 0.0,
    };
    let drifting = Fate {
        drift: true,
        ..steady
    };
    for (bikes, rides, fate, facts) in [
        (1, 40, steady, 3),
        (8, 8, drifting, 3),
        // A step is found and fitted beside the facts: 6 kN/m of one bicycle, 8 of each of several.
        (
            1,
            60,
            Fate {
                step: 6.0,
                ..steady
            },
            3,
        ),
        (
            4,
            40,
            Fate {
                step: 8.0,
                ..drifting
            },
            3,
        ),
    ] {
        let counts = within(bikes, rides, fate, facts);
        let (drift, step) = (fate.drift, fate.step);
        let all: usize = counts.iter().sum();
        let right = counts.iter().all(|count| *count >= 182) && 100 * all <= 98 * 200 * facts;
        assert!(
            right,
            "{bikes} bicycles, {rides} rides, drift {drift}, step {step}: {counts:?} of 200"
        );
    }
}

/// A bicycle of soft tyres that are pumped hard does not hide what pressure does: its level is its own.
#[test]
fn levels_of_bicycles_are_not_taken_for_the_facts() {
    let mut data = season(
        7,
        30,
        20,
        Fate {
            drift: false,
            step: 0.0,
        },
    );
    for i in 0..data.rides() {
        // Where pressure is usually higher, stiffness is lower.
        let usual: f64 = (0..20)
            .map(|j| data.facts[(i / 20 * 20 + j, 0)])
            .sum::<f64>()
            / 20.0;
        data.values[i] -= 2.0 * TRUTH[0] * (usual - 2.3);
    }
    let fit = Fit::of(&data).unwrap();
    assert!(
        (fit.slopes[0].value / TRUTH[0] - 1.0).abs() < 0.05,
        "{:?}",
        fit.slopes[0]
    );
}

/// Ten bicycles, one of which loses 0.12 kN/m a day with a tyre that leaks. It is named, with its slope, and no other one is; the fleet's
/// slope is that of the nine. Without it nothing is named.
#[test]
fn one_leaking_bicycle_of_ten_is_named_and_the_fleet_does_not_fall() {
    const LEAK: f64 = -0.12;
    let steady = Fate {
        drift: false,
        step: 0.0,
    };
    let (mut named, mut within, mut own, mut innocent) = (0, 0, 0, 0);
    for seed in 0..SEASONS / 2 {
        let mut data = season(seed, 10, 20, steady);
        innocent += usize::from(
            with_departures(season(seed, 10, 20, steady), &[0, 1, 2])
                .1
                .is_empty(),
        );
        for i in 60..80 {
            data.values[i] += LEAK * data.dates[i];
        }
        let (data, found) = with_departures(data, &[0, 1, 2]);
        let leaks = Departure::Slope { bike: 3, fact: 2 };
        named += usize::from(found == [leaks]);
        let Some(place) = found.iter().position(|d| *d == leaks) else {
            continue;
        };
        let fit = Fit::of(&data).unwrap();
        let close =
            |slope: Coefficient, truth: f64| usize::from((slope.low..slope.high).contains(&truth));
        within += close(fit.slopes[2], 0.0);
        own += close(fit.slopes[3 + place], LEAK);
    }
    assert!(innocent >= 98, "{innocent} of 100 have no departure");
    assert!(named >= 95, "{named} of 100 are named alone");
    assert!((90..=99).contains(&within), "{within}: the fleet's slope");
    assert!((90..=99).contains(&own), "{own}: the bicycle's own slope");
}
