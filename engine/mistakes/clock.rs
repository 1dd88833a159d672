//! Times in another unit than was said.

use veloid_core::document::format_number::significant;
use veloid_report::{Mistake, MistakeKind};
use veloid_ride::Ride;

/// Slowest rate (Hz) at which an axle's motion is recorded, and the fastest of any logger.
const RATES_HZ: [f64; 2] = [2.0, 52e3];
/// Rate (Hz) from which a record's times are doubted: that of a slow logger, 20 Hz, under a unit a thousand times too small. Below, records of
/// beams in units of their own move as fast (`../shared/real/double_beam`, 5120 Hz).
const DOUBTED_HZ: f64 = 20e3;
/// Times by which stamps are too short where they were given in such a unit but named as the next smaller one.
const LONGER: [f64; 2] = [1e3, 1e6];
/// Shortest ride (m) in which the rear wheel meets anything that the front wheel met: a wheelbase.
const SHORTEST_M: f64 = 1.0;
/// Distances (m) that rides go.
const RIDES_M: std::ops::Range<f64> = 10.0..1e6;
/// Speed (m/s) below which nothing is ridden over.
const SLOWEST_M_S: f64 = 1.0;
/// Largest acceleration (m/s^2) of a displacement, a thousand times gravity: above the hardest shock that accelerometers for vehicles
/// record; and the samples to both sides over which it is taken.
const FASTEST: f64 = 1e4;
const OVER: usize = 12;

/// That a ride goes so slowly or so fast that its times must be in another unit.
pub fn mistake(ride: &Ride) -> Option<Mistake> {
    let rate = 1.0 / ride.step_s;
    let [slowest, fastest] = RATES_HZ;
    let sentence = match ridden_m(ride) {
        // Accelerometers are thinned to the common clock; how far they were ridden is left of their times.
        Some(ridden) if ridden < SHORTEST_M => {
            let by = LONGER
                .into_iter()
                .find(|by| RIDES_M.contains(&(ridden * by)))?;
            let [shown, plausible] = [ridden, ridden * by].map(|m| significant(m, 2));
            too_short(&format!("went {shown} m"), &format!("{plausible} m"), by)
        }
        _ if rate < slowest => too_slow(rate),
        None if rate > DOUBTED_HZ && is_too_fast(ride) => {
            let by = LONGER
                .into_iter()
                .find(|by| (slowest..fastest).contains(&(rate / by)))?;
            let [shown, plausible] = [rate, rate / by].map(|hz| significant(hz, 3));
            let shown = format!("has {shown} samples a second, and moves faster than any axle");
            too_short(&shown, &plausible, by)
        }
        _ => return None,
    };
    Some(Mistake {
        kind: MistakeKind::WrongUnit,
        sentence,
        takes_the_verdict: true,
    })
}

/// That the stamps of a ride with so many samples a second are not seconds.
fn too_slow(rate: f64) -> String {
    format!(
        "By its time stamps this ride has {} samples a second, fewer than any axle is recorded with: they may count samples (give the \
         rate with rate_hz, --rate HZ) or be in another unit (state it in the header, as in t [ms]).",
        significant(rate, 3)
    )
}

/// That the stamps of a ride of which this is `shown` are in a unit so many times larger, which would give what is plausible.
fn too_short(shown: &str, plausible: &str, by: f64) -> String {
    format!(
        "By its time stamps this ride {shown}; their unit seems to be {} times larger, which would give {plausible}: seconds under \
         \"t [ms]\", or milliseconds under \"t [us]\".",
        significant(by, 1)
    )
}

/// How far a ride with accelerometers went (m); nothing where it has no speed or stood.
fn ridden_m(ride: &Ride) -> Option<f64> {
    let speed = ride.speed.as_ref().filter(|_| !ride.sensors.is_empty())?;
    let mean = speed.iter().sum::<f64>() / speed.len().max(1) as f64;
    (mean > SLOWEST_M_S).then_some(mean * ride.duration_s())
}

/// Whether an axle's motion is faster than anything that carries a wheel.
fn is_too_fast(ride: &Ride) -> bool {
    let mut axles = ride.axles.iter();
    axles.any(|(_, axle)| acceleration(&axle.displacement, ride.step_s) > FASTEST)
}

/// Acceleration (m/s^2, RMS) of a displacement over [`OVER`] samples to both sides: what it has within a sample or two is noise.
fn acceleration(z: &[f64], step_s: f64) -> f64 {
    let triples = z
        .iter()
        .zip(z.iter().skip(OVER))
        .zip(z.iter().skip(2 * OVER));
    let (sum, count) = triples.fold((0.0, 0.0), |(sum, count), ((a, b), c)| {
        (sum + (a - 2.0 * b + c).powi(2), count + 1.0)
    });
    (sum / f64::max(count, 1.0)).sqrt() / (OVER as f64 * step_s).powi(2)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use veloid_methods::simulate::simulated_ride::SimulatedRide;

    fn found(slower: f64) -> Option<String> {
        let mut ride = SimulatedRide::default().ride();
        ride.step_s *= slower;
        mistake(&ride).map(|m| m.sentence)
    }

    #[test]
    fn times_are_too_long_or_too_short_by_a_unit() {
        assert_eq!(found(1.0), None);
        assert!(found(1e3).is_some_and(|s| s.contains("may count samples")));
        let short = found(1e-3).unwrap_or_default();
        assert!(short.contains("1000 times larger"), "{short}");
        // A minute of a rig that is read as 20 s is no other unit.
        assert_eq!(found(0.3), None);
    }

    /// A sine over many samples has its own acceleration.
    #[test]
    fn val_the_acceleration_of_a_slow_sine_is_its_own() {
        let omega = TAU / 400.0;
        let sine: Vec<f64> = (0..8000).map(|i| (omega * f64::from(i)).sin()).collect();
        let found = acceleration(&sine, 0.01);
        let truth = (omega / 0.01).powi(2) / 2.0_f64.sqrt();
        assert!((found / truth - 1.0).abs() < 0.01, "{found} {truth}");
    }

    /// The bound stands far from a bicycle: its default ride is slower by more than a hundred.
    #[test]
    fn the_bound_is_far_from_a_bicycle() {
        let ride = SimulatedRide::default().ride();
        let front = ride.axles.front.unwrap_or_else(|| unreachable!());
        let found = acceleration(&front.displacement, ride.step_s);
        assert!(
            found < 0.01 * FASTEST && 1e6 * found > 10.0 * FASTEST,
            "{found}"
        );
    }
}
