//! The kernels, each with its input made ready.

use std::hint::black_box;

use veloid_engine::bicycle::Bike;
use veloid_engine::observer::differentiate_all;
use veloid_engine::output_error::{self, Start};
use veloid_engine::ride::{ReadOptions, Ride, parse_only};
use veloid_engine::simulate::simulated_ride::SimulatedRide;
use veloid_engine::swarm::Swarm;
use veloid_engine::{Objective, Settings, Silent, observe};

pub const NAMES: [&str; 7] = [
    "parse",
    "observer",
    "observe",
    "swarm_gradient",
    "swarm_consistent",
    "swarm_consistent_600_s",
    "output_error",
];

/// What runs the kernel of this name once.
pub fn ready(name: &str) -> Box<dyn Fn()> {
    match name {
        "parse" => {
            let (file, options) = (text(&ride(60.0)), ReadOptions::default());
            once(move || parse_only(&file, &options).is_ok())
        }
        "observer" => {
            let ride = ride(60.0);
            once(move || {
                let signals: Vec<(&[f64], f64)> = (ride.axles.iter())
                    .flat_map(|(_, r)| [(&r.displacement[..], 2000.0), (&r.road, 2000.0)])
                    .collect();
                differentiate_all(&signals, ride.step_s)
            })
        }
        "observe" => {
            let ride = ride(60.0);
            once(move || observe(&ride, &bike(), &Settings::default()).is_ok())
        }
        "swarm_gradient" => swarm(60.0, Objective::Gradient),
        "swarm_consistent" => swarm(60.0, Objective::Consistent),
        "swarm_consistent_600_s" => swarm(600.0, Objective::Consistent),
        "output_error" => {
            let ride = ride(60.0);
            let start = ride.axles.map(|_, _| Start {
                kappa: 3000.0,
                beta: 40.0,
                per_mass: 0.03,
            });
            let settings = Settings::default();
            once(move || {
                output_error::fit(&ride, &bike(), &settings, std::slice::from_ref(&start)).is_ok()
            })
        }
        _ => panic!("no kernel '{name}'"),
    }
}

fn once<T>(work: impl Fn() -> T + 'static) -> Box<dyn Fn()> {
    Box::new(move || {
        black_box(work());
    })
}

/// One trial, the ride made ready.
fn swarm(duration_s: f64, objective: Objective) -> Box<dyn Fn()> {
    let ride = ride(duration_s);
    let settings = Settings {
        objective,
        ..Settings::default()
    };
    let ready = observe(&ride, &bike(), &settings)
        .and_then(|observed| Swarm::new(&ride, &bike(), &settings, &observed));
    let Ok(ready) = ready else {
        panic!("the ride cannot be searched")
    };
    once(move || ready.trial(0, &Silent).is_ok())
}

fn ride(duration_s: f64) -> Ride {
    SimulatedRide {
        duration_s,
        noise_displacement_m: 5e-5,
        ..SimulatedRide::default()
    }
    .ride()
}

fn bike() -> Bike {
    Bike {
        mass_front_kg: Some(23.0),
        mass_rear_kg: Some(63.0),
        ..Bike::default()
    }
}

fn text(ride: &Ride) -> Vec<u8> {
    let mut text = "t,u_f,z_f,u_r,z_r\n".to_owned();
    for i in 0..ride.samples {
        text += &format!("{:.4}", ride.time_s(i));
        for (_, record) in ride.axles.iter() {
            text += &format!(",{:.7},{:.7}", record.road[i], record.displacement[i]);
        }
        text += "\n";
    }
    text.into_bytes()
}
