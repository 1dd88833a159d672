//! Makes one planned ride: bicycle, excitation, concealed effects, motion, log.

use serde_json::{Value, json};

use super::case::{Case, Class, Noise, Setting};
use super::circumstance::Circumstance;
use super::disguise;
use super::excitation::{Excitation, Ridden};
use super::sizes::{self, Scale};
use super::strange::{self, Around};
use crate::chance::Chance;
use crate::refit::known::{Known, Truth, assess};
use crate::simulate::drive::Drive;
use crate::simulate::effect::{Axle, Effect, Kind};
use crate::simulate::integrate::{Motion, integrate};
use crate::simulate::outside::{Outside, Strange};
use crate::simulate::sensors::{Log, Sensors};
use crate::simulate::vehicle::{Bike, Vehicle};

/// A ride with its truth.
pub struct Made {
    pub log: Log,
    pub bike_file: Value,
    pub truth: Value,
}

/// Times a ride is drawn again until it is bounded and shows what it conceals.
const ATTEMPTS: u64 = 6;
/// Largest displacement of a believable ride, m.
const BOUNDED_M: f64 = 0.15;
/// Largest held-out error with which the truth, driven by the log, predicts a believable ride, m.
const PREDICTABLE_M: f64 = 5e-4;
/// Share of the explainable held-out variance from which a library effect is as good as strange physics.
const DISGUISED: f64 = 0.97;
/// Share of the samples that a clipped displacement passes.
const CLIPPED: f64 = 0.03;
/// How far a wrong mass is off, either way.
const MASS_ERROR: f64 = 0.1;

/// Makes ride number `number` of the suite drawn from `seed`; the same arguments give the same bytes.
pub fn make(case: &Case, name: &str, seed: u64, number: u64) -> Made {
    let mut attempt = 0;
    loop {
        let chance = &mut Chance::new(seed, 1 + number + (attempt << 32));
        let scene = Dataset::draw(case, chance);
        let vehicle = scene.conceal(attempt, chance);
        let mut log = scene.record(&vehicle, chance);
        attempt += 1;
        let bounded = log.z.iter().flatten().all(|z| z.abs() < BOUNDED_M);
        if attempt == ATTEMPTS || (bounded && scene.shows(&vehicle, &log, chance)) {
            let truth = scene.truth(name, &vehicle, &log);
            if let Some(axle) = case.circumstance.and_then(Circumstance::alone) {
                log.leave_out(1 - axle);
            }
            return Made {
                log,
                bike_file: scene.bike_file(name, chance),
                truth,
            };
        }
    }
}

/// A clean ride with all that moved, for benches with other sensors.
pub struct Plain {
    pub bike: Bike,
    pub motion: Motion,
    pub log: Log,
    pub bike_file: Value,
    ridden: Ridden,
}

impl Plain {
    /// Height of the road under a wheel at `t`, m.
    pub fn road(&self, axle: usize, t: f64) -> f64 {
        match &self.ridden.excitation {
            Excitation::Road { road, behind_m } => {
                let behind = if axle == 0 { 0.0 } else { *behind_m };
                road.height(self.ridden.distance(t) - behind)
            }
            Excitation::Plate(waves) => waves[axle].at(t).0,
            Excitation::Shaker(_) | Excitation::Decay(_) => 0.0,
        }
    }
}

/// A clean ride of the seed's stream `number`.
pub fn plain(case: &Case, seed: u64, number: u64) -> Plain {
    let chance = &mut Chance::new(seed, number);
    let scene = Dataset::draw(case, chance);
    let vehicle = scene.conceal(0, chance);
    let drive = scene.ridden.drive(&vehicle.effects);
    let motion = whole(&vehicle, &drive, &scene.ridden);
    let log = write_log(
        &vehicle,
        &scene.ridden,
        &motion,
        &scene.sensors,
        &scene.nominal,
        chance,
    );
    let noise_m = total_noise(&scene.sensors);
    let bike_file = bike_file(
        &scene.bike,
        "misread",
        noise_m,
        scene.sensors.road_m,
        chance,
    );
    let Dataset { bike, ridden, .. } = scene;
    Plain {
        bike,
        motion,
        log,
        bike_file,
        ridden,
    }
}

/// A ride without what it conceals.
struct Dataset<'a> {
    case: &'a Case,
    bike: Bike,
    sensors: Sensors,
    nominal: Vec<f64>,
    ridden: Ridden,
    mean_speed_m_s: f64,
    scale: Scale,
}

