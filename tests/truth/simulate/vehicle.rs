//! The two-axle bicycle with concealed effects: state, forces and their sum.

use super::contact::Contact;
use super::drive::Moment;
use super::effect::{Effect, Kind};
use super::outside::Outside;

/// Speed over which dry friction builds up, m/s.
const SLIP_M_S: f64 = 1.5e-3;
/// States of one axle: z, z', then what effects need.
pub const STATES: usize = 8;
pub type State = [[f64; STATES]; 2];

/// The plain bicycle, front then rear, SI.
#[derive(Clone, Debug)]
pub struct Bike {
    pub mass_kg: [f64; 2],
    /// Distance of each wheel centre from the centre of gravity.
    pub arm_m: [f64; 2],
    pub wheel_radius_m: [f64; 2],
    pub stiffness_n_m: [f64; 2],
    pub damping_n_s_m: [f64; 2],
}

impl Bike {
    pub fn wheelbase_m(&self) -> f64 {
        self.arm_m[0] + self.arm_m[1]
    }

    pub fn total_kg(&self) -> f64 {
        self.mass_kg[0] + self.mass_kg[1]
    }
}

#[derive(Clone, Debug)]
pub struct Vehicle {
    pub bike: Bike,
    pub effects: Vec<Effect>,
    pub outside: Option<Outside>,
    /// Constant force per axle, N: the rest point of rides without a road.
    pub rest_n: [f64; 2],
    /// Mean speed over the ride, m/s (speed-dependent stiffness).
    pub mean_speed_m_s: f64,
}

/// Sum of the forces on one axle mass, the mass that carries them, and what a mode on top or below changes.
struct Sum {
    force_n: f64,
    mass_kg: f64,
}

impl Vehicle {
    pub fn plain(bike: Bike) -> Self {
        Self {
            bike,
            effects: Vec::new(),
            outside: None,
            rest_n: [0.0; 2],
            mean_speed_m_s: 0.0,
        }
    }

    pub fn find(&self, kind: Kind, axle: usize) -> Option<&[f64]> {
        self.effects
            .iter()
            .find(|e| e.kind == kind && e.axle.covers(axle))
            .map(|e| e.values.as_slice())
    }

    /// Fastest rate at which dry friction pulls a mass to rest, 1/s: what limits an explicit step.
    pub fn friction_rate(&self, axle: usize) -> f64 {
        let friction = [Kind::CoulombFriction, Kind::GuideFriction]
            .iter()
            .filter_map(|&kind| self.find(kind, axle))
            .map(|p| p[0])
            .fold(0.0, f64::max);
        let left = self
            .find(Kind::SprungMass, axle)
            .map_or(1.0, |p| 1.0 - p[0]);
        let wheel = self.find(Kind::UnsprungMass, axle).map_or(1.0, |p| p[0]);
        friction / SLIP_M_S / (self.bike.mass_kg[axle] * left * wheel)
    }

    /// States in use on one axle.
    pub fn states(&self, axle: usize) -> usize {
        let inside: usize = self
            .effects
            .iter()
            .filter(|e| e.axle.covers(axle))
            .map(|e| e.kind.states())
            .sum();
        let strange = self.outside.as_ref().filter(|o| o.axle == axle);
        2 + inside + strange.map_or(0, |o| o.kind.states())
    }

    /// Time derivative of the state of the axles in `active`.
    pub fn derivative(&self, m: &Moment, s: &State, active: [bool; 2]) -> State {
        let mut rate = [[0.0; STATES]; 2];
        let mut sums = [
            Sum {
                force_n: 0.0,
                mass_kg: 1.0,
            },
            Sum {
                force_n: 0.0,
                mass_kg: 1.0,
            },
        ];
        for axle in 0..2 {
            if active[axle] {
                sums[axle] = self.axle(axle, m, s, &mut rate[axle]);
            }
        }
        for axle in 0..2 {
            rate[axle][0] = s[axle][1];
            rate[axle][1] = sums[axle].force_n / sums[axle].mass_kg;
        }
        if let Some(p) = self.find(Kind::PitchCoupling, 0) {
            let total = self.bike.total_kg();
            let [front, rear] = self.bike.arm_m;
            let cross = 1.0 / total - front * rear / p[0];
            rate[0][1] =
                sums[0].force_n * (1.0 / total + front * front / p[0]) + sums[1].force_n * cross;
            rate[1][1] =
                sums[1].force_n * (1.0 / total + rear * rear / p[0]) + sums[0].force_n * cross;
        }
        rate
    }

