//! One axle of a ride as the extended model sees it: its inputs with their slopes, its measurement, and the sizes from
//! which effects take their starts and limits.

use rand_chacha::ChaCha8Rng;

use crate::law::Scale;
use veloid_core::bicycle::{Axle, Bike};
use veloid_core::numerics::random::normal;
use veloid_core::numerics::spectrum::{Spectrum, measured_noise, white_floor};
use veloid_core::numerics::spline::{cubic, slopes};
use veloid_core::numerics::statistics::variance;
use veloid_core::plant::{Coefficient, Coefficients, Known, Plant, Sizes};
use veloid_methods::output_error::{self, AxleFit};
use veloid_methods::simulate::linear::{Input, road_answer};
use veloid_report::diagnosis::Predicted;
use veloid_ride::{AxleRecord, Band, Ride};

/// One axle's inputs and measurement.
#[derive(Clone, Debug)]
pub struct Track {
    pub axle: Axle,
    pub input: Input,
    /// What road and displacement contain, where they were computed from other sensors.
    pub band: Option<Band>,
    /// Integral of the road's spline up to each sample (m s).
    road_integral: Vec<f64>,
    /// What models predict: the displacement (m), or the force (N) that answers where the motion is prescribed.
    pub measured: Vec<f64>,
    pub valid: Vec<bool>,
    pub scale: Scale,
    pub has_road: bool,
    /// Density of white noise in the road channel and the displacement (m^2/Hz, one-sided), at most.
    pub road_floor: f64,
    pub sensor_floor: f64,
    /// Noise (m, RMS) that the bike file says the displacement sensor has.
    pub declared_noise: Option<f64>,
    /// The same of the road channel whatever its sensor is said to have: a jittering clock adds to it.
    pub road_most: f64,
    /// The same of the force channel (N^2/Hz).
    pub force_most: f64,
    /// Gain in log likelihood that what lies between the samples may bring to a model.
    pub unresolved: f64,
    /// The same of what the lifted samples of the inputs leave.
    pub beyond_lifting: f64,
    /// Deviations of height (m) and velocity (m/s) at the first sample from its measured height and none, where the
    /// record shows that it starts at rest.
    pub at_rest: Option<[f64; 2]>,
    /// Whether the mass is estimated, and whether the rest point is.
    pub free_mass: bool,
    pub rest_point: bool,
    /// Ends of k/m (1/s^2) and B/m (1/s), where the user has set them.
    limits: [Option<[f64; 2]>; 2],
    /// What the axle is where nothing is left out.
    pub plant: &'static dyn Plant,
}

/// What the tracks of a ride have in common.
pub struct Recorded<'a> {
    pub ride: &'a Ride,
    pub bike: &'a Bike,
    /// Samples that models are fitted to.
    pub train_end: usize,
    /// Speed (m/s), and its standard deviation.
    pub mean_speed: f64,
    pub speed_span: f64,
    /// Distance (m) of the samples that models are fitted to.
    pub train_distance: f64,
}

impl Track {
    pub fn new(recorded: &Recorded, axle: Axle, record: &AxleRecord, fit: &AxleFit) -> Self {
        let Recorded {
            ride,
            bike,
            train_end,
            ..
        } = *recorded;
        let input = Input::of(record, ride.step_s);
        let scale = scale(recorded, axle, &PlainMotion::new(record, &input, fit), fit);
        let mass = scale.mass;
        let road_integral = spline_integral(&input);
        let at_rest = record.at_rest(ride.step_s);
        let most = |x: &[f64]| white_floor(x, ride.step_s);
        // What a laser puts into a road that was made from it has no part where that road holds nothing.
        let by_laser = laser_noise(ride, axle);
        let road_most = most(&record.road).max(by_laser);
        let density = |noise: f64| 2.0 * noise * noise * ride.step_s;
        let declared = bike.noise_displacement_m.filter(|_| !record.prescribed);
        Self {
            axle,
            road_floor: bike.noise_road_m.map_or(road_most, density),
            road_most,
            force_most: input.force.as_ref().map_or(0.0, |(force, _)| most(force)),
            sensor_floor: declared.map_or_else(|| most(record.output()), density),
            declared_noise: declared,
            input,
            band: record.band,
            road_integral,
            measured: record.output().to_vec(),
            valid: fitted_to(record, at_rest.is_some(), ride.step_s, train_end),
            scale,
            has_road: record.has_road(),
            at_rest,
            unresolved: 0.0,
            beyond_lifting: 0.0,
            free_mass: bike.mass(axle).is_none() && !record.prescribed,
            rest_point: record.force.is_some() || !record.has_road(),
            limits: bike
                .limits(axle)
                .map(|ends| ends.map(|ends| ends.map(|x| x / mass))),
            plant: record.base_model(),
        }
    }

