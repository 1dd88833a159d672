//! The force between ground and mass over deflection and rate: measured, and of the models.

use std::f64::consts::TAU;

use veloid_core::numerics::filter::{Beyond, filter};
use veloid_core::plant::Coefficients;
use veloid_methods::output_error::AxleFit;
use veloid_report::Method;
use veloid_report::identifiable::fastest;
use veloid_report::validation::{ForceCurve, Restoring};

use crate::record::{Models, Record, short, shortened};

/// Times the axle's own frequency above which the measurement holds more noise than motion: a cubic spring's force at three times is
/// passed on to within 1 %.
const BAND: f64 = 6.0;
/// The same, of half the sampling rate, at most.
const MOST: f64 = 0.8;
/// Periods of the highest frequency by which the filter reaches: its answer to an impulse is then below 1e-4.
const REACH: f64 = 4.0;
/// Bins of a curve, over so much of the record (shares below and above), and samples that one has at least.
const BINS: usize = 25;
const TAILS: f64 = 0.005;
const LEAST: usize = 10;
/// Standard deviations of a 95 % interval.
const WIDE: f64 = 1.96;

/// Samples of deflection (m), rate (m/s) and force (N).
struct Samples {
    deflection: Vec<f64>,
    rate: Vec<f64>,
    force: Vec<f64>,
}

/// The curves of an axle.
pub fn restoring(record: &Record, models: &Models) -> Result<Restoring, String> {
    let plain = &models.plain.plain;
    let (less_by, base) = match &models.extended {
        Some(model) => (Method::Extended, &model.base),
        None => (Method::OutputError, plain),
    };
    let below_hz = (!record.input.prescribed).then(|| cut(base, record.step()));
    let usable = usable(record, below_hz);
    let measured = match below_hz {
        Some(hz) => filtered(record, base, hz),
        None => answered(record, base),
    };
    let own = models.extended.as_ref().map(|model| Samples {
        deflection: model.deflection.clone(),
        rate: model.rate.clone(),
        force: (0..record.measured.len())
            .map(|i| force(record, &model.base, model.acceleration[i], i))
            .collect(),
    });
    let (k, b) = (base.kappa / base.per_mass, base.beta / base.per_mass);
    let [k_std, b_std] = errors(models.plain);
    let spring = |s: &Samples, i: usize| (s.deflection[i], s.force[i] - b * s.rate[i]);
    let damper = |s: &Samples, i: usize| (s.rate[i], s.force[i] - k * s.deflection[i]);
    let curve = |of: &dyn Fn(&Samples, usize) -> (f64, f64), slope: f64, std: f64| {
        let pairs = |s: &Samples| -> Vec<(f64, f64)> {
            let known = usable.iter().enumerate().filter(|(_, usable)| **usable);
            known.map(|(i, _)| of(s, i)).collect()
        };
        binned(&pairs(&measured), own.as_ref().map(pairs), slope, std)
    };
    let over_deflection = curve(&spring, plain.kappa / plain.per_mass, k_std);
    let over_rate = curve(&damper, plain.beta / plain.per_mass, b_std);
    if over_deflection.at.is_empty() || over_rate.at.is_empty() {
        return Err(format!(
            "restoring force: no bin of deflection or rate has {LEAST} samples away from gaps and ends"
        ));
    }
    Ok(Restoring {
        less_by,
        below_hz: below_hz.map(short),
        over_deflection,
        over_rate,
    })
}

/// Force (N) between ground and mass where that moves with an acceleration (m/s^2).
fn force(record: &Record, base: &Coefficients, acceleration: f64, i: usize) -> f64 {
    let push = record.input.force.as_ref().map_or(0.0, |(f, _)| f[i]);
    (acceleration - base.constant) / base.per_mass - push
}

/// Highest frequency (Hz) of the measurement that is used.
fn cut(base: &Coefficients, step: f64) -> f64 {
    let own = fastest(base.kappa, base.beta) / TAU;
    (BAND * own).min(MOST * 0.5 / step)
}

/// What was measured below a frequency, the acceleration by differentiating the displacement twice without phase.
fn filtered(record: &Record, base: &Coefficients, below_hz: f64) -> Samples {
    let rate_hz = 1.0 / record.step();
    let low = |hz: f64| 1.0 / (1.0 + (hz / below_hz).powi(8));
    let through = |x: &[f64], gain: &dyn Fn(f64) -> f64| {
        filter(x, rate_hz, REACH / below_hz, Beyond::Points, gain)
    };
    let pass = |x: &[f64]| through(x, &low);
    let input = record.input;
    let z = pass(record.measured);
    let acceleration = through(record.measured, &|hz| -(TAU * hz).powi(2) * low(hz));
    let v = veloid_core::numerics::spline::slopes(&z, record.step());
    let minus = |a: Vec<f64>, b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect();
    let push = input.force.as_ref().map(|(f, _)| pass(f));
    let mass = 1.0 / base.per_mass;
    let force = |(i, a): (usize, &f64)| {
        mass * (a - base.constant) - push.as_ref().map_or(0.0, |push| push[i])
    };
    Samples {
        deflection: minus(pass(&input.road), &z),
        rate: minus(pass(&input.road_slope), &v),
        force: acceleration.iter().enumerate().map(force).collect(),
    }
}

