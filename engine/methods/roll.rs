//! Roll, paper eqs. (3) to (9).
//!
//! Two slips in print are set right, because as printed eq. (4) is dimensionally impossible: all of
//! its terms are moments (N m), so m33 divides the whole bracket, and m13 multiplies the lateral
//! acceleration v_y', not v_y.

use crate::observer::{States, differentiate, jerk_bound};
use veloid_core::bicycle::{Axle, Bike, GRAVITY, RollParameters};
use veloid_report::RollReport;
use veloid_ride::Ride;

/// Steady roll angle phi = atan(v^2 / (g R_c)) (rad), eq. (3), with the radius of curvature
/// R_c = v / psi' from the yaw rate: atan(v psi' / g).
pub fn steady_roll(speed: f64, yaw_rate: f64) -> f64 {
    (speed * yaw_rate / GRAVITY).atan()
}

/// Coefficients of eq. (4) that do not change along a ride.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    /// r31 (N m): eq. (5).
    pub r31: f64,
    /// m_F e g (N m) and eta (m) of r32 = m_F e g - eta F_nF: eq. (6).
    pub steer_weight: f64,
    pub trail: f64,
    /// r34, r36 (kg m): eqs. (7), (8).
    pub r34: f64,
    pub r36: f64,
    /// m13 (kg m), m23, m33, m34 (kg m^2): eq. (9).
    pub m13: f64,
    pub m23: f64,
    pub m33: f64,
    pub m34: f64,
}

/// What enters eq. (4) at one moment; rad, s, m, N.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    pub roll: f64,
    pub steer: f64,
    pub steer_rate: f64,
    pub steer_acceleration: f64,
    pub speed: f64,
    pub lateral_acceleration: f64,
    pub yaw_rate: f64,
    pub yaw_acceleration: f64,
    pub front_load: f64,
}

impl Coefficients {
    /// `radius`: of the front and of the rear wheel (m).
    pub fn new(p: &RollParameters, radius: [f64; 2]) -> Self {
        let (mf, mr) = (p.front_part_mass_kg, p.rear_part_mass_kg);
        let (j, h) = (p.front_part_height_m, p.rear_part_height_m);
        let (e, kx) = (p.steering_axis_offset_m, p.longitudinal_distance_m);
        let (sin, cos) = p.caster_angle_rad.sin_cos();
        let (ix, iz) = (p.front_roll_inertia_kg_m2, p.front_yaw_inertia_kg_m2);
        let spin_front = p.wheel_inertia_front_kg_m2 / radius[0];
        let spin_rear = p.wheel_inertia_rear_kg_m2 / radius[1];
        let m13 = mf * j + mr * h;
        Self {
            r31: m13 * GRAVITY,
            steer_weight: mf * e * GRAVITY,
            trail: p.trail_m,
            r34: -m13 - spin_front - spin_rear,
            r36: -spin_front * cos,
            m13,
            m23: mf * j * kx - p.rear_product_inertia_kg_m2 + (iz - ix) * sin * cos,
            m33: mf * j * j
                + mr * h * h
                + p.rear_roll_inertia_kg_m2
                + iz * sin * sin
                + ix * cos * cos,
            m34: mf * e * j + iz * sin,
        }
    }

    /// phi'' (rad/s^2), eq. (4).
    pub fn roll_acceleration(&self, m: &Moment) -> f64 {
        let r32 = self.steer_weight - self.trail * m.front_load;
        let moments = self.r31 * m.roll
            + r32 * m.steer
            + self.r34 * m.speed * m.yaw_rate
            + self.r36 * m.speed * m.steer_rate
            - (self.m13 * m.lateral_acceleration
                + self.m23 * m.yaw_acceleration
                + self.m34 * m.steer_acceleration);
        moments / self.m33
    }
}

/// Points kept for plotting.
const PLOT_POINTS: usize = 600;

