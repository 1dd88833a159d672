//! What a record cannot resolve. Between its samples the road is taken for a cubic spline; what it was
//! instead moves the axle too, and leaves a residual that is no noise. Sensors drown it. A record that is
//! quieter, as simulations are, would have physics sought in it, so white noise is laid over it for the
//! search (dither), and taken off the figures again.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use veloid_core::bicycle::{Bike, PerAxle};
use veloid_core::numerics::random::normal;
use veloid_core::numerics::spectrum::{Spectrum, deviation, white_floor};
use veloid_core::numerics::spline::{lift, response};
use veloid_core::numerics::statistics::variance;
use veloid_core::plant::Coefficients;
use veloid_methods::output_error::AxleFit;
use veloid_methods::simulate::linear::{Input, force_answer, road_answer, simulate};
use veloid_ride::{AxleRecord, Ride};

/// Gain in log likelihood that a model of all that lies between the samples may have under a record's own
/// noise, and that it has under ours.
const BORNE: f64 = 10.0;
const HIDDEN: f64 = 0.25;
/// Most noise that is laid over a record, as a share of the deflection's standard deviation, unless what lies between the samples asks for more.
const MOST: f64 = 0.03;
/// The same in any case: what is left of a mass that drifts, since no spring holds it, would be drowned by noise that hides a drift.
const MOST_EVER: f64 = 0.3;
/// Noise that is laid over a record whose channels hold only a band, as a share of what the plain model leaves: beyond a band that takes
/// an eighth to a quarter of the rate its density is then a tenth of that within it. What an effect makes there, and the record cannot
/// show, would be held against the effect by any less.
const BANDED: f64 = 0.6;
/// Errors of a cubic spline fall with the fourth power of the step, where it follows the road at all.
const FOURTH: f64 = 1.0 / 16.0;
/// Images of a spectrum, to either side of the multiples of the sampling rate, that a spline leaves: those beyond fall with the fourth
/// power of their order.
const IMAGES: usize = 3;

/// Share of the motion (RMS) that no sensor shows (20 bits), and no integrator needs to.
const FINEST: f64 = 1e-6;

/// What lies between the samples of each axle.
#[derive(Default)]
pub struct Between {
    /// Noise (m) to lay over each sample of the displacement, on the axles that need it.
    pub noise: PerAxle<Vec<f64>>,
    /// Gain in log likelihood that a model of all of it would have on the fitted part, under the noise that there is then.
    pub unresolved: PerAxle<f64>,
    /// The same of splines through lifted samples, which are what models have.
    pub beyond_lifting: PerAxle<f64>,
}

/// What one axle's record lacks: noise (m, RMS) to hide what lies between its samples from a fit, and gains in log likelihood as in
/// [`Between`].
#[derive(Debug, Default, PartialEq)]
struct Lacking {
    noise: f64,
    unresolved: f64,
    beyond_lifting: f64,
}

/// Finds what lies between the samples, and the noise that hides it from a fit.
pub fn between(
    ride: &Ride,
    bike: &Bike,
    fits: &PerAxle<AxleFit>,
    fitted: usize,
    seed: u64,
) -> Between {
    let mut found = Between::default();
    for (axle, record) in ride.axles.iter() {
        let Some(fit) = fits.get(axle) else { continue };
        let Lacking {
            noise,
            unresolved,
            beyond_lifting,
        } = lacking(record, fit, bike, ride.step_s, fitted);
        found.unresolved.set(axle, unresolved);
        found.beyond_lifting.set(axle, beyond_lifting);
        if noise > 0.0 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(u64::MAX - axle as u64);
            let draws = (0..ride.samples).map(|_| noise * normal(&mut rng));
            found.noise.set(axle, draws.collect());
        }
    }
    found
}

/// The ride with the noise on it; nothing where there is none.
pub fn lay_over(ride: &Ride, dither: &PerAxle<Vec<f64>>) -> Option<Ride> {
    let mut noisy = None;
    for (axle, noise) in dither.iter() {
        let noisy = noisy.get_or_insert_with(|| ride.clone());
        if let Some(record) = noisy.axles.get_mut(axle) {
            (record.output_mut().iter_mut().zip(noise)).for_each(|(z, n)| *z += n);
        }
    }
    noisy
}