    /// Where the mass is (m) when models predict this: it rests where the motion is prescribed.
    pub fn height(&self, predicted: Vec<f64>) -> Vec<f64> {
        match self.input.prescribed {
            true => vec![0.0; predicted.len()],
            false => predicted,
        }
    }

    /// Whether a fit may move a number of the base model.
    pub fn is_free(&self, number: Coefficient) -> bool {
        let known = Known {
            mass: !self.free_mass,
            rest: !self.rest_point,
        };
        let is_fixed = self.limit(number).is_some_and(|[low, high]| low == high);
        !is_fixed && self.plant.is_free(number, known)
    }

    fn limit(&self, number: Coefficient) -> Option<[f64; 2]> {
        match number {
            Coefficient::Kappa => self.limits[0],
            Coefficient::Beta => self.limits[1],
            _ => None,
        }
    }

    /// The nearest numbers of the base model within the user's limits.
    pub fn within(&self, base: Coefficients) -> Coefficients {
        Coefficients::from_fn(|number| match self.limit(number) {
            Some([low, high]) => base.get(number).clamp(low, high),
            None => base.get(number),
        })
    }

    /// The base model by the plain fit, at rest at the height 0.
    pub fn plain(&self) -> Coefficients {
        let s = &self.scale;
        Coefficients {
            kappa: s.k / s.mass,
            beta: s.b / s.mass,
            per_mass: 1.0 / s.mass,
            ..Coefficients::default()
        }
    }

    /// A typical size of a number of the base model, and its limits.
    pub fn range(&self, number: Coefficient) -> (f64, [f64; 2]) {
        let s = &self.scale;
        let sizes = Sizes {
            stiffness: s.k_size(),
            damping: s.b_size(),
            mass: s.mass,
            acceleration: s.a_rms,
            height: s.z_rms,
            velocity: s.v_rms,
            slack: 25.0 / (s.train_s * s.train_s),
            most: output_error::most(self.input.step),
        };
        let (size, range) = self.plant.range(number, &sizes);
        (size, self.limit(number).unwrap_or(range))
    }

    /// What models predict on this track.
    pub fn predicted(&self) -> Predicted {
        match self.input.prescribed {
            true => Predicted::Force,
            false => Predicted::Displacement,
        }
    }

    /// Whether a spring holds the mass.
    pub fn swings(&self) -> bool {
        let is_spring = self.scale.k > self.scale.as_good_as_none()[0];
        self.plant.has_spring() && self.plant.moves() && is_spring
    }

    /// Whether a road, a force or a rig moves the axle.
    pub fn is_driven(&self) -> bool {
        self.has_road || self.input.force.is_some() || self.input.prescribed
    }

    /// Noise (m, RMS) of the displacement sensor, declared or measured; nothing where neither is so.
    pub fn sensor_noise(&self) -> Option<f64> {
        self.declared_noise
            .or_else(|| measured_noise(&self.measured, self.input.step))
    }

    /// Standard deviation of what is measured.
    pub fn spread(&self) -> f64 {
        variance(&self.measured).sqrt()
    }

    /// Puts another record of the road under the axle.
    pub fn set_road(&mut self, road: &[f64]) {
        let force = self.input.force.as_ref().map(|(f, _)| f.clone());
        self.set_inputs(road, force.as_deref());
    }

    /// Drives the axle by another road and another force.
    pub fn set_inputs(&mut self, road: &[f64], force: Option<&[f64]>) {
        self.input = self.input.driven_by(road, force, self.input.step);
        self.road_integral = spline_integral(&self.input);
    }