    fn axle(&self, axle: usize, m: &Moment, s: &State, rate: &mut [f64; STATES]) -> Sum {
        let own = &s[axle];
        let mut k = self.bike.stiffness_n_m[axle];
        let mut b = self.bike.damping_n_s_m[axle];
        let mut mass = self.bike.mass_kg[axle];
        let (mut top, mut top_rate, mut play) = (own[0], own[1], 0.0);
        let mut slot = 2;
        for e in self.effects.iter().filter(|e| e.axle.covers(axle)) {
            let p = &e.values;
            match e.kind {
                Kind::StiffnessDrift => k *= 1.0 + p[0] * m.t,
                Kind::SpeedDependentStiffness => k *= 1.0 + p[0] * (m.speed - self.mean_speed_m_s),
                Kind::SpeedDependentDamping => b *= 1.0 + p[0] * (5.0 / m.speed.max(0.5) - 1.0),
                Kind::MassStep if m.t >= p[1] && m.t < p[2] => mass *= 1.0 + p[0],
                Kind::FreePlay => play = (0.5 * p[0]).max(0.0),
                Kind::UnsprungMass => (top, top_rate) = (own[slot], own[slot + 1]),
                _ => {}
            }
            slot += e.kind.states();
        }
        let d = m.road[axle] - top;
        let w = m.road_rate[axle] - top_rate;
        if let Some(p) = self.find(Kind::AsymmetricDamping, axle) {
            b *= 1.0 + if w > 0.0 { p[0] } else { -p[0] };
        }
        let mut tyre = b * w + k * (d - d.clamp(-play, play));
        let mut body = m.force[axle] + self.rest_n[axle];
        slot = 2;
        for e in self.effects.iter().filter(|e| e.axle.covers(axle)) {
            let p = &e.values;
            match e.kind {
                Kind::CubicStiffness => tyre += p[0] * d * d * d,
                Kind::ProgressiveStiffness => tyre += progressive(p[0], k, d),
                Kind::QuadraticDamping => tyre += p[0] * w * w.abs(),
                Kind::CoulombFriction => tyre += p[0] * (w / SLIP_M_S).tanh(),
                Kind::Hysteresis => {
                    rate[slot] = p[0] * (w - w.abs() * own[slot] / p[1]);
                    tyre += own[slot];
                }
                Kind::ViscoelasticTyre => {
                    rate[slot] = p[0] * w - own[slot] / p[1];
                    tyre += own[slot];
                }
                Kind::BumpStop => tyre += stop(p[0], p[1], p[2], d),
                Kind::PedallingForce => body += p[0] * (2.0 * m.crank + p[1]).sin(),
                Kind::LoadTransfer => {
                    let lift =
                        self.bike.total_kg() * m.acceleration * p[0] / self.bike.wheelbase_m();
                    body += if axle == 0 { lift } else { -lift };
                }
                Kind::GroundDamping => body -= p[0] * own[1],
                Kind::GuideFriction => body -= p[0] * (own[1] / SLIP_M_S).tanh(),
                _ => {}
            }
            slot += e.kind.states();
        }
        if let Some(outside) = self.outside.as_ref().filter(|o| o.axle == axle) {
            let other = 1 - axle;
            let contact = Contact {
                t: m.t,
                x: m.distance,
                speed: m.speed,
                crank: m.crank,
                d,
                w,
                z: own[0],
                z_rate: own[1],
                other_d: m.road[other] - s[other][0],
                k,
                b,
            };
            let inside = slot..slot + outside.kind.states();
            tyre += outside.force(&contact, &own[inside.clone()], &mut rate[inside]);
        }
        if let Some(p) = self.find(Kind::WheelLift, axle) {
            tyre = tyre.max(-p[0]);
        }
        self.with_modes(axle, own, rate, mass, tyre, body)
    }

