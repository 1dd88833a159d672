//! What was found, as the report shows it.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::band::Band;
use super::bins::Bins;
use super::fit::Fit;
use super::intervals::{RESTS_ON_ROAD, Spread};
use super::parameters::{CLASS_C, GAIN, Layout, SPEED, index};
use super::record::{Record, Sensor};
use super::windows::WINDOW_S;
use veloid_core::bicycle::{Axle, Bike};
use veloid_core::document::format_number::{WIDE, significant};
use veloid_core::numerics::spectrum::deviation;
use veloid_methods::simulate::road::Roughness;
use veloid_report::{Correction, Estimate, LatentRoad, RoadSpectrum, SensorFound};
use veloid_ride::{SensorKind, channel_name};

/// Part of what was known beforehand that a standard error may have, to count as determined by the ride.
const TOLD: f64 = 0.5;
/// Ratio of the spectra to what the model makes of them, over half an octave, from which a misfit is said, and how many
/// standard errors it must be.
pub const MISFIT: f64 = 0.5;
const SURE: f64 = 5.0;
/// Standard error of the logarithm of a noise density from which the road hides the noise: its 95 % interval then spans a factor of four.
const HIDDEN: f64 = 0.7;
/// Factor by which noise reads high or low beyond the fit's own error, on six simulated rides with noise of 0.03 and 0.3 m/s^2.
const ROUGH: f64 = 1.3;

/// Why only the road's spectrum determines k and B.
const ALIKE: &str = "only the shape of the road's spectrum determines it, not the comparison of the sensors: the axles are too similar \
    (k/m, B/m), or the speed is too low";
const ONE_AXLE: &str = "only the shape of the road's spectrum determines the gain between the sensors of one axle, on which k depends: add \
    an accelerometer on the other axle";

/// Everything that a fit ended with.
pub struct Ended<'a> {
    pub record: &'a Record,
    pub band: Band,
    pub bins: &'a Bins,
    pub layout: &'a Layout,
    pub fit: &'a Fit,
    pub spread: &'a Spread,
}