fn lacking(record: &AxleRecord, fit: &AxleFit, bike: &Bike, step: f64, fitted: usize) -> Lacking {
    if record.band.is_some() {
        return Lacking {
            noise: BANDED * fit.train_rms,
            ..Lacking::default()
        };
    }
    let once = moved(record, &fit.plain, step, 1);
    let halves = by_halves(&once, record, &fit.plain, step);
    let (between, lifted) = match record.prescribed {
        true => (halves, halves),
        false => {
            let by = |lift: &dyn Fn(f64) -> f64| by_spectrum(record, &fit.plain, step, lift);
            (by(&|_| 1.0).max(halves), by(&lift))
        }
    };
    // From where nothing is known of its start, the motion may come from anywhere.
    let known = |x: &[f64]| -> Vec<f64> {
        let each = x.iter().zip(&record.valid).filter(|(_, valid)| **valid);
        each.map(|(x, _)| *x).collect()
    };
    let between = between.max(FINEST * rms(&known(&once)));
    if between == 0.0 {
        return Lacking::default();
    }
    let own = (bike.noise_displacement_m.filter(|_| !record.prescribed))
        .unwrap_or_else(|| deviation(white_floor(record.output(), step), step));
    let own = own.min(fit.train_rms);
    let noise = |gain: f64| between * (fitted as f64 / (2.0 * gain)).sqrt();
    let lacking = |added: f64, noise: f64| {
        let under = |missed: f64| 0.5 * fitted as f64 * (missed / noise).powi(2);
        Lacking {
            noise: added,
            unresolved: under(between),
            beyond_lifting: under(lifted.min(between)),
        }
    };
    if own >= noise(BORNE) {
        return lacking(0.0, own);
    }
    let deflection: Vec<f64> = record.road.iter().zip(&once).map(|(u, z)| u - z).collect();
    // Without a mass the road is none, and this the force that answers to the deflection.
    let moves = variance(&known(&deflection)).sqrt();
    let least = noise(BORNE).min(MOST_EVER * moves);
    let wanted = noise(HIDDEN).min((MOST * moves).max(least));
    let added = (wanted * wanted - own * own).max(0.0).sqrt();
    lacking(added, wanted.max(own))
}

/// RMS of what is between the samples (m, or N), by Richardson's extrapolation from every second and fourth of them.
fn by_halves(once: &[f64], record: &AxleRecord, plain: &Coefficients, step: f64) -> f64 {
    let [twice, four] = [2, 4].map(|every| moved(record, plain, step, every));
    let valid = |every: usize| record.valid.iter().step_by(every);
    let near = distance(once, &twice, valid(2));
    let far = distance(&twice, &four, valid(4));
    near * (near / far).min(FOURTH)
}

/// RMS (m) of how the plain axle answers to the error of the splines that stand for what drives it, through samples in which a sine
/// (turns a sample) is so many times as large as in the record.
fn by_spectrum(
    record: &AxleRecord,
    plain: &Coefficients,
    step: f64,
    lift: &dyn Fn(f64) -> f64,
) -> f64 {
    let Coefficients {
        kappa,
        beta,
        per_mass,
        ..
    } = *plain;
    let road = |hz| road_answer(kappa, beta, hz);
    let push = |hz| per_mass * per_mass * force_answer(kappa, beta, hz);
    let of_road = Spectrum::new(&record.road, step).map_or(0.0, |spectrum| {
        spline_error(&spectrum, step, &road, lift) + folded(&spectrum, step, &road)
    });
    let of_force = record
        .force
        .as_ref()
        .and_then(|force| Spectrum::new(force, step))
        .map(|spectrum| spline_error(&spectrum, step, &push, lift));
    (of_road + of_force.unwrap_or_default()).sqrt()
}

/// Power of the error of a cubic spline through samples behind a filter of that power gain: what the spline damps, and the images
/// that it leaves (Unser 1999, doi:10.1109/79.799930), where a sine (turns a sample) in the samples is `lift` times as large.
fn spline_error(
    spectrum: &Spectrum,
    step: f64,
    gain: &dyn Fn(f64) -> f64,
    lift: &dyn Fn(f64) -> f64,
) -> f64 {
    let rate = step.recip();
    let floor = spectrum.white_floor();
    let error = |hz: f64| {
        let images = (1..=IMAGES).flat_map(|k| [k as f64 * rate - hz, k as f64 * rate + hz]);
        let images: f64 = images.map(|f| response(f * step).powi(2) * gain(f)).sum();
        let lift = lift(hz * step);
        (1.0 - lift * response(hz * step)).powi(2) * gain(hz) + lift * lift * images
    };
    // A mass without a spring answers to what is constant without bound.
    let bins = spectrum.hz.iter().zip(&spectrum.density).skip(1);
    let power: f64 = bins
        .map(|(hz, density)| (density - floor).max(0.0) * error(*hz))
        .sum();
    let width = spectrum.hz.get(1).copied().unwrap_or_default();
    power * width
}

/// Power behind the same filter of what is faster than half the rate in a road and shows below it, at the distance from the next multiple
/// of the rate: it moves the axle with its own frequency, and the model with the one that was recorded.
fn folded(spectrum: &Spectrum, step: f64, gain: &dyn Fn(f64) -> f64) -> f64 {
    let (tail, rate) = (spectrum.tail(), step.recip());
    if tail == 0.0 {
        return 0.0;
    }
    const PARTS: usize = 200;
    let width = rate / PARTS as f64;
    let each = (0..PARTS).map(|i| 0.5 * rate + (i as f64 + 0.5) * width);
    let moved = |hz: f64| {
        let shown = (hz - rate * (hz / rate).round()).abs();
        tail / (hz * hz) * (gain(hz) + gain(shown))
    };
    each.map(moved).sum::<f64>() * width
}

