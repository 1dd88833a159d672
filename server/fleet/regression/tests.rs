#![allow(clippy::unwrap_used)]

use nalgebra::DMatrix;
use serde::Deserialize;

use super::*;

/// A case of tests/regression/statsmodels_reference.py.
#[derive(Deserialize)]
struct Case {
    name: String,
    bikes: Vec<usize>,
    values: Vec<f64>,
    errors: Vec<f64>,
    facts: Vec<Vec<f64>>,
    params: Vec<f64>,
    std_errors: Vec<f64>,
    between_rides: f64,
    between_bikes: Option<f64>,
}

fn data(bikes: Vec<usize>, values: Vec<f64>, errors: Vec<f64>, facts: &[Vec<f64>]) -> Data {
    let columns = facts.first().map_or(0, Vec::len);
    Data {
        dates: (0..values.len()).map(|i| i as f64).collect(),
        facts: DMatrix::from_fn(values.len(), columns, |i, j| facts[i][j]),
        bikes,
        values: values.into(),
        errors: errors.into(),
    }
}

fn close(found: f64, expected: f64, share: f64) -> bool {
    (found - expected).abs() <= share * expected.abs()
}

/// Both stop when their own criterion is flat, which leaves some of the sixth digit. MixedLM takes its standard errors from the Hessian
/// of coefficients and variances together, so that they are larger by some parts in ten thousand.
#[test]
fn val_coefficients_and_variances_are_those_of_statsmodels() {
    let cases = include_str!("../../../tests/regression/statsmodels.json");
    let cases: Vec<Case> = serde_json::from_str(cases).unwrap();
    assert_eq!(cases.len(), 3);
    for case in cases {
        let fit = Fit::of(&data(case.bikes, case.values, case.errors, &case.facts)).unwrap();
        let found = [&[fit.level], fit.slopes.as_slice()].concat();
        for ((found, value), error) in found.iter().zip(&case.params).zip(&case.std_errors) {
            assert!(
                close(found.value, *value, 1e-5),
                "{}: {found:?}, {value}",
                case.name
            );
            let digits = if case.name == "MixedLM" { 1e-3 } else { 1e-5 };
            assert!(
                close(found.std_error, *error, digits),
                "{}: {found:?}, {error}",
                case.name
            );
        }
        assert!(
            close(fit.between_rides, case.between_rides, 1e-5),
            "{}",
            case.name
        );
        assert_eq!(fit.between_bikes.is_some(), case.between_bikes.is_some());
        for (found, expected) in fit.between_bikes.iter().zip(&case.between_bikes) {
            assert!(
                close(*found, *expected, 1e-5),
                "{}: {found}, {expected}",
                case.name
            );
        }
    }
}

/// With equal errors the line is that of least squares, and the excess what its scatter has beyond them.
#[test]
fn one_bicycle_with_equal_errors_is_least_squares() {
    let x = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
    let y = [2.1, 3.9, 6.2, 7.8, 10.1, 11.9];
    let facts = x.map(|x| vec![x]);
    let fit = Fit::of(&data(vec![0; 6], y.to_vec(), vec![0.05; 6], &facts)).unwrap();
    let (mx, my) = (3.5, 7.0);
    let sxx: f64 = x.iter().map(|x| (x - mx) * (x - mx)).sum();
    let sxy: f64 = x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum();
    let slope = sxy / sxx;
    let left: f64 = x
        .iter()
        .zip(y)
        .map(|(x, y)| (y - my - slope * (x - mx)).powi(2))
        .sum();
    let variance = left / 4.0;
    assert!(close(fit.slopes[0].value, slope, 1e-9));
    assert!(close(
        fit.slopes[0].std_error,
        (variance / sxx).sqrt(),
        1e-6
    ));
    assert!(close(fit.between_rides, (variance - 0.0025).sqrt(), 1e-6));
    // 2.776 is Student's t of four degrees of freedom.
    assert!(close(
        fit.slopes[0].margin(),
        2.7764 * (variance / sxx).sqrt(),
        1e-4
    ));
    let at = fit.at(&[5.5]);
    assert!(close(at.value, my + 2.0 * slope, 1e-9));
    assert!(close(
        at.std_error,
        (variance * (1.0 / 6.0 + 4.0 / sxx)).sqrt(),
        1e-6
    ));
    assert!(close(
        at.single_ride,
        at.std_error.hypot(fit.between_rides),
        1e-12
    ));
}

