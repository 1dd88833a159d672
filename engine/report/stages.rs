//! What the stages hand on to each other.

use serde::{Deserialize, Serialize};

use super::{
    Comparison, Estimate, LatentRoad, Mistake, ObserverReport, Parameters, RecursivePath,
    RollReport, SwarmReport, Trial,
};
use veloid_core::bicycle::PerAxle;

/// First stage: observer, least squares and instrumental variables.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Observed {
    /// How well the observer followed each axle.
    pub observer: PerAxle<ObserverReport>,
    /// Least squares on the observer's states, paper eqs. (19) to (21).
    pub least_squares: PerAxle<Estimate>,
    /// Least squares with instruments from the simulated model.
    pub instrumental: PerAxle<Estimate>,
    /// Recursive least squares along the ride, paper eqs. (22), (23).
    pub recursive: PerAxle<RecursivePath>,
    /// Roll angle and roll acceleration, paper eqs. (3) to (9), where their channels are recorded.
    pub roll: Option<RollReport>,
    /// k and B from sensors on the axles alone; null where the ride has none.
    #[serde(default)]
    pub latent_road: Option<LatentRoad>,
}

/// Third stage: the swarm's result, the output-error fit and the comparison of all methods.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Conclusion {
    /// What seems to have been done wrong to record or bicycle before.
    #[serde(default)]
    pub mistakes: Vec<Mistake>,
    /// Least squares on the observer's states, paper eqs. (19) to (21), with the bias beside output error.
    pub least_squares: PerAxle<Estimate>,
    /// Least squares with instruments from the simulated model, with the bias beside output error.
    pub instrumental: PerAxle<Estimate>,
    /// All trials of the swarm and the best of them.
    pub swarm: SwarmReport,
    /// The plain model fitted by its simulated displacement: the reference for the other methods.
    pub output_error: PerAxle<Estimate>,
    /// Part of the standard errors of k and B that comes from the laser that the road was made from.
    #[serde(default)]
    pub laser_error: PerAxle<Parameters>,
    /// The part of them that comes from masses that are not known exactly (one standard deviation): how far k and B move, with their sign,
    /// when the mass is that much larger.
    #[serde(default)]
    pub mass_error: PerAxle<Parameters>,
    /// Change of k and B by output error due to noise in the road channel; part of their standard errors.
    #[serde(default)]
    pub road_noise_error: PerAxle<Parameters>,
    /// Change of k and B by output error due to the interpolation of the road between its samples; part of their standard errors.
    #[serde(default)]
    pub interpolation_error: PerAxle<Parameters>,
    /// Why a sensor's clock that was set right may be physics that is missing.
    #[serde(default)]
    pub clock_unconfirmed: Option<String>,
    /// Why sensors of an unknown road determine nothing.
    #[serde(default)]
    pub unidentified: Option<String>,
    /// Errors of the model with each method's parameters.
    pub comparison: Comparison,
}

impl SwarmReport {
    /// Ranks the trials; the scatter over them is the standard deviation of the estimates.
    pub fn of(trials: Vec<Trial>, observed: &Observed) -> Self {
        let last = |t: &Trial| t.best_cost.last().copied().unwrap_or(f64::INFINITY);
        let best_trial = (0..trials.len())
            .min_by(|a, b| last(&trials[*a]).total_cmp(&last(&trials[*b])))
            .unwrap_or(0);
        let spread = |pick: fn(&Trial) -> &Option<Parameters>| {
            let all: Vec<&Parameters> = trials.iter().filter_map(|t| pick(t).as_ref()).collect();
            let mean = |of: fn(&Parameters) -> f64| {
                all.iter().map(|p| of(p)).sum::<f64>() / all.len() as f64
            };
            let (k, b) = (mean(|p| p.k_n_m), mean(|p| p.b_n_s_m));
            let std = |of: fn(&Parameters) -> f64, mean: f64| {
                (all.iter().map(|p| (of(p) - mean).powi(2)).sum::<f64>() / all.len() as f64).sqrt()
            };
            let best = trials.get(best_trial).and_then(|t| pick(t).clone())?;
            Some((
                Parameters {
                    k_n_m: k,
                    b_n_s_m: b,
                },
                std(|p| p.k_n_m, k),
                std(|p| p.b_n_s_m, b),
                best,
            ))
        };
        let (front, rear) = (spread(|t| &t.front), spread(|t| &t.rear));
        let estimate = |of: &Option<(Parameters, f64, f64, Parameters)>,
                        mass: Option<&Estimate>| {
            let (_, k_scatter, b_scatter, best) = of.as_ref()?;
            Some(Estimate {
                k_n_m: best.k_n_m,
                b_n_s_m: best.b_n_s_m,
                k_scatter_n_m: Some(*k_scatter),
                b_scatter_n_s_m: Some(*b_scatter),
                mass_kg: mass?.mass_kg,
                ..Estimate::default()
            })
        };
        Self {
            best_trial,
            front: estimate(&front, observed.instrumental.front.as_ref()),
            rear: estimate(&rear, observed.instrumental.rear.as_ref()),
            mean: PerAxle {
                front: front.map(|f| f.0),
                rear: rear.map(|r| r.0),
            },
            trials,
        }
    }
}
