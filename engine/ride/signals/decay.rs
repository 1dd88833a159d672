//! What of a free decay says something: from its release to where the swing has faded. What comes later is known by its phase
//! alone, and after many swings every model that is not perfect has lost that.

use std::ops::Range;

use crate::signals::checks::swings;
use crate::{AxleRecord, Ride};
use veloid_core::numerics::statistics::variance;

/// Part of the largest swing below which a decay has faded: a hundredth of its energy is left. On a beam with magnets
/// (../shared/real) a model with hardening errs by 18 % of the held-out swing where the record ends here, and by more than all
/// of it where it ends at a fiftieth.
const FADED: f64 = 0.1;
/// Fewest swings that are kept, and the least part of a record that is worth taking off.
const KEPT: usize = 10;
const WORTH: f64 = 0.1;

/// Cuts a ride that nothing drives down to its decay, and says so; nothing where it is one all along.
pub fn cut(ride: &mut Ride) -> Option<String> {
    let free = |record: &AxleRecord| !record.has_road() && !record.is_pushed();
    if !ride.axles.iter().all(|(_, record)| free(record)) {
        return None;
    }
    let loud: Option<Vec<Range<usize>>> = (ride.axles.iter())
        .map(|(_, record)| loud(&record.displacement))
        .collect();
    let loud = loud?;
    let from = loud.iter().map(|r| r.start).min()?;
    let to = loud.iter().map(|r| r.end).max()?;
    if ((to - from) as f64) > (1.0 - WORTH) * ride.samples as f64 {
        return None;
    }
    let said = format!(
        "nothing drives the axles: {:.2} s to {:.2} s are used, where the oscillation is at least {:.0} % of its maximum; before \
         that nothing oscillates, and after it models could be judged only by their phase",
        ride.time_s(from),
        ride.time_s(to - 1),
        100.0 * FADED
    );
    ride.start_s = ride.time_s(from);
    ride.samples = to - from;
    for axle in veloid_core::bicycle::Axle::BOTH {
        if let Some(record) = ride.axles.get_mut(axle) {
            let AxleRecord {
                road,
                force,
                displacement,
                acceleration,
                valid,
                ..
            } = record;
            let channels = [
                Some(road),
                force.as_mut(),
                Some(displacement),
                acceleration.as_mut(),
            ];
            channels
                .into_iter()
                .flatten()
                .for_each(|x| keep(x, from..to));
            keep(valid, from..to);
        }
    }
    let others = [
        &mut ride.speed,
        &mut ride.cadence,
        &mut ride.roll,
        &mut ride.steer,
        &mut ride.yaw_rate,
        &mut ride.lateral_speed,
    ];
    others.into_iter().flatten().for_each(|x| keep(x, from..to));
    Some(said)
}

fn keep<T>(x: &mut Vec<T>, range: Range<usize>) {
    x.truncate(range.end);
    x.drain(..range.start);
}

/// The samples between the release and where the swing has faded; nothing where no steady swing shows.
fn loud(values: &[f64]) -> Option<Range<usize>> {
    let period = (2.0 * swings(values)?).round() as usize;
    // A block of one period: what is held at rest before the release has no spread of its own.
    let spread: Vec<f64> = (values.chunks_exact(period.max(1)))
        .map(|block| variance(block).sqrt())
        .collect();
    let least = FADED * spread.iter().copied().fold(0.0, f64::max);
    let first = spread.iter().position(|s| *s >= least)?;
    let last = spread.iter().rposition(|s| *s >= least)?;
    // The release itself lies somewhere in the first block that moves.
    let first = if first > 0 { first + 1 } else { 0 };
    let end = if last + 1 == spread.len() {
        values.len()
    } else {
        (last + 1) * period
    };
    (last + 1 >= first + KEPT).then_some(first * period..end)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 20 s at 100 Hz: held at 1 until the release, then a decay of 2 Hz by `rate` (1/s).
    fn released(at: usize, rate: f64) -> Vec<f64> {
        let value = |i: usize| match i.checked_sub(at) {
            None => 1.0,
            Some(i) => {
                let t = i as f64 * 0.01;
                (-rate * t).exp() * (std::f64::consts::TAU * 2.0 * t).cos()
            }
        };
        (0..2000).map(value).collect()
    }

    #[test]
    fn a_decay_is_kept_from_its_release_until_it_has_faded() {
        let faded = (1.0 / FADED).ln();
        for (at, rate) in [(0, 0.3), (0, 0.4), (310, 0.4)] {
            let range = loud(&released(at, rate)).unwrap_or_default();
            let end = at as f64 + 100.0 * faded / rate;
            assert!(
                (range.end as f64 - end).abs() < 60.0,
                "{range:?} instead of {end}"
            );
            assert!(range.start >= at && range.start <= at + 100, "{range:?}");
        }
    }

    #[test]
    fn what_does_not_fade_is_kept_whole() {
        assert_eq!(loud(&released(0, 0.05)), Some(0..2000));
        assert_eq!(loud(&vec![1.0; 2000]), None);
        // Fewer swings than are worth judging by.
        assert_eq!(loud(&released(0, 4.0)), None);
    }
}
