//! The sensors of a ride's file, on its clock.

use crate::channels::channel::Channel;
use crate::channels::sensor::{SensorKind, SensorRecord, channel};
use crate::signals::common::{Common, Lapse};
use veloid_core::bicycle::Axle;

/// Accelerometers and lasers of a ride whose road, displacement and force were not recorded, where they determine k and B together with
/// the speed, or each other's clock. The laser's sign is the options'.
pub fn recorded(common: &Common<'_>, deflection_sign: f64) -> Vec<SensorRecord> {
    let kinds = [SensorKind::Acceleration, SensorKind::Deflection];
    let of = |kind| Axle::BOTH.map(|axle| (kind, axle));
    let has = |kind: SensorKind, axle| common.has(channel(kind, axle));
    let driven = Axle::BOTH.into_iter().any(|axle| {
        let others = [SensorKind::Road, SensorKind::Displacement];
        others.into_iter().any(|kind| has(kind, axle)) || common.has(Channel::Force(axle))
    });
    let moved = Axle::BOTH
        .into_iter()
        .any(|axle| has(SensorKind::Acceleration, axle));
    if driven || !moved {
        return Vec::new();
    }
    let suffices = |axle| common.has(Channel::Speed) || kinds.iter().all(|kind| has(*kind, axle));
    (kinds.into_iter().flat_map(of))
        .filter(|(_, axle)| suffices(*axle))
        .filter_map(|(kind, axle)| {
            let channel = channel(kind, axle);
            let own = common.clock(channel)?.grid;
            let mut values = common.look(channel)?;
            if kind == SensorKind::Deflection {
                values.iter_mut().for_each(|d| *d *= deflection_sign);
            }
            Some(SensorRecord {
                axle,
                kind,
                values,
                valid: trusted(common, channel),
                rate_hz: own.rate_hz().min(common.grid.rate_hz()),
                first_s: own.start_s,
            })
        })
        .collect()
}

/// Counts the sensors' channels as used.
pub fn used(common: &mut Common<'_>, sensors: &[SensorRecord]) {
    for sensor in sensors {
        common.take(channel(sensor.kind, sensor.axle));
    }
}

fn trusted(common: &Common<'_>, channel: Channel) -> Vec<bool> {
    let grid = common.grid;
    let mut valid = vec![true; grid.count];
    for Lapse {
        from_s,
        to_s,
        bridged,
        ..
    } in common.lapses(channel)
    {
        // A sample or two are bridged, and what that leaves passes for noise of the sensor.
        if bridged {
            continue;
        }
        let first = ((from_s - grid.start_s) / grid.step_s).ceil().max(0.0) as usize;
        let last = ((to_s - grid.start_s) / grid.step_s).floor();
        if last >= 0.0 {
            let last = (last as usize).min(grid.count.saturating_sub(1));
            valid
                .iter_mut()
                .take(last + 1)
                .skip(first)
                .for_each(|v| *v = false);
        }
    }
    valid
}