/// Mean squares between and within, as in the textbooks (Searle, Casella and McCulloch 1992, section 3.6).
#[test]
fn a_balanced_fleet_has_the_variances_of_its_mean_squares() {
    let rides = [
        [9.0, 10.0, 11.5],
        [13.0, 12.0, 12.5],
        [7.0, 8.5, 7.5],
        [10.0, 11.0, 9.5],
    ];
    let values = rides.concat();
    let bikes = (0..12).map(|i| i / 3).collect();
    let fit = Fit::of(&data(bikes, values.clone(), vec![0.0; 12], &[])).unwrap();
    let mean = values.iter().sum::<f64>() / 12.0;
    let means = rides.map(|r| r.iter().sum::<f64>() / 3.0);
    let between = 3.0 * means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / 3.0;
    let within = rides
        .iter()
        .zip(means)
        .flat_map(|(r, m)| r.map(|y| (y - m) * (y - m)));
    let within = within.sum::<f64>() / 8.0;
    assert!(close(fit.between_rides.powi(2), within, 1e-6));
    assert!(close(
        fit.between_bikes.unwrap().powi(2),
        (between - within) / 3.0,
        1e-6
    ));
    assert!(close(fit.level.std_error, (between / 12.0).sqrt(), 1e-6));
    assert!(close(fit.level.value, mean, 1e-12));
}

#[test]
fn rides_that_agree_better_than_their_errors_have_no_excess() {
    let values = (0..20).map(|i| 5.0 + 0.001 * f64::from(i % 3)).collect();
    let bikes = (0..20).map(|i| i / 5).collect();
    let fit = Fit::of(&data(bikes, values, vec![1.0; 20], &[])).unwrap();
    assert_eq!((fit.between_rides, fit.between_bikes), (0.0, Some(0.0)));
    assert!(close(fit.level.std_error, 1.0 / 20f64.sqrt(), 1e-9));
}

#[test]
fn too_few_or_equal_rides_are_not_fitted() {
    let facts: Vec<Vec<f64>> = (0..6).map(|i| vec![f64::from(i)]).collect();
    let of = |n: usize, y: fn(usize) -> f64| {
        Fit::of(&data(
            vec![0; n],
            (0..n).map(y).collect(),
            vec![0.1; n],
            &facts[..n],
        ))
        .is_some()
    };
    assert!(of(5, |i| (i * i) as f64) && !of(4, |i| (i * i) as f64));
    assert!(!of(6, |_| 3.0));
}

/// Columns: pressure, twice the pressure, temperature, the same everywhere, one that belongs to the bicycle.
#[test]
fn facts_that_stand_for_others_are_reported() {
    let rides = 24;
    let pressure = |i: usize| 2.0 + 0.1 * (i % 5) as f64;
    let rows: Vec<Vec<f64>> = (0..rides)
        .map(|i| {
            let temperature = 10.0 + ((i * 7) % 11) as f64;
            vec![
                pressure(i),
                2.0 * pressure(i) + 0.01 * (i % 2) as f64,
                temperature,
                4.0,
                (i / 8) as f64,
            ]
        })
        .collect();
    let bikes: Vec<usize> = (0..rides).map(|i| i / 8).collect();
    let values = vec![0.0; rides];
    let found = Confounding::of(&data(bikes, values.clone(), values.clone(), &rows));
    let refused: Vec<_> = found.iter().map(|c| c.refused).collect();
    assert_eq!(
        refused,
        [
            None,
            Some(Refusal::Shared),
            None,
            Some(Refusal::Constant),
            None
        ]
    );
    assert_eq!(found[1].with.map(|w| w.0), Some(0));
    assert!(found[1].with.unwrap().1 > 0.99 && found[1].shared > 0.99);
    assert!(found[4].between_bikes > 0.999 && found[0].between_bikes < 0.1);
    let two = (0..rides).map(|i| i / 12).collect();
    let of_two: Vec<Vec<f64>> = (0..rides).map(|i| vec![(i / 12) as f64]).collect();
    let found = Confounding::of(&data(two, values.clone(), values, &of_two));
    assert_eq!(found[0].refused, Some(Refusal::FewBikes));
}
