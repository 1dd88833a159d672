//! A ride on one uniform clock, as every later step uses it.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::{FileSummary, SensorClock, SensorRecord, channel_name};
use crate::band::Band;
use crate::channels::values;
use veloid_core::EngineError;
use veloid_core::bicycle::{Bike, PerAxle};
use veloid_core::numerics::statistics::variance;
use veloid_core::plant::{self, Plant, PlantRef};

/// A ride after reading: SI units, one clock, no blanks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ride {
    /// Time of the first sample (s).
    pub start_s: f64,
    /// Epoch (s since 1970) of the time 0, where the file's stamps say when they were taken.
    pub epoch_s: Option<f64>,
    /// Sample interval (s).
    pub step_s: f64,
    /// Number of samples; every channel has as many.
    pub samples: usize,
    /// What was recorded on each axle.
    pub axles: PerAxle<AxleRecord>,
    /// Accelerometers and lasers where neither road, displacement nor force was recorded; an axle has a record then only where it
    /// could be made from its own.
    pub sensors: Vec<SensorRecord>,
    /// What a laser that the road was made from may have made wrong in it.
    pub road_doubts: Vec<RoadDoubt>,
    /// Speed (m/s).
    pub speed: Option<Vec<f64>>,
    /// Crank rate (revolutions per minute).
    pub cadence: Option<Vec<f64>>,
    /// Roll angle (rad).
    pub roll: Option<Vec<f64>>,
    /// Steering angle (rad).
    pub steer: Option<Vec<f64>>,
    /// Yaw rate (rad/s).
    pub yaw_rate: Option<Vec<f64>>,
    /// Lateral speed (m/s).
    pub lateral_speed: Option<Vec<f64>>,
    /// What the reader understood.
    pub summary: RideSummary,
}

/// A way in which the road under the wheels may be wrong, because of the sensor that it was made from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RoadDoubt {
    /// By how much it would be higher (m): if a clock were off by one standard error more, or with as much noise of the sensor again.
    pub change: PerAxle<Vec<f64>>,
    /// Whether it is noise, whose sign means nothing.
    pub is_noise: bool,
}

/// What was recorded on one axle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AxleRecord {
    /// Road height u under the wheel (m); all zero where the ground is at rest.
    pub road: Vec<f64>,
    /// Force applied to the axle mass (N, up), on rides with a shaker; the force that was measured where the motion is
    /// prescribed.
    pub force: Option<Vec<f64>>,
    /// Vertical displacement z (m); the deflection d where the motion is prescribed.
    pub displacement: Vec<f64>,
    /// Measured vertical acceleration (m/s^2).
    pub acceleration: Option<Vec<f64>>,
    /// Samples to trust: false where z is clipped, missing or bridged over a gap.
    pub valid: Vec<bool>,
    /// Whether a rig prescribes the motion, so that the force answers to it and no mass moves: F = k d + B d'.
    pub prescribed: bool,
    /// What the axle is where nothing is left out.
    #[serde(default)]
    pub plant: PlantRef,
    /// What road and displacement contain, where they were computed from other sensors.
    #[serde(default)]
    pub band: Option<Band>,
}

/// First samples that must be alike for a record to start at rest.
const STILL: usize = 3;
/// Part of the motion (standard deviation) below which samples are alike, whatever the resolution.
const ALIKE: f64 = 1e-4;

impl AxleRecord {
    /// What the axle is where nothing is left out, as the record was taken.
    pub fn base_model(&self) -> &'static dyn Plant {
        match self.prescribed {
            true => self.plant.driven().unwrap_or(&plant::Axle::DRIVEN),
            false => self.plant.0,
        }
    }

    /// How far height (m) and velocity (m/s) may be from the first sample's height and from none, where the record starts at
    /// rest: its first samples are alike, to within its resolution.
    pub fn at_rest(&self, step_s: f64) -> Option<[f64; 2]> {
        if self.prescribed {
            return None;
        }
        let z = &self.displacement;
        let finest = z.windows(2).map(|p| (p[1] - p[0]).abs());
        let finest = finest.filter(|d| *d > 0.0).fold(f64::INFINITY, f64::min);
        let alike = ALIKE * variance(z).sqrt();
        let still = z.iter().take_while(|x| (*x - z[0]).abs() <= alike).count();
        let width = alike.max(finest);
        (still >= STILL && width.is_finite()).then(|| [width, width / (still as f64 * step_s)])
    }

    /// What a model of the axle predicts: its displacement (m), or the force (N) where the motion is prescribed.
    pub fn output(&self) -> &[f64] {
        match &self.force {
            Some(force) if self.prescribed => force,
            _ => &self.displacement,
        }
    }

    /// The same, to be changed.
    pub fn output_mut(&mut self) -> &mut [f64] {
        match &mut self.force {
            Some(force) if self.prescribed => force,
            _ => &mut self.displacement,
        }
    }

    /// Whether a force moves the axle: one that changes.
    pub fn is_pushed(&self) -> bool {
        self.force
            .as_deref()
            .is_some_and(|f| !values::is_constant(f))
    }

    /// Whether the road moves at all.
    pub fn has_road(&self) -> bool {
        self.road.iter().any(|u| *u != self.road[0])
    }
}

