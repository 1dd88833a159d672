//! Two accelerometers on a fine clock, cut into segments of equal length, one axle before the other.

use std::f64::consts::{PI, TAU};
use std::ops::Range;
use std::sync::Arc;

use veloid_core::bicycle::Axle;
use veloid_fourier::{Complex, RealToComplex, forward, inverse};
use veloid_model::dataset::speed;
use veloid_ride::{Ride, SensorKind, distance};

/// Rate (Hz) of the clock on which the laws are integrated: 0.5 % of B at 40 Hz by trapezoids.
const FINE_HZ: f64 = 600.0;
/// Longest segment (s): a knot of the delay each second makes 63 columns of its projection.
const LONGEST_S: f64 = 60.0;
/// Shortest segment (s) that leaves something between its ends.
const SHORTEST_S: f64 = 12.0;
/// Seconds at a segment's ends that are not judged, and over which its window rises: the deflection starts unknown, and a wheel is
/// late by up to a second.
const BEFORE_S: f64 = 2.0;
const AFTER_S: f64 = 1.5;
const RISES_S: f64 = 1.0;
/// Lowest frequency (Hz) of an acceleration that is believed, from which to which it comes in, and the lowest that is judged.
const DRIFTS_HZ: f64 = 0.3;
const HOLDS_HZ: f64 = 0.7;
const LOWEST_HZ: f64 = 1.0;
/// Highest frequency (Hz) that is judged, and the same in parts of the rate.
const HIGHEST_HZ: f64 = 40.0;
const OF_RATE: f64 = 0.35;
/// Where the road, or a logger's filter, ends: a density falls to this part within a quarter of an octave, below what it was over the octave
/// before. Cells of an eighth of an octave, from the lowest frequency (Hz) at which that is looked for.
const FALLS_TO: f64 = 0.1;
const PER_OCTAVE: usize = 8;
const ENDS_ABOVE_HZ: f64 = 4.0;
/// Speed (m/s) below which a wheelbase takes too long.
const SLOWEST: f64 = 1.0;
/// Gravity (m/s^2), and parts of it: a wheel that falls faster than the first is in the air, where nothing but gravity acts and the road
/// is not seen, unless it also falls faster than the second about as often as it is thrown up so fast: then something holds it down.
const GRAVITY: f64 = 9.81;
const FALLS: f64 = 0.9;
const PULLED: f64 = 1.2;
const AS_OFTEN: f64 = 0.3;
/// Seconds around a flight that are not judged, and over which the window falls before that.
const AROUND_S: f64 = 0.1;
/// Share of the ride that must be left between flights.
const ON_THE_GROUND: f64 = 0.5;
/// Fewest lines in a band of unknown noise, and bands at most.
const LINES: usize = 70;
const BANDS: usize = 14;

/// What is recorded of a ride, for one axle (`lead`) that gives the road and another that rides over it.
pub struct Record {
    pub rate_hz: f64,
    pub lead: Axle,
    pub segments: Vec<Segment>,
    /// Lines of a segment's spectrum that are judged, and bands of them whose noise is unknown.
    pub lines: Range<usize>,
    pub bands: Vec<Range<usize>>,
    pub fourier: Arc<dyn RealToComplex<f64>>,
}

/// What moves one axle, on the fine clock.
#[derive(Clone, Debug, Default)]
pub struct Moved {
    /// Acceleration (m/s^2), velocity (m/s) and height (m).
    pub a: Vec<f64>,
    pub v: Vec<f64>,
    pub z: Vec<f64>,
}

/// A stretch of the ride.
pub struct Segment {
    /// Time of its first sample (s).
    pub start_s: f64,
    /// Steps of the fine clock for each sample, and such a step (s).
    pub over: usize,
    pub step: f64,
    pub lead: Moved,
    pub speed: Vec<f64>,
    pub speed_rate: Vec<f64>,
    pub distance: Vec<f64>,
    pub crank: Vec<f64>,
    pub double_crank: Vec<[f64; 2]>,
    /// When (s) the leading axle stood where the other one stands at each step.
    pub stood: Vec<f64>,
    pub window: Vec<f64>,
    /// The other axle's acceleration (m/s^2), and its spectrum.
    pub other: Vec<f64>,
    pub measured: Vec<Complex<f64>>,
}