/// Displacement (m) of the plain axle, or the force (N) that answers, if one sample in `every` had been recorded of what
/// drives it.
fn moved(record: &AxleRecord, plain: &Coefficients, step: f64, every: usize) -> Vec<f64> {
    let thin = |x: &Vec<f64>| -> Vec<f64> { x.iter().copied().step_by(every).collect() };
    let whole = Input::of(record, step);
    let force = whole.force.as_ref().map(|(force, _)| thin(force));
    let input = whole.driven_by(&thin(&whole.road), force.as_deref(), step * every as f64);
    let Coefficients {
        kappa,
        beta,
        per_mass,
        constant,
        ..
    } = *plain;
    simulate(&input, kappa, beta, per_mass, constant, plain.start()).0
}

/// RMS of the difference of two motions, the second with half the samples, where these are valid.
fn distance<'a>(fine: &[f64], coarse: &[f64], valid: impl Iterator<Item = &'a bool>) -> f64 {
    let pairs = fine.iter().step_by(2).zip(coarse).zip(valid);
    let pairs = pairs.filter(|(_, valid)| **valid);
    rms(&pairs.map(|((a, b), _)| a - b).collect::<Vec<_>>())
}

fn rms(x: &[f64]) -> f64 {
    (x.iter().map(|x| x * x).sum::<f64>() / x.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use veloid_core::numerics::spline::{cubic, lifted, slopes};

    /// A wave between the samples, beside the spline through them as `made` of these.
    fn missed(turns: f64, made: fn(&[f64]) -> Vec<f64>) -> f64 {
        const PARTS: usize = 16;
        let wave = |at: f64| (std::f64::consts::TAU * turns * at).sin();
        let samples: Vec<f64> = (0..4000).map(|i| wave(i as f64)).collect();
        let samples = made(&samples);
        let slope = slopes(&samples, 1.0);
        let inside = 100..samples.len() - 100;
        let errors = inside.flat_map(|i| {
            let u = cubic(samples[i], samples[i + 1], slope[i], slope[i + 1], 1.0);
            (0..PARTS).map(move |part| {
                let s = part as f64 / PARTS as f64;
                wave(i as f64 + s) - (u[0] + s * (u[1] + s * (u[2] + s * u[3])))
            })
        });
        rms(&errors.collect::<Vec<_>>())
    }

    /// A road whose slope is white, recorded at one sample in eight.
    #[test]
    fn what_is_faster_than_half_the_rate_is_counted_where_the_record_shows_its_tail() {
        let slope = veloid_core::numerics::example::white(160_000, 7);
        let road: Vec<f64> = (slope.iter())
            .scan(0.0, |u, s| {
                *u = 0.999 * *u + s;
                Some(*u)
            })
            .collect();
        let recorded: Vec<f64> = road.iter().copied().step_by(8).collect();
        let fast = Spectrum::new(&road, 0.125).expect("long enough");
        let width = fast.hz[1];
        let beyond = fast.hz.iter().zip(&fast.density);
        let beyond = beyond.filter(|(hz, _)| (0.5..1.5).contains(*hz));
        let expected = 2.0 * width * beyond.map(|(_, density)| density).sum::<f64>();
        let spectrum = Spectrum::new(&recorded, 1.0).expect("long enough");
        let found = folded(&spectrum, 1.0, &|_| 1.0);
        assert!(
            (0.6..1.4).contains(&(found / expected)),
            "{found} for {expected}"
        );
        let noise = veloid_core::numerics::example::white(20_000, 8);
        let noise = Spectrum::new(&noise, 1.0).expect("long enough");
        assert!(folded(&noise, 1.0, &|_| 1.0) < 0.05);
    }

    #[test]
    fn val_the_error_between_samples_is_the_splines() {
        for turns in [0.1, 0.2, 0.3, 0.4] {
            let wave = |i: usize| (std::f64::consts::TAU * turns * i as f64).sin();
            let samples: Vec<f64> = (0..4000).map(wave).collect();
            let spectrum = Spectrum::new(&samples, 1.0).expect("long enough");
            let each: [(f64, &dyn Fn(f64) -> f64); 2] = [
                (missed(turns, <[f64]>::to_vec), &|_| 1.0),
                (missed(turns, lifted), &lift),
            ];
            for (expected, lift) in each {
                let found = spline_error(&spectrum, 1.0, &|_| 1.0, lift).sqrt();
                assert!(
                    (found / expected - 1.0).abs() < 0.03,
                    "{turns}: {found} for {expected}"
                );
            }
        }
    }

    /// Without motion and noise there is nothing between the samples, and no division by it.
    #[test]
    fn a_record_at_rest_hides_nothing() {
        let ride = veloid_methods::simulate::simulated_ride::SimulatedRide::default().ride();
        let mut record = ride.axles.front.expect("both");
        for x in [&mut record.road, &mut record.displacement] {
            x.fill(0.0);
        }
        let plain = Coefficients {
            kappa: 2400.0,
            beta: 20.0,
            per_mass: 0.04,
            ..Coefficients::default()
        };
        let fit = AxleFit::exact(plain, ride.samples);
        let found = lacking(&record, &fit, &Bike::default(), ride.step_s, ride.samples);
        assert_eq!(found, Lacking::default());
    }
}