impl Ended<'_> {
    pub fn report(&self, bike: &Bike) -> LatentRoad {
        let windows = self.bins.groups.iter().filter(|g| !g.is_empty()).count();
        let tops = self.bins.all().map(|b| b.omega / TAU);
        LatentRoad {
            front: self.estimate(Axle::Front, bike),
            rear: self.estimate(Axle::Rear, bike),
            reason: None,
            road: self.road(),
            speed: self
                .layout
                .speed
                .and_then(|at| self.correction(at, 1.0, SPEED)),
            sensors: (self.record.sensors.iter().enumerate())
                .map(|(i, sensor)| self.sensor(i, sensor))
                .collect(),
            band_hz: [self.band.low_hz, tops.fold(0.0, f64::max)],
            windows,
            window_s: WINDOW_S,
            notes: misfits(
                &self.fit.at.quadratic,
                self.bins.repeats,
                self.bins.spacing / TAU,
            ),
        }
    }

    fn estimate(&self, axle: Axle, bike: &Bike) -> Option<Estimate> {
        let at = self.layout.axles[index(axle)]?;
        let mass_kg = bike.mass(axle)?;
        let value = |at: usize| mass_kg * self.fit.theta[at].exp();
        let (k_n_m, b_n_s_m) = (value(at), value(at + 1));
        // The error of a logarithm is a share.
        let std = |at: usize, value: f64| value * self.spread.std_error[at];
        let estimate = Estimate {
            k_n_m,
            b_n_s_m,
            k_std_n_m: Some(std(at, k_n_m)),
            b_std_n_s_m: Some(std(at + 1, b_n_s_m)),
            mass_kg,
            covariance: Estimate::propagated([[k_n_m, 0.0], [0.0, b_n_s_m], [0.0; 2]], |p, q| {
                self.spread.covariance[(at + p, at + q)]
            }),
            ..Estimate::default()
        };
        let why = rests_on_road(&self.spread.widens[at..at + 2]).then(|| match self.layout.apart {
            Some(_) => ALIKE.to_owned(),
            None => ONE_AXLE.to_owned(),
        });
        let estimate = match why {
            Some(why) => estimate.withheld(&why),
            None => estimate,
        };
        let reported = estimate.within_reach(self.record.step_s).reportable();
        reported.is_finite().then_some(reported)
    }

    /// A correction of `unit` per unknown, where the ride shows it better than `known` was.
    fn correction(&self, at: usize, unit: f64, known: f64) -> Option<Correction> {
        let std_error = unit * self.spread.std_error[at];
        (std_error < TOLD * known).then(|| Correction {
            value: unit * self.fit.theta[at],
            std_error,
        })
    }

    /// How late a sensor's clock is in the record's middle (s).
    pub fn delay(&self, i: usize) -> Option<Correction> {
        let sensor = &self.record.sensors[i];
        let found = self.correction(self.layout.delay[i]?, sensor.clock_s, sensor.clock_s)?;
        Some(Correction {
            value: found.value + sensor.known.offset_s,
            ..found
        })
    }

    /// The one-sided density of a sensor's noise (unit^2/Hz) at a frequency.
    pub fn noise_density(&self, i: usize, hz: f64) -> f64 {
        let share = self.layout.noise[i].density(&self.fit.theta, hz);
        share * self.bins.scale[i].powi(2)
    }

    /// Standard error of the logarithm of a sensor's noise density, that of the level known least.
    fn noise_error(&self, i: usize) -> f64 {
        let levels = self.layout.noise[i];
        let errors = &self.spread.std_error[levels.first..levels.first + levels.count];
        errors.iter().copied().fold(0.0, f64::max)
    }

    /// k/B of an axle (1/s).
    pub fn stiffness_per_damping(&self, axle: Axle) -> Option<f64> {
        let at = self.layout.axles[index(axle)]?;
        Some((self.fit.theta[at] - self.fit.theta[at + 1]).exp())
    }

    /// The share by which it runs fast.
    pub fn drift(&self, i: usize) -> Option<Correction> {
        let sensor = &self.record.sensors[i];
        let found = self.correction(self.layout.drift[i]?, sensor.drift, sensor.drift)?;
        Some(Correction {
            value: found.value + sensor.known.drift,
            ..found
        })
    }

    fn sensor(&self, i: usize, sensor: &Sensor) -> SensorFound {
        let seen = self.bins.all().filter(|b| b.active > i);
        let densities = seen.map(|b| self.noise_density(i, b.omega / TAU));
        let (sum, count) = densities.fold((0.0, 0.0), |(s, n), d| (s + d, n + 1.0));
        let density = sum / f64::max(count, 1.0);
        let error = self.noise_error(i);
        let noise = (error < HIDDEN).then(|| deviation(density, self.record.step_s));
        // The deviation goes with the root of the density.
        let times = (0.5 * WIDE * error).hypot(ROUGH.ln()).exp();
        let (frequency_hz, shown) = self.shown(i);
        SensorFound {
            channel: channel_name(sensor.kind, sensor.axle).to_owned(),
            gain: self.layout.gain[i].and_then(|at| {
                let share = self.correction(at, 1.0, GAIN)?;
                let value = share.value.exp();
                let std_error = value * share.std_error;
                Some(Correction { value, std_error })
            }),
            delay_s: self.delay(i),
            drift_ppm: self.drift(i).map(|drift| Correction {
                value: 1e6 * drift.value,
                std_error: 1e6 * drift.std_error,
            }),
            noise,
            noise_interval: noise.map(|noise| [noise / times, noise * times]),
            unit: if sensor.kind == SensorKind::Acceleration {
                "m/s^2"
            } else {
                "m"
            }
            .to_owned(),
            frequency_hz,
            density: shown,
        }
    }

    /// Frequencies (Hz) that a sensor reaches, and its mean density over the windows at each of them.
    fn shown(&self, i: usize) -> (Vec<f64>, Vec<f64>) {
        let mut sums: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
        for bin in self.bins.all().filter(|bin| bin.active > i) {
            let line = (bin.omega / self.bins.spacing).round() as usize;
            let [sum, count] = sums.entry(line).or_default();
            *sum += bin.x[i].norm_sqr() * self.bins.scale[i].powi(2);
            *count += 1.0;
        }
        let hz = |line: usize| line as f64 * self.bins.spacing / TAU;
        let shown = sums.into_iter();
        shown
            .map(|(line, [sum, count])| (hz(line), sum / count))
            .unzip()
    }

    fn road(&self) -> Option<RoadSpectrum> {
        let (low, high) = self.bins.span()?;
        // ISO 8608 fits its straight line up to 2.83 cycles/m.
        let counted = |n: &f64| *n <= 2.83_f64.max(1.5 * low);
        let knots = self.layout.knots_at.iter().map(|ln| ln.exp());
        let level = |n: f64| self.layout.road(&self.fit.theta, n);
        let levels: Vec<f64> = knots.clone().filter(counted).map(level).collect();
        let mean = levels.iter().sum::<f64>() / levels.len().max(1) as f64;
        let psd_m3 = Roughness::C.psd_m3() * mean.exp();
        let density = |n: f64| level(n).exp() * CLASS_C / (n * n);
        let density_m3: Vec<f64> = knots.clone().map(density).collect();
        (psd_m3.is_finite() && density_m3.iter().all(|d| d.is_finite())).then(|| RoadSpectrum {
            class: Roughness::nearest(psd_m3).name().to_owned(),
            psd_m3,
            band_cycles_per_m: [low, high],
            cycles_per_m: knots.collect(),
            density_m3,
        })
    }
}