    /// Adds white noise (m, RMS) to the recorded road, within what that contains.
    pub fn add_road_noise(&mut self, noise: f64, rng: &mut ChaCha8Rng) {
        let draws = self.input.road.iter().map(|_| noise * normal(rng));
        let mut draws: Vec<f64> = draws.collect();
        if let Some(band) = self.band {
            draws = band.keep(&draws, self.input.step.recip());
        }
        let road: Vec<f64> = (self.input.road.iter().zip(&draws))
            .map(|(u, n)| u + n)
            .collect();
        self.set_road(&road);
    }

    /// Variance (m^2) that noise of the displacement sensor and of the road channel has at the
    /// displacement of an axle with these numbers.
    pub fn noise_variance(&self, numbers: &Coefficients) -> f64 {
        const BANDS: usize = 256;
        let width = 0.5 / self.input.step / BANDS as f64;
        let answer = |band: usize| {
            let hz = width * (band as f64 + 0.5);
            match self.band.is_none_or(|contained| contained.contains(hz)) {
                true => road_answer(numbers.kappa, numbers.beta, hz),
                false => 0.0,
            }
        };
        let road = (0..BANDS).map(answer).sum::<f64>() * width;
        0.5 * self.sensor_floor / self.input.step + self.road_floor * road
    }

    /// Road height and rate at `position` (samples, fractional), the spline held at its ends.
    fn road_at(&self, position: f64) -> (f64, f64) {
        let (i, s) = self.locate(position);
        let u = self.piece(i);
        let value = u[0] + s * (u[1] + s * (u[2] + s * u[3]));
        let slope = (u[1] + s * (2.0 * u[2] + s * 3.0 * u[3])) / self.input.step;
        (value, slope)
    }

    fn integral_at(&self, position: f64) -> f64 {
        let (i, s) = self.locate(position);
        let u = self.piece(i);
        let part = s * (u[0] + s * (u[1] / 2.0 + s * (u[2] / 3.0 + s * u[3] / 4.0)));
        self.road_integral[i] + part * self.input.step
    }

    fn locate(&self, position: f64) -> (usize, f64) {
        let last = self.input.len() - 1;
        let p = position.clamp(0.0, last as f64);
        let i = (p as usize).min(last - 1);
        (i, p - i as f64)
    }

    fn piece(&self, i: usize) -> [f64; 4] {
        let x = &self.input;
        cubic(
            x.road[i],
            x.road[i + 1],
            x.road_slope[i],
            x.road_slope[i + 1],
            x.step,
        )
    }

    /// Height (m) and rate (m/s) of the road `shift` (s) before sample `i`, averaged over `half_window` (s) to both sides.
    pub fn road_before(&self, i: usize, shift: f64, half_window: f64) -> (f64, f64) {
        let step = self.input.step;
        let centre = i as f64 - shift / step;
        // Beyond its ends the record is held constant, so the window shrinks there.
        let last = (self.input.len() - 1) as f64;
        let room = centre.clamp(0.0, last).min(last - centre.clamp(0.0, last));
        let half = (half_window / step).min(room);
        if half < 1e-6 {
            return self.road_at(centre);
        }
        let width = 2.0 * half * step;
        (
            (self.integral_at(centre + half) - self.integral_at(centre - half)) / width,
            (self.road_at(centre + half).0 - self.road_at(centre - half).0) / width,
        )
    }
}

/// An axle's motion by its plain fit: displacement, velocity, acceleration (of the mass, or what the force gives 1 kg where
/// the motion is prescribed), deflection and its rate.
struct PlainMotion {
    z: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    d: Vec<f64>,
    w: Vec<f64>,
}

