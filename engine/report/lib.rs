//! The report: the one document that the CLI writes, the API serves and the pages show.

pub mod diagnosis;
pub mod dynamics;
mod estimate;
pub mod identifiable;
mod latent_road;
mod method;
mod mistake;
pub mod model;
pub mod model_on_ride;
mod parameter;
mod result;
pub mod simulation;
pub mod stages;
pub mod study;
mod summary;
pub mod tried;
pub mod validation;
pub mod windows;

use serde::{Deserialize, Serialize};

use dynamics::Dynamics;
use veloid_core::bicycle::{Axle, Bike, PerAxle};
use veloid_core::settings::Settings;
use veloid_ride::RideSummary;

pub use estimate::{Estimate, at_limit};
pub use latent_road::{Correction, LatentRoad, RoadSpectrum, SensorFound};
pub use method::Method;
pub use mistake::{Mistake, MistakeKind};
pub use model::IdentifiedModel;
pub use model_on_ride::ModelOnRide;
pub use result::{AxleResult, ResultQuantity};
pub use summary::summary;
use validation::Validation;

/// Complete result of one identification.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Report {
    /// Version of veloid that made this report.
    pub veloid: String,
    /// Contents of the ride's files.
    pub ride: RideSummary,
    /// The bike file.
    pub bike: Bike,
    /// Settings of the identification, with defaults for those not given.
    pub settings: Settings,
    /// Apparent mistakes in the record or the bicycle data, to be fixed first.
    #[serde(default)]
    pub mistakes: Vec<Mistake>,
    /// The one answer of each axle: `k`, `B`, `mass`, `natural_frequency` and `damping_ratio`, or what else its base model names. Empty in stored reports of
    /// earlier versions.
    #[serde(default)]
    pub result: PerAxle<AxleResult>,
    /// Poles, step response and joint errors of each axle's k, B and m. Empty in stored reports of earlier versions.
    #[serde(default)]
    pub dynamics: PerAxle<Dynamics>,
    /// The models beside the record that they come from. Empty in stored reports of earlier versions.
    #[serde(default)]
    pub validation: PerAxle<Validation>,
    /// How well the observer followed each axle; null where nothing is observed, for example where a rig prescribes the motion.
    pub observer: PerAxle<ObserverReport>,
    /// Least squares on the observer's states, paper eqs. (19) to (21).
    pub least_squares: PerAxle<Estimate>,
    /// Least squares with instruments from the simulated model.
    pub instrumental: PerAxle<Estimate>,
    /// Recursive least squares along the ride, paper eqs. (22), (23).
    pub recursive: PerAxle<RecursivePath>,
    /// The particle swarm's estimates, paper eqs. (24) to (30).
    pub swarm: SwarmReport,
    /// The plain model fitted by its simulated displacement: the reference for the other methods.
    pub output_error: PerAxle<Estimate>,
    /// k and B of a ride whose road was not recorded; no other method then has an estimate.
    #[serde(default)]
    pub latent_road: Option<LatentRoad>,
    /// Errors of the model with each method's parameters.
    pub comparison: Comparison,
    /// Part of the standard errors of k and B that comes from the laser from which the road was computed: from its clock error
    /// (`ride.clocks`) and its noise; null without a laser.
    #[serde(default)]
    pub laser_error: PerAxle<Parameters>,
    /// Part of the standard errors that comes from uncertain masses (one standard deviation): how far k and B move, with their sign,
    /// when the mass is that much larger.
    #[serde(default)]
    pub mass_error: PerAxle<Parameters>,
    /// Change of k and B by output error due to noise in the road channel; part of their standard errors.
    #[serde(default)]
    pub road_noise_error: PerAxle<Parameters>,
    /// Change of k and B by output error due to the interpolation of the road between its samples; part of their standard errors.
    /// Null for axles that are slow beside the sampling rate.
    #[serde(default)]
    pub interpolation_error: PerAxle<Parameters>,
    /// Roll angle and roll acceleration, paper eqs. (3) to (9), where their channels are recorded.
    pub roll: Option<RollReport>,
    /// How well k and B are known, and which ride would halve their intervals, one sentence each.
    #[serde(default)]
    pub what_next: Vec<String>,
    /// Absent with `--no-diagnosis`.
    pub diagnosis: Option<diagnosis::Diagnosis>,
}