impl<'a> Dataset<'a> {
    fn draw(case: &'a Case, chance: &mut Chance) -> Self {
        let bike = draw_bike(case, chance);
        let sensors = match case.circumstance {
            Some(Circumstance::Noiseless) => Sensors {
                one_clock: true,
                ..Sensors::default()
            },
            _ => draw_sensors(case.noise, chance),
        };
        let samples = (case.duration_s * case.rate_hz) as usize;
        let nominal: Vec<f64> = (0..=samples).map(|i| i as f64 / case.rate_hz).collect();
        let mut ridden = Ridden::draw(case, &bike, chance);
        resize(&mut ridden, case, &bike, chance);
        let mean_speed_m_s =
            nominal.iter().map(|&t| ridden.speed.value(t)).sum::<f64>() / nominal.len() as f64;
        let drive = ridden.drive(&[]);
        let motion = whole(&Vehicle::plain(bike.clone()), &drive, &ridden);
        let scale = Scale::measure(
            &motion,
            &drive,
            case.duration_s,
            mean_speed_m_s,
            total_noise(&sensors),
        );
        Self {
            case,
            bike,
            sensors,
            nominal,
            ridden,
            mean_speed_m_s,
            scale,
        }
    }

    /// The bicycle with its concealed physics; later attempts make pairs and strange physics stronger.
    fn conceal(&self, attempt: u64, chance: &mut Chance) -> Vehicle {
        let case = self.case;
        let size = if matches!(case.class, Class::Two | Class::Three) {
            (case.size + attempt as usize).min(2)
        } else {
            case.size
        };
        let effects = case
            .effects
            .iter()
            .map(|&(kind, axle)| sizes::draw(kind, axle, size, &self.bike, &self.scale, chance))
            .collect();
        let boost = 1.4_f64.powi(attempt as i32);
        let outside = case.strange.and_then(|(kind, axle)| {
            let around = Around::new(axle, case.size, boost, &self.bike, &self.scale);
            strange::draw(kind, axle, &around, chance)
        });
        Vehicle {
            effects,
            outside,
            mean_speed_m_s: self.mean_speed_m_s,
            ..Vehicle::plain(self.bike.clone())
        }
    }

    fn record(&self, vehicle: &Vehicle, chance: &mut Chance) -> Log {
        let motion = whole(vehicle, &self.ridden.drive(&vehicle.effects), &self.ridden);
        let mut log = write_log(
            vehicle,
            &self.ridden,
            &motion,
            &self.sensors,
            &self.nominal,
            chance,
        );
        if self.case.circumstance == Some(Circumstance::Clipped) {
            log.clip(CLIPPED);
        }
        log
    }

    /// The bike file, with wrong masses (and no static loads, which would tell) where the case asks for them.
    fn bike_file(&self, name: &str, chance: &mut Chance) -> Value {
        let noise_m = total_noise(&self.sensors);
        let mut file = bike_file(&self.bike, name, noise_m, self.sensors.road_m, chance);
        let circumstance = self.case.circumstance;
        if circumstance.is_some_and(Circumstance::has_wrong_mass) {
            for (axle, side) in ["front", "rear"].into_iter().enumerate() {
                let mass = self.bike.mass_kg[axle] * (1.0 + MASS_ERROR * chance.sign());
                file[format!("mass_{side}_kg")] = json!((10.0 * mass).round() / 10.0);
                file[format!("static_load_{side}_n")] = Value::Null;
                if circumstance == Some(Circumstance::MassDeclared) {
                    let std = (100.0 * MASS_ERROR * mass).round() / 100.0;
                    file[format!("mass_{side}_std_kg")] = json!(std);
                }
            }
        }
        file
    }

    /// Strange physics must raise the plain model's held-out error to 1.3 x the floor and be no library effect in disguise; a medium or large effect, and each effect
    /// of several alone, to 1.15 x. A ride that the truth itself cannot predict from its log (chaotic bouncing) shows nothing.
    fn shows(&self, vehicle: &Vehicle, log: &Log, chance: &mut Chance) -> bool {
        match self.case.class {
            Class::Clean => true,
            Class::Single if self.case.size == 0 => true,
            Class::Single => self.visibility(vehicle, log.clone()) >= 1.15,
            Class::Outside => self.strange(vehicle, log),
            Class::Beside => self.both_show(vehicle, chance),
            Class::Two | Class::Three => {
                self.visibility(vehicle, log.clone()) > 0.0
                    && vehicle.effects.iter().all(|effect| {
                        let alone = Vehicle {
                            effects: vec![effect.clone()],
                            ..vehicle.clone()
                        };
                        let log = self.record(&alone, chance);
                        self.visibility(&alone, log) >= 1.15
                    })
            }
        }
    }

