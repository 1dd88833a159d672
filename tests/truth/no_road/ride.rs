//! Makes one planned ride.

use serde_json::{Value, json};

use super::conceal;
use super::conditions::Conditions;
use super::course::Course;
use super::plan::Planned;
use crate::chance::Chance;
use crate::outcome::{Name, sorted};
use crate::simulate::effect::{Effect, Kind};
use crate::simulate::integrate::Motion;
use crate::simulate::outside::Outside;
use crate::simulate::sensors::Log;
use crate::simulate::vehicle::{Bike, Vehicle};
use crate::suite::ride::bike_file;

/// A ride with its truth.
pub struct Made {
    pub log: Log,
    pub bike_file: Value,
    pub bike: Bike,
    /// What is concealed, as reports name it.
    pub names: Vec<Name>,
    pub key: Value,
}

/// Draws a ride; the same arguments give the same bytes.
pub fn make(planned: &Planned, name: &str, chance: &mut Chance) -> Made {
    let course = Course::draw(planned, chance);
    let vehicle = conceal::vehicle(planned, &course.bike, &course.scale(), chance);
    let motion = course.motion(&vehicle);
    let names = vehicle.effects.iter();
    let names = names.map(|e| (e.kind.id().to_owned(), e.axle.name().to_owned()));
    Made {
        log: course.log(&vehicle, &motion, chance),
        names: sorted(names.collect()),
        key: key(&course, planned, name, &vehicle, &motion),
        bike_file: without_noise(&course.bike, name, chance),
        bike: course.bike,
    }
}

/// Without noise of displacements, of which there are none.
fn without_noise(bike: &Bike, name: &str, chance: &mut Chance) -> Value {
    let mut file = bike_file(bike, name, 0.0, 0.0, chance);
    for noise in ["noise_displacement_m", "noise_road_m"] {
        file[noise] = Value::Null;
    }
    file
}

fn key(
    course: &Course,
    planned: &Planned,
    name: &str,
    vehicle: &Vehicle,
    motion: &Motion,
) -> Value {
    let Conditions {
        ground,
        logger,
        duration_s,
        ..
    } = &course.conditions;
    let in_the_air = [0, 1].map(|axle| in_the_air(vehicle, motion, axle));
    json!({
        "ride": name,
        "class": planned.class.words(),
        "effects": vehicle.effects.iter().map(Effect::to_json).collect::<Vec<_>>(),
        "outside": vehicle.outside.as_ref().map(Outside::to_json),
        "mass_kg": course.bike.mass_kg,
        "stiffness_n_m": course.bike.stiffness_n_m,
        "damping_n_s_m": course.bike.damping_n_s_m,
        "density_m3": ground.density_m3,
        "patch_m": ground.patch_m,
        "offset_m": ground.offset_m,
        "duration_s": duration_s,
        "rate_hz": logger.rate_hz,
        "speed_m_s": course.conditions.speed.base,
        "noise": {"a_m_s2": logger.noise_m_s2, "v_m_s": logger.speed_m_s},
        "rear": {"gain": logger.rear_gain, "late_s": logger.rear_late_s},
        "in_the_air": in_the_air,
    })
}

/// Share of the time that a wheel's tyre is without load.
fn in_the_air(vehicle: &Vehicle, motion: &Motion, axle: usize) -> f64 {
    let Some(load) = vehicle.find(Kind::WheelLift, axle) else {
        return 0.0;
    };
    let falls = load[0] / vehicle.bike.mass_kg[axle] - 1e-6;
    let a = &motion.z_acceleration[axle];
    a.iter().filter(|a| **a < -falls).count() as f64 / a.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::no_road::class::Class;
    use crate::no_road::plan;

    fn planned(is: impl Fn(&Planned) -> bool) -> Planned {
        let plan = plan::plan(&mut Chance::new(1, 0));
        plan.into_iter().find(is).expect("the plan has it")
    }

    fn made(planned: &Planned, stream: u64) -> Made {
        make(planned, "ride_000", &mut Chance::new(5, stream))
    }

    #[test]
    fn a_ride_has_two_accelerometers_and_a_speed_and_is_the_same_each_time() {
        let clean = planned(|p| p.class == Class::Clean);
        let (one, again, other) = (made(&clean, 1), made(&clean, 1), made(&clean, 2));
        let csv = one.log.to_csv();
        assert!(csv.starts_with("t,a_f,a_r,v"), "{}", &csv[..20]);
        assert_eq!(csv, again.log.to_csv());
        assert_ne!(csv, other.log.to_csv());
        assert!(one.names.is_empty() && one.key["outside"].is_null());
        let seconds = one.key["duration_s"].as_f64().expect("a number");
        let rate = one.key["rate_hz"].as_f64().expect("a number");
        assert_eq!(one.log.t.len() as f64, seconds * rate);
    }

    #[test]
    fn cranks_that_push_are_logged_and_the_truth_is_named() {
        let pedals = planned(|p| {
            p.effects
                .first()
                .is_some_and(|e| e.0 == Kind::PedallingForce)
        });
        for stream in 0..3 {
            let ride = made(&pedals, stream);
            assert_eq!(ride.log.cadence.len(), ride.log.t.len());
            assert_eq!(ride.names[0].0, "pedalling_force");
        }
    }

    #[test]
    fn wheels_that_are_to_lift_do() {
        let lift = made(&planned(|p| p.class == Class::Lift), 1);
        let share = |axle: usize| lift.key["in_the_air"][axle].as_f64();
        assert!(
            (0..2).all(|axle| share(axle).is_some_and(|s| s > 0.02)),
            "{}",
            lift.key
        );
        let clean = made(&planned(|p| p.class == Class::Clean), 1);
        assert_eq!(clean.key["in_the_air"], json!([0.0, 0.0]));
    }
}
