//! Frequency response: measured, of the plain model, and as the model with effects shows it.

use veloid_core::numerics::spline::lift;
use veloid_core::plant::Coefficients;
use veloid_fourier::Complex;
use veloid_methods::output_error::AxleFit;
use veloid_report::validation::{FrequencyResponse, ModelResponse};

use crate::periodic::distortion;
use crate::record::{Models, Record, short, shortened};
use crate::welch::Spectra;

/// Segments in the length of a record: of a minute, a resonance is resolved to 0.5 Hz (Hann's window) by 17 independent averages.
const PARTS: usize = 16;
/// Shortest segment (samples), and fewest of them: the coherence of unrelated records is one over their number in the mean.
const SHORTEST: usize = 64;
const FEWEST: usize = 8;
/// Frequencies that are reported at most, in equal ratios.
const FREQUENCIES: usize = 60;
/// Highest frequency, of half the sampling rate: beyond, the road between the samples is not known.
const HIGHEST: f64 = 0.9;
/// Coherence from which on a frequency is said to be measured.
const COHERENT: f64 = 0.5;
/// Standard deviations of a 95 % interval.
const WIDE: f64 = 1.96;

/// What is divided by what.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ratio {
    /// z/u.
    Road,
    /// z/F.
    Force,
    /// F/d.
    Rig,
}

/// The responses, or why there are none.
pub fn response(record: &Record, models: &Models) -> Result<FrequencyResponse, String> {
    let (ratio, input) = driven(record)?;
    let step = record.step();
    let length = (record.measured.len() / PARTS).max(SHORTEST) & !1;
    if record.measured.len() < length {
        return Err(short_record(0));
    }
    let extended = models.extended.as_ref().map(|model| -> Vec<f64> {
        let both = record.measured.iter().zip(&model.residual);
        both.map(|(y, left)| y - left).collect()
    });
    let outputs: Vec<&[f64]> = (std::iter::once(record.measured))
        .chain(extended.as_deref())
        .collect();
    let spectra = Spectra::new(input, &outputs, record.valid, length);
    if spectra.segments < FEWEST {
        return Err(short_record(spectra.segments));
    }
    let bins = bins(&spectra);
    let hz: Vec<f64> = (bins.iter())
        .map(|bin| *bin as f64 / (length as f64 * step))
        .collect();
    // Inputs are lifted so that their splines pass on all of a sine; a rig's motion is as it was measured.
    let raised = |hz: f64| match ratio {
        Ratio::Rig => 1.0,
        _ => lift(hz * step),
    };
    let seen = |output: usize| -> Vec<Complex<f64>> {
        let at = |(bin, hz): (&usize, &f64)| spectra.response(output, *bin) * raised(*hz);
        bins.iter().zip(&hz).map(at).collect()
    };
    let measured = seen(0);
    let coherence: Vec<f64> = bins.iter().map(|bin| spectra.coherence(0, *bin)).collect();
    let (low, high) = intervals(&measured, &coherence, spectra.averages());
    let (of, unit) = match ratio {
        Ratio::Road => ("z/u", "-"),
        Ratio::Force => ("z/F", "m/N"),
        Ratio::Rig => ("F/d", "N/m"),
    };
    let distortion = distortion(input, record.measured, record.valid, step);
    Ok(FrequencyResponse {
        of: of.to_owned(),
        unit: unit.to_owned(),
        segments: spectra.segments,
        segment_s: length as f64 * step,
        window: "hann".to_owned(),
        overlap: 0.5,
        detrend: "linear".to_owned(),
        averages: spectra.averages(),
        magnitude: shortened(measured.iter().map(|h| h.norm())),
        magnitude_low: low,
        magnitude_high: high,
        phase_rad: shortened(measured.iter().map(|h| h.arg())),
        coherent_above: COHERENT,
        coherent_hz: bands(&hz, &coherence),
        coherence: shortened(coherence),
        plain: plain(ratio, models.plain, &hz),
        extended: models.extended.as_ref().map(|_| ModelResponse {
            magnitude: shortened(seen(1).iter().map(|h| h.norm())),
            phase_rad: shortened(seen(1).iter().map(|h| h.arg())),
            ..ModelResponse::default()
        }),
        frequency_hz: shortened(hz),
        distortion_why: distortion.as_ref().err().cloned(),
        distortion: distortion.ok(),
    })
}

/// The one input that drives the axle.
fn driven<'r>(record: &'r Record) -> Result<(Ratio, &'r [f64]), String> {
    let why = match (record.input.prescribed, record.has_road, record.force()) {
        (true, ..) => return Ok((Ratio::Rig, &record.input.road)),
        (false, true, None) => return Ok((Ratio::Road, &record.input.road)),
        (false, false, Some(force)) => return Ok((Ratio::Force, force)),
        (false, true, Some(_)) => {
            "response: a road and a force move the axle at once, and one response would hold both"
        }
        (false, false, None) => "response: nothing drives the axle, which decays freely",
    };
    Err(why.to_owned())
}

