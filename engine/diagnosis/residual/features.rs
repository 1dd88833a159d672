//! Generic features of an axle's motion: what a force without a name, or a sensor's fault, could go with.

use veloid_model::dataset::Dataset;
use veloid_model::fit::Motion;

/// A feature: its signal, and whether it acts as a force or on the sensor.
pub struct Feature {
    pub signal: Vec<f64>,
    pub acts: bool,
}

/// Powers and products of deflection and rate, memory of several lengths, time windows, the other
/// axle, speed, wheel and crank angle; on the sensor's side shifts, gain, zero point and drift.
pub fn features(dataset: &Dataset, motions: &[Motion], track: usize) -> Vec<Feature> {
    let moving = Moving::new(dataset, motions, track);
    [
        moving.powers(),
        moving.kinks(),
        moving.memory(),
        moving.windows(),
        moving.other_axle(),
        moving.speed(),
        moving.wheel(),
        moving.crank(),
        moving.sensor(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// An axle that moves.
struct Moving<'a> {
    dataset: &'a Dataset,
    motions: &'a [Motion],
    track: usize,
    /// Deflection and its rate over their RMS.
    d: Vec<f64>,
    w: Vec<f64>,
    /// Largest speed (m/s).
    top: f64,
}

impl<'a> Moving<'a> {
    fn new(dataset: &'a Dataset, motions: &'a [Motion], track: usize) -> Self {
        let m = &motions[track];
        let (ds, ws) = (rms(&m.d), rms(&m.w));
        Self {
            dataset,
            motions,
            track,
            d: m.d.iter().map(|x| x / ds).collect(),
            w: m.w.iter().map(|x| x / ws).collect(),
            top: dataset.speed.iter().copied().fold(0.0, f64::max),
        }
    }

    fn powers(&self) -> Vec<Feature> {
        let (d, w) = (&self.d, &self.w);
        let mut all = vec![self.force(&|_| 1.0)];
        for order in 1..=5 {
            for j in 0..=order {
                // Beyond three deviations powers only repeat single events.
                all.push(self.force(&|i| {
                    d[i].clamp(-4.0, 4.0).powi(order - j) * w[i].clamp(-4.0, 4.0).powi(j)
                }));
            }
        }
        all
    }

    /// Where a force of deflection or rate bends, jumps or stops.
    fn kinks(&self) -> Vec<Feature> {
        let (d, w) = (&self.d, &self.w);
        vec![
            self.force(&|i| d[i].abs()),
            self.force(&|i| w[i].abs()),
            self.force(&|i| w[i] / (w[i] * w[i] + 1e-3).sqrt()),
            self.force(&|i| d[i] / (d[i] * d[i] + 1e-3).sqrt()),
            self.force(&|i| (d[i] - 1.5).max(0.0)),
            self.force(&|i| (d[i] + 1.5).min(0.0)),
            self.force(&|i| w[i] * d[i].abs()),
        ]
    }

    fn memory(&self) -> Vec<Feature> {
        let d = &self.d;
        let mut all = Vec::new();
        for tau in [0.012, 0.04, 0.1, 0.4] {
            let keep = (-self.dataset.step / tau).exp();
            let (mut lag, mut out) = (0.0, Vec::with_capacity(self.dataset.samples));
            for x in d {
                lag = keep * lag + (1.0 - keep) * x;
                out.push(lag);
            }
            all.push(self.force(&|i| out[i]));
            all.push(self.force(&|i| (d[i] - out[i]) * d[i].abs()));
        }
        all
    }

    fn windows(&self) -> Vec<Feature> {
        let (windows, n) = (6, self.dataset.samples);
        let mut all = Vec::new();
        for k in 0..windows {
            let inside = |i: usize| i * windows / n == k;
            all.push(self.force(&|i| if inside(i) { self.d[i] } else { 0.0 }));
            all.push(self.force(&|i| if inside(i) { self.w[i] } else { 0.0 }));
        }
        all
    }

    fn other_axle(&self) -> Vec<Feature> {
        let mut tracks = 0..self.motions.len();
        let other = tracks.find(|t| *t != self.track);
        let feature = other.map(|other| {
            let acceleration = &self.motions[other].acceleration;
            let a = rms(acceleration);
            self.force(&|i| acceleration[i] / a)
        });
        feature.into_iter().collect()
    }

    fn rides(&self) -> bool {
        self.top > 0.3
    }

    fn speed(&self) -> Vec<Feature> {
        if !self.rides() {
            return Vec::new();
        }
        let (speed, top) = (&self.dataset.speed, self.top);
        vec![
            self.force(&|i| self.d[i] * speed[i] / top),
            self.force(&|i| self.w[i] * speed[i] / top),
            self.force(&|i| self.dataset.speed_rate[i]),
        ]
    }

    fn wheel(&self) -> Vec<Feature> {
        let mut all = Vec::new();
        let radius = self.dataset.tracks[self.track].scale.wheel_radius;
        if !self.rides() || !radius.is_finite() {
            return all;
        }
        let (d, distance) = (&self.d, &self.dataset.distance);
        for harmonic in [1.0, 2.0] {
            let angle = |x: f64| harmonic * x / radius;
            all.push(self.force(&|i| angle(distance[i]).sin()));
            all.push(self.force(&|i| angle(distance[i]).cos()));
            all.push(self.force(&|i| angle(distance[i]).sin() * d[i]));
            all.push(self.force(&|i| angle(distance[i]).cos() * d[i]));
        }
        all
    }

    fn crank(&self) -> Vec<Feature> {
        let mut all = Vec::new();
        let crank = &self.dataset.crank;
        if crank.last().is_some_and(|c| *c > 1.0) {
            for harmonic in [1.0, 2.0] {
                all.push(self.force(&|i| (harmonic * crank[i]).sin()));
                all.push(self.force(&|i| (harmonic * crank[i]).cos()));
            }
        }
        all
    }

    fn sensor(&self) -> Vec<Feature> {
        let (m, n) = (&self.motions[self.track], self.dataset.samples);
        let z = rms(&m.z);
        let shifted =
            |i: usize, by: isize| m.z[(i as isize + by).clamp(0, n as isize - 1) as usize] / z;
        vec![
            self.reading(&|i| m.z[i] / z),
            self.reading(&|i| shifted(i, -2)),
            self.reading(&|i| shifted(i, 2)),
            self.reading(&|_| 1.0),
            self.reading(&|i| i as f64 / n as f64),
        ]
    }

    fn force(&self, f: &dyn Fn(usize) -> f64) -> Feature {
        Feature {
            signal: (0..self.dataset.samples).map(f).collect(),
            acts: true,
        }
    }

    fn reading(&self, f: &dyn Fn(usize) -> f64) -> Feature {
        Feature {
            signal: (0..self.dataset.samples).map(f).collect(),
            acts: false,
        }
    }
}

fn rms(x: &[f64]) -> f64 {
    (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64)
        .sqrt()
        .max(1e-30)
}
