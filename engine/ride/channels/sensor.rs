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
