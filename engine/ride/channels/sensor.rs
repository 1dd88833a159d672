//! Sensors of a ride whose road was not recorded as a channel, as they stand in the file.

use serde::{Deserialize, Serialize};

use crate::channels::channel::Channel;
use veloid_core::bicycle::Axle;

/// What a sensor measures of its axle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SensorKind {
    /// z'' (m/s^2).
    Acceleration,
    /// u - z (m), up to a constant.
    Deflection,
    /// z (m), up to a constant.
    Displacement,
    /// u (m), up to a constant.
    Road,
}

/// One sensor on the ride's clock.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorRecord {
    /// Where it sits.
    pub axle: Axle,
    /// What it measures.
    pub kind: SensorKind,
    /// One for each of the ride's samples, in the unit of `kind`.
    pub values: Vec<f64>,
    /// Samples to trust: false where it was clipped or missing.
    pub valid: Vec<bool>,
    /// Its own rate (Hz).
    pub rate_hz: f64,
    /// Time stamp of its own first sample (s).
    pub first_s: f64,
}

/// Where a sensor sits, what it measures, and its file where the ride has several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed<'a> {
    /// Where it sits.
    pub axle: Axle,
    /// What it measures.
    pub kind: SensorKind,
    /// Its file, where the ride has several.
    pub file: Option<&'a str>,
}

/// Why the sensors of a ride with a speed but without a road cannot give k and B; nothing where they can.
pub fn lacking(sensors: &[Placed<'_>], has_wheelbase: bool) -> Option<String> {
    let of = |kind: SensorKind| sensors.iter().filter(move |s| s.kind == kind);
    let mut accelerometers = of(SensorKind::Acceleration);
    let first = accelerometers.next().and_then(|sensor| sensor.file);
    if let Some(other) = accelerometers
        .filter_map(|s| s.file)
        .find(|other| Some(*other) != first)
    {
        return Some(format!(
            "the accelerometers are in two files ({} and {other}), whose clocks cannot be compared through the road that both wheels \
             ride over: record both on one logger",
            first.unwrap_or_default()
        ));
    }
    let on = |axle: Axle| sensors.iter().any(|s| s.axle == axle);
    match (sensors, on(Axle::Front) && on(Axle::Rear)) {
        ([], _) => Some("there is no sensor on either axle".to_owned()),
        ([only], _) => Some(format!(
            "one accelerometer alone (on the {} axle) cannot separate the road from the axle: add a second one on the other axle",
            only.axle
        )),
        (_, true) if !has_wheelbase => Some(
            "the wheelbase (l_front_m and l_rear_m of the bike) is missing: it determines when the rear wheel meets the road".to_owned(),
        ),
        _ => None,
    }
}

/// Canonical name of a sensor's channel, e.g. `a_f`.
pub fn channel_name(kind: SensorKind, axle: Axle) -> &'static str {
    channel(kind, axle).name()
}

pub fn channel(kind: SensorKind, axle: Axle) -> Channel {
    match kind {
        SensorKind::Acceleration => Channel::Acceleration(axle),
        SensorKind::Deflection => Channel::Deflection(axle),
        SensorKind::Displacement => Channel::Displacement(axle),
        SensorKind::Road => Channel::Road(axle),
    }
}
