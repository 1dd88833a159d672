//! What the extended model needs to know of a ride: its axles, its speed and its pedalling.

use std::sync::Arc;

use super::speed;
use super::track::{Recorded, Track};
use super::work::Work;
use crate::law::{Need, OwnLaw};
use veloid_core::bicycle::{Bike, PerAxle};
use veloid_methods::output_error::AxleFit;
use veloid_ride::Ride;

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
        let recorded = Recorded {
            ride,
            bike,
            train_end,
            mean_speed: mean,
            speed_span: span,
            train_distance: dataset
                .distance
                .get(train_end.saturating_sub(1))
                .copied()
                .unwrap_or(0.0),
        };
        for (axle, record) in ride.axles.iter() {
            if let Some(fit) = fits.get(axle) {
                dataset
                    .tracks
                    .push(Track::new(&recorded, axle, record, fit));
            }
        }
        dataset
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
                "the motion is prescribed, so no mass moves freely",
            ),
            Need::Drive => (
                track.is_driven(),
                "nothing drives the axle, and a free decay confounds it with the amplitude",
            ),
            Need::Hold => (
                self.is_held,
                "no spring holds the mass, so its drift cannot be distinguished from the sensor's",
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;
    use veloid_core::plant::Coefficients;

    fn axle(kappa: f64, beta: f64) -> Coefficients {
        Coefficients {
            kappa,
            beta,
            ..Coefficients::default()
        }
    }

    #[test]
    fn noise_at_the_axle_is_the_sensors_and_what_comes_through_from_the_road() {
        let mut track = example::dataset().tracks[0].clone();
        let nyquist = 0.5 / track.input.step;
        track.sensor_floor = 3e-10;
        track.road_floor = 0.0;
        let sensor = track.noise_variance(&axle(2400.0, 20.0));
        assert!((sensor / (3e-10 * nyquist) - 1.0).abs() < 1e-12);
        // White noise through k/m and B/m has the variance S (k/m + (B/m)^2) / (4 B/m) on a band without end.
        track.sensor_floor = 0.0;
        track.road_floor = 2e-10;
        let (kappa, beta) = (2400.0, 20.0);
        let road = track.noise_variance(&axle(kappa, beta));
        // What the band ends cut off falls with 1/f^2.
        let beyond = beta * beta / (std::f64::consts::TAU.powi(2) * nyquist);
        let expected = 2e-10 * ((kappa + beta * beta) / (4.0 * beta) - beyond);
        assert!((road / expected - 1.0).abs() < 0.02, "{road} {expected}");
    }

    #[test]
    fn a_road_read_earlier_is_what_it_was_and_averaged_over_a_window() {
        let mut track = example::dataset().tracks[0].clone();
        // 3 m for every second, so that no spline is in the way.
        let step = track.input.step;
        let road: Vec<f64> = (0..500).map(|i| 3.0 * step * f64::from(i)).collect();
        track.set_road(&road);
        for half_window in [0.0, 0.05] {
            let (height, rate) = track.road_before(200, 0.123, half_window);
            assert!((height - 3.0 * (200.0 * step - 0.123)).abs() < 1e-9);
            assert!((rate - 3.0).abs() < 1e-9);
        }
        // Before its start the record is held.
        assert_eq!(track.road_before(10, 1.0, 0.05).0, road[0]);
        // Over a parabola t^2 a window adds a third of its half's square.
        let bowl: Vec<f64> = (0..500).map(|i| (step * f64::from(i)).powi(2)).collect();
        track.set_road(&bowl);
        let (height, _) = track.road_before(250, 0.0, 0.3);
        assert!((height - (2.5_f64.powi(2) + 0.3_f64.powi(2) / 3.0)).abs() < 1e-6);
    }

    #[test]
    fn an_integral_is_by_trapezoids() {
        assert_eq!(integral(&[1.0, 3.0, 5.0], 0.5), [0.0, 1.0, 3.0]);
        assert!(integral(&[], 0.5).is_empty());
    }

    #[test]
    fn a_mass_that_is_prescribed_rests_and_another_is_where_models_say() {
        let mut track = example::dataset().tracks[0].clone();
        assert_eq!(track.height(vec![1.0, 2.0]), [1.0, 2.0]);
        track.input.prescribed = true;
        assert_eq!(track.height(vec![1.0, 2.0]), [0.0, 0.0]);
    }

    #[test]
    fn an_effect_is_not_looked_for_where_what_it_needs_is_missing() {
        let dataset = example::dataset();
        let lacks = |need| dataset.lacks(&dataset.tracks[0], need);
        assert_eq!(lacks(Need::Road), None);
        assert_eq!(lacks(Need::Mass), None);
        assert_eq!(
            lacks(Need::Cadence),
            Some("no cadence channel, or no pedalling")
        );
        assert_eq!(
            lacks(Need::WheelRadius),
            Some("no wheel radius in the bike file")
        );
        let mut free = dataset.clone();
        free.is_held = false;
        assert!(free.lacks(&free.tracks[0], Need::Hold).is_some());
        assert_eq!(dataset.lacks(&dataset.tracks[0], Need::Hold), None);
        let mut released = dataset.clone();
        released.tracks[0].has_road = false;
        assert!(released.lacks(&released.tracks[0], Need::Drive).is_some());
        assert_eq!(lacks(Need::Drive), None);
    }
}
