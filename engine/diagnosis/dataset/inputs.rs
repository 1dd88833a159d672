//! What the extended model needs to know of a ride: the inputs of every axle with their slopes, and
//! the sizes from which effects take their starts and limits.

use std::sync::Arc;

use rand_chacha::ChaCha8Rng;

use super::speed;
use super::work::Work;
use crate::bicycle::{Axle, Bike, PerAxle};
use crate::diagnosis::law::{Need, OwnLaw, Scale};
use crate::numerics::random::normal;
use crate::numerics::spectrum::{measured_noise, white_floor};
use crate::numerics::spline::{cubic, slopes};
use crate::numerics::statistics::variance;
use crate::output_error::{self, AxleFit};
use crate::plant::{Coefficient, Coefficients, Known, Plant, Sizes};
use crate::report::diagnosis::Predicted;
use crate::ride::{AxleRecord, Ride};
use crate::simulate::linear::{Input, road_answer};

/// One axle's inputs and measurement.
#[derive(Clone, Debug)]
pub struct Track {
    pub axle: Axle,
    pub input: Input,
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
    /// Deviations of height (m) and velocity (m/s) at the first sample from its measured height and none, where the
    /// record shows that it starts at rest.
    pub at_rest: Option<[f64; 2]>,
    /// Whether the mass is estimated, and whether the rest point is.
    pub free_mass: bool,
    pub rest_point: bool,
    /// What the axle is where nothing is left out.
    pub plant: &'static dyn Plant,
}