impl Segment {
    pub fn steps(&self) -> usize {
        self.speed.len()
    }

    pub fn time(&self, step: usize) -> f64 {
        step as f64 * self.step
    }

    pub fn duration(&self) -> f64 {
        self.steps() as f64 * self.step
    }
}

impl Record {
    /// # Errors
    /// Why the ride cannot be used.
    pub fn new(ride: &Ride, wheelbase_m: f64, lead: Axle) -> Result<Self, String> {
        let of = |axle: Axle| {
            let found = ride.sensors.iter();
            let mut found = found.filter(|s| s.axle == axle && s.kind == SensorKind::Acceleration);
            found.next()
        };
        let (Some(front), Some(rear), Some(speed)) =
            (of(Axle::Front), of(Axle::Rear), ride.speed.as_ref())
        else {
            return Err("accelerometers on both axles and a speed are needed".to_owned());
        };
        let rate_hz = 1.0 / ride.step_s;
        let is_good = |i: usize| front.valid[i] && rear.valid[i] && speed[i] >= SLOWEST;
        let spans = spans(ride.samples, rate_hz, is_good);
        let Some(samples) = spans.first().map(Range::len) else {
            return Err(format!(
                "no stretch of {SHORTEST_S} s has both accelerometers and a speed above {SLOWEST} m/s"
            ));
        };
        let over = (FINE_HZ / rate_hz).round().max(1.0) as usize;
        let duration = samples as f64 * ride.step_s;
        let highest = (OF_RATE * rate_hz).min(HIGHEST_HZ);
        let lines = (LOWEST_HZ * duration).ceil() as usize..(highest * duration) as usize;
        let fourier = forward(samples * over);
        let (lead_values, other) = match lead {
            Axle::Front => (&front.values, &rear.values),
            Axle::Rear => (&rear.values, &front.values),
        };
        let ahead = match lead {
            Axle::Front => -wheelbase_m,
            Axle::Rear => wheelbase_m,
        };
        let flights = [lead_values, other].map(|a| flights(a, rate_hz));
        let crank = crank(ride);
        let segment = |span: &Range<usize>| {
            let fine = |x: &[f64]| finer(&x[span.clone()], over);
            let speed = fine(speed);
            let step = ride.step_s / over as f64;
            let distance = distance(&speed, step);
            let crank = fine(&crank);
            let stood = stood(&distance, step, ahead);
            let mut window = window(samples * over, step);
            let [lead_flies, flies] = flights.each_ref().map(|f| fine(f));
            for (i, weight) in window.iter_mut().enumerate() {
                let then = (stood[i] / step).round() as usize;
                *weight *= (1.0 - flies[i]) * (1.0 - lead_flies[then.min(lead_flies.len() - 1)]);
            }
            let follower = moved(&other[span.clone()], over, ride.step_s);
            let windowed: Vec<f64> = follower.a.iter().zip(&window).map(|(a, w)| a * w).collect();
            Segment {
                start_s: span.start as f64 * ride.step_s,
                over,
                step,
                lead: moved(&lead_values[span.clone()], over, ride.step_s),
                speed_rate: speed::rate(&speed, step),
                speed,
                distance,
                double_crank: crank.iter().map(|x| (2.0 * x).sin_cos().into()).collect(),
                crank,
                stood,
                measured: spectrum(&*fourier, windowed, &lines, over),
                other: follower.a,
                window,
            }
        };
        let mut segments: Vec<Segment> = spans.iter().map(segment).collect();
        let full = window(samples * over, ride.step_s / over as f64)
            .iter()
            .sum::<f64>();
        let left = segments
            .iter()
            .map(|s| s.window.iter().sum::<f64>())
            .sum::<f64>();
        let on_the_ground = left / (full * segments.len() as f64);
        if on_the_ground < ON_THE_GROUND {
            return Err(format!(
                "a wheel is in the air so often that {:.0} % of the ride is left, and there the road is not seen",
                100.0 * on_the_ground
            ));
        }
        let ends = |spectra: &[Vec<Complex<f64>>]| ends(spectra, &lines, duration);
        let measured: Vec<_> = segments.iter().map(|s| s.measured.clone()).collect();
        let of_lead = |s: &Segment| {
            let windowed = s.lead.a.iter().zip(&s.window).map(|(a, w)| a * w);
            spectrum(&*fourier, windowed.collect(), &lines, over)
        };
        let of_lead: Vec<_> = segments.iter().map(of_lead).collect();
        let lines = lines.start..ends(&measured).min(ends(&of_lead));
        segments
            .iter_mut()
            .for_each(|s| s.measured.truncate(lines.len()));
        Ok(Self {
            rate_hz,
            lead,
            segments,
            bands: bands(&lines, spans.len()),
            lines,
            fourier,
        })
    }