    /// The effect is seen alone, and so is the strange physics, which is no library effect in disguise.
    fn both_show(&self, vehicle: &Vehicle, chance: &mut Chance) -> bool {
        let listed = Vehicle {
            outside: None,
            ..vehicle.clone()
        };
        let strange = Vehicle {
            effects: Vec::new(),
            ..vehicle.clone()
        };
        let log = self.record(&listed, chance);
        self.visibility(&listed, log) >= 1.15 && {
            let log = self.record(&strange, chance);
            self.strange(&strange, &log)
        }
    }

    fn visibility(&self, vehicle: &Vehicle, log: Log) -> f64 {
        self.assess(vehicle, log)
            .map_or(0.0, |known| known.visibility())
    }

    /// Seen, and not a library effect in disguise.
    fn strange(&self, vehicle: &Vehicle, log: &Log) -> bool {
        let Some((known, outside)) = self
            .assess(vehicle, log.clone())
            .zip(vehicle.outside.as_ref())
        else {
            return false;
        };
        known.visibility() >= 1.3
            && disguise::share(
                log.clone(),
                &self.bike,
                (outside.kind, outside.axle),
                &known,
                &self.scale,
            ) < DISGUISED
    }

    fn assess(&self, vehicle: &Vehicle, log: Log) -> Option<Known> {
        let truth = Truth {
            effects: vehicle.effects.clone(),
            outside: vehicle.outside.clone(),
            stiffness_n_m: self.bike.stiffness_n_m,
            damping_n_s_m: self.bike.damping_n_s_m,
            mass_kg: None,
        };
        assess(log, &self.bike, &truth, false)
            .filter(|known| known.floor_m.iter().all(|floor| *floor < PREDICTABLE_M))
    }

    fn truth(&self, name: &str, vehicle: &Vehicle, log: &Log) -> Value {
        let (case, sensors) = (self.case, &self.sensors);
        let mut truth = json!({
            "ride": name,
            "class": case.class.name(),
            "setting": case.setting.name(),
            "size": case.size,
            "effects": vehicle.effects.iter().map(Effect::to_json).collect::<Vec<_>>(),
            "outside": vehicle.outside.as_ref().map(Outside::to_json),
            "stiffness_n_m": self.bike.stiffness_n_m,
            "damping_n_s_m": self.bike.damping_n_s_m,
            "mean_speed_m_s": self.mean_speed_m_s,
            "deflection_rms_m": self.scale.deflection_m,
            "duration_s": case.duration_s,
            "rate_hz": case.rate_hz,
            "noise": {
                "kind": case.noise.name(),
                "white_m": sensors.white_m, "coloured_m": sensors.coloured_m, "correlation": sensors.correlation,
                "quantum_m": sensors.quantum_m, "road_m": sensors.road_m, "jitter_s": sensors.jitter_s,
                "one_clock": sensors.one_clock,
            },
        });
        // Keys of suites that know no circumstances keep their bytes.
        if let Some(circumstance) = case.circumstance {
            truth["circumstance"] = json!(circumstance.name());
            if circumstance.has_wrong_mass() {
                truth["mass_kg"] = json!(self.bike.mass_kg);
            }
        }
        if let Some(limit_m) = log.limit_m {
            truth["limit_m"] = json!(limit_m);
        }
        truth
    }
}

/// The motion of the whole ride.
pub fn whole(vehicle: &Vehicle, drive: &Drive, ridden: &Ridden) -> Motion {
    integrate(
        vehicle,
        drive,
        ridden.release(),
        [true, true],
        f64::INFINITY,
    )
}

fn draw_bike(case: &Case, chance: &mut Chance) -> Bike {
    let tenth = |x: f64| (10.0 * x).round() / 10.0;
    let total = chance.uniform(76.0, 108.0);
    let front = tenth(total * chance.uniform(0.25, 0.42));
    let mass_kg = [front, tenth(total - front)];
    let wheelbase = chance.uniform(0.98, 1.14);
    let radius = chance.pick(&[0.334, 0.34, 0.348, 0.355, 0.368]);
    Bike {
        mass_kg,
        arm_m: [mass_kg[1], mass_kg[0]]
            .map(|m| (1e4 * wheelbase * m / (mass_kg[0] + mass_kg[1])).round() / 1e4),
        wheel_radius_m: [radius; 2],
        stiffness_n_m: [0, 1].map(|_| match case.circumstance {
            Some(Circumstance::Stiff) => chance.log_uniform(300e3, 800e3),
            _ => chance.log_uniform(60e3, 150e3),
        }),
        damping_n_s_m: [0, 1].map(|_| match case.setting {
            // A release must still ring in the part that is held out.
            Setting::Decay => chance.uniform(5.0, 12.0),
            _ => chance.log_uniform(200.0, 1200.0),
        }),
    }
}