impl Ride {
    /// Whether `bike` gives the masses that this ride does not.
    pub fn fits(&self, bike: &Bike) -> Result<(), EngineError> {
        for (axle, record) in self.axles.iter() {
            bike.mass_or_force(axle, record.force.is_some())?;
        }
        for sensor in &self.sensors {
            bike.mass_or_force(sensor.axle, false)?;
        }
        Ok(())
    }

    /// The ride with those axles alone that a mass moves on; itself where that is all of them.
    pub fn with_masses(&self) -> Cow<'_, Ride> {
        if self.axles.iter().all(|(_, record)| !record.prescribed) {
            return Cow::Borrowed(self);
        }
        let moving = |record: &Option<AxleRecord>| record.clone().filter(|r| !r.prescribed);
        Cow::Owned(Ride {
            axles: PerAxle {
                front: moving(&self.axles.front),
                rear: moving(&self.axles.rear),
            },
            ..self.clone()
        })
    }

    /// Whether nothing says how the axles moved and what drove them: k and B come from the sensors alone.
    pub fn has_no_road(&self) -> bool {
        self.axles.iter().next().is_none()
    }

    /// Time from the first to the last sample (s).
    pub fn duration_s(&self) -> f64 {
        self.samples.saturating_sub(1) as f64 * self.step_s
    }

    /// Time of a sample, counted from 0 (s).
    pub fn time_s(&self, sample: usize) -> f64 {
        self.start_s + sample as f64 * self.step_s
    }
}

/// How the file was read: the report's `ride` section.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct RideSummary {
    /// SHA-256 of the file's bytes (hex); for several files that of their SHA-256, one per line.
    pub sha256: String,
    /// Rows of the file that were used.
    pub rows: usize,
    /// Samples on the common clock.
    pub samples: usize,
    /// Time from the first to the last sample (s).
    pub duration_s: f64,
    /// Times of the first and last sample (s) where only a part of a free decay is used.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part_s: Option<[f64; 2]>,
    /// Rate of the common clock (Hz).
    pub rate_hz: f64,
    /// Recognised columns.
    pub columns: Vec<Column>,
    /// The files, where the ride has several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<FileSummary>,
    /// Clocks of lasers relative to those of the accelerometers on their axles.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub clocks: Vec<SensorClock>,
    /// Header texts of columns without a recognised channel.
    pub ignored: Vec<String>,
    /// What was assumed while the files were read, in sentences.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reading: Vec<String>,
    /// Warnings: what was interpolated, clipped, resampled or looks doubtful.
    pub warnings: Vec<String>,
}

impl RideSummary {
    /// The file that a channel stands in, where the ride has several.
    pub fn file_of(&self, channel: &str) -> Option<&str> {
        let column = self.columns.iter().find(|c| c.channel == channel)?;
        column.file.as_deref()
    }
}

/// One recognised column.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Column {
    /// Its file, where the ride has several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Header text as in the file.
    pub header: String,
    /// Canonical channel name, e.g. `z_f`.
    pub channel: String,
    /// Unit in the file.
    pub unit: String,
    /// Factor that converts it to SI.
    pub scale: f64,
    /// Samples that were not blank.
    pub samples: usize,
    /// Their mean rate (Hz).
    pub rate_hz: f64,
}

impl Ride {
    /// Names and values of what was recorded, each as long as the ride has samples, in SI units; not the time
    /// ([`Ride::time_s`]).
    pub fn channels(&self) -> Vec<(&'static str, &[f64])> {
        let mut channels: Vec<(&str, &[f64])> = Vec::new();
        for (axle, names) in [
            (&self.axles.front, ["u_f", "z_f", "force_f", "a_f"]),
            (&self.axles.rear, ["u_r", "z_r", "force_r", "a_r"]),
        ] {
            let Some(record) = axle else { continue };
            if record.has_road() {
                channels.push((names[0], &record.road));
            }
            channels.push((names[1], &record.displacement));
            for (name, values) in [(names[2], &record.force), (names[3], &record.acceleration)] {
                channels.extend(values.as_deref().map(|values| (name, values)));
            }
        }
        let sensors = self.sensors.iter();
        channels.extend(sensors.map(|s| (channel_name(s.kind, s.axle), s.values.as_slice())));
        for (name, channel) in [
            ("v", &self.speed),
            ("cadence", &self.cadence),
            ("roll", &self.roll),
            ("steer", &self.steer),
            ("yaw_rate", &self.yaw_rate),
            ("v_lat", &self.lateral_speed),
        ] {
            channels.extend(channel.as_deref().map(|values| (name, values)));
        }
        channels
    }
}