    /// The axle that rides over the leading one's road.
    pub fn other(&self) -> Axle {
        match self.lead {
            Axle::Front => Axle::Rear,
            Axle::Rear => Axle::Front,
        }
    }

    /// Real numbers that are judged.
    pub fn values(&self) -> usize {
        2 * self.segments.len() * self.lines.len()
    }

    /// Frequency (Hz) of a line that is judged.
    pub fn hz(&self, line: usize) -> f64 {
        let duration = self.segments.first().map_or(1.0, Segment::duration);
        (self.lines.start + line) as f64 / duration
    }
}

/// The line at which a road, or a logger's filter, ends, or the last one.
fn ends(spectra: &[Vec<Complex<f64>>], lines: &Range<usize>, duration: f64) -> usize {
    let edge = |cell: usize| {
        let line = lines.start as f64 * 2f64.powf(cell as f64 / PER_OCTAVE as f64);
        (line.round() as usize).min(lines.end)
    };
    let density = |cell: usize| {
        let own = edge(cell) - lines.start..edge(cell + 1) - lines.start;
        let power =
            |x: &Vec<Complex<f64>>| x[own.clone()].iter().map(|x| x.norm_sqr()).sum::<f64>();
        spectra.iter().map(power).sum::<f64>() / own.len().max(1) as f64
    };
    let cells = (0..).take_while(|cell| edge(cell + 1) < lines.end).count();
    let densities: Vec<f64> = (0..cells).map(density).collect();
    let quarter = PER_OCTAVE / 4;
    let falls = |cell: &usize| {
        let before = densities[cell - PER_OCTAVE..=*cell]
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        let after = densities[cell + quarter];
        after < FALLS_TO * densities[*cell] && after < before
    };
    let first = (PER_OCTAVE..cells.saturating_sub(quarter))
        .filter(|cell| edge(*cell) as f64 >= ENDS_ABOVE_HZ * duration);
    first.clone().find(falls).map_or(lines.end, edge)
}

/// Spectrum at the lines that are judged.
pub fn spectrum(
    fourier: &dyn RealToComplex<f64>,
    mut values: Vec<f64>,
    lines: &Range<usize>,
    over: usize,
) -> Vec<Complex<f64>> {
    let mut all = fourier.make_output_vec();
    // Lengths are those of the plan.
    if fourier.process(&mut values, &mut all).is_err() {
        return vec![Complex::default(); lines.len()];
    }
    all[lines.clone()].iter().map(|x| x / over as f64).collect()
}

/// How far (0 to 1) each sample is to be left out since the wheel is in the air.
fn flights(a: &[f64], rate_hz: f64) -> Vec<f64> {
    let mut out = vec![0.0; a.len()];
    let count = |is: &dyn Fn(f64) -> bool| a.iter().filter(|a| is(**a)).count() as f64;
    let pulled = count(&|a| a < -PULLED * GRAVITY);
    let thrown = count(&|a| a > PULLED * GRAVITY);
    if pulled > AS_OFTEN * thrown {
        return out;
    }
    let reach = (AROUND_S * rate_hz).ceil() as usize;
    for i in (0..a.len()).filter(|i| a[*i] < -FALLS * GRAVITY) {
        for j in i.saturating_sub(2 * reach)..(i + 2 * reach + 1).min(a.len()) {
            let beyond = (i.abs_diff(j) as f64 / reach as f64 - 1.0).max(0.0);
            out[j] = f64::max(out[j], 0.5 + 0.5 * (PI * beyond).cos());
        }
    }
    out
}

