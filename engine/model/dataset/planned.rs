//! A ride that has not been ridden yet: the present one at another pace, over a rougher road, or without pedalling.
//! Everything that an effect may look at follows from the place on the present ride, so that a
//! road stays a function of the distance.

use std::f64::consts::TAU;

use super::inputs::Dataset;
use veloid_core::numerics::spline::{cubic, slopes};

/// How the present ride's inputs change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// Factor on road, force and release.
    pub rougher: f64,
    /// Factor on the pace at which the same course is ridden, in the same gear.
    pub faster: f64,
    /// Share by which that pace swings to both sides, with a period of `SWING_S`.
    pub swing: f64,
    /// Whether the cranks rest.
    pub coasting: bool,
}

/// Period of a pace that swings (s): slow enough to be ridden.
pub const SWING_S: f64 = 20.0;

impl Change {
    /// The present ride once more.
    pub const NONE: Self = Self {
        rougher: 1.0,
        faster: 1.0,
        swing: 0.0,
        coasting: false,
    };

    /// Factor on the pace at a time (s), how fast that grows (1/s), and how far it has led (s of the present ride).
    fn pace(&self, t: f64) -> [f64; 3] {
        let (sin, cos) = (TAU * t / SWING_S).sin_cos();
        let turn = SWING_S / TAU;
        [
            self.faster * (1.0 + self.swing * sin),
            self.faster * self.swing * cos / turn,
            self.faster * (t + self.swing * turn * (1.0 - cos)),
        ]
    }
}

