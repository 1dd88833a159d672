//! Rides as prescribed: bicycle, speed, road and log are given, not drawn.

use serde_json::Value;

use crate::chance::Chance;
use crate::simulate::effect::Effect;
use crate::simulate::integrate::Motion;
use crate::simulate::sensors::{Log, Sensors};
use crate::simulate::speed::Profile;
use crate::simulate::vehicle::{Bike, Vehicle};
use crate::suite::case::{Case, Class, Noise, Setting};
use crate::suite::excitation::Ridden;
use crate::suite::ride;

/// One prescribed ride.
#[derive(Clone, Debug)]
pub struct Plan {
    pub case: Case,
    pub bike: Bike,
    /// Mean speed (m/s); without meaning where there is no road.
    pub speed_m_s: f64,
    /// Density of the road at 0.1 cycles/m (m^3).
    pub density_m3: f64,
    /// Where it ends (cycles/m), unless the log carries less.
    pub highest_per_m: f64,
}

impl Plan {
    /// A minute at 5 m/s on a road between classes A and C, logged at 100 Hz with noise of any kind.
    pub fn usual(bike: Bike, chance: &mut Chance) -> Self {
        Self {
            case: clean(Setting::Road, chance.pick(&Noise::ALL)),
            bike,
            speed_m_s: 5.0 * chance.uniform(0.8, 1.25),
            density_m3: chance.log_uniform(32e-6, 256e-6),
            highest_per_m: f64::INFINITY,
        }
    }
}

/// A case that conceals nothing.
pub fn clean(setting: Setting, noise: Noise) -> Case {
    let release = setting == Setting::Decay;
    Case {
        class: Class::Clean,
        effects: Vec::new(),
        strange: None,
        size: 1,
        setting,
        noise,
        circumstance: None,
        duration_s: if release { 12.0 } else { 60.0 },
        rate_hz: if release { 200.0 } else { 100.0 },
    }
}

/// A bicycle with stiffnesses (N/m) and dampings (N s/m) drawn between limits.
pub fn bike(stiffness: [f64; 2], damping: [f64; 2], chance: &mut Chance) -> Bike {
    let total = chance.uniform(76.0, 108.0);
    let tenth = |x: f64| (10.0 * x).round() / 10.0;
    let front = tenth(total * chance.uniform(0.25, 0.42));
    let mass_kg = [front, tenth(total - front)];
    let wheelbase = chance.uniform(0.98, 1.14);
    let arm = |m: f64| (1e4 * wheelbase * m / (mass_kg[0] + mass_kg[1])).round() / 1e4;
    Bike {
        mass_kg,
        arm_m: [arm(mass_kg[1]), arm(mass_kg[0])],
        wheel_radius_m: [0.34; 2],
        stiffness_n_m: [0, 1].map(|_| chance.log_uniform(stiffness[0], stiffness[1])),
        damping_n_s_m: [0, 1].map(|_| chance.log_uniform(damping[0], damping[1])),
    }
}

/// The bicycle with the rear axle's mass and the front axle's stiffness and damping on both.
pub fn alike(bike: Bike) -> Bike {
    let half = bike.wheelbase_m() / 2.0;
    Bike {
        mass_kg: [bike.mass_kg[1]; 2],
        arm_m: [half; 2],
        stiffness_n_m: [bike.stiffness_n_m[0]; 2],
        damping_n_s_m: [bike.damping_n_s_m[0]; 2],
        ..bike
    }
}

/// A prescribed ride whose road and sensors are drawn; it can be ridden several times.
pub struct Scene {
    pub plan: Plan,
    pub bike_file: Value,
    sensors: Sensors,
    ridden: Ridden,
    nominal: Vec<f64>,
}

/// One time that it was ridden.
pub struct Take {
    pub log: Log,
    pub motion: Motion,
}

impl Scene {
    pub fn draw(plan: Plan, chance: &mut Chance) -> Self {
        let Plan { case, bike, .. } = &plan;
        let sensors = ride::draw_sensors(case.noise, chance);
        let ridden = if case.setting == Setting::Road {
            let speed = Profile::wobble(plan.speed_m_s, 0.04 * plan.speed_m_s, chance);
            let road = (plan.density_m3, plan.highest_per_m);
            Ridden::on_road(case, bike, speed, road, chance)
        } else {
            let mut ridden = Ridden::draw(case, bike, chance);
            ride::resize(&mut ridden, case, bike, chance);
            ridden
        };
        let samples = (case.duration_s * case.rate_hz) as usize;
        let nominal = (0..=samples).map(|i| i as f64 / case.rate_hz).collect();
        let (noise_m, road_m) = (ride::total_noise(&sensors), sensors.road_m);
        Self {
            bike_file: ride::bike_file(bike, "trial", noise_m, road_m, chance),
            sensors,
            ridden,
            nominal,
            plan,
        }
    }

    /// The ride with these effects, its noise drawn from `chance`.
    pub fn ride(&self, effects: Vec<Effect>, chance: &mut Chance) -> Take {
        let speeds = self.nominal.iter().map(|&t| self.ridden.speed.value(t));
        let vehicle = Vehicle {
            effects,
            mean_speed_m_s: speeds.sum::<f64>() / self.nominal.len() as f64,
            ..Vehicle::plain(self.plan.bike.clone())
        };
        let motion = ride::whole(&vehicle, &self.ridden.drive(&vehicle.effects), &self.ridden);
        let log = ride::write_log(
            &vehicle,
            &self.ridden,
            &motion,
            &self.sensors,
            &self.nominal,
            chance,
        );
        Take { log, motion }
    }
}

impl Take {
    /// The log of two accelerometers and the speed, with white noise (m/s^2).
    pub fn accelerometers(&self, noise_m_s2: f64, chance: &mut Chance) -> String {
        let mut text = "t,a_f,a_r,v\n".to_owned();
        for (t, v) in self.log.t.iter().zip(&self.log.v) {
            let [front, rear] = [0, 1]
                .map(|axle| self.motion.acceleration(axle, *t) + noise_m_s2 * chance.normal());
            text += &format!("{t:.4},{front:.6},{rear:.6},{v:.3}\n");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_is_the_same_ride_each_time() {
        let chance = &mut Chance::new(3, 0);
        let bike = bike([60e3, 150e3], [200.0, 1200.0], chance);
        let mut plan = Plan::usual(bike, chance);
        plan.case.duration_s = 4.0;
        let scene = Scene::draw(plan, chance);
        let take = |stream| scene.ride(Vec::new(), &mut Chance::new(3, stream));
        let (one, other) = (take(1), take(2));
        assert_eq!(one.motion.z, other.motion.z);
        assert_ne!(one.log.z, other.log.z);
        let text = one.accelerometers(0.05, chance);
        assert_eq!(text.lines().count(), one.log.t.len() + 1);
    }
}
