//! The plain model's motion along a ride.

use veloid_methods::simulate::linear::{Input, simulate};
use veloid_methods::simulate::start::start;
use veloid_report::Estimate;
use veloid_ride::AxleRecord;

/// Displacement (m) of the plain model with an estimate's parameters. The motion begins as suits
/// the measured one best. Where it is prescribed, the force (N) that answers.
pub(super) fn simulated(record: &AxleRecord, step: f64, estimate: &Estimate) -> Vec<f64> {
    let input = Input::of(record, step);
    if input.prescribed {
        return answered(record, &input, estimate);
    }
    motion(record, &input, estimate).0
}

/// Displacement (m) and velocity (m/s) of the plain model.
pub(super) fn motion(
    record: &AxleRecord,
    input: &Input,
    estimate: &Estimate,
) -> (Vec<f64>, Vec<f64>) {
    let m = estimate.mass_kg;
    let theta = [estimate.k_n_m / m, estimate.b_n_s_m / m, 1.0 / m];
    let rest_point = record.force.is_some() || !record.has_road();
    let from = start(
        input,
        theta,
        &record.displacement,
        &record.valid,
        rest_point,
    );
    let [kappa, beta, per_mass] = theta;
    simulate(input, kappa, beta, per_mass, from.constant, from.initial)
}

/// The force (N) that answers to a prescribed motion, its constant part as suits the measured one best.
fn answered(record: &AxleRecord, input: &Input, estimate: &Estimate) -> Vec<f64> {
    let (k, b) = (estimate.k_n_m, estimate.b_n_s_m);
    let valid = || (0..input.len()).filter(|i| record.valid[*i]);
    let off = |i: usize| record.output()[i] - input.answer(k, b, 0.0, i);
    let constant = valid().map(off).sum::<f64>() / valid().count().max(1) as f64;
    simulate(input, k, b, 1.0, constant, [0.0; 2]).0
}