/// The changed ride. What is measured on it is not known yet; the sizes in `Scale` stay, since the laws
/// of the present ride's effects are written in them (the mean speed that a slope counts from).
pub fn planned(dataset: &Dataset, change: &Change) -> Dataset {
    let mut next = dataset.clone();
    let last = dataset.samples.saturating_sub(1);
    // Place on the present ride (samples), the pace there and its growth.
    let way = |i: usize| {
        let [pace, growth, led] = change.pace(i as f64 * dataset.step);
        (led / dataset.step, pace, growth)
    };
    let places: Vec<(f64, f64, f64)> = (0..)
        .map(way)
        .take_while(|(place, ..)| *place <= last as f64)
        .collect();
    let at = |x: &[f64]| -> Vec<f64> {
        let slope = slopes(x, dataset.step);
        let at = |(place, ..): &(f64, f64, f64)| {
            let i = (*place as usize).min(last.saturating_sub(1));
            let s = place - i as f64;
            let j = (i + 1).min(last);
            let c = cubic(x[i], x[j], slope[i], slope[j], dataset.step);
            c[0] + s * (c[1] + s * (c[2] + s * c[3]))
        };
        places.iter().map(at).collect()
    };
    let times = |mut x: Vec<f64>, factor: f64| -> Vec<f64> {
        x.iter_mut().for_each(|x| *x *= factor);
        x
    };
    next.samples = places.len();
    let (speed, rate) = (at(&dataset.speed), at(&dataset.speed_rate));
    let paced = || speed.iter().zip(&rate).zip(&places);
    next.speed = paced().map(|((v, _), (_, pace, _))| v * pace).collect();
    next.speed_rate = paced()
        .map(|((v, a), (_, pace, growth))| a * pace * pace + v * growth)
        .collect();
    next.distance = at(&dataset.distance);
    next.set_crank(match change.coasting {
        true => vec![dataset.crank.first().copied().unwrap_or(0.0); places.len()],
        false => at(&dataset.crank),
    });
    for track in &mut next.tracks {
        let road = times(at(&track.input.road), change.rougher);
        let force = (track.input.force.as_ref()).map(|(f, _)| times(at(f), change.rougher));
        track.set_inputs(&road, force.as_deref());
        let valid = |(place, ..): &(f64, f64, f64)| track.valid[(place.round() as usize).min(last)];
        track.valid = places.iter().map(valid).collect();
        track.measured = vec![0.0; places.len()];
    }
    next
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Kind;
    use crate::fit::{Point, Term, Unit};
    use crate::law::{AT_REST, MAX_PARAMETERS};
    use veloid_core::bicycle::{Axle, Bike, PerAxle};
    use veloid_core::numerics::lanes::LANES;
    use veloid_core::plant::Coefficients;
    use veloid_methods::output_error::AxleFit;
    use veloid_methods::simulate::road::Bump;
    use veloid_methods::simulate::simulated_ride::{Excitation, SimulatedRide, SpeedChange};
    use veloid_report::diagnosis::Place;

    fn bike() -> Bike {
        Bike {
            mass_front_kg: Some(23.0),
            mass_rear_kg: Some(63.0),
            l_front_m: Some(0.808),
            l_rear_m: Some(0.293),
            wheel_radius_front_m: Some(0.34),
            wheel_radius_rear_m: Some(0.34),
            ..Bike::default()
        }
    }

    /// A course over bumps with a swinging speed and steady pedalling in one gear, ridden so many times faster.
    fn course(faster: f64) -> Dataset {
        let change = SpeedChange {
            share: 0.25,
            period_s: 8.0 / faster,
        };
        ridden(faster, Some(change), Some(60.0 * faster))
    }

    fn ridden(faster: f64, speed_change: Option<SpeedChange>, cadence_rpm: Option<f64>) -> Dataset {
        let bumps = (0..12).map(|i| Bump {
            at_m: 4.0 + 6.5 * f64::from(i),
            length_m: 1.2,
            height_m: 0.01 + 1e-3 * f64::from(i),
        });
        let simulated_ride = SimulatedRide {
            duration_s: 20.0 / faster,
            rate_hz: 400.0,
            speed_m_s: 4.0 * faster,
            speed_change,
            cadence_rpm,
            excitation: Excitation::Road {
                roughness: None,
                bumps: bumps.collect(),
            },
            ..SimulatedRide::default()
        };
        let ride = simulated_ride.ride();
        let mut fits = PerAxle::default();
        for (axle, mass) in [(Axle::Front, 23.0), (Axle::Rear, 63.0)] {
            let plain = Coefficients {
                kappa: 110e3 / mass,
                beta: 1150.0 / mass,
                per_mass: 1.0 / mass,
                constant: 0.0,
                height: 0.0,
                velocity: 0.0,
            };
            fits.set(axle, AxleFit::exact(plain, ride.samples));
        }
        Dataset::new(&ride, &bike(), &fits, ride.samples)
    }

    /// Motion of the axles (m) with an effect of these values, or none.
    fn moved(dataset: &Dataset, effect: Option<(Kind, Place, [f64; 2])>) -> Vec<f64> {
        let terms: Vec<Term> = (effect.iter())
            .map(|(kind, place, _)| Term {
                kind: *kind,
                place: *place,
            })
            .collect();
        let mut out = Vec::new();
        for unit in Unit::all(dataset, &terms) {
            let base = unit.tracks.iter().map(|t| dataset.tracks[*t].plain());
            let mut values = [0.0; MAX_PARAMETERS];
            if let Some((_, _, [first, second])) = effect {
                values[..2].copy_from_slice(&[first, second]);
                values[2] = 1.0;
            }
            let point = Point {
                base: base.collect(),
                values: vec![values; unit.terms.len()],
                initial: vec![AT_REST; unit.terms.len()],
            };
            let points: [Point; LANES] = std::array::from_fn(|_| point.clone());
            for z in unit.simulate(dataset, &points, None, 0..dataset.samples, 2) {
                out.extend(z.iter().map(|z| z.0[0]));
            }
        }
        out
    }

    fn rms(x: impl Iterator<Item = f64>) -> f64 {
        let (sum, n) = x.fold((0.0, 0.0), |(sum, n), x| (sum + x * x, n + 1.0));
        (sum / n).sqrt()
    }

    #[test]
    fn every_input_of_a_faster_ride_is_that_of_the_course_ridden_faster() {
        let slow = course(1.0);
        for faster in [0.75, 1.5] {
            let change = Change {
                faster,
                ..Change::NONE
            };
            let (next, ridden) = (planned(&slow, &change), course(faster));
            let near = |name: &str, a: &[f64], b: &[f64]| {
                let n = a.len().min(b.len());
                assert!(
                    n + 2 > a.len().max(b.len()),
                    "{name}: {} {}",
                    a.len(),
                    b.len()
                );
                let off = rms(a[..n].iter().zip(b).map(|(a, b)| a - b));
                let size = rms(b.iter().copied());
                assert!(off < 0.01 * size, "{name} at {faster}: {off} of {size}");
            };
            near("speed", &next.speed, &ridden.speed);
            near("speed rate", &next.speed_rate, &ridden.speed_rate);
            near("distance", &next.distance, &ridden.distance);
            near("crank", &next.crank, &ridden.crank);
            for (a, b) in next.tracks.iter().zip(&ridden.tracks) {
                near("road", &a.input.road, &b.input.road);
                near("road slope", &a.input.road_slope, &b.input.road_slope);
            }
        }
    }

    /// Each effect that looks at speed, distance, crank or road moves the planned ride as the ridden one.
    #[test]
    fn every_kind_of_effect_is_predicted_for_another_pace() {
        let effects = [
            (Kind::WheelOutOfRound, Place::Front, [1e-3, 0.0]),
            (Kind::PedallingForce, Place::Rear, [60.0, 0.0]),
            (Kind::LoadTransfer, Place::Both, [1.0, 0.0]),
            (Kind::TyreEnveloping, Place::Front, [0.5, 0.0]),
            (Kind::SpeedDependentStiffness, Place::Front, [0.1, 0.0]),
            (Kind::SpeedDependentDamping, Place::Front, [0.9, 0.0]),
            (Kind::WheelbaseDelay, Place::Rear, [0.1, 0.0]),
            (Kind::CubicStiffness, Place::Front, [4e9, 0.0]),
            (Kind::SensorDelay, Place::Front, [0.01, 0.0]),
        ];
        let change = Change {
            faster: 1.5,
            ..Change::NONE
        };
        let slow = course(1.0);
        let next = planned(&slow, &change);
        let mut ridden = course(1.5);
        for (ridden, track) in ridden.tracks.iter_mut().zip(&slow.tracks) {
            ridden.scale = track.scale.clone();
        }
        let samples = next.samples.min(ridden.samples);
        assert!(samples + 2 > next.samples.max(ridden.samples));
        let mut next = next;
        (next.samples, ridden.samples) = (samples, samples);
        for effect in effects {
            let predicted = moved(&next, Some(effect));
            let truth = moved(&ridden, Some(effect));
            let without = moved(&ridden, None);
            let does = rms(truth.iter().zip(&without).map(|(a, b)| a - b));
            let off = rms(predicted.iter().zip(&truth).map(|(a, b)| a - b));
            assert!(off < 0.03 * does, "{effect:?}: {off} of {does}");
        }
    }

    #[test]
    fn a_pace_that_swings_leads_over_the_same_course() {
        let change = Change {
            faster: 1.25,
            swing: 0.3,
            ..Change::NONE
        };
        let next = planned(&ridden(1.0, None, None), &change);
        let swing = SpeedChange {
            share: 0.3,
            period_s: SWING_S,
        };
        let truth = ridden(1.25, Some(swing), None);
        let of = |dataset: &Dataset| {
            let road = dataset.tracks[1].input.road.clone();
            [dataset.speed.clone(), dataset.distance.clone(), road]
        };
        for (reported, true_) in of(&next).iter().zip(of(&truth)) {
            assert!(reported.len() > 4000);
            let off = rms(reported.iter().zip(&true_).map(|(a, b)| a - b));
            assert!(off < 0.01 * rms(true_.iter().copied()), "{off}");
        }
        let slope = |x: &[f64]| slopes(x, next.step);
        let off = next.speed_rate.iter().zip(slope(&next.speed));
        assert!(rms(off.map(|(a, b)| a - b)) < 0.01);
    }

    #[test]
    fn who_coasts_does_not_pedal() {
        let change = Change {
            coasting: true,
            ..Change::NONE
        };
        let pedalled = |dataset: &Dataset| dataset.crank.iter().any(|c| *c != dataset.crank[0]);
        let dataset = course(1.0);
        assert!(pedalled(&dataset) && !pedalled(&planned(&dataset, &change)));
    }

    #[test]
    fn a_rougher_ride_scales_what_drives_it() {
        let dataset = course(1.0);
        let next = planned(
            &dataset,
            &Change {
                rougher: 2.0,
                ..Change::NONE
            },
        );
        let (a, b) = (&next.tracks[0].input.road, &dataset.tracks[0].input.road);
        assert!(a.iter().zip(b).all(|(a, b)| (a - 2.0 * b).abs() < 1e-12));
        assert_eq!(next.speed.len(), dataset.speed.len());
    }
}