impl Report {
    /// What a method estimates.
    pub fn estimates(&self, method: Method) -> PerAxle<Estimate> {
        match method {
            Method::Extended => {
                let extended = self.diagnosis.as_ref().map(|d| d.extended.clone());
                extended.unwrap_or_default()
            }
            Method::OutputError => self.output_error.clone(),
            Method::LatentRoad => {
                let latent = self.latent_road.as_ref().map(LatentRoad::axles);
                latent.unwrap_or_default()
            }
            Method::Swarm => PerAxle {
                front: self.swarm.front.clone(),
                rear: self.swarm.rear.clone(),
            },
            Method::Instrumental => self.instrumental.clone(),
            Method::LeastSquares => self.least_squares.clone(),
        }
    }

    /// The same report with this result. No method has an interval of what the result withholds.
    pub fn with_result(self, result: PerAxle<AxleResult>) -> Self {
        let bound = |axle, estimate: Estimate| match result.get(axle) {
            Some(of_axle) => of_axle.bound(estimate),
            None => estimate,
        };
        let all = |estimates: PerAxle<Estimate>| estimates.map(|axle, e| bound(axle, e.clone()));
        let one = |axle, estimate: Option<Estimate>| estimate.map(|e| bound(axle, e));
        Self {
            least_squares: all(self.least_squares),
            instrumental: all(self.instrumental),
            swarm: SwarmReport {
                front: one(Axle::Front, self.swarm.front),
                rear: one(Axle::Rear, self.swarm.rear),
                ..self.swarm
            },
            output_error: all(self.output_error),
            latent_road: self.latent_road.map(|latent| LatentRoad {
                front: one(Axle::Front, latent.front),
                rear: one(Axle::Rear, latent.rear),
                ..latent
            }),
            diagnosis: self.diagnosis.map(|diagnosis| diagnosis::Diagnosis {
                extended: all(diagnosis.extended),
                ..diagnosis
            }),
            validation: self.validation.map(|axle, found| {
                let withheld = |of_axle: &AxleResult| {
                    of_axle.withheld("k").or(of_axle.withheld("B")).is_some()
                };
                match result.get(axle).is_some_and(withheld) {
                    true => found.clone().without_intervals(),
                    false => found.clone(),
                }
            }),
            result,
            ..self
        }
    }

    /// Mistakes that the verdict's sentence does not show.
    pub fn other_mistakes(&self) -> impl Iterator<Item = &Mistake> {
        let reported = self.diagnosis.is_some();
        let mistakes = self.mistakes.iter();
        mistakes.filter(move |mistake| !(reported && mistake.takes_the_verdict))
    }

    /// Whether nothing but the sensors determines k and B, as no road, displacement or force was recorded.
    pub fn has_no_road(&self) -> bool {
        self.output_error.iter().next().is_none()
    }
}

/// How well the sliding-mode observer follows the measurement, paper figures 4 and 5.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ObserverReport {
    /// Largest difference from the measured displacement (m) after convergence.
    pub position_max_m: f64,
    /// Largest difference from the displacement's zero-phase derivative (m/s) after convergence.
    pub velocity_max_m_s: f64,
    /// RMS difference from the measured displacement (m) after convergence.
    pub position_rms_m: f64,
    /// RMS difference from the displacement's zero-phase derivative (m/s) after convergence.
    pub velocity_rms_m_s: f64,
    /// The jerk bound f of eq. (15) that was used (m/s^3).
    pub jerk_bound_m_s3: f64,
    /// Time from the first sample after which the observer has converged (s).
    pub converged_after_s: f64,
}

/// Path of the recursive estimate, thinned for plotting.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct RecursivePath {
    /// Time (s) on the ride's clock.
    pub t_s: Vec<f64>,
    /// k (N/m) from the samples up to each time.
    pub k_n_m: Vec<f64>,
    /// B (N s/m) from the samples up to each time.
    pub b_n_s_m: Vec<f64>,
}