/// The force that a rig measured.
fn answered(record: &Record, base: &Coefficients) -> Samples {
    Samples {
        deflection: record.input.road.clone(),
        rate: record.input.road_slope.clone(),
        force: (record.measured.iter())
            .map(|f| f - base.constant / base.per_mass)
            .collect(),
    }
}

/// Samples that no gap and no end reaches through the filter.
fn usable(record: &Record, below_hz: Option<f64>) -> Vec<bool> {
    let n = record.valid.len();
    let reach = below_hz.map_or(0, |hz| (REACH / hz / record.step()).ceil() as usize);
    let reach = reach.min(n);
    let mut bad_until = reach;
    let mut usable = vec![false; n];
    for i in 0..n {
        if !record.valid[i] {
            bad_until = i + reach + 1;
            let from = i.saturating_sub(reach);
            usable[from..=i]
                .iter_mut()
                .for_each(|usable| *usable = false);
        } else if i >= bad_until && i + reach < n {
            usable[i] = true;
        }
    }
    usable
}

/// Standard errors of k (N/m) and B (N s/m) of the plain fit.
fn errors(fit: &AxleFit) -> [f64; 2] {
    let e = fit.estimate(true);
    [e.k_std_n_m, e.b_std_n_s_m].map(|std| std.unwrap_or(0.0))
}

/// Mean forces in bins of equal width, those of a model in the same bins of its own motion.
fn binned(
    measured: &[(f64, f64)],
    extended: Option<Vec<(f64, f64)>>,
    slope: f64,
    std: f64,
) -> ForceCurve {
    let mut sorted: Vec<f64> = measured.iter().map(|(x, _)| *x).collect();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else {
        return ForceCurve::default();
    };
    let quantile = |share: f64| sorted[(share * last as f64).round() as usize];
    let (low, high) = (quantile(TAILS), quantile(1.0 - TAILS));
    let width = (high - low) / BINS as f64;
    let of = |pairs: &[(f64, f64)]| -> Vec<Bin> {
        let mut bins = vec![Bin::default(); BINS];
        for (x, force) in pairs {
            let at = ((x - low) / width).floor();
            if at >= 0.0 && at < BINS as f64 {
                bins[at as usize].add(*x, *force);
            }
        }
        bins
    };
    let bins = of(measured);
    let kept: Vec<usize> = (0..BINS).filter(|i| bins[*i].count >= LEAST).collect();
    let each = |of: &dyn Fn(&Bin) -> f64| shortened(kept.iter().map(|i| of(&bins[*i])));
    ForceCurve {
        at: each(&|bin| bin.at()),
        measured_n: each(&|bin| bin.force()),
        std_error_n: each(&|bin| bin.std_error()),
        samples: kept.iter().map(|i| bins[*i].count).collect(),
        plain_n: each(&|bin| slope * bin.at()),
        plain_margin_n: each(&|bin| WIDE * std * bin.at().abs()),
        extended_n: match extended.map(|pairs| of(&pairs)) {
            None => Vec::new(),
            Some(own) => (kept.iter())
                .map(|i| (own[*i].count >= LEAST).then(|| short(own[*i].force())))
                .collect(),
        },
    }
}

/// Sums of a bin.
#[derive(Clone, Copy, Default)]
struct Bin {
    count: usize,
    at: f64,
    force: f64,
    squares: f64,
}

impl Bin {
    fn add(&mut self, at: f64, force: f64) {
        self.count += 1;
        self.at += at;
        self.force += force;
        self.squares += force * force;
    }

    fn at(&self) -> f64 {
        self.at / self.count as f64
    }

    fn force(&self) -> f64 {
        self.force / self.count as f64
    }

