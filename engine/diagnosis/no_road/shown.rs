//! The other axle's acceleration as it was measured and as the models predict it.

use super::fit::Frame;
use super::judged::View;
use super::model::Model;
use super::predict::Spectra;
use super::record::Record;
use crate::explain::evidence::surface_of;
use veloid_core::bicycle::{Axle, PerAxle};
use veloid_core::numerics::finite::finite;
use veloid_fourier::Complex;
use veloid_report::diagnosis::{Evidence, Excerpt, HeldOut, Predicted, ResidualSpectrum, Surface};

/// Seconds that are shown where the plain model errs most.
const EXCERPT_S: f64 = 1.5;
/// Weight of a window from which the force is the whole one.
const WHOLE: f64 = 0.99;

pub struct Shown {
    pub axle: Axle,
    pub held_out: HeldOut,
    pub evidence: Evidence,
    /// Standard deviation of the acceleration (m/s^2).
    pub spread: f64,
}

impl Shown {
    /// `masses`: kg.
    pub fn of(view: &View, masses: &PerAxle<f64>) -> Self {
        let record = view.record;
        let axle = record.other();
        let plain = Seen::of(view, view.plain);
        let best = Seen::of(view, view.best);
        let measured: Vec<Vec<f64>> = (record.segments.iter())
            .map(|s| s.other.iter().zip(&s.window).map(|(a, w)| a * w).collect())
            .collect();
        let power = |x: &[Vec<f64>]| x.iter().flatten().map(|x| x * x).sum::<f64>();
        let weight: f64 = (record.segments.iter().flat_map(|s| &s.window))
            .map(|w| w * w)
            .sum();
        let spread = (power(&measured) / weight.max(f64::MIN_POSITIVE)).sqrt();
        let duration: f64 = record.segments.iter().map(|s| s.duration()).sum();
        let rms = |seen: &Option<Seen>| seen.as_ref().and_then(|s| finite(spread * s.share.sqrt()));
        let mass = masses.get(axle).copied().unwrap_or(1.0);
        Self {
            axle,
            held_out: HeldOut {
                plain_rms_m: rms(&plain),
                extended_rms_m: rms(&best),
                noise_floor_why: Some(NO_FLOOR.to_owned()),
                predicted: Predicted::Acceleration,
                window_s: [0.0, duration],
                ..HeldOut::default()
            },
            evidence: Evidence {
                predicted: Predicted::Acceleration,
                worst: excerpt(record, plain.as_ref(), best.as_ref()),
                spectrum: spectrum(record, plain.as_ref(), best.as_ref()),
                surface: (best.as_ref()).map_or_else(Surface::default, |b| missing(view, b, mass)),
            },
            spread,
        }
    }
}

/// Why there is no noise floor.
const NO_FLOOR: &str = "without a road the noise of both accelerometers and what the wheels' roads do not share are in these errors:     `latent_road.sensors` has each sensor's noise";

/// What a model makes of the record.
struct Seen {
    /// Predicted acceleration (m/s^2) by segment.
    predicted: Vec<Vec<f64>>,
    /// Deflection (m) and its rate (m/s) by segment.
    deflected: Vec<Vec<[f64; 2]>>,
    residuals: Spectra,
    /// Share of the power that it leaves.
    share: f64,
}

impl Seen {
    fn of(view: &View, model: &Model) -> Option<Self> {
        let record = view.record;
        let frame = Frame::around(record, view.scales, view.courses, model)?;
        let predicted = frame.predictor.spectra(std::slice::from_ref(model)).pop()?;
        let residuals = frame.left(&predicted).residuals;
        let power = |x: &[Complex<f64>]| x.iter().map(|x| x.norm_sqr()).sum::<f64>();
        let all: f64 = record.segments.iter().map(|s| power(&s.measured)).sum();
        let left: f64 = residuals.iter().map(|r| power(r)).sum();
        let mut predicted = Vec::new();
        let mut deflected = Vec::new();
        for (s, course) in view.courses.iter().enumerate() {
            let other = frame.predictor.ridden(std::slice::from_ref(model), s).other;
            predicted.push(other.a.iter().map(|a| a.0[0] * course.gain).collect());
            let pairs = other.d.iter().zip(&other.w);
            deflected.push(pairs.map(|(d, w)| [d.0[0], w.0[0]]).collect());
        }
        Some(Self {
            predicted,
            deflected,
            residuals,
            share: left / all.max(f64::MIN_POSITIVE),
        })
    }
}

