//! How likely a ride's sensors are under one reading of them, for comparison with other readings of the same numbers.

use std::f64::consts::TAU;

use nalgebra::Complex;

use super::band::{self, Band, Cross, LOWEST_HZ};
use super::bins::Bins;
use super::gather::gather;
use super::parameters::{Layout, index};
use super::record::{Record, Sensor};
use super::windows::Windows;
use super::{KNOTS_PER_OCTAVE, search, windows};
use veloid_core::bicycle::{Axle, Bike};
use veloid_ride::{Ride, SensorKind};

/// Windows on which readings are compared, about.
const FEW: usize = 12;
/// Highest frequency (Hz) at which both axles follow the road, and so each other: a third of a front axle's resonance.
const FOLLOWS_HZ: f64 = 4.0;

/// Highest frequency (Hz) at which a laser is compared in size: a quarter of a slow one's rate.
const LASER_HZ: f64 = 6.0;

/// One reading of a ride, made ready.
pub struct Reading {
    record: Record,
    windows: Windows,
}

/// What the first two sensors have in common where both axles follow the road.
#[derive(Clone, Copy, Debug)]
pub struct Shared {
    /// Mean coherence with its phase: 1 where they show the same, -1 where one is turned, near 0 where they are not aligned.
    pub coherence: Complex<f64>,
    /// Size of the second beside the first.
    pub ratio: f64,
    /// How much later (s) the second one is.
    pub late_s: f64,
}

/// How well a reading explains the sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// Negative log likelihood of each independent number (nats), and how many there are.
    per_number: f64,
    numbers: f64,
    /// k/m (1/s^2) and B/m (1/s) of front and rear axle under it.
    rates: [Option<[f64; 2]>; 2],
    /// How much later (s) the rear axle's first sensor is than the front's under it, and how many times larger it reads.
    pub late_s: f64,
    pub gain: f64,
}

impl Evidence {
    /// By how many nats this reading explains a ride better than `other`.
    pub fn beyond(&self, other: &Self) -> f64 {
        (other.per_number - self.per_number) * self.numbers.min(other.numbers)
    }

    /// k/m (1/s^2) and B/m (1/s) of an axle under it.
    pub fn rates(&self, axle: Axle) -> Option<[f64; 2]> {
        self.rates[index(axle)]
    }
}

impl Reading {
    /// Nothing of a ride whose sensors cannot be compared as they are read.
    pub fn of(ride: &Ride, bike: &Bike) -> Option<Self> {
        Self::of_record(gather(ride, bike).ok()?)
    }

    /// The same of a record.
    pub fn of_record(record: Record) -> Option<Self> {
        let windows = windows(&record).ok()?;
        Some(Self { record, windows })
    }

    /// Where the sensors have something in common under this reading, in frequencies over time, which do not depend on the speed.
    pub fn band(&self) -> Option<Band> {
        let found = band::band(&self.windows, &self.record.sensors).ok()?;
        let speeds = self.windows.list.iter().map(|w| w.speed);
        let slowest = speeds.fold(f64::INFINITY, f64::min);
        Some(Band {
            high_hz: found.high_hz.min(found.highest_per_m * slowest),
            highest_per_m: f64::INFINITY,
            ..found
        })
    }

    /// How likely the sensors are in a band.
    pub fn evidence(&self, band: Band) -> Option<Evidence> {
        let sensors = &self.record.sensors;
        let all = Bins::of(&self.windows, sensors, band);
        let bins = all.thinned(all.groups.len() / FEW);
        let layout = Layout::new(sensors, bins.span()?, KNOTS_PER_OCTAVE);
        let fit = search::climbed(&bins, sensors, &layout)?;
        let numbers: usize = bins.all().map(|bin| bin.active).sum();
        let numbers = numbers as f64 / bins.repeats;
        // Gain and delay are the second sensor's beside the first, whichever axle that is on.
        let way = match sensors.get(1).map(|s| s.axle) {
            Some(Axle::Front) => -1.0,
            _ => 1.0,
        };
        let second = |at: &[Option<usize>], unit: f64| {
            let at = at.get(1).copied().flatten();
            at.map_or(0.0, |at| way * unit * fit.theta[at])
        };
        let clock_s = sensors.get(1).map_or(0.0, |s| s.clock_s);
        let rates = |at: usize| [fit.theta[at].exp(), fit.theta[at + 1].exp()];
        Some(Evidence {
            per_number: fit.at.value / numbers,
            numbers,
            rates: layout.axles.map(|at| at.map(rates)),
            late_s: second(&layout.delay, clock_s),
            gain: second(&layout.gain, 1.0).exp(),
        })
    }