/// Where the sensors show more or less than the model explains: by half octaves of frequencies `spacing_hz` apart, of which
/// `lines` holds what is shown and what is due, each number `repeats` times.
fn misfits(lines: &[[f64; 2]], repeats: f64, spacing_hz: f64) -> Vec<String> {
    let mut notes = Vec::new();
    let mut from = 0;
    while from < lines.len() {
        let half_octave = (from as f64 * std::f64::consts::SQRT_2).ceil() as usize;
        let to = half_octave.max(from + 4).min(lines.len());
        let sums = lines[from..to].iter();
        let [shown, due] = sums.fold([0.0, 0.0], |s, line| [s[0] + line[0], s[1] + line[1]]);
        let ratio = shown / due.max(1.0);
        let error = (repeats / due.max(1.0)).sqrt();
        if due > 0.0 && (ratio - 1.0).abs() > MISFIT.max(SURE * error) {
            notes.push(format!(
                "between {} Hz and {} Hz the sensors show {} times the power expected of two axles on one road",
                significant(from as f64 * spacing_hz, 2),
                significant((to - 1) as f64 * spacing_hz, 2),
                significant(ratio, 2)
            ));
        }
        from = to;
    }
    notes
}

/// Whether it is the road's smoothness that determines k or B.
fn rests_on_road(widens: &[Option<f64>]) -> bool {
    widens.iter().any(|w| w.is_none_or(|w| w > RESTS_ON_ROAD))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misfits_are_said_where_they_are() {
        let lines = |off: f64, due: f64| -> Vec<[f64; 2]> {
            let shown = |k: usize| {
                if (36..51).contains(&k) {
                    1.0 + off
                } else {
                    1.0
                }
            };
            (0..80).map(|k| [due * shown(k), due]).collect()
        };
        let said = |off: f64, due: f64| misfits(&lines(off, due), 2.1, 0.25);
        assert!(said(0.9 * MISFIT, 500.0).is_empty() && said(-0.9 * MISFIT, 500.0).is_empty());
        let found = said(1.2 * MISFIT, 500.0);
        assert!(
            !found.is_empty() && found.iter().all(|n| n.contains("1.6 times")),
            "{found:?}"
        );
        assert!(!said(-1.2 * MISFIT, 500.0).is_empty());
        // Few numbers say nothing.
        assert!(said(1.2 * MISFIT, 1.0).is_empty());
        assert!(misfits(&[], 2.1, 0.25).is_empty());
    }

    #[test]
    fn what_widens_twice_rests_on_the_road() {
        let twice = |share: f64| rests_on_road(&[Some(1.0), Some(share * RESTS_ON_ROAD)]);
        assert!(!twice(0.999) && twice(1.001) && rests_on_road(&[None, Some(1.0)]));
    }
}