    fn std_error(&self) -> f64 {
        let n = self.count as f64;
        let variance = (self.squares - n * self.force().powi(2)) / (n - 1.0);
        (variance.max(0.0) / n).sqrt()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use veloid_core::numerics::example::white;
    use veloid_methods::simulate::linear::Input;

    /// k (N/m), k3 (N/m^3), B (N s/m) and m (kg).
    const K: f64 = 60e3;
    const CUBIC: f64 = 4e9;
    const B: f64 = 500.0;
    const M: f64 = 25.0;

    /// Displacement of a mass on a cubic spring over a rough road, by Runge-Kutta at a tenth of the step, with noise.
    fn ridden(road: &Input, noise: f64) -> Vec<f64> {
        let (n, fine) = (road.len(), 10);
        let h = road.step / fine as f64;
        let rates = |i: usize, s: f64, z: f64, v: f64| {
            let c = veloid_core::numerics::spline::cubic(
                road.road[i],
                road.road[i + 1],
                road.road_slope[i],
                road.road_slope[i + 1],
                road.step,
            );
            let u = c[0] + s * (c[1] + s * (c[2] + s * c[3]));
            let slope = (c[1] + s * (2.0 * c[2] + s * 3.0 * c[3])) / road.step;
            let d = u - z;
            (v, (K * d + CUBIC * d.powi(3) + B * (slope - v)) / M)
        };
        let (mut z, mut v) = (0.0, 0.0);
        let mut out = vec![0.0];
        for i in 0..n - 1 {
            for sub in 0..fine {
                let s = sub as f64 / fine as f64;
                let half = 0.5 / fine as f64;
                let a = rates(i, s, z, v);
                let b = rates(i, s + half, z + 0.5 * h * a.0, v + 0.5 * h * a.1);
                let c = rates(i, s + half, z + 0.5 * h * b.0, v + 0.5 * h * b.1);
                let d = rates(i, s + 2.0 * half, z + h * c.0, v + h * c.1);
                z += h / 6.0 * (a.0 + 2.0 * b.0 + 2.0 * c.0 + d.0);
                v += h / 6.0 * (a.1 + 2.0 * b.1 + 2.0 * c.1 + d.1);
            }
            out.push(z);
        }
        let noises = white(n, 3);
        out.iter()
            .zip(&noises)
            .map(|(z, x)| z + noise * x)
            .collect()
    }

    #[test]
    fn val_a_cubic_springs_force_is_a_cubic() {
        let n = 6000;
        let mut u = white(n, 1);
        (0..6).for_each(|_| (1..n).for_each(|i| u[i] = 0.7 * u[i - 1] + 0.3 * u[i]));
        let u: Vec<f64> = u.iter().map(|u| 0.02 * u).collect();
        let input = Input::new(&u, None, 0.005);
        let z = ridden(&input, 2e-5);
        let record = Record {
            measured: &z,
            valid: &vec![true; n],
            input: &input,
            has_road: true,
            train: 0..n,
        };
        let base = Coefficients {
            kappa: K / M,
            beta: B / M,
            per_mass: 1.0 / M,
            ..Coefficients::default()
        };
        let models = Models {
            plain: &AxleFit::exact(base, n),
            extended: None,
        };
        let found = restoring(&record, &models).unwrap();
        let curve = &found.over_deflection;
        assert!(curve.at.len() > 15 && curve.at.len() <= BINS);
        let most = curve.at.iter().fold(0.0, |most: f64, d| most.max(d.abs()));
        // The cubic part is worth seeing.
        assert!(CUBIC * most.powi(2) > 0.3 * K, "{most}");
        for (i, d) in curve.at.iter().enumerate() {
            let expected = K * d + CUBIC * d.powi(3);
            let off = (curve.measured_n[i] - expected).abs();
            assert!(
                off < 0.02 * K * most + 4.0 * curve.std_error_n[i],
                "{d}: {off} N"
            );
            assert!((curve.plain_n[i] - K * d).abs() < 1e-3 * K * most);
        }
        // Over the rate the cubic part is scatter that averages out, and B is the slope.
        let damping = &found.over_rate;
        let pairs = || damping.at.iter().zip(&damping.measured_n);
        let slope =
            pairs().map(|(w, f)| w * f).sum::<f64>() / pairs().map(|(w, _)| w * w).sum::<f64>();
        assert!((slope / B - 1.0).abs() < 0.1, "{slope}");
    }

    #[test]
    fn gaps_and_ends_reach_through_the_filter() {
        let input = Input::new(&[0.0; 100], None, 0.01);
        let mut valid = [true; 100];
        valid[50] = false;
        let record = Record {
            measured: &[0.0; 100],
            valid: &valid,
            input: &input,
            has_road: false,
            train: 0..100,
        };
        // Five samples to each side.
        let usable = usable(&record, Some(REACH / 0.05));
        let bad = |range: std::ops::Range<usize>| range.into_iter().all(|i| !usable[i]);
        let good = |range: std::ops::Range<usize>| range.into_iter().all(|i| usable[i]);
        assert!(bad(0..5) && good(5..45) && bad(45..56) && good(56..95) && bad(95..100));
    }
}
