//! Windows of a record, each with a starting state of its own.

use super::*;
use veloid_core::plant::Coefficients;
use veloid_diagnosis::policy;
use veloid_model::dataset::Windows;
use veloid_model::dataset::windows::dominant_period;
use veloid_model::fit::physical::has_physical_effects;
use veloid_model::fit::shooting::Shooting;

/// N/m^3
const K3: f64 = 3e9;

/// A ride on a spring that stiffens, as the extended model sees it.
fn stiffening(k3: f64) -> Dataset {
    let ride = ride(|_, d, _| k3 * d.powi(3));
    let settings = Settings::default();
    let observed = veloid_engine::observe(&ride, &bike(), &settings).unwrap();
    let start = starts_from(&observed.instrumental);
    let fits = output_error::fit(&ride, &bike(), &settings, &[start]).unwrap();
    let end = Split::of(&ride, &settings).train.end;
    Dataset::new(&ride, &bike(), &fits, end)
}

#[test]
fn windows_show_a_law_and_predict_what_they_were_not_fitted_to() {
    let dataset = stiffening(K3);
    let windows = Windows::of(&dataset.tracks[0], dataset.samples, 1.0).unwrap();
    let shooting = Shooting {
        dataset: &dataset,
        track: 0,
        spans: &windows.spans,
        period: windows.period / dataset.step,
        variance: dataset.tracks[0].spread().powi(2),
    };
    let (even, odd): (Vec<usize>, Vec<usize>) =
        (0..windows.spans.len()).partition(|window| window % 2 == 0);
    let mean = |left: Vec<f64>| left.iter().sum::<f64>() / left.len() as f64;
    let held_out = |terms: Vec<Term>| {
        let start = Point {
            base: vec![axle(1.2 * K)],
            values: terms.iter().map(|_| padded([0.3 * K3])).collect(),
            initial: terms.iter().map(|_| AT_REST).collect(),
        };
        let tracks = vec![0];
        let unit = Unit { tracks, terms };
        let shot = shooting.fit(&unit, &start, &even, 20).unwrap();
        (
            mean(shooting.held_out(&unit, &shot.point, &odd)),
            shot.point,
        )
    };
    let cubic = Term {
        kind: Kind::CubicStiffness,
        place: Place::Front,
    };
    let (plain, _) = held_out(Vec::new());
    let (with, point) = held_out(vec![cubic]);
    assert!(with < 0.1 * plain, "{with} of {plain}");
    let Coefficients { kappa, beta, .. } = point.base[0];
    for (found, truth) in [
        (point.values[0][0], K3),
        (kappa, K / MASS),
        (beta, B / MASS),
    ] {
        assert!((found / truth - 1.0).abs() < 0.02, "{found} for {truth}");
    }
}

#[test]
fn the_force_that_is_missed_grows_with_what_is_missing() {
    let missed = |k3: f64| {
        let dataset = stiffening(k3);
        let track = &dataset.tracks[0];
        let period = dominant_period(track).unwrap();
        weak_form::missed(&dataset, track, dataset.samples, period).unwrap()
    };
    let [none, some, much] = [0.0, K3, 4.0 * K3].map(missed);
    assert!(
        none < 0.5 * some && some < 0.7 * much,
        "{none} {some} {much}"
    );
}

#[test]
fn a_tyre_that_relaxes_keeps_a_part_of_its_stiffness() {
    let dataset = stiffening(0.0);
    let relaxing = Term {
        kind: Kind::ViscoelasticTyre,
        place: Place::Front,
    };
    let unit = Unit {
        tracks: vec![0],
        terms: vec![relaxing],
    };
    let is_physical = |stiffness: f64| {
        let branch = 0.2 * K;
        let point = Point {
            base: vec![axle(stiffness * branch)],
            values: vec![padded([branch, 0.05])],
            initial: vec![AT_REST],
        };
        has_physical_effects(&dataset, &unit, &point)
    };
    assert!(is_physical(1.01 * policy::STATIC) && !is_physical(0.99 * policy::STATIC));
}