fn short_record(segments: usize) -> String {
    format!("response: the record has {segments} whole segments, at least {FEWEST} are needed")
}

/// Bins in about equal ratios of frequency, where the input holds something.
fn bins(spectra: &Spectra) -> Vec<usize> {
    let last = (HIGHEST * (spectra.length / 2) as f64).floor();
    let at = |i: usize| last.powf(i as f64 / (FREQUENCIES - 1) as f64).round() as usize;
    let mut found: Vec<usize> = (0..FREQUENCIES).map(at).collect();
    found.dedup();
    found.retain(|bin| spectra.input[*bin] > 0.0 && spectra.outputs[0][*bin] > 0.0);
    found
}

/// 95 % intervals of a magnitude (Bendat & Piersol 2010, Random Data, table 9.6).
fn intervals(
    response: &[Complex<f64>],
    coherence: &[f64],
    averages: f64,
) -> (Vec<Option<f64>>, Vec<Option<f64>>) {
    let end = |sign: f64| {
        let of = move |(h, coherence): (&Complex<f64>, &f64)| {
            let share = WIDE * ((1.0 - coherence) / (2.0 * averages * coherence)).sqrt();
            (share < 1.0).then(|| short(h.norm() * (1.0 + sign * share)))
        };
        response.iter().zip(coherence).map(of).collect()
    };
    (end(-1.0), end(1.0))
}

/// Stretches of frequencies whose coherence is high.
fn bands(hz: &[f64], coherence: &[f64]) -> Vec<[f64; 2]> {
    let mut found: Vec<[f64; 2]> = Vec::new();
    let mut is_open = false;
    for (hz, coherence) in hz.iter().zip(coherence) {
        let belongs = *coherence > COHERENT;
        match (found.last_mut(), belongs && is_open) {
            (Some(last), true) => last[1] = short(*hz),
            _ if belongs => found.push([short(*hz); 2]),
            _ => {}
        }
        is_open = belongs;
    }
    found
}

/// The transfer function of a plain model.
fn transfer(ratio: Ratio, p: &Coefficients, hz: f64) -> Complex<f64> {
    let s = Complex::new(0.0, std::f64::consts::TAU * hz);
    let spring = s * p.beta + p.kappa;
    match ratio {
        Ratio::Road => spring / (s * s + spring),
        Ratio::Force => p.per_mass / (s * s + spring),
        Ratio::Rig => spring / p.per_mass,
    }
}

/// That of the plain fit, with what its covariance makes of it.
fn plain(ratio: Ratio, fit: &AxleFit, hz: &[f64]) -> ModelResponse {
    let at = |p: &Coefficients, hz: f64| transfer(ratio, p, hz);
    let margin = |hz: f64| {
        let by: [f64; 3] = std::array::from_fn(|q| slope(fit, q, |p| at(p, hz).norm()));
        let pairs = (0..3).flat_map(|a| (0..3).map(move |b| (a, b)));
        let variance: f64 = pairs
            .map(|(a, b)| by[a] * by[b] * fit.covariance[(a, b)])
            .sum();
        WIDE * variance.max(0.0).sqrt()
    };
    let known = |hz: &f64| at(&fit.plain, *hz).norm();
    ModelResponse {
        magnitude: shortened(hz.iter().map(known)),
        magnitude_low: shortened(hz.iter().map(|f| (known(f) - margin(*f)).max(0.0))),
        magnitude_high: shortened(hz.iter().map(|f| known(f) + margin(*f))),
        phase_rad: shortened(hz.iter().map(|f| at(&fit.plain, *f).arg())),
    }
}