/// k and B without uncertainty.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Parameters {
    /// Stiffness k (N/m).
    pub k_n_m: f64,
    /// Damping B (N s/m).
    pub b_n_s_m: f64,
}

impl Parameters {
    /// What these numbers are of an estimate's, as shares without sign: of k and of B.
    pub fn shares_of(&self, e: &Estimate) -> [f64; 2] {
        [self.k_n_m / e.k_n_m, self.b_n_s_m / e.b_n_s_m].map(f64::abs)
    }
}

/// All swarm trials and the best of them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct SwarmReport {
    /// Index of the trial with the lowest cost (from 0).
    pub best_trial: usize,
    /// The best trial's k and B of the front axle, with the scatter over the trials.
    pub front: Option<Estimate>,
    /// The best trial's k and B of the rear axle, with the scatter over the trials.
    pub rear: Option<Estimate>,
    /// Means of k and B over the trials (figure 7).
    pub mean: PerAxle<Parameters>,
    /// All trials, in the order of their seeds.
    pub trials: Vec<Trial>,
}

/// One run of the swarm from one seed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Trial {
    /// Seed of its random numbers.
    pub seed: u64,
    /// Best cost after each iteration (figure 6).
    pub best_cost: Vec<f64>,
    /// Best position after each iteration: k/m (1/s^2) and B/m (1/s) of each axle, front first; one
    /// pair k (N/m), B (N s/m) when the bike has equal axles.
    pub best_position: Vec<Vec<f64>>,
    /// k and B of the front axle at the best position.
    pub front: Option<Parameters>,
    /// k and B of the rear axle at the best position.
    pub rear: Option<Parameters>,
}

/// Table 1 of the paper, for every method and axle.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Comparison {
    /// One row per method and axle, methods in the order of `ComparisonRow::method`.
    pub rows: Vec<ComparisonRow>,
    /// Why a row is absent.
    #[serde(default)]
    pub notes: Vec<String>,
}

/// Errors of the model simulated with one method's parameters against the measurement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ComparisonRow {
    /// `least_squares`, `instrumental`, `swarm` or `output_error`, in this order.
    pub method: String,
    /// The axle that was simulated.
    pub axle: veloid_core::bicycle::Axle,
    /// Largest error of the displacement (m).
    pub position_max_m: f64,
    /// Mean squared error of the displacement (m^2).
    pub position_mse_m2: f64,
    /// Largest error of the displacement's central difference (m/s).
    pub velocity_max_m_s: f64,
    /// Mean squared error of that velocity (m^2/s^2).
    pub velocity_mse_m2_s2: f64,
    /// Largest error of the displacement's second central difference (m/s^2).
    pub acceleration_max_m_s2: f64,
    /// Mean squared error of that acceleration (m^2/s^4).
    pub acceleration_mse_m2_s4: f64,
}

/// Result of the roll equations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct RollReport {
    /// Time (s) of the values below, thinned for plotting.
    pub t_s: Vec<f64>,
    /// Roll angle of steady cornering, eq. (3) (rad).
    pub steady_roll_rad: Vec<f64>,
    /// Measured roll angle (rad), where the ride has it.
    pub measured_roll_rad: Option<Vec<f64>>,
    /// Roll acceleration, eq. (4) (rad/s^2).
    pub roll_acceleration_rad_s2: Option<Vec<f64>>,
    /// Second derivative of the measured roll angle by the observer (rad/s^2), where the ride has the angle.
    #[serde(default)]
    pub observed_roll_acceleration_rad_s2: Option<Vec<f64>>,
    /// Largest difference between eq. (4) and the measured roll angle's second derivative (rad/s^2).
    pub acceleration_error_max_rad_s2: Option<f64>,
    /// RMS difference between the two (rad/s^2).
    pub acceleration_error_rms_rad_s2: Option<f64>,
    /// What was missing for a complete result.
    pub notes: Vec<String>,
}
