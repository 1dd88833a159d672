//! Table 1 of the paper: errors of the model simulated with each method's parameters.

use crate::replay::motion::simulated;
use veloid_core::bicycle::{Axle, PerAxle};
use veloid_report::{Comparison, ComparisonRow, Estimate};
use veloid_ride::{AxleRecord, Ride};

/// One row per method and axle, methods in the order given.
///
/// Measured velocity and acceleration are the central difference D z and D^2 z of the measured
/// displacement; the model's are the same differences of the simulated one, so that both sides
/// are seen through one differentiator. Only samples count whose neighbours (velocity: one,
/// acceleration: two on each side) are valid. The simulated motion begins as suits the measured
/// one best. A model that runs away along the ride has no row, but a note.
pub fn of(ride: &Ride, methods: &[(&str, &PerAxle<Estimate>)]) -> Comparison {
    let mut found = Comparison::default();
    let prescribed = ride.axles.iter().filter(|(_, record)| record.prescribed);
    found.notes.extend(prescribed.map(|(axle, _)| {
        format!(
            "{axle} axle: a rig prescribes the motion, so there is none to predict; `output_error` is the least-squares fit of \
             the force to deflection and rate"
        )
    }));
    for (method, estimates) in methods {
        for (axle, estimate) in estimates.iter() {
            let record = ride.axles.get(axle);
            if let Some(record) = record.filter(|record| !record.prescribed) {
                let row = row(method, axle, record, ride.step_s, estimate);
                match is_finite(&row) {
                    true => found.rows.push(row),
                    false => found.notes.push(format!(
                        "{axle} axle: the model of {} diverges along the ride",
                        method.replace('_', " ")
                    )),
                }
            }
        }
    }
    found
}

fn is_finite(row: &ComparisonRow) -> bool {
    [
        row.position_max_m,
        row.position_mse_m2,
        row.velocity_max_m_s,
        row.velocity_mse_m2_s2,
        row.acceleration_max_m_s2,
        row.acceleration_mse_m2_s4,
    ]
    .iter()
    .all(|x| x.is_finite())
}

fn row(
    method: &str,
    axle: Axle,
    record: &AxleRecord,
    step: f64,
    estimate: &Estimate,
) -> ComparisonRow {
    let model = simulated(record, step, estimate);
    let z = &record.displacement;
    let error: Vec<f64> = z.iter().zip(&model).map(|(z, m)| z - m).collect();
    let valid = |i: usize, margin: usize| {
        i >= margin
            && i + margin < error.len()
            && record.valid[i - margin..=i + margin].iter().all(|v| *v)
    };
    let measure = |margin: usize, of: &dyn Fn(usize) -> f64| {
        let (mut largest, mut sum, mut count) = (0.0_f64, 0.0, 0_usize);
        for i in (0..error.len()).filter(|i| valid(*i, margin)) {
            let e = of(i);
            largest = largest.max(e.abs());
            sum += e * e;
            count += 1;
        }
        (largest, sum / count.max(1) as f64)
    };
    let e = &error;
    let position = measure(0, &|i| e[i]);
    let velocity = measure(1, &|i| (e[i + 1] - e[i - 1]) / (2.0 * step));
    let acceleration = measure(2, &|i| {
        (e[i + 2] - 2.0 * e[i] + e[i - 2]) / (4.0 * step * step)
    });
    ComparisonRow {
        method: method.to_owned(),
        axle,
        position_max_m: position.0,
        position_mse_m2: position.1,
        velocity_max_m_s: velocity.0,
        velocity_mse_m2_s2: velocity.1,
        acceleration_max_m_s2: acceleration.0,
        acceleration_mse_m2_s4: acceleration.1,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use veloid_methods::simulate::simulated_ride::SimulatedRide;

    fn estimate(k: f64, mass: f64) -> Estimate {
        Estimate {
            k_n_m: k,
            b_n_s_m: 1150.0,
            mass_kg: mass,
            ..Estimate::default()
        }
    }

    fn both(k: f64) -> PerAxle<Estimate> {
        PerAxle {
            front: Some(estimate(k, 23.0)),
            rear: Some(estimate(k, 63.0)),
        }
    }

    #[test]
    fn rows_stand_in_the_order_of_the_methods() {
        let ride = SimulatedRide {
            duration_s: 5.0,
            ..SimulatedRide::default()
        }
        .ride();
        let (a, b) = (both(110e3), both(100e3));
        let rows = of(&ride, &[("least_squares", &a), ("swarm", &b)]).rows;
        let names: Vec<_> = rows.iter().map(|r| (r.method.as_str(), r.axle)).collect();
        let want = ["least_squares", "swarm"].map(|m| Axle::BOTH.map(|a| (m, a)));
        assert_eq!(names, want.concat());
        assert!(rows[0].position_max_m < 1e-5 && rows[2].position_max_m > 1e-4);
    }

    /// With the truth only the noise is left, through D and D^2.
    #[test]
    fn truth_leaves_the_noise() {
        let noise = 1e-4;
        let ride = SimulatedRide {
            noise_displacement_m: noise,
            ..SimulatedRide::default()
        }
        .ride();
        let methods = both(110e3);
        for row in of(&ride, &[("swarm", &methods)]).rows {
            let square = noise * noise;
            let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 0.1, "{a} {b}");
            near(row.position_mse_m2, square);
            near(row.velocity_mse_m2_s2, square * 2.0 / 0.02_f64.powi(2));
            near(row.acceleration_mse_m2_s4, square * 6.0 / 0.02_f64.powi(4));
        }
    }

    /// Undamped the wrong way round: the motion grows beyond all numbers.
    #[test]
    fn a_model_that_runs_away_has_a_note_in_place_of_a_row() {
        let ride = SimulatedRide::default().ride();
        let mut methods = both(110e3);
        methods.front.as_mut().unwrap().b_n_s_m = -2000.0;
        let found = of(&ride, &[("output_error", &methods)]);
        assert_eq!(found.rows.len(), 1, "{:?}", found.rows);
        assert_eq!(found.rows[0].axle, Axle::Rear);
        assert_eq!(
            found.notes,
            ["front axle: the model of output error diverges along the ride"]
        );
    }

    #[test]
    fn samples_not_valid_do_not_count() {
        let mut ride = SimulatedRide::default().ride();
        let front = ride.axles.front.as_mut().unwrap();
        for i in 3000..3010 {
            front.displacement[i] += 1.0;
            front.valid[i] = false;
        }
        let methods = both(110e3);
        let rows = of(&ride, &[("swarm", &methods)]).rows;
        assert!(rows[0].position_max_m < 1e-5 && rows[0].acceleration_max_m_s2 < 0.1);
    }
}
