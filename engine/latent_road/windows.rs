//! Spectra of short windows, in which the speed hardly changes.

use std::sync::Arc;

use nalgebra::Complex;
use veloid_fourier::RealToComplex;

use super::align::{interpolate, places};
use super::record::Record;
use veloid_core::bicycle::Axle;
use veloid_core::numerics::spectrum::hann;

/// Length of a window (s): long beside an axle's memory (0.1 s), short beside what a speed needs to change.
pub const WINDOW_S: f64 = 4.0;
/// Speed (m/s) below which a window is left out: who pushes a bicycle or stands.
pub const SLOWEST: f64 = 1.0;
/// Largest ratio of the speeds within a window.
pub const STEADY: f64 = 2.0;
/// Windows that are used at most (13 minutes of half-overlapping ones); longer rides are looked at in evenly spread ones.
pub const MOST_WINDOWS: usize = 400;

/// One window.
#[derive(Clone, Debug)]
pub struct Window {
    /// Its middle, since the record's (s, the front wheel's time).
    pub time_s: f64,
    /// Mean speed of the front wheel (m/s).
    pub speed: f64,
    /// Mean delay of the rear wheel behind the front (s), by the speed.
    pub delay_s: f64,
    /// How many times faster the rear wheel's time runs than its aligned record.
    pub stretch: f64,
    /// Spectra by frequency, then sensor; |.|^2 is a one-sided density (unit^2/Hz).
    pub spectra: Vec<Vec<Complex<f64>>>,
}

/// All windows of a record.
#[derive(Clone, Debug)]
pub struct Windows {
    /// Spacing (Hz) of the spectra's frequencies, which begin at 0.
    pub spacing_hz: f64,
    pub list: Vec<Window>,
}

/// The record with the rear wheel's sensors brought to the front wheel's time.
struct Aligned {
    sensors: Vec<Vec<f64>>,
    valid: Vec<bool>,
    /// For every sample, that of the rear wheel on the same road.
    rear_at: Vec<Option<f64>>,
}

impl Windows {
    /// Half-overlapping Hann windows over all that may be trusted.
    pub fn of(record: &Record) -> Self {
        let n = ((WINDOW_S / record.step_s).round() as usize).max(16) & !1;
        let mut out = Self {
            spacing_hz: 1.0 / (n as f64 * record.step_s),
            list: Vec::new(),
        };
        let samples = record.valid.len();
        if samples < n {
            return out;
        }
        let aligned = Aligned::of(record);
        let fourier = Fourier::new(n, record.step_s);
        let firsts = (0..=samples - n).step_by(n / 2);
        let usable: Vec<(usize, f64)> = firsts
            .filter_map(|first| Some((first, steady(record, &aligned, first, n)?)))
            .collect();
        let every = usable.len().div_ceil(MOST_WINDOWS).max(1);
        out.list = (usable.into_iter().step_by(every))
            .filter_map(|(first, speed)| window(record, &aligned, &fourier, first, speed))
            .collect();
        out
    }
}

/// Mean speed of a window in which all may be trusted and the speed is steady; nothing elsewhere.
fn steady(record: &Record, aligned: &Aligned, first: usize, n: usize) -> Option<f64> {
    let range = first..first + n;
    let speeds = record.speed.get(range.clone())?;
    let slowest = speeds.iter().copied().fold(f64::INFINITY, f64::min);
    let fastest = speeds.iter().copied().fold(0.0, f64::max);
    let trusted = aligned.valid[range].iter().all(|v| *v);
    (trusted && slowest >= SLOWEST && fastest <= STEADY * slowest)
        .then(|| speeds.iter().sum::<f64>() / n as f64)
}

fn window(
    record: &Record,
    aligned: &Aligned,
    fourier: &Fourier,
    first: usize,
    speed: f64,
) -> Option<Window> {
    let n = fourier.shape.len();
    let range = first..first + n;
    let places = &aligned.rear_at[range.clone()];
    let (from, to) = (places.first().copied()??, places.last().copied()??);
    let late = |(i, place): (usize, &Option<f64>)| place.unwrap_or(0.0) - (first + i) as f64;
    let mean_late = places.iter().enumerate().map(late).sum::<f64>() / n as f64;
    let mut spectra = vec![Vec::with_capacity(aligned.sensors.len()); n / 2 + 1];
    for values in &aligned.sensors {
        let spectrum = fourier.spectrum(&values[range.clone()])?;
        for (all, x) in spectra.iter_mut().zip(spectrum) {
            all.push(x);
        }
    }
    let stretch = (to - from) / (n - 1) as f64;
    (stretch > 0.0).then_some(Window {
        time_s: record.since_middle_s(first as f64 + 0.5 * (n - 1) as f64),
        speed,
        delay_s: mean_late * record.step_s,
        stretch,
        spectra,
    })
}

