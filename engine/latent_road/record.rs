//! What the method is given: sensors on the axles, the speed, which samples may be trusted.

use veloid_core::bicycle::Axle;
use veloid_ride::SensorKind;

/// One sensor's samples on the common clock.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    pub axle: Axle,
    pub kind: SensorKind,
    pub values: Vec<f64>,
    /// How late its clock was found already: `values` are set right by it.
    pub known: Lateness,
    /// Highest frequency (Hz) that its own rate carries.
    pub highest_hz: f64,
    /// Standard deviation (s) of what its clock is off by, beside the first sensor's, or beside that of the sensor `beside` it on
    /// the same axle, which the speed's error does not part them by.
    pub clock_s: f64,
    pub beside: Option<usize>,
    /// Standard deviation of the share by which its clock runs fast; 0 where it has none of its own.
    pub drift: f64,
}

/// How late a clock is: by `offset_s` in the middle of the record, and by the share `drift` of the time since.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lateness {
    pub offset_s: f64,
    pub drift: f64,
}

impl Lateness {
    /// At so many seconds after the record's middle.
    pub fn at(&self, since_middle_s: f64) -> f64 {
        self.offset_s + self.drift * since_middle_s
    }

    pub fn plus(&self, other: Lateness) -> Self {
        Self {
            offset_s: self.offset_s + other.offset_s,
            drift: self.drift + other.drift,
        }
    }
}

/// All that was recorded, on one clock. Sensors stand in the order of falling reach; the first one's gain and clock are
/// those that the others are distinguished by.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    pub step_s: f64,
    pub sensors: Vec<Sensor>,
    /// Speed (m/s) at every sample.
    pub speed: Vec<f64>,
    /// Samples at which every sensor may be trusted.
    pub valid: Vec<bool>,
    /// Distance between the wheels (m), where both have sensors.
    pub wheelbase_m: Option<f64>,
}

impl Record {
    /// Time (s) of a sample since the record's middle.
    pub fn since_middle_s(&self, sample: f64) -> f64 {
        since_middle_s(sample, self.valid.len(), self.step_s)
    }

    pub fn has(&self, axle: Axle) -> bool {
        self.sensors.iter().any(|s| s.axle == axle)
    }
}

/// Time (s) of a sample since the middle of so many.
pub fn since_middle_s(sample: f64, samples: usize, step_s: f64) -> f64 {
    (sample - 0.5 * samples.saturating_sub(1) as f64) * step_s
}