/// The report's roll section; nothing without speed and yaw rate. `front_load`: eq. (2) at every
/// sample (N), where the front axle was recorded.
pub fn roll(ride: &Ride, bike: &Bike, front_load: Option<&[f64]>) -> Option<RollReport> {
    let (speed, yaw_rate) = (ride.speed.as_ref()?, ride.yaw_rate.as_ref()?);
    let mut notes = Vec::new();
    let steady: Vec<f64> = speed
        .iter()
        .zip(yaw_rate)
        .map(|(v, r)| steady_roll(*v, *r))
        .collect();
    if ride.roll.is_none() {
        notes.push("no roll channel: eq. (4) uses the steady roll angle of eq. (3)".to_owned());
    }
    let angle = ride.roll.as_ref().unwrap_or(&steady);
    let measured = Measured {
        speed,
        yaw_rate,
        angle,
        front_load,
    };
    let acceleration = acceleration(ride, bike, &measured, &mut notes);
    let observed = ride
        .roll
        .as_ref()
        .map(|r| states(r, ride.step_s).acceleration);
    let errors = acceleration.as_ref().zip(observed.as_ref()).map(|(a, b)| {
        let after = (1.0 / ride.step_s) as usize;
        let e = a.iter().zip(b).skip(after).map(|(a, b)| a - b);
        let (largest, sum, count) = e.fold((0.0_f64, 0.0, 0_usize), |(l, s, c), e| {
            (l.max(e.abs()), s + e * e, c + 1)
        });
        (largest, (sum / count.max(1) as f64).sqrt())
    });
    let every = ride.samples.div_ceil(PLOT_POINTS).max(1);
    let thin = |x: &Vec<f64>| x.iter().step_by(every).copied().collect::<Vec<_>>();
    Some(RollReport {
        t_s: (0..ride.samples)
            .step_by(every)
            .map(|i| ride.time_s(i))
            .collect(),
        steady_roll_rad: thin(&steady),
        measured_roll_rad: ride.roll.as_ref().map(thin),
        roll_acceleration_rad_s2: acceleration.as_ref().map(thin),
        observed_roll_acceleration_rad_s2: observed.as_ref().map(thin),
        acceleration_error_max_rad_s2: errors.map(|e| e.0),
        acceleration_error_rms_rad_s2: errors.map(|e| e.1),
        notes,
    })
}

/// At every sample: what eq. (4) takes as it is, without a derivative.
struct Measured<'a> {
    speed: &'a [f64],
    yaw_rate: &'a [f64],
    /// The roll angle, measured or steady.
    angle: &'a [f64],
    front_load: Option<&'a [f64]>,
}

/// Eq. (4) along the ride, where bike and ride have what it needs; derivatives by the observer.
fn acceleration(
    ride: &Ride,
    bike: &Bike,
    measured: &Measured,
    notes: &mut Vec<String>,
) -> Option<Vec<f64>> {
    let front_load = measured.front_load;
    let mut lacking = Vec::new();
    if bike.roll.is_none() {
        lacking.push("the bike file has no roll parameters");
    }
    if bike.wheel_radius_front_m.is_none() || bike.wheel_radius_rear_m.is_none() {
        lacking.push("the bike file lacks a wheel radius");
    }
    if ride.steer.is_none() {
        lacking.push("the ride has no steer channel");
    }
    let weight = bike.static_load(Axle::Front);
    if front_load.is_none() && weight.is_none() {
        lacking.push("the front wheel's load is unknown");
    }
    if !lacking.is_empty() {
        notes.push(format!(
            "no roll acceleration, eq. (4): {}",
            lacking.join(", ")
        ));
        return None;
    }
    let radius = [bike.wheel_radius_front_m?, bike.wheel_radius_rear_m?];
    let c = Coefficients::new(bike.roll.as_ref()?, radius);
    let steer = states(ride.steer.as_ref()?, ride.step_s);
    let yaw = states(measured.yaw_rate, ride.step_s);
    let lateral = ride.lateral_speed.as_ref().map(|v| states(v, ride.step_s));
    if lateral.is_none() {
        notes.push("no v_lat channel: lateral acceleration set to 0 in eq. (4)".to_owned());
    }
    if front_load.is_none() {
        notes.push("no front axle: its static load is used as F_nF in eq. (6)".to_owned());
    }
    let at = |i: usize| Moment {
        roll: measured.angle[i],
        steer: steer.position[i],
        steer_rate: steer.velocity[i],
        steer_acceleration: steer.acceleration[i],
        speed: measured.speed[i],
        lateral_acceleration: lateral.as_ref().map_or(0.0, |l| l.velocity[i]),
        yaw_rate: measured.yaw_rate[i],
        yaw_acceleration: yaw.velocity[i],
        front_load: front_load.map_or(weight.unwrap_or(0.0), |f| f[i]),
    };
    Some(
        (0..ride.samples)
            .map(|i| c.roll_acceleration(&at(i)))
            .collect(),
    )
}