impl Aligned {
    fn of(record: &Record) -> Self {
        let samples = record.valid.len();
        let both = record.has(Axle::Front) && record.has(Axle::Rear);
        let rear_at: Vec<Option<f64>> = match record.wheelbase_m {
            Some(wheelbase) if both => places(&record.speed, record.step_s, wheelbase),
            _ => (0..samples).map(|i| Some(i as f64)).collect(),
        };
        let trusted = |i: usize| record.valid.get(i).copied().unwrap_or(false);
        let valid = rear_at.iter().enumerate().map(|(i, place)| {
            let at = place.map(|p| p as usize);
            trusted(i) && at.is_some_and(|at| trusted(at) && trusted((at + 1).min(samples - 1)))
        });
        let sensors = record.sensors.iter().map(|s| match s.axle {
            Axle::Front => s.values.clone(),
            Axle::Rear => (rear_at.iter())
                .map(|p| p.map_or(0.0, |p| interpolate(&s.values, p)))
                .collect(),
        });
        Self {
            sensors: sensors.collect(),
            valid: valid.collect(),
            rear_at,
        }
    }
}

/// Hann windows and what they are transformed by.
struct Fourier {
    transform: Arc<dyn RealToComplex<f64>>,
    shape: Vec<f64>,
    scale: f64,
}

impl Fourier {
    fn new(n: usize, step_s: f64) -> Self {
        let (shape, power) = hann(n);
        Self {
            transform: veloid_fourier::forward(n),
            scale: (2.0 * step_s / power).sqrt(),
            shape,
        }
    }

    /// Nothing where the numbers are too large.
    fn spectrum(&self, values: &[f64]) -> Option<Vec<Complex<f64>>> {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let mut part: Vec<f64> = (values.iter().zip(&self.shape))
            .map(|(x, w)| (x - mean) * w)
            .collect();
        let mut out = self.transform.make_output_vec();
        self.transform.process(&mut part, &mut out).ok()?;
        let spectrum = out.iter().map(|x| x * self.scale);
        let spectrum: Vec<Complex<f64>> = spectrum.collect();
        spectrum
            .iter()
            .all(|x| x.norm_sqr().is_finite())
            .then_some(spectrum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{Lateness, Sensor};
    use veloid_core::numerics::example::white;
    use veloid_ride::SensorKind;

    fn record(speed: Vec<f64>, sensors: &[(Axle, Vec<f64>)]) -> Record {
        Record {
            step_s: 0.01,
            valid: vec![true; speed.len()],
            speed,
            sensors: (sensors.iter())
                .map(|(axle, values)| Sensor {
                    axle: *axle,
                    kind: SensorKind::Acceleration,
                    values: values.clone(),
                    known: Lateness::default(),
                    highest_hz: 40.0,
                    clock_s: 0.01,
                    beside: None,
                    drift: 0.0,
                })
                .collect(),
            wheelbase_m: Some(1.0),
        }
    }

    #[test]
    fn white_noise_has_its_density() {
        let windows = Windows::of(&record(
            vec![5.0; 60_000],
            &[(Axle::Front, white(60_000, 3))],
        ));
        let all = windows.list.iter().flat_map(|w| &w.spectra[4..190]);
        let densities: Vec<f64> = all.map(|x| x[0].norm_sqr()).collect();
        let mean = densities.iter().sum::<f64>() / densities.len() as f64;
        assert!((mean / 0.02 - 1.0).abs() < 0.02, "{mean}");
    }

    #[test]
    fn the_same_road_is_in_phase_on_both_axles() {
        let noise = white(12_000, 5);
        // 1 m at 4 m/s: 25 samples.
        let late: Vec<f64> = (0..12_000_usize)
            .map(|i| i.checked_sub(25).map_or(0.0, |j| noise[j]))
            .collect();
        let both = [(Axle::Front, noise), (Axle::Rear, late)];
        let windows = Windows::of(&record(vec![4.0; 12_000], &both));
        for window in &windows.list {
            assert!((window.delay_s - 0.25).abs() < 1e-9 && (window.stretch - 1.0).abs() < 1e-9);
            for x in &window.spectra[4..150] {
                assert!((x[0] - x[1]).norm() < 1e-6 + 1e-3 * x[0].norm());
            }
        }
    }

    #[test]
    fn windows_end_at_stops_and_where_nothing_can_be_trusted() {
        let count = |change: &dyn Fn(usize) -> f64| {
            let speed = (0..4000).map(change).collect();
            let one = [(Axle::Front, white(4000, 1))];
            Windows::of(&record(speed, &one)).list.len()
        };
        assert_eq!(count(&|_| 5.0), 19);
        assert_eq!(count(&|_| 1.001 * SLOWEST), 19);
        assert_eq!(count(&|_| 0.999 * SLOWEST), 0);
        assert_eq!(count(&|i| if i < 2000 { 5.0 } else { 0.0 }), 9);
        let jump = |ratio: f64| count(&|i| if i == 1999 { 5.0 * ratio } else { 5.0 });
        assert_eq!((jump(0.999 * STEADY), jump(1.001 * STEADY)), (19, 17));
        let mut gap = record(vec![5.0; 4000], &[(Axle::Front, white(4000, 1))]);
        gap.valid[1999] = false;
        assert_eq!(Windows::of(&gap).list.len(), 17);
    }

    #[test]
    fn long_rides_are_looked_at_in_spread_windows() {
        let n = 200 * (MOST_WINDOWS + 2);
        let one = [(Axle::Front, white(n, 1))];
        let windows = Windows::of(&record(vec![5.0; n], &one));
        assert_eq!(windows.list.len(), (MOST_WINDOWS + 1).div_ceil(2));
    }
}
