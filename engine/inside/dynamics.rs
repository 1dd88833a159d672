//! The report's `dynamics` section.

use nalgebra::{DMatrix, SymmetricEigen};

use crate::oscillator::{Oscillator, correlations};
use veloid_core::document::{NotFinite, checked};
use veloid_core::numerics::finite::finite;
use veloid_report::dynamics::{Dynamics, ParameterErrors, StepInput, StepResponse};
use veloid_report::{Estimate, Method};

/// Points of a step response.
const POINTS: usize = 60;
/// Condition numbers below this are not worth a word: no combination has three times the error of another.
const WELL: f64 = 10.0;
/// Weight, of 1, below which a parameter is no part of the combination that is known least.
const PART: f64 = 0.3;

/// Why there are no poles where a rig prescribes the motion.
const NO_MASS: &str =
    "a rig prescribes the motion, so that no mass swings: no poles and no step response";
const NO_SPRING: &str =
    "no spring above zero: no natural frequency, and nothing returns after a step";
const NO_CORRELATION: &str = "the method gives no covariance of k and B";

/// Of an estimate by a method; `input` is what drives the axle, `linear_part` whether effects stand beside it.
pub fn dynamics(e: &Estimate, method: Method, input: StepInput, linear_part: bool) -> Dynamics {
    // Errors are not propagated here.
    let oscillator = Oscillator::of(e, [0.0; 3]);
    let parameters = errors(e);
    let mut why = Vec::new();
    match &oscillator {
        None if e.mass_kg == 0.0 => why.push(NO_MASS.to_owned()),
        None => why.push(NO_SPRING.to_owned()),
        Some(_) => {}
    }
    if parameters.is_none() {
        why.push(NO_CORRELATION.to_owned());
    }
    let found = Dynamics {
        method,
        linear_part,
        poles: oscillator.iter().flat_map(Oscillator::poles).collect(),
        parameters,
        step_response: oscillator.as_ref().and_then(|o| step_response(o, input)),
        why,
    };
    checked("dynamics", found)
        .unwrap_or_else(|error: NotFinite| without_dynamics(method, &error.to_string()))
}

/// Nothing, for a reason.
pub fn without_dynamics(method: Method, why: &str) -> Dynamics {
    Dynamics {
        method,
        linear_part: false,
        poles: Vec::new(),
        parameters: None,
        step_response: None,
        why: vec![why.to_owned()],
    }
}

fn step_response(oscillator: &Oscillator, input: StepInput) -> Option<StepResponse> {
    let until = oscillator.settled_after_s();
    let t_s: Vec<f64> = (0..POINTS)
        .map(|i| until * i as f64 / (POINTS - 1) as f64)
        .collect();
    let at = |t: &f64| match input {
        StepInput::Road => oscillator.after_road_step(*t),
        StepInput::Force => oscillator.after_force_step(*t),
    };
    let displacement_m: Vec<f64> = t_s.iter().map(at).collect();
    (displacement_m.iter().all(|z| z.is_finite())).then_some(StepResponse {
        input,
        t_s,
        displacement_m,
    })
}

fn errors(e: &Estimate) -> Option<ParameterErrors> {
    let fit = e.covariance?;
    let widened = [e.k_std_n_m, e.b_std_n_s_m, e.mass_std_kg];
    let all = [("k", "N/m"), ("B", "N s/m"), ("mass", "kg")];
    let known: Vec<usize> = (0..3)
        .filter(|q| widened[*q].is_some() && fit[*q][*q] > 0.0)
        .collect();
    if known.is_empty() {
        return None;
    }
    let of = |matrix: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
        let row = |p: &usize| known.iter().map(|q| matrix(*p, *q)).collect();
        known.iter().map(row).collect()
    };
    let whole = correlations(&fit);
    let correlation = of(&|p, q| whole[(p, q)]);
    let names: Vec<String> = known.iter().map(|q| all[*q].0.to_owned()).collect();
    let (condition, least_known) = condition(&correlation, &names);
    Some(ParameterErrors {
        units: known.iter().map(|q| all[*q].1.to_owned()).collect(),
        covariance: of(&|p, q| fit[p][q]),
        widened: known.iter().filter_map(|q| widened[*q]).collect(),
        names,
        correlation,
        condition,
        least_known,
    })
}