fn states(signal: &[f64], step: f64) -> States {
    let bound = jerk_bound(signal, &vec![true; signal.len()], step);
    let [states] = differentiate([signal], [bound], step);
    states
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::simulate::simulated_ride::SimulatedRide;

    fn parameters() -> RollParameters {
        RollParameters {
            front_part_mass_kg: 5.0,
            rear_part_mass_kg: 80.0,
            front_part_height_m: 0.6,
            rear_part_height_m: 1.0,
            steering_axis_offset_m: 0.03,
            trail_m: 0.06,
            caster_angle_rad: 0.3,
            longitudinal_distance_m: 0.5,
            wheel_inertia_front_kg_m2: 0.1,
            wheel_inertia_rear_kg_m2: 0.12,
            front_roll_inertia_kg_m2: 0.08,
            front_yaw_inertia_kg_m2: 0.05,
            rear_roll_inertia_kg_m2: 9.0,
            rear_product_inertia_kg_m2: 2.0,
        }
    }

    /// Every coefficient worked out by hand, with its unit.
    #[test]
    fn golden_coefficients() {
        let c = Coefficients::new(&parameters(), [0.34, 0.35]);
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9 * b.abs(), "{a} {b}");
        near(c.m13, 83.0); // 5*0.6 + 80*1 kg m
        near(c.r31, 83.0 * 9.80665); // N m
        near(c.steer_weight, 5.0 * 0.03 * 9.80665); // N m
        near(c.r34, -83.0 - 0.1 / 0.34 - 0.12 / 0.35); // kg m
        near(c.r36, -0.1 / 0.34 * 0.955_336_489_125_606); // kg m
        near(
            c.m23,
            1.5 - 2.0 - 0.03 * 0.295_520_206_661_34 * 0.955_336_489_125_606,
        ); // kg m^2
        near(
            c.m33,
            1.8 + 80.0 + 9.0 + 0.05 * 0.087_332_192_545_161 + 0.08 * 0.912_667_807_454_839,
        ); // kg m^2
        near(c.m34, 0.09 + 0.05 * 0.295_520_206_661_34); // kg m^2
    }

    /// In another system of units (cm, g, ms) eq. (4) gives the same angle acceleration.
    #[test]
    fn equation_4_holds_in_any_units() {
        let p = parameters();
        let m = Moment {
            roll: 0.1,
            steer: 0.02,
            steer_rate: 0.3,
            steer_acceleration: 1.1,
            speed: 5.0,
            lateral_acceleration: 0.4,
            yaw_rate: 0.25,
            yaw_acceleration: 0.6,
            front_load: 210.0,
        };
        let c = Coefficients::new(&p, [0.34, 0.35]);
        let (kg, metre, s) = (1e3, 1e2, 1e3);
        let newton = kg * metre / (s * s);
        let scaled = Coefficients {
            r31: c.r31 * newton * metre,
            steer_weight: c.steer_weight * newton * metre,
            trail: c.trail * metre,
            r34: c.r34 * kg * metre,
            r36: c.r36 * kg * metre,
            m13: c.m13 * kg * metre,
            m23: c.m23 * kg * metre * metre,
            m33: c.m33 * kg * metre * metre,
            m34: c.m34 * kg * metre * metre,
        };
        let moment = Moment {
            roll: m.roll,
            steer: m.steer,
            steer_rate: m.steer_rate / s,
            steer_acceleration: m.steer_acceleration / (s * s),
            speed: m.speed * metre / s,
            lateral_acceleration: m.lateral_acceleration * metre / (s * s),
            yaw_rate: m.yaw_rate / s,
            yaw_acceleration: m.yaw_acceleration / (s * s),
            front_load: m.front_load * newton,
        };
        let (a, b) = (
            c.roll_acceleration(&m),
            scaled.roll_acceleration(&moment) * s * s,
        );
        assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
    }

    /// A rider on a straight line who leans falls like an inverted pendulum.
    #[test]
    fn without_steer_and_speed_it_is_a_pendulum() {
        let c = Coefficients::new(&parameters(), [0.34, 0.35]);
        let lean = Moment {
            roll: 0.05,
            ..Moment::default()
        };
        assert!((c.roll_acceleration(&lean) - c.r31 / c.m33 * 0.05).abs() < 1e-15);
    }

    #[test]
    fn steady_roll_of_a_known_corner() {
        // 5 m/s on a radius of 10 m: psi' = 0.5 rad/s, tan(phi) = 25 / (9.80665 * 10).
        assert!((steady_roll(5.0, 0.5) - (25.0_f64 / 98.0665).atan()).abs() < 1e-15);
        assert_eq!(steady_roll(5.0, 0.0), 0.0);
    }

    #[test]
    fn section_says_what_it_lacks() {
        let mut ride = SimulatedRide {
            duration_s: 10.0,
            ..SimulatedRide::default()
        }
        .ride();
        assert!(roll(&ride, &Bike::default(), None).is_none());
        let n = ride.samples;
        let sway = |w: f64, a: f64| (0..n).map(|i| a * (w * i as f64 * 0.01).sin()).collect();
        ride.yaw_rate = Some(sway(1.0, 0.3));
        let bare = roll(&ride, &Bike::default(), None).unwrap();
        assert!(bare.roll_acceleration_rad_s2.is_none() && bare.notes.len() == 2);
        ride.steer = Some(sway(2.0, 0.05));
        ride.roll = Some(sway(1.0, 0.1));
        let bike = Bike {
            roll: Some(parameters()),
            wheel_radius_front_m: Some(0.34),
            wheel_radius_rear_m: Some(0.34),
            mass_front_kg: Some(23.0),
            ..Bike::default()
        };
        let full = roll(&ride, &bike, None).unwrap();
        assert_eq!(full.notes.len(), 2, "{:?}", full.notes);
        assert!(full.acceleration_error_rms_rad_s2.unwrap() > 0.0);
        assert!(full.t_s.len() <= 601 && full.t_s.len() == full.steady_roll_rad.len());
    }
}
