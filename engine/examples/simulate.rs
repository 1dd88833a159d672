//! Simulates a ride with friction in the front wheel, and shows what it does: `cargo run --workspace --example simulate`.

use std::collections::BTreeMap;

use veloid_engine::report::diagnosis::Place;
use veloid_engine::simulate::road::Roughness;
use veloid_engine::simulate::simulated_ride::{Excitation, SimulatedRide};
use veloid_engine::{Bike, EngineError, Imposed, Ride, simulate};

fn main() -> Result<(), EngineError> {
    let simulated_ride = SimulatedRide {
        duration_s: 20.0,
        excitation: Excitation::Road {
            roughness: Some(Roughness::C),
            bumps: Vec::new(),
        },
        ..SimulatedRide::default()
    };
    let bike = Bike::default();
    let friction = Imposed {
        id: "coulomb_friction".to_owned(),
        axle: Place::Front,
        parameters: BTreeMap::from([("friction".to_owned(), 40.0)]),
    };
    let (plain, rubbing) = (
        simulate(&simulated_ride, &bike, &[])?,
        simulate(&simulated_ride, &bike, &[friction])?,
    );
    println!("rms of the front axle's displacement:");
    println!(
        "{:.3} mm without friction, {:.3} mm with 40 N of it",
        rms(&plain),
        rms(&rubbing)
    );
    Ok(())
}

/// Of z_f (mm).
fn rms(ride: &Ride) -> f64 {
    let front = ride.axles.front.as_ref();
    let z = front.map_or(&[][..], |record| &record.displacement);
    1e3 * (z.iter().map(|z| z * z).sum::<f64>() / z.len().max(1) as f64).sqrt()
}