/// The ratio of the largest to the smallest eigenvalue of the correlations, and the combination of the largest in words.
fn condition(correlation: &[Vec<f64>], names: &[String]) -> (Option<f64>, String) {
    let n = names.len();
    let eigen = SymmetricEigen::new(DMatrix::from_fn(n, n, |i, j| correlation[i][j]));
    let (least, most) = (eigen.eigenvalues.min(), eigen.eigenvalues.max());
    let condition = finite(most / least.max(0.0));
    if condition.is_some_and(|condition| condition < WELL) {
        let words = "no combination of the parameters is known much less than each alone";
        return (condition, words.to_owned());
    }
    let worst = eigen.eigenvectors.column(eigen.eigenvalues.imax());
    let mut parts: Vec<(usize, f64)> = (0..n).map(|i| (i, worst[i])).collect();
    parts.retain(|(_, weight)| weight.abs() > PART);
    let sign = parts.first().map_or(1.0, |(_, weight)| weight.signum());
    let part = |(i, weight): &(usize, f64)| {
        let way = if weight * sign > 0.0 {
            "larger"
        } else {
            "smaller"
        };
        format!("{way} {}", names[*i])
    };
    let parts: Vec<String> = parts.iter().map(part).collect();
    let words = format!(
        "least known is {} at once: the record hardly tells them apart",
        parts.join(" with ")
    );
    (condition, words)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn estimate(correlation: f64) -> Estimate {
        let cross = correlation * 100.0 * 5.0;
        Estimate {
            k_n_m: 110e3,
            b_n_s_m: 1150.0,
            k_std_n_m: Some(150.0),
            b_std_n_s_m: Some(5.0),
            mass_kg: 23.0,
            covariance: Some([[1e4, cross, 0.0], [cross, 25.0, 0.0], [0.0; 3]]),
            ..Estimate::default()
        }
    }

    fn of(correlation: f64) -> Dynamics {
        dynamics(
            &estimate(correlation),
            Method::OutputError,
            StepInput::Road,
            false,
        )
    }

    #[test]
    fn the_matrix_is_that_of_the_fit_and_errors_are_as_reported() {
        let errors = of(0.5).parameters.unwrap();
        assert_eq!(errors.names, ["k", "B"]);
        assert_eq!(errors.covariance, [[1e4, 250.0], [250.0, 25.0]]);
        assert_eq!(errors.correlation, [[1.0, 0.5], [0.5, 1.0]]);
        assert_eq!(errors.widened, [150.0, 5.0]);
        // Eigenvalues 1.5 and 0.5.
        assert!((errors.condition.unwrap() - 3.0).abs() < 1e-9);
        assert!(errors.least_known.starts_with("no combination"));
    }

    #[test]
    fn what_goes_together_is_said_to() {
        let edge = (WELL - 1.0) / (WELL + 1.0);
        assert!(
            of(0.99 * edge)
                .parameters
                .unwrap()
                .least_known
                .starts_with("no combination")
        );
        let said = of(1.01 * edge).parameters.unwrap().least_known;
        assert!(said.contains("larger k with larger B"), "{said}");
        let said = of(-1.01 * edge).parameters.unwrap().least_known;
        assert!(said.contains("larger k with smaller B"), "{said}");
        assert_eq!(of(1.0).parameters.unwrap().condition, None);
    }

    #[test]
    fn a_step_ends_where_it_settles_and_what_is_absent_has_its_reason() {
        let found = of(0.0);
        let step = found.step_response.unwrap();
        assert_eq!(step.displacement_m.len(), POINTS);
        assert!((step.displacement_m[POINTS - 1] - 1.0).abs() < 0.05);
        assert!(found.why.is_empty());
        let rig = Estimate {
            mass_kg: 0.0,
            ..estimate(0.0)
        };
        let rig = dynamics(&rig, Method::OutputError, StepInput::Road, false);
        assert_eq!(rig.why, [NO_MASS]);
        assert!(rig.poles.is_empty() && rig.parameters.is_some());
    }
}