impl Track {
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
        self.plant.is_free(number, known)
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
        self.plant.range(number, &sizes)
    }

    /// What models predict on this track.
    pub fn predicted(&self) -> Predicted {
        match self.input.prescribed {
            true => Predicted::Force,
            false => Predicted::Displacement,
        }
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

    /// Adds white noise (m, RMS) to the recorded road.
    pub fn add_road_noise(&mut self, noise: f64, rng: &mut ChaCha8Rng) {
        let road = self.input.road.iter().map(|u| u + noise * normal(rng));
        let road: Vec<f64> = road.collect();
        self.set_road(&road);
    }

    /// Variance (m^2) that noise of the displacement sensor and of the road channel has at the
    /// displacement of an axle with these numbers.
    pub fn noise_variance(&self, numbers: &Coefficients) -> f64 {
        const BANDS: usize = 256;
        let width = 0.5 / self.input.step / BANDS as f64;
        let answer =
            |band: usize| road_answer(numbers.kappa, numbers.beta, width * (band as f64 + 0.5));
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

/// The ride as the extended model sees it.
#[derive(Clone, Debug)]
pub struct Dataset {
    pub samples: usize,
    pub step: f64,
    pub tracks: Vec<Track>,
    /// Speed (m/s), its smoothed rate (m/s^2), distance (m) and crank angle (rad) at the samples;
    /// zeros where there is no channel.
    pub speed: Vec<f64>,
    pub speed_rate: Vec<f64>,
    pub distance: Vec<f64>,
    pub crank: Vec<f64>,
    /// Sine and cosine of twice the crank angle.
    pub double_crank: Vec<[f64; 2]>,
    has_speed: bool,
    varying_speed: bool,
    has_cadence: bool,
    /// Whether anything holds the masses in their places: what wanders may then be a sensor.
    pub is_held: bool,
    /// l_F, l_R (m), m_F, m_R (kg).
    pub geometry: Option<[f64; 4]>,
    /// Order of the autoregressive noise under which models are compared.
    pub noise_order: usize,
    /// What was simulated of this dataset and its variants so far.
    pub work: Work,
}

/// Order of the noise model under which structures are compared: the same for all.
const ORDER: usize = 10;

/// Time (s) at the start of a driven ride that no fit looks at: what an effect's own states did
/// before the first sample is not known.
const WARM_UP_S: f64 = 1.0;

impl Dataset {
    pub fn new(ride: &Ride, bike: &Bike, fits: &PerAxle<AxleFit>, train_end: usize) -> Self {
        let n = ride.samples;
        let speed = ride.speed.clone().unwrap_or_else(|| vec![0.0; n]);
        let speed_rate = speed::rate(&speed, ride.step_s);
        let distance = integral(&speed, ride.step_s);
        let cadence = ride.cadence.clone().unwrap_or_else(|| vec![0.0; n]);
        let crank: Vec<f64> = integral(&cadence, ride.step_s)
            .iter()
            .map(|x| x * std::f64::consts::TAU / 60.0)
            .collect();
        let mean = speed.iter().sum::<f64>() / n.max(1) as f64;
        let span = (speed.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n.max(1) as f64).sqrt();
        let geometry = match (
            bike.l_front_m,
            bike.l_rear_m,
            bike.mass_front_kg,
            bike.mass_rear_kg,
        ) {
            (Some(a), Some(b), Some(c), Some(d)) => Some([a, b, c, d]),
            _ => None,
        };
        let mut dataset = Self {
            samples: n,
            step: ride.step_s,
            tracks: Vec::new(),
            has_speed: ride.speed.is_some() && mean > 0.3,
            varying_speed: ride.speed.is_some() && span > 0.05 + 0.02 * mean.abs(),
            has_cadence: cadence.iter().any(|c| *c > 5.0),
            speed,
            speed_rate,
            distance,
            double_crank: double(&crank),
            crank,
            is_held: true,
            geometry,
            noise_order: ORDER,
            work: Work::default(),
        };
        for (axle, record) in ride.axles.iter() {
            if let Some(fit) = fits.get(axle) {
                let track = dataset.track(ride, bike, axle, record, fit, train_end, mean, span);
                dataset.tracks.push(track);
            }
        }
        dataset
    }

    #[expect(
        clippy::too_many_arguments,
        reason = "called once, all are plain facts of the ride"
    )]
    fn track(
        &self,
        ride: &Ride,
        bike: &Bike,
        axle: Axle,
        record: &AxleRecord,
        fit: &AxleFit,
        train_end: usize,
        mean_speed: f64,
        speed_span: f64,
    ) -> Track {
        let input = Input::of(record, ride.step_s);
        let mass = 1.0 / fit.plain.per_mass;
        let fitted = record.output().iter().zip(&fit.residual);
        let fitted: Vec<f64> = fitted.map(|(y, r)| y - r).collect();
        let (z, a) = if record.prescribed {
            (vec![0.0; fitted.len()], fitted)
        } else {
            let a = slopes(&slopes(&fitted, ride.step_s), ride.step_s);
            (fitted, a)
        };
        let v = slopes(&z, ride.step_s);
        let d: Vec<f64> = input.road.iter().zip(&z).map(|(u, z)| u - z).collect();
        let w: Vec<f64> = input
            .road_slope
            .iter()
            .zip(&v)
            .map(|(u, z)| u - z)
            .collect();
        let rms = |x: &[f64]| {
            let part = &x[..train_end.min(x.len())];
            (part.iter().map(|x| x * x).sum::<f64>() / part.len().max(1) as f64)
                .sqrt()
                .max(f64::MIN_POSITIVE)
        };
        let d_low = d.iter().copied().fold(0.0, f64::min);
        let d_high = d.iter().copied().fold(0.0, f64::max);
        let sign = if axle == Axle::Front { 1.0 } else { -1.0 };
        let total = bike.mass_front_kg.unwrap_or(0.0) + bike.mass_rear_kg.unwrap_or(0.0);
        let scale = Scale {
            mass,
            k: fit.plain.kappa * mass,
            b: fit.plain.beta * mass,
            d_rms: rms(&d),
            d_low,
            d_high,
            d_peak: d_high.max(-d_low).max(f64::MIN_POSITIVE),
            w_rms: rms(&w),
            z_rms: rms(&z),
            v_rms: rms(&v),
            a_rms: rms(&a),
            train_s: train_end as f64 * ride.step_s,
            duration: ride.duration_s(),
            step: ride.step_s,
            static_load: bike.static_load(axle).unwrap_or(f64::NAN),
            wheel_radius: bike.wheel_radius(axle).unwrap_or(f64::NAN),
            mean_speed,
            speed_span: speed_span.max(1e-3),
            train_distance: self
                .distance
                .get(train_end.saturating_sub(1))
                .copied()
                .unwrap_or(0.0),
            lift: bike.wheelbase().map_or(0.0, |l| sign * total / l),
            balanced_pitch_inertia: bike.l_front_m.unwrap_or(0.0)
                * bike.l_rear_m.unwrap_or(0.0)
                * total,
            own: None,
        };
        let road_integral = spline_integral(&input);
        let driven = record.has_road() || record.force.is_some();
        let mut valid = record.valid.clone();
        let at_rest = record.at_rest(ride.step_s);
        if driven && at_rest.is_none() {
            let warm_up = (WARM_UP_S / ride.step_s).min(0.03 * train_end as f64) as usize;
            valid[..warm_up].fill(false);
        }
        let most = |x: &[f64]| white_floor(x, ride.step_s);
        let floor = |x: &[f64], declared: Option<f64>| {
            declared.map_or_else(|| most(x), |noise| 2.0 * noise * noise * ride.step_s)
        };
        let declared = bike.noise_displacement_m.filter(|_| !record.prescribed);
        Track {
            axle,
            road_floor: floor(&record.road, bike.noise_road_m),
            road_most: most(&record.road),
            force_most: input.force.as_ref().map_or(0.0, |(force, _)| most(force)),
            sensor_floor: floor(record.output(), declared),
            declared_noise: declared,
            input,
            road_integral,
            measured: record.output().to_vec(),
            valid,
            scale,
            has_road: record.has_road(),
            at_rest,
            free_mass: bike.mass(axle).is_none() && !record.prescribed,
            rest_point: record.force.is_some() || !record.has_road(),
            plant: record.base_model(),
        }
    }

    /// Puts the user's own law into the sizes of every axle.
    pub fn set_law(&mut self, law: &Arc<OwnLaw>) {
        for track in &mut self.tracks {
            track.scale.own = Some(Arc::clone(law));
        }
    }

    /// Has the crank at other angles (rad).
    pub fn set_crank(&mut self, crank: Vec<f64>) {
        self.double_crank = double(&crank);
        self.crank = crank;
    }

    /// Takes the spring out of the plain model of every axle.
    pub fn remove_springs(&mut self) {
        for track in &mut self.tracks {
            track.plant = track.plant.without_spring().unwrap_or(track.plant);
        }
    }

    /// The ride without the noise (m) that was laid over its displacements.
    pub fn without(&self, dither: &PerAxle<Vec<f64>>) -> Self {
        let mut dataset = self.clone();
        for track in &mut dataset.tracks {
            let noise = dither.get(track.axle).into_iter().flatten();
            (track.measured.iter_mut().zip(noise)).for_each(|(z, n)| *z -= n);
        }
        dataset
    }

    /// Whether a road passes below an axle: a base that moves without a speed is a bench's.
    pub fn is_ridden(&self, track: &Track) -> bool {
        track.has_road && self.has_speed
    }

    /// What is lacking on this axle for an effect, in words; nothing if it can be spoken about.
    pub fn lacks(&self, track: &Track, need: Need) -> Option<&'static str> {
        let (there, why) = match need {
            Need::Road => (track.has_road, "the ground is at rest"),
            Need::Speed => (self.has_speed, "no speed channel"),
            Need::VaryingSpeed => (
                self.varying_speed,
                "no speed channel, or the speed hardly varies",
            ),
            Need::Cadence => (self.has_cadence, "no cadence channel, or no pedalling"),
            Need::Geometry => (
                self.geometry.is_some() && self.tracks.len() == 2,
                "both axles with masses, l_front_m and l_rear_m are needed",
            ),
            Need::WheelRadius => (
                track.scale.wheel_radius.is_finite(),
                "no wheel radius in the bike file",
            ),
            Need::StaticLoad => (
                track.scale.static_load.is_finite(),
                "no static load or mass in the bike file",
            ),
            Need::PrescribedMotion => (track.input.prescribed, "no rig prescribes the motion"),
            Need::Mass => (
                track.plant.moves(),
                "the motion is prescribed, so that no mass moves",
            ),
            Need::Hold => (
                self.is_held,
                "no spring holds the mass, so that its drift and a sensor's are one",
            ),
        };
        (!there).then_some(why)
    }
}

fn double(crank: &[f64]) -> Vec<[f64; 2]> {
    crank.iter().map(|x| (2.0 * x).sin_cos().into()).collect()
}

fn integral(x: &[f64], step: f64) -> Vec<f64> {
    let mut sum = 0.0;
    let mut out = Vec::with_capacity(x.len());
    for i in 0..x.len() {
        if i > 0 {
            sum += 0.5 * (x[i - 1] + x[i]) * step;
        }
        out.push(sum);
    }
    out
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
