//! Displacements that are all early or late beside the roads, as two loggers make them. The plain axle's fit to such a record may lose
//! its damping, and the diagnosis, which starts from there, then names what one axle alone suggests.

use super::gain::{RIGHT, explained_when_late};
use veloid_core::bicycle::{Axle, PerAxle};
use veloid_core::document::format_number::significant;
use veloid_methods::output_error::AxleFit;
use veloid_report::{Mistake, MistakeKind};
use veloid_ride::{AxleRecord, Ride};

/// Longest delay (s) that is looked for: as between accelerometers.
const LONGEST_S: f64 = 0.06;

/// That the displacements of both axles are late by the same time, where a fit has lost its damping.
pub fn mistake(ride: &Ride, fitted: &PerAxle<AxleFit>) -> Option<Mistake> {
    let is_lost = |fit: &AxleFit| fit.plain.beta < 0.0;
    if !ride.sensors.is_empty() || !fitted.iter().any(|(_, fit)| is_lost(fit)) {
        return None;
    }
    let late = |axle: Axle| late(ride, ride.axles.get(axle)?);
    let (front, rear) = (late(Axle::Front)?, late(Axle::Rear)?);
    if front.signum() * rear.signum() != 1 || front.abs_diff(rear) > 1 {
        return None;
    }
    let late_s = 0.5 * ride.step_s * (front + rear) as f64;
    Some(said(late_s, mean_speed(ride)))
}

/// How late an axle's displacement is (samples): where the plain axle explains most, if that is nearly all.
fn late(ride: &Ride, record: &AxleRecord) -> Option<isize> {
    let longest = (LONGEST_S / ride.step_s) as isize;
    let explained = |by: isize| Some((by, explained_when_late(ride, record, by)?));
    let tried = (-longest..=longest).filter_map(explained);
    let (by, explained) = tried.max_by(|(_, a), (_, b)| a.total_cmp(b))?;
    (explained > RIGHT).then_some(by)
}

fn mean_speed(ride: &Ride) -> Option<f64> {
    let speed = ride.speed.as_ref()?;
    Some(speed.iter().sum::<f64>() / speed.len().max(1) as f64)
}

fn said(late_s: f64, speed: Option<f64>) -> Mistake {
    let late = if late_s > 0.0 { "late" } else { "early" };
    let wheelbase = speed.map_or(String::new(), |speed| {
        let error = significant((speed * late_s).abs(), 2);
        format!(
            " (At the rear axle alone, a wheelbase that is {error} m off would look the same at a steady speed.)"
        )
    });
    Mistake {
        kind: MistakeKind::LateChannel,
        sentence: format!(
            "z_f and z_r are both about {} ms {late} relative to u_f and u_r: displacements and roads seem to have two clocks. Record them \
             on one logger, or correct the times.{wheelbase}",
            significant(1e3 * late_s.abs(), 2)
        ),
        takes_the_verdict: true,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use veloid_core::plant::Coefficients;
    use veloid_methods::simulate::simulated_ride::SimulatedRide;

    fn found(early: [usize; 2], beta: f64) -> Option<MistakeKind> {
        let simulated = SimulatedRide {
            duration_s: 30.0,
            noise_displacement_m: 5e-5,
            ..SimulatedRide::default()
        };
        let mut ride = simulated.ride();
        let records = [ride.axles.front.as_mut(), ride.axles.rear.as_mut()];
        for (record, early) in records.into_iter().zip(early) {
            record.unwrap().displacement.rotate_left(early);
        }
        let fit = |_: Axle, _: &AxleRecord| {
            let plain = Coefficients {
                beta,
                ..Coefficients::default()
            };
            AxleFit::exact(plain, ride.samples)
        };
        mistake(&ride, &ride.axles.map(fit)).map(|m| m.kind)
    }

    #[test]
    fn both_displacements_are_early_by_the_same_time_or_nothing_is_said() {
        assert_eq!(found([2, 2], -1.0), Some(MistakeKind::LateChannel));
        assert_eq!(found([2, 3], -1.0), Some(MistakeKind::LateChannel));
        assert_eq!(found([2, 4], -1.0), None);
        assert_eq!(found([0, 2], -1.0), None);
        assert_eq!(found([0, 0], -1.0), None);
        // Where the fit has kept its damping, the diagnosis names the delays.
        assert_eq!(found([2, 2], 1.0), None);
    }
}