    /// Splits the mass where a second one rides above or below.
    fn with_modes(
        &self,
        axle: usize,
        own: &[f64; STATES],
        rate: &mut [f64; STATES],
        mass: f64,
        tyre: f64,
        body: f64,
    ) -> Sum {
        let mut sum = Sum {
            force_n: tyre + body,
            mass_kg: mass,
        };
        let mut slot = 2;
        for e in self.effects.iter().filter(|e| e.axle.covers(axle)) {
            let p = &e.values;
            if matches!(e.kind, Kind::SprungMass | Kind::UnsprungMass) {
                let omega = std::f64::consts::TAU * p[1];
                let upper = if e.kind == Kind::SprungMass {
                    p[0]
                } else {
                    1.0 - p[0]
                } * mass;
                let (low, high) = if e.kind == Kind::SprungMass {
                    (0, slot)
                } else {
                    (slot, 0)
                };
                let push = upper
                    * omega
                    * (omega * (own[low] - own[high])
                        + 2.0 * p[2] * (own[low + 1] - own[high + 1]));
                rate[slot] = own[slot + 1];
                if e.kind == Kind::SprungMass {
                    rate[slot + 1] = push / upper;
                    sum.force_n -= push;
                    sum.mass_kg -= upper;
                } else {
                    rate[slot + 1] = (tyre - push) / (mass - upper);
                    sum = Sum {
                        force_n: push + body,
                        mass_kg: upper,
                    };
                }
            }
            slot += e.kind.states();
        }
        sum
    }
}

/// k2 d^2 added to k d, the total constant beyond its turning point.
fn progressive(k2: f64, k: f64, d: f64) -> f64 {
    let turn = -k / (2.0 * k2);
    let past = if k2 > 0.0 { d < turn } else { d > turn };
    if past {
        k2 * turn * turn + k * (turn - d)
    } else {
        k2 * d * d
    }
}

/// Stop of stiffness `ks` beyond `gap`; side 1 compression, -1 rebound, 0 both.
fn stop(gap: f64, ks: f64, side: f64, d: f64) -> f64 {
    let compression = if side >= 0.0 { (d - gap).max(0.0) } else { 0.0 };
    let rebound = if side <= 0.0 { (d + gap).min(0.0) } else { 0.0 };
    ks * (compression + rebound)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::effect::Axle;

    fn with(effects: Vec<Effect>) -> Vehicle {
        let bike = Bike {
            mass_kg: [20.0, 60.0],
            arm_m: [0.8, 0.3],
            wheel_radius_m: [0.34; 2],
            stiffness_n_m: [1e5; 2],
            damping_n_s_m: [0.0; 2],
        };
        Vehicle {
            effects,
            ..Vehicle::plain(bike)
        }
    }

    /// Force on the front mass with the road `d` above it, moving up at `w`.
    fn force(vehicle: &Vehicle, d: f64, w: f64) -> f64 {
        let moment = Moment {
            road: [d, 0.0],
            road_rate: [w, 0.0],
            ..Moment::default()
        };
        20.0 * vehicle.derivative(&moment, &[[0.0; STATES]; 2], [true, true])[0][1]
    }

    #[test]
    fn laws_have_the_library_forces() {
        let one = |kind, values: &[f64], d, w| {
            force(&with(vec![Effect::new(kind, Axle::Front, values)]), d, w)
        };
        let near = |got: f64, expected: f64| {
            assert!(
                (got - expected).abs() < 1e-9 * expected.abs().max(1.0),
                "{got} {expected}"
            )
        };
        near(one(Kind::FreePlay, &[2e-3], 3e-3, 0.0), 200.0);
        near(one(Kind::FreePlay, &[2e-3], -0.5e-3, 0.0), 0.0);
        near(one(Kind::BumpStop, &[2e-3, 3e5, 1.0], 3e-3, 0.0), 600.0);
        near(one(Kind::BumpStop, &[2e-3, 3e5, 1.0], -3e-3, 0.0), -300.0);
        near(one(Kind::BumpStop, &[2e-3, 3e5, 0.0], -3e-3, 0.0), -600.0);
        near(one(Kind::ProgressiveStiffness, &[1e7], -5e-3, 0.0), -250.0);
        near(one(Kind::ProgressiveStiffness, &[1e7], -9e-3, 0.0), -250.0);
        near(one(Kind::QuadraticDamping, &[100.0], 0.0, -0.5), -25.0);
        near(one(Kind::CoulombFriction, &[12.0], 0.0, 0.5), 12.0);
        near(one(Kind::WheelLift, &[196.2], -1e-2, 0.0), -196.2);
        near(one(Kind::MassStep, &[0.25, 0.0, 1.0], 1e-3, 0.0), 80.0);
    }

    #[test]
    fn a_refit_may_try_what_is_not_physical() {
        assert_eq!(
            force(
                &with(vec![Effect::new(Kind::FreePlay, Axle::Front, &[-1e-3])]),
                1e-3,
                0.0
            ),
            100.0
        );
    }
}
