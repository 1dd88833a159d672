//! Identifies a bicycle from arrays: `cargo run --workspace --example identify`.

use veloid_engine::simulate::simulated_ride::SimulatedRide;
use veloid_engine::{Bike, EngineError, Settings, Silent, from_arrays, identify, simulate};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let bike = Bike {
        bike: "example".to_owned(),
        mass_front_kg: Some(23.0),
        mass_rear_kg: Some(63.0),
        l_front_m: Some(0.808),
        l_rear_m: Some(0.293),
        ..Bike::default()
    };
    let logged = logged(&bike)?;
    let columns: Vec<(&str, &[f64])> = (logged.iter())
        .map(|(name, values)| (*name, values.as_slice()))
        .collect();
    let ride = from_arrays(&columns, &bike, &Default::default())?;
    let settings = Settings {
        diagnosis: false,
        ..Settings::default()
    };
    let report = identify(&ride, &bike, &settings, &Silent)?;
    for (axle, found) in report.output_error.iter() {
        let error = found.k_std_n_m.unwrap_or(f64::NAN);
        println!(
            "{axle}: k = {:.0} N/m, standard error {error:.0} N/m",
            found.k_n_m
        );
    }
    Ok(())
}

/// Time (s), road and displacement (m) as a logger's arrays, here of a simulated ride.
fn logged(bike: &Bike) -> Result<Vec<(&'static str, Vec<f64>)>, EngineError> {
    let simulated_ride = SimulatedRide {
        duration_s: 20.0,
        noise_displacement_m: 5e-5,
        ..SimulatedRide::default()
    };
    let ride = simulate(&simulated_ride, bike, &[])?;
    let times = (0..ride.samples).map(|i| ride.time_s(i)).collect();
    let channels = ride.channels().into_iter();
    let channels = channels.map(|(name, values)| (name, values.to_vec()));
    Ok([("t", times)].into_iter().chain(channels).collect())
}
