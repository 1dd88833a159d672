//! Wheel load along the ride by each model, paper eq. (2).

use super::motion::motion;
use veloid_core::bicycle::load::wheel_load;
use veloid_methods::simulate::linear::Input;
use veloid_report::Estimate;
use veloid_ride::AxleRecord;

/// The load (N) that each model puts on the road; none where a rig prescribes the motion, on a resting ground or without a
/// static load (N).
pub(super) fn loads(
    record: &AxleRecord,
    step: f64,
    models: &[(&'static str, Option<&Estimate>)],
    static_load: Option<f64>,
) -> Vec<(&'static str, Vec<f64>)> {
    let Some(static_load) = static_load.filter(|_| record.has_road() && !record.prescribed) else {
        return Vec::new();
    };
    let input = Input::of(record, step);
    let of = |(name, estimate): &(&'static str, Option<&Estimate>)| {
        let estimate = (*estimate)?;
        let (z, v) = motion(record, &input, estimate);
        let (k, b) = (estimate.k_n_m, estimate.b_n_s_m);
        let load = |i: usize| {
            let (deflection, rate) = (input.road[i] - z[i], input.road_slope[i] - v[i]);
            wheel_load(static_load, k, b, deflection, rate)
        };
        Some((*name, (0..z.len()).map(load).collect()))
    };
    models.iter().filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use veloid_methods::simulate::simulated_ride::SimulatedRide;

    /// m z'' = k (u - z) + B (u' - z'): the load is the static one and m z''.
    #[test]
    fn the_load_carries_the_mass() {
        let ride = SimulatedRide {
            duration_s: 5.0,
            ..SimulatedRide::default()
        }
        .ride();
        let record = ride.axles.front.as_ref().unwrap();
        let truth = Estimate {
            k_n_m: 110e3,
            b_n_s_m: 1150.0,
            mass_kg: 23.0,
            ..Estimate::default()
        };
        let found = loads(record, ride.step_s, &[("plain", Some(&truth))], Some(225.0));
        let z = &record.displacement;
        let rms = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>().sqrt();
        let (mut carried, mut off) = (Vec::new(), Vec::new());
        for i in 100..400 {
            let acceleration = (z[i + 1] - 2.0 * z[i] + z[i - 1]) / ride.step_s.powi(2);
            carried.push(23.0 * acceleration);
            off.push(found[0].1[i] - 225.0 - 23.0 * acceleration);
        }
        assert!(
            rms(&off) < 0.15 * rms(&carried),
            "{} of {}",
            rms(&off),
            rms(&carried)
        );
        assert!(loads(record, ride.step_s, &[("plain", Some(&truth))], None).is_empty());
    }
}