/// Segments of one length: as few as possible of each good stretch, none longer than [`LONGEST_S`].
fn spans(samples: usize, rate_hz: f64, is_good: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
    let mut stretches: Vec<Range<usize>> = Vec::new();
    let mut from = None;
    for i in 0..=samples {
        let good = i < samples && is_good(i);
        match (good, from) {
            (true, None) => from = Some(i),
            (false, Some(first)) => {
                stretches.push(first..i);
                from = None;
            }
            _ => {}
        }
    }
    let longest = stretches.iter().map(Range::len).max().unwrap_or(0);
    let pieces = (longest as f64 / (LONGEST_S * rate_hz)).ceil().max(1.0);
    let length = smooth((longest as f64 / pieces) as usize);
    if (length as f64) < SHORTEST_S * rate_hz {
        return Vec::new();
    }
    let of_stretch = |s: &Range<usize>| {
        let start = s.start;
        (0..s.len() / length).map(move |i| start + i * length..start + (i + 1) * length)
    };
    stretches.iter().flat_map(of_stretch).collect()
}

/// The largest even number up to `n` without a prime factor above 5, so that transforms are fast.
fn smooth(n: usize) -> usize {
    let is_smooth = |n: &usize| {
        let mut rest = *n;
        for prime in [2, 3, 5] {
            while rest.is_multiple_of(prime) {
                rest /= prime;
            }
        }
        rest == 1 && n.is_multiple_of(2)
    };
    (2..=n).rev().find(is_smooth).unwrap_or(0)
}

/// Bands of neighbouring lines, in nearly equal ratios.
fn bands(lines: &Range<usize>, segments: usize) -> Vec<Range<usize>> {
    let least = LINES.div_ceil(segments.max(1)).max(4);
    let ratio = lines.end as f64 / lines.start.max(1) as f64;
    let edge = |i: usize| {
        let at = lines.start as f64 * ratio.powf(i as f64 / BANDS as f64);
        (at.round() as usize).min(lines.end) - lines.start
    };
    let mut found = Vec::new();
    let mut from = 0;
    for i in 1..=BANDS {
        if edge(i) - from >= least {
            found.push(from..edge(i));
            from = edge(i);
        }
    }
    match found.last_mut() {
        Some(last) => last.end = lines.len(),
        None => found.push(0..lines.len()),
    }
    found
}

/// Angle (rad) of the crank at every sample.
fn crank(ride: &Ride) -> Vec<f64> {
    match &ride.cadence {
        Some(cadence) => (distance(cadence, ride.step_s).iter())
            .map(|turns| turns * TAU / 60.0)
            .collect(),
        None => vec![0.0; ride.samples],
    }
}

/// Between the samples along straight lines.
fn finer(x: &[f64], over: usize) -> Vec<f64> {
    let at = |i: usize| {
        let (j, part) = (i / over, (i % over) as f64 / over as f64);
        let next = x[(j + 1).min(x.len() - 1)];
        x[j] + part * (next - x[j])
    };
    (0..x.len() * over).map(at).collect()
}

/// When a place `ahead` (m) of every step's was or will be passed (s); the ends where it never is.
fn stood(distance: &[f64], step: f64, ahead: f64) -> Vec<f64> {
    let mut j = 0;
    let last = distance.len().saturating_sub(2);
    let at = |x: &f64| {
        let place = x + ahead;
        while j < last && distance[j + 1] < place {
            j += 1;
        }
        let width = (distance[j + 1] - distance[j]).max(f64::MIN_POSITIVE);
        (j as f64 + ((place - distance[j]) / width).clamp(0.0, 1.0)) * step
    };
    distance.iter().map(at).collect()
}