/// Sensors with noise of a kind, its size drawn.
pub fn draw_sensors(noise: Noise, chance: &mut Chance) -> Sensors {
    let size = chance.log_uniform(2e-5, 2e-4);
    let white = Sensors {
        white_m: size,
        one_clock: true,
        ..Sensors::default()
    };
    match noise {
        Noise::White => white,
        Noise::Coloured => Sensors {
            white_m: 0.4 * size,
            coloured_m: 0.9 * size,
            correlation: chance.uniform(0.7, 0.97),
            ..white
        },
        Noise::Quantised => Sensors {
            quantum_m: chance.pick(&[1e-5, 2e-5, 5e-5, 1e-4]),
            ..white
        },
        Noise::Road => Sensors {
            road_m: chance.log_uniform(2e-5, 2e-4),
            ..white
        },
        Noise::Jitter => Sensors {
            jitter_s: chance.log_uniform(1e-4, 8e-4),
            one_clock: chance.happens(0.5),
            ..white
        },
    }
}

/// Standard deviation of the displacement noise, m.
pub fn total_noise(s: &Sensors) -> f64 {
    (s.white_m.powi(2) + s.coloured_m.powi(2) + s.quantum_m.powi(2) / 12.0).sqrt()
}

/// Scales road or shakers so that deflections are a bicycle's, or so that the wheels lift as often as asked.
pub fn resize(ridden: &mut Ridden, case: &Case, bike: &Bike, chance: &mut Chance) {
    let drive = ridden.drive(&[]);
    let motion = whole(&Vehicle::plain(bike.clone()), &drive, ridden);
    let scale = Scale::measure(&motion, &drive, case.duration_s, 0.0, 0.0);
    let target = [0, 1].map(|_| chance.log_uniform(0.9e-3, 3e-3));
    let factors = match &ridden.excitation {
        Excitation::Road { .. } => {
            let lifting = case
                .effects
                .iter()
                .find(|(kind, _)| *kind == Kind::WheelLift);
            let factor = match lifting {
                Some((_, axle)) => lift_factor(
                    &motion,
                    &drive,
                    bike,
                    usize::from(*axle == Axle::Rear),
                    case.size,
                ),
                None => target[0] / (scale.deflection_m[0] * scale.deflection_m[1]).sqrt(),
            };
            [factor; 2]
        }
        _ => [0, 1].map(|a| target[a] / scale.deflection_m[a]),
    };
    ridden.scale(factors);
}

/// Factor on the road with which the plain tyre's load would be negative for 0.4, 1.5 or 5 % of the time.
fn lift_factor(motion: &Motion, drive: &Drive, bike: &Bike, axle: usize, size: usize) -> f64 {
    let mut pull: Vec<f64> = (0..motion.z[axle].len())
        .map(|i| {
            let at = drive.at(2 * i);
            bike.stiffness_n_m[axle] * (motion.z[axle][i] - at.road[axle])
                + bike.damping_n_s_m[axle] * (motion.z_rate[axle][i] - at.road_rate[axle])
        })
        .collect();
    pull.sort_by(f64::total_cmp);
    let share = [0.004, 0.015, 0.05][size];
    let quantile = pull[((1.0 - share) * (pull.len() - 1) as f64) as usize];
    9.81 * bike.mass_kg[axle] / quantile
}

