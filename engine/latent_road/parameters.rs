//! The unknowns in one vector, each with what is known of it before the ride is looked at.

use nalgebra::DVector;

use super::record::Sensor;
use veloid_core::bicycle::Axle;
use veloid_ride::SensorKind;

/// What is known beforehand: mean and standard deviation of a normal distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior {
    pub mean: f64,
    pub deviation: f64,
}

/// k/m (1/s^2) and B/m (1/s) about which bicycles lie, and the factor by which they may well be off (one deviation).
pub const KAPPA: [f64; 2] = [2500.0, 50.0];
pub const BETA: [f64; 2] = [25.0, 50.0];
/// Shares: a speed (wheel sensors and GPS are good to some 2 %), and a sensor's gain beside another's.
pub const SPEED: f64 = 0.03;
pub const GAIN: f64 = 0.1;
/// Start, and factor of one deviation, of a sensor's noise density beside all that it shows in the band.
const NOISE: [f64; 2] = [3e-4, 1e3];
/// The same of the part of the road's density that the wheels do not share, and of the jitter (s) of the delay between them.
const APART: [f64; 2] = [3e-3, 10.0];
const JITTER: [f64; 2] = [1e-3, 10.0];
/// The same of the road's density about that of class C.
const ROAD: f64 = 1e3;
/// Density of class C (m^3) at 0.1 cycles/m times (0.1 cycles/m)^2: the density that every knot is reported beside, falling as
/// the square of the spatial frequency (ISO 8608).
pub const CLASS_C: f64 = 256e-6 * 0.01;

/// Frequencies (in parts of a laser's reach, evenly spaced) at which the density of its noise is reported: a sensor without a low-pass folds
/// the road that is above half its rate below, most of it near its reach.
const LASER_LEVELS: usize = 5;

/// Where the levels of a sensor's noise stand: ln of its density, at frequencies spaced evenly from 0 to its reach and straight
/// lines between them; one level is white noise.
#[derive(Clone, Copy, Debug)]
pub struct NoiseLevels {
    pub first: usize,
    pub count: usize,
    pub highest_hz: f64,
}

impl NoiseLevels {
    /// The level at or before a frequency, and the share of the one after it.
    pub fn between(&self, hz: f64) -> (usize, f64) {
        let last = self.count.saturating_sub(1);
        let place = (hz / self.highest_hz * last as f64).clamp(0.0, last as f64);
        let low = (place as usize).min(last.saturating_sub(1));
        (self.first + low, place - low as f64)
    }

    /// The density at a frequency.
    pub fn density(&self, theta: &DVector<f64>, hz: f64) -> f64 {
        let (low, upper) = self.between(hz);
        match upper > 0.0 {
            true => (theta[low] * (1.0 - upper) + theta[low + 1] * upper).exp(),
            false => theta[low].exp(),
        }
    }
}

/// Where each unknown stands.
#[derive(Clone, Debug)]
pub struct Layout {
    /// ln(k/m); ln(B/m) stands after it. By axle, where it has a sensor.
    pub axles: [Option<usize>; 2],
    /// Each sensor's noise density, beside all that it shows in the band.
    pub noise: Vec<NoiseLevels>,
    /// -ln of the coherence of what both wheels ride over: ln of its constant part, ln of the jitter (s) of their delay.
    pub apart: Option<[usize; 2]>,
    /// Share by which the speed reads too little.
    pub speed: Option<usize>,
    /// ln of the gain, and delay in deviations of the clock, of each sensor beside the first.
    pub gain: Vec<Option<usize>>,
    pub delay: Vec<Option<usize>>,
    /// Share by which each sensor's clock runs fast beside those of the accelerometers, in deviations.
    pub drift: Vec<Option<usize>>,
    /// ln of the road's density beside [`CLASS_C`] at each knot.
    pub knots: usize,
    /// ln of the knots' spatial frequencies (cycles/m), evenly spaced.
    pub knots_at: Vec<f64>,
    pub priors: Vec<Prior>,
}