/// The force that spring and damper leave of the axle's mass times its acceleration, over the deflection of the best model. That is of
/// the road that the other wheel gives: the force measured here was not used for it.
fn missing(view: &View, best: &Seen, mass: f64) -> Surface {
    let axle = view.record.other();
    let [k, b] = view.best.base(axle).map(|x| mass * x.exp());
    let mut points = Vec::new();
    for (s, segment) in view.record.segments.iter().enumerate() {
        for i in (0..segment.steps()).step_by(segment.over) {
            if segment.window[i] > WHOLE {
                let [d, w] = best.deflected[s][i];
                let force = mass * segment.other[i] / view.courses[s].gain;
                points.push([d, w, force - k * d - b * w]);
            }
        }
    }
    surface_of(&points, [k, b])
}

/// Where the plain model errs most.
fn excerpt(record: &Record, plain: Option<&Seen>, best: Option<&Seen>) -> Excerpt {
    let Some(plain) = plain else {
        return Excerpt::default();
    };
    let segments = &record.segments;
    let mut worst = (0.0, 0, 0);
    for (s, segment) in segments.iter().enumerate() {
        let length = (EXCERPT_S / segment.step) as usize;
        let errors: Vec<f64> = (segment
            .other
            .iter()
            .zip(&plain.predicted[s])
            .zip(&segment.window))
        .map(|((a, p), w)| (w * (a - p)).powi(2))
        .collect();
        for from in (0..errors.len().saturating_sub(length)).step_by((length / 2).max(1)) {
            let sum: f64 = errors[from..from + length].iter().sum();
            if sum > worst.0 {
                worst = (sum, s, from);
            }
        }
    }
    let (_, s, from) = worst;
    let Some(segment) = segments.get(s) else {
        return Excerpt::default();
    };
    let length = (EXCERPT_S / segment.step) as usize;
    let steps: Vec<usize> = (from..(from + length).min(segment.steps()))
        .step_by(segment.over)
        .collect();
    let of = |seen: Option<&Seen>| {
        let at = |i: &usize| seen.and_then(|seen| finite(seen.predicted[s][*i]));
        steps.iter().map(at).collect()
    };
    Excerpt {
        t_s: steps
            .iter()
            .map(|i| segment.start_s + segment.time(*i))
            .collect(),
        measured_m: steps.iter().map(|i| finite(segment.other[*i])).collect(),
        plain_m: of(Some(plain)),
        extended_m: of(best),
    }
}

/// Densities of what the models leave, by the bands of unknown noise.
fn spectrum(record: &Record, plain: Option<&Seen>, best: Option<&Seen>) -> ResidualSpectrum {
    let weight: f64 = (record.segments.iter())
        .map(|s| s.window.iter().map(|w| w * w).sum::<f64>() / s.over as f64)
        .sum();
    let density = |seen: Option<&Seen>, band: &std::ops::Range<usize>| {
        let seen = seen?;
        let power: f64 = (seen.residuals.iter())
            .flat_map(|r| r[band.clone()].iter().map(|x| x.norm_sqr()))
            .sum();
        finite(2.0 * power / band.len() as f64 / weight / record.rate_hz)
    };
    let centre = |b: &std::ops::Range<usize>| (record.hz(b.start) * record.hz(b.end)).sqrt();
    ResidualSpectrum {
        frequency_hz: record.bands.iter().map(centre).collect(),
        plain_m2_hz: record.bands.iter().map(|b| density(plain, b)).collect(),
        extended_m2_hz: record.bands.iter().map(|b| density(best, b)).collect(),
    }
}