/// What the loggers make of a motion.
pub fn write_log(
    vehicle: &Vehicle,
    ridden: &Ridden,
    motion: &Motion,
    sensors: &Sensors,
    nominal: &[f64],
    chance: &mut Chance,
) -> Log {
    let shared = sensors.instants(nominal, chance);
    let mut log = Log {
        t: nominal.to_vec(),
        ..Log::default()
    };
    let instants = |chance: &mut Chance| {
        if sensors.one_clock {
            shared.clone()
        } else {
            sensors.instants(nominal, chance)
        }
    };
    for axle in 0..2 {
        let at = instants(chance);
        log.z[axle] = sensors.displacement(motion, axle, &vehicle.effects, &at, nominal, chance);
        let at = instants(chance);
        match &ridden.excitation {
            Excitation::Road { road, behind_m } => {
                let behind = if axle == 0 { 0.0 } else { *behind_m };
                log.u[axle] =
                    sensors.road(|t| road.height(ridden.distance(t) - behind), &at, chance);
            }
            Excitation::Plate(waves) => {
                log.u[axle] = sensors.road(|t| waves[axle].at(t).0, &at, chance)
            }
            Excitation::Shaker(waves) => {
                log.force[axle] = at.iter().map(|&t| waves[axle].at(t).0).collect()
            }
            Excitation::Decay(_) => {}
        }
    }
    if matches!(ridden.excitation, Excitation::Road { .. }) {
        log.v = nominal
            .iter()
            .map(|&t| ridden.speed.value(t) + 0.01 * chance.normal())
            .collect();
        let pedals = vehicle
            .effects
            .iter()
            .any(|e| e.kind == Kind::PedallingForce)
            || (vehicle.outside.as_ref()).is_some_and(|o| o.kind == Strange::CrankDamping);
        if pedals || chance.happens(0.9) {
            log.cadence = nominal
                .iter()
                .map(|&t| ridden.cadence.value(t) + 0.2 * chance.normal())
                .collect();
        }
    }
    log
}

/// The bike file of the contract; noise is declared in a third of them.
pub fn bike_file(bike: &Bike, name: &str, noise_m: f64, road_m: f64, chance: &mut Chance) -> Value {
    let declared = chance.happens(0.35);
    let loads = chance.happens(0.5);
    let round = |x: f64| (1e7 * x).round() / 1e7;
    let some = |yes: bool, x: f64| if yes { json!(x) } else { Value::Null };
    json!({
        "bike": format!("truth-{name}"),
        "mass_front_kg": bike.mass_kg[0], "mass_rear_kg": bike.mass_kg[1],
        "l_front_m": bike.arm_m[0], "l_rear_m": bike.arm_m[1],
        "wheel_radius_front_m": bike.wheel_radius_m[0], "wheel_radius_rear_m": bike.wheel_radius_m[1],
        "static_load_front_n": some(loads, (bike.mass_kg[0] * 981.0).round() / 100.0),
        "static_load_rear_n": some(loads, (bike.mass_kg[1] * 981.0).round() / 100.0),
        "noise_displacement_m": some(declared, round(noise_m)),
        "noise_road_m": some(declared, round(road_m)),
        "equal_axles": false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::suite::plan::{conditions, standard, strange};

    #[test]
    fn the_same_seed_gives_the_same_bytes_and_another_seed_does_not() {
        let chance = &mut Chance::new(5, 0);
        for plan in [standard(chance), strange(chance), conditions(chance)] {
            let concealing = plan.iter().find(|c| c.class > Class::Single);
            let case = Case {
                duration_s: 5.0,
                ..concealing.expect("the suite has them").clone()
            };
            let csv = |seed| make(&case, "a", seed, 3).log.to_csv();
            assert_eq!(csv(1), csv(1));
            assert_ne!(csv(1), csv(2));
        }
    }

    fn short(circumstance: Circumstance) -> Case {
        let chance = &mut Chance::new(5, 0);
        let case = Case::new(Class::Clean, Setting::Road, Noise::White, chance).under(circumstance);
        Case {
            duration_s: 5.0,
            ..case
        }
    }

    #[test]
    fn an_axle_alone_has_no_channels_of_the_other() {
        let log = make(&short(Circumstance::RearAlone), "a", 1, 3).log;
        assert!(log.to_csv().starts_with("t,u_r,z_r,v"));
    }

    #[test]
    fn a_wrong_mass_is_ten_percent_off_and_the_key_has_the_true_one() {
        for circumstance in [Circumstance::MassDeclared, Circumstance::MassWrong] {
            let made = make(&short(circumstance), "a", 1, 3);
            let truth = made.truth["mass_kg"][1].as_f64().expect("a mass");
            let said = made.bike_file["mass_rear_kg"].as_f64().expect("a mass");
            assert!(((said / truth - 1.0).abs() - MASS_ERROR).abs() < 2e-3);
            let declares = made.bike_file["mass_rear_std_kg"].is_number();
            assert_eq!(declares, circumstance == Circumstance::MassDeclared);
        }
    }
}