/// 0 for the front, 1 for the rear.
pub fn index(axle: Axle) -> usize {
    match axle {
        Axle::Front => 0,
        Axle::Rear => 1,
    }
}

impl Layout {
    /// For a band of spatial frequencies (cycles/m).
    pub fn new(sensors: &[Sensor], (low, high): (f64, f64), knots_per_octave: f64) -> Self {
        let mut priors: Vec<Prior> = Vec::new();
        let mut add = |mean: f64, deviation: f64| {
            priors.push(Prior { mean, deviation });
            priors.len() - 1
        };
        let mut about = |[mean, factor]: [f64; 2]| add(mean.ln(), factor.ln());
        let has = |axle| sensors.iter().any(|s| s.axle == axle);
        let axles = Axle::BOTH.map(|axle| {
            has(axle).then(|| {
                let at = about(KAPPA);
                about(BETA);
                at
            })
        });
        let noise = sensors.iter().map(|sensor| {
            let count = match sensor.kind {
                SensorKind::Deflection => LASER_LEVELS,
                _ => 1,
            };
            let first = (0..count).map(|_| about(NOISE)).min().unwrap_or(0);
            NoiseLevels {
                first,
                count,
                highest_hz: sensor.highest_hz,
            }
        });
        let noise: Vec<NoiseLevels> = noise.collect();
        let both = axles.iter().all(Option::is_some);
        let apart = both.then(|| [about(APART), about(JITTER)]);
        let speed = both.then(|| add(0.0, SPEED));
        let others = |i: usize| i > 0;
        let gain = (0..sensors.len()).map(|i| others(i).then(|| add(0.0, GAIN)));
        let gain = gain.collect();
        let clock = |i: usize| others(i) && sensors[i].clock_s > 0.0;
        let delay = (0..sensors.len()).map(|i| clock(i).then(|| add(0.0, 1.0)));
        let delay = delay.collect();
        let drift = sensors
            .iter()
            .map(|s| (s.drift > 0.0).then(|| add(0.0, 1.0)));
        let drift = drift.collect();
        let count = (((high / low).log2() * knots_per_octave).round() as usize).max(1) + 1;
        let spacing = (high / low).ln() / (count - 1) as f64;
        let knots_at: Vec<f64> = (0..count).map(|i| low.ln() + spacing * i as f64).collect();
        let knots = (knots_at.iter().map(|_| add(0.0, ROAD.ln())).min()).unwrap_or(0);
        Self {
            axles,
            noise,
            apart,
            speed,
            gain,
            delay,
            drift,
            knots,
            knots_at,
            priors,
        }
    }

    pub fn count(&self) -> usize {
        self.priors.len()
    }

    pub fn start(&self) -> DVector<f64> {
        DVector::from_iterator(self.count(), self.priors.iter().map(|p| p.mean))
    }

    /// Whether an unknown says how much the sensors do not share: of these little is known at the start.
    pub fn is_noise(&self, at: usize) -> bool {
        let is_level = |n: &NoiseLevels| (n.first..n.first + n.count).contains(&at);
        self.noise.iter().any(is_level) || self.apart.is_some_and(|apart| apart.contains(&at))
    }

    /// The knot at or before a spatial frequency (cycles/m), and the share of the one after it.
    pub fn between(&self, cycles_per_m: f64) -> (usize, f64) {
        let last = self.knots_at.len() - 1;
        let width = (self.knots_at[last] - self.knots_at[0]) / last as f64;
        let place = (cycles_per_m.ln() - self.knots_at[0]) / width;
        let place = place.clamp(0.0, last as f64);
        let low = (place as usize).min(last - 1);
        (low, place - low as f64)
    }

    /// ln of the road's density beside [`CLASS_C`] at a spatial frequency (cycles/m).
    pub fn road(&self, theta: &DVector<f64>, cycles_per_m: f64) -> f64 {
        let (low, part) = self.between(cycles_per_m);
        let at = self.knots + low;
        theta[at] * (1.0 - part) + theta[at + 1] * part
    }
}