    /// What the first two sensors have in common; their clocks at most `reach_s` apart.
    pub fn shared(&self, reach_s: f64) -> Option<Shared> {
        let lines = self.lines(0, 1, FOLLOWS_HZ)?;
        let count = lines.len() as f64;
        let together = |late_s: f64| {
            let turned =
                |line: &Line| line.coherence * Complex::from_polar(1.0, -line.omega * late_s);
            lines.iter().map(turned).sum::<Complex<f64>>() / count
        };
        let steps = (reach_s / LAG_STEP_S) as i32;
        let lags = (-steps..=steps).map(|lag| LAG_STEP_S * f64::from(lag));
        let size = |late_s: &f64| together(*late_s).re.abs();
        let late_s = lags.max_by(|a, b| size(a).total_cmp(&size(b)))?;
        let ln_ratio = lines.iter().map(|line| line.ratio.ln()).sum::<f64>() / count;
        Some(Shared {
            coherence: together(0.0),
            ratio: ln_ratio.exp(),
            late_s,
        })
    }

    /// How many times too large an axle's laser reads beside its accelerometer, if the axle has these k/m and B/m:
    /// d (k/m + i omega B/m) is its acceleration.
    pub fn laser_gain(&self, axle: Axle, [kappa, beta]: [f64; 2]) -> Option<f64> {
        let place = |kind| {
            let is_it = |s: &super::record::Sensor| s.axle == axle && s.kind == kind;
            self.record.sensors.iter().position(is_it)
        };
        let pair = [
            place(SensorKind::Acceleration)?,
            place(SensorKind::Deflection)?,
        ];
        let lines = self.lines(pair[0], pair[1], LASER_HZ)?;
        let gain = |line: &Line| {
            line.power * line.transfer.conj() * Complex::new(kappa, line.omega * beta)
        };
        let sum: Complex<f64> = lines.iter().map(gain).sum();
        Some(sum.norm() / lines.iter().map(|line| line.power).sum::<f64>())
    }

    /// The axles that have a laser beside an accelerometer.
    pub fn lasers(&self) -> impl Iterator<Item = Axle> {
        let is_laser = |s: &&Sensor| s.beside.is_some();
        self.record.sensors.iter().filter(is_laser).map(|s| s.axle)
    }

    /// Two sensors at each frequency up to `top_hz`; nothing where one of them rests.
    fn lines(&self, one: usize, other: usize, top_hz: f64) -> Option<Vec<Line>> {
        let spacing = self.windows.spacing_hz;
        let [first, last] = [LOWEST_HZ, top_hz].map(|hz| (hz / spacing).round() as usize);
        let line = |k: usize| {
            let mut sums = Cross::default();
            for window in &self.windows.list {
                let x = window.spectra.get(k)?;
                sums.add(*x.get(one)?, *x.get(other)?);
            }
            let ([a, b], cross) = (sums.density, sums.sum);
            (a > 0.0 && b > 0.0).then_some(Line {
                omega: TAU * k as f64 * spacing,
                coherence: cross / (a * b).sqrt(),
                ratio: (b / a).sqrt(),
                transfer: cross / a,
                power: a,
            })
        };
        (first..=last).map(line).collect()
    }
}

/// Spacing (s) of the delays that are tried.
const LAG_STEP_S: f64 = 1e-3;

/// Two sensors at one frequency.
struct Line {
    omega: f64,
    coherence: Complex<f64>,
    ratio: f64,
    /// First times the other's conjugate, beside the first's power.
    transfer: Complex<f64>,
    power: f64,
}