/// How something changes with k/m, B/m or 1/m, by a central difference over a thousandth of its standard error.
fn slope(fit: &AxleFit, q: usize, of: impl Fn(&Coefficients) -> f64) -> f64 {
    let number = veloid_core::plant::Coefficient::ALL[q];
    let step = 1e-3 * fit.covariance[(q, q)].max(0.0).sqrt();
    if !(step > 0.0) {
        return 0.0;
    }
    let moved = |by: f64| {
        let mut p = fit.plain;
        p.set(number, p.get(number) + by);
        of(&p)
    };
    (moved(step) - moved(-step)) / (2.0 * step)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use veloid_core::numerics::example::white;
    use veloid_methods::simulate::linear::{Input, simulate};

    const PLAIN: Coefficients = Coefficients {
        kappa: 1500.0,
        beta: 20.0,
        per_mass: 0.04,
        constant: 0.0,
        height: 0.0,
        velocity: 0.0,
    };

    fn found(input: &Input, measured: &[f64], has_road: bool) -> FrequencyResponse {
        let record = Record {
            measured,
            valid: &vec![true; measured.len()],
            input,
            has_road,
            train: 0..measured.len(),
        };
        let mut fit = AxleFit::exact(PLAIN, measured.len());
        fit.covariance[(0, 0)] = 15.0_f64.powi(2);
        let models = Models {
            plain: &fit,
            extended: None,
        };
        response(&record, &models).unwrap()
    }

    /// Of a spline through samples, which is what the exact solution is driven by.
    #[test]
    fn val_measured_responses_are_the_transfer_functions() {
        let n = 24_000;
        let slow = |seed| {
            let mut x = white(n, seed);
            (0..3).for_each(|_| (1..n).for_each(|i| x[i] = 0.5 * (x[i] + x[i - 1])));
            x
        };
        let road = Input::new(&slow(1), None, 0.01);
        let push = Input::new(&vec![0.0; n], Some(&slow(2)), 0.01);
        for (input, has_road, ratio) in [(road, true, Ratio::Road), (push, false, Ratio::Force)] {
            let p = PLAIN;
            let (z, _) = simulate(&input, p.kappa, p.beta, p.per_mass, 0.0, [0.0; 2]);
            let found = found(&input, &z, has_road);
            for (i, hz) in found.frequency_hz.iter().enumerate() {
                let expected = transfer(ratio, &p, *hz) * lift(*hz * 0.01);
                if *hz > 20.0 {
                    continue;
                }
                let near = (found.magnitude[i] / expected.norm() - 1.0).abs();
                let turned = (found.phase_rad[i] - expected.arg()).abs();
                assert!(
                    near < 0.03 && turned < 0.03,
                    "{ratio:?} {hz} Hz: {near} {turned}"
                );
                assert!(found.coherence[i] > 0.98);
                let plain = transfer(ratio, &p, *hz);
                assert!((found.plain.magnitude[i] / plain.norm() - 1.0).abs() < 1e-4);
                assert!(found.plain.magnitude_high[i] >= found.plain.magnitude[i]);
            }
            assert!(found.distortion.is_none() && found.distortion_why.is_some());
        }
    }

    #[test]
    fn val_a_rig_shows_spring_and_damper() {
        let n = 8000;
        let d: Vec<f64> = (0..n)
            .map(|i| 1e-3 * (0.05 * i as f64 + 1e-5 * (i * i) as f64).sin())
            .collect();
        let input = Input {
            prescribed: true,
            ..Input::new(&d, None, 0.01)
        };
        let force: Vec<f64> = (0..n).map(|i| input.answer(1500.0, 20.0, 0.0, i)).collect();
        let record = Record {
            measured: &force,
            valid: &vec![true; n],
            input: &input,
            has_road: true,
            train: 0..n,
        };
        let fit = AxleFit::exact(
            Coefficients {
                per_mass: 1.0,
                ..PLAIN
            },
            n,
        );
        let models = Models {
            plain: &fit,
            extended: None,
        };
        let found = response(&record, &models).unwrap();
        assert_eq!((found.of.as_str(), found.unit.as_str()), ("F/d", "N/m"));
        let within = |hz: &f64| (1.0..2.5).contains(hz);
        assert!(found.frequency_hz.iter().any(&within));
        for (i, hz) in found
            .frequency_hz
            .iter()
            .enumerate()
            .filter(|(_, hz)| within(hz))
        {
            let expected = Complex::new(1500.0, 20.0 * std::f64::consts::TAU * hz).norm();
            assert!(
                (found.magnitude[i] / expected - 1.0).abs() < 0.03,
                "{hz} Hz"
            );
        }
    }

    #[test]
    fn noise_lowers_the_coherence_and_widens_the_interval() {
        let (input, noise) = (white(16_000, 1), white(16_000, 9));
        let output: Vec<f64> = (0..16_000).map(|i| input[i] + noise[i]).collect();
        let found = found(&Input::new(&input, None, 0.01), &output, true);
        let mean = found.coherence.iter().sum::<f64>() / found.coherence.len() as f64;
        assert!((mean - 0.5).abs() < 0.08, "{mean}");
        // Half of coherence: 1.96 sqrt(1/(2 n)).
        let n = found.averages;
        let margin = |i: usize| found.magnitude_high[i].unwrap() / found.magnitude[i] - 1.0;
        let some = (0..found.coherence.len()).filter(|i| (found.coherence[*i] - 0.5).abs() < 0.02);
        for i in some {
            assert!((margin(i) / (WIDE / (2.0 * n).sqrt()) - 1.0).abs() < 0.06);
        }
        let hz = [1.0, 2.0, 3.0, 4.0];
        let edge = [COHERENT + 1e-6, COHERENT + 1e-6, COHERENT - 1e-6, 0.9];
        assert_eq!(bands(&hz, &edge), [[1.0, 2.0], [4.0, 4.0]]);
    }
}