fn window(steps: usize, step: f64) -> Vec<f64> {
    let end = steps as f64 * step - AFTER_S;
    let rises = |t: f64| 0.5 - 0.5 * (PI * (t / RISES_S).clamp(0.0, 1.0)).cos();
    (0..steps)
        .map(|i| rises(i as f64 * step - BEFORE_S) * rises(end - i as f64 * step))
        .collect()
}

/// An accelerometer's samples on the fine clock, without what drifts, with their integrals.
fn moved(values: &[f64], over: usize, step_s: f64) -> Moved {
    let n = values.len();
    let mean = values.iter().sum::<f64>() / n.max(1) as f64;
    let edge = (0.5 / step_s) as usize;
    let ramp = |i: usize| {
        let from_end = i.min(n - 1 - i) as f64;
        0.5 - 0.5 * (PI * (from_end / edge.max(1) as f64).min(1.0)).cos()
    };
    let mut tapered: Vec<f64> = (0..n).map(|i| (values[i] - mean) * ramp(i)).collect();
    let plan = forward(n);
    let mut coarse = plan.make_output_vec();
    let back = inverse(n * over);
    let mut fine = back.make_input_vec();
    if plan.process(&mut tapered, &mut coarse).is_err() {
        return Moved::default();
    }
    let duration = n as f64 * step_s;
    for (k, x) in coarse.iter().enumerate().take(n / 2) {
        let hz = k as f64 / duration;
        let part = ((hz - DRIFTS_HZ) / (HOLDS_HZ - DRIFTS_HZ)).clamp(0.0, 1.0);
        fine[k] = x * ((0.5 - 0.5 * (PI * part).cos()) / n as f64);
    }
    let integrated = |spectrum: &[Complex<f64>]| -> Vec<Complex<f64>> {
        let divided = |(k, x): (usize, &Complex<f64>)| match k {
            0 => Complex::default(),
            _ => x / Complex::new(0.0, TAU * k as f64 / duration),
        };
        spectrum.iter().enumerate().map(divided).collect()
    };
    let rate = integrated(&fine);
    let height = integrated(&rate);
    let values = |mut spectrum: Vec<Complex<f64>>| {
        let mut out = back.make_output_vec();
        match back.process(&mut spectrum, &mut out) {
            Ok(()) => out,
            Err(_) => vec![0.0; n * over],
        }
    };
    Moved {
        a: values(fine),
        v: values(rate),
        z: values(height),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines of 40 s from 1 Hz to 35 Hz.
    #[test]
    fn a_road_ends_where_its_density_falls_at_once() {
        let lines = 40..1400;
        let of = |density: &dyn Fn(f64) -> f64| {
            let line = |k: usize| Complex::new(density(k as f64 / 40.0).sqrt(), 0.0);
            ends(&[lines.clone().map(line).collect()], &lines, 40.0)
        };
        assert_eq!(of(&|_| 1.0), 1400);
        assert_eq!(of(&|hz| hz.powi(-2)), 1400);
        let ended = of(&|hz| if hz < 20.0 { 1.0 } else { 1e-2 }) as f64 / 40.0;
        assert!((17.0..=20.0).contains(&ended), "{ended} Hz");
        // A resonance falls back to where it rose from.
        let peak = |hz: f64| 1.0 + 100.0 * (-((hz - 10.0) / 0.4).powi(2)).exp();
        assert_eq!(of(&peak), 1400);
    }

    #[test]
    fn a_wheel_that_is_held_down_is_not_in_the_air() {
        let wave = |i: usize| 20.0 * (0.7 * i as f64).sin();
        let held: Vec<f64> = (0..400).map(wave).collect();
        assert!(flights(&held, 100.0).iter().all(|f| *f == 0.0));
        let flown: Vec<f64> = (0..400).map(|i| wave(i).max(-GRAVITY)).collect();
        assert!(flights(&flown, 100.0).contains(&1.0));
    }
}
