//! Stiffness, damping and mass of an axle under a model.

use super::model::Model;
use super::unit::Slot;
use crate::dataset::Dataset;
use veloid_core::numerics::finite::std_error;
use veloid_core::plant::{Coefficient, Coefficients};
use veloid_report::Estimate;

/// k, B and m of one track under a model.
pub fn estimate(dataset: &Dataset, model: &Model, track: usize) -> Estimate {
    let (fit, a) = model.of_track(track);
    let slots = fit.unit.slots(dataset);
    let base = fit.point.base[a];
    let (Coefficients { kappa, beta, .. }, m) = (base, base.mass());
    let moves = dataset.tracks[track].plant.moves();
    let index = |q: Coefficient| slots.iter().position(|s| *s == Slot::Base(a, q));
    let at = [Coefficient::Kappa, Coefficient::Beta, Coefficient::PerMass].map(index);
    // How k, B and m change with k/m, B/m and 1/m.
    let by = [
        [m, 0.0, -kappa * m * m],
        [0.0, m, -beta * m * m],
        [0.0, 0.0, -m * m],
    ];
    let covariance = Estimate::propagated(by, |a, b| match (at[a], at[b]) {
        (Some(a), Some(b)) => fit.covariance[(a, b)],
        _ => 0.0,
    });
    let error = |q: usize| std_error(covariance?[q][q]);
    Estimate {
        k_n_m: kappa * m,
        b_n_s_m: beta * m,
        k_std_n_m: error(0),
        b_std_n_s_m: error(1),
        mass_kg: if moves { m } else { 0.0 },
        mass_std_kg: at[2].and_then(|_| error(2)),
        covariance,
        ..Estimate::default()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::example;

    #[test]
    fn stiffness_and_damping_are_those_over_the_mass_times_it() {
        let dataset = example::dataset();
        let mut model = example::model(&dataset, &[]);
        let slots = model.fits[1].unit.slots(&dataset);
        let at = |q| slots.iter().position(|s| *s == Slot::Base(0, q)).unwrap();
        model.fits[1].covariance[(at(Coefficient::Kappa), at(Coefficient::Kappa))] = 9.0;
        model.fits[1].covariance[(at(Coefficient::Beta), at(Coefficient::Beta))] = 4.0;
        let found = estimate(&dataset, &model, 1);
        let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
        near(found.k_n_m, example::K);
        near(found.b_n_s_m, example::B);
        near(found.mass_kg, example::REAR);
        // The mass is known, so that errors of k/m and B/m are all.
        near(found.k_std_n_m.unwrap(), 3.0 * example::REAR);
        near(found.b_std_n_s_m.unwrap(), 2.0 * example::REAR);
        assert_eq!(found.mass_std_kg, None);
    }

    #[test]
    fn an_unknown_mass_adds_its_own_error() {
        let mut dataset = example::dataset();
        dataset.tracks[0].free_mass = true;
        let mut model = example::model(&dataset, &[]);
        let slots = model.fits[0].unit.slots(&dataset);
        let at = |q| slots.iter().position(|s| *s == Slot::Base(0, q)).unwrap();
        let (kappa, per_mass) = (7.0, 1e-4);
        let covariance = &mut model.fits[0].covariance;
        covariance[(at(Coefficient::Kappa), at(Coefficient::Kappa))] = kappa * kappa;
        covariance[(at(Coefficient::PerMass), at(Coefficient::PerMass))] = per_mass * per_mass;
        // k/m and 1/m are known to go together, so that k is known better than by either.
        covariance[(at(Coefficient::Kappa), at(Coefficient::PerMass))] = kappa * per_mass;
        covariance[(at(Coefficient::PerMass), at(Coefficient::Kappa))] = kappa * per_mass;
        let found = estimate(&dataset, &model, 0);
        let mass = example::FRONT;
        // Of k = (k/m) / (1/m) to first order, errors that are one number's.
        let expected = (kappa * mass - example::K * mass * per_mass).abs();
        assert!((found.k_std_n_m.unwrap() / expected - 1.0).abs() < 1e-6);
        assert!((found.mass_std_kg.unwrap() / (mass * mass * per_mass) - 1.0).abs() < 1e-9);
    }
}