impl PlainMotion {
    fn new(record: &AxleRecord, input: &Input, fit: &AxleFit) -> Self {
        let fitted = record.output().iter().zip(&fit.residual);
        let fitted: Vec<f64> = fitted.map(|(y, r)| y - r).collect();
        let (z, a) = if record.prescribed {
            (vec![0.0; fitted.len()], fitted)
        } else {
            let a = slopes(&slopes(&fitted, input.step), input.step);
            (fitted, a)
        };
        let v = slopes(&z, input.step);
        let d: Vec<f64> = input.road.iter().zip(&z).map(|(u, z)| u - z).collect();
        let w: Vec<f64> = input
            .road_slope
            .iter()
            .zip(&v)
            .map(|(u, z)| u - z)
            .collect();
        Self { z, v, a, d, w }
    }
}

/// The sizes from which effects take their starts and limits.
fn scale(recorded: &Recorded, axle: Axle, motion: &PlainMotion, fit: &AxleFit) -> Scale {
    let Recorded {
        ride,
        bike,
        train_end,
        ..
    } = *recorded;
    let mass = 1.0 / fit.plain.per_mass;
    let rms = |x: &[f64]| {
        let part = &x[..train_end.min(x.len())];
        (part.iter().map(|x| x * x).sum::<f64>() / part.len().max(1) as f64)
            .sqrt()
            .max(f64::MIN_POSITIVE)
    };
    let d_low = motion.d.iter().copied().fold(0.0, f64::min);
    let d_high = motion.d.iter().copied().fold(0.0, f64::max);
    let sign = if axle == Axle::Front { 1.0 } else { -1.0 };
    let total = bike.mass_front_kg.unwrap_or(0.0) + bike.mass_rear_kg.unwrap_or(0.0);
    Scale {
        mass,
        k: fit.plain.kappa * mass,
        b: fit.plain.beta * mass,
        d_rms: rms(&motion.d),
        d_low,
        d_high,
        d_peak: d_high.max(-d_low).max(f64::MIN_POSITIVE),
        w_rms: rms(&motion.w),
        z_rms: rms(&motion.z),
        v_rms: rms(&motion.v),
        a_rms: rms(&motion.a),
        train_s: train_end as f64 * ride.step_s,
        duration: ride.duration_s(),
        step: ride.step_s,
        static_load: bike.static_load(axle).unwrap_or(f64::NAN),
        wheel_radius: bike.wheel_radius(axle).unwrap_or(f64::NAN),
        mean_speed: recorded.mean_speed,
        speed_span: recorded.speed_span.max(1e-3),
        train_distance: recorded.train_distance,
        lift: bike.wheelbase().map_or(0.0, |l| sign * total / l),
        balanced_pitch_inertia: bike.l_front_m.unwrap_or(0.0)
            * bike.l_rear_m.unwrap_or(0.0)
            * total,
        own: None,
    }
}

/// Time (s) at the start of a driven ride that no fit looks at: what an effect's own states did
/// before the first sample is not known.
const WARM_UP_S: f64 = 1.0;

/// The samples that fits look at.
fn fitted_to(record: &AxleRecord, at_rest: bool, step_s: f64, train_end: usize) -> Vec<bool> {
    let mut valid = record.valid.clone();
    let driven = record.has_road() || record.force.is_some();
    if driven && !at_rest {
        let warm_up = (WARM_UP_S / step_s).min(0.03 * train_end as f64) as usize;
        valid[..warm_up].fill(false);
    }
    valid
}

/// Density (m^2/Hz, one-sided) of the noise that a laser put into the road that was made from it, within what that contains; 0 where a
/// road was recorded.
fn laser_noise(ride: &Ride, axle: Axle) -> f64 {
    let mut noises = ride.road_doubts.iter().filter(|doubt| doubt.is_noise);
    let noise = noises.find_map(|doubt| doubt.change.get(axle));
    let spectrum = noise.and_then(|noise| Spectrum::new(noise, ride.step_s));
    spectrum.map_or(0.0, |s| s.level())
}

fn spline_integral(input: &Input) -> Vec<f64> {
    let mut sum = 0.0;
    let mut out = vec![0.0];
    for i in 0..input.len().saturating_sub(1) {
        let u = cubic(
            input.road[i],
            input.road[i + 1],
            input.road_slope[i],
            input.road_slope[i + 1],
            input.step,
        );
        sum += (u[0] + u[1] / 2.0 + u[2] / 3.0 + u[3] / 4.0) * input.step;
        out.push(sum);
    }
    out
}
