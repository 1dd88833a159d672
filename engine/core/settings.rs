use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::bicycle::{Bike, LimitError, limits};
use crate::{EngineError, SettingProblem};

/// Objective of the swarm: paper, eqs. (25), (26), with three interpretations of its velocity and acceleration errors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Objective {
    /// Measured and simulated displacement through the same central differences: unbiased.
    #[default]
    Consistent,
    /// The observer's velocity and acceleration against the model's own states, as printed.
    Paper,
    /// Central differences of the measurement against the model's own states, linear road.
    Gradient,
}

/// Everything that controls an identification apart from the ride and the bike.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Seed of the first swarm trial; trial i uses `seed + i`. The bootstrap's seed is derived from it.
    pub seed: u64,
    /// Swarm trials (1 to 100).
    pub trials: usize,
    /// Particles of a swarm (2 to 10 000).
    pub particles: usize,
    /// Iterations of a swarm (1 to 10 000).
    pub iterations: usize,
    /// Errors that the swarm minimises.
    #[allow(missing_docs, reason = "the type says it")]
    pub objective: Objective,
    /// Cognitive weight c1 of paper eq. (28) (0 to 4).
    pub cognitive: f64,
    /// Social weight c2 of paper eq. (28) (0 to 4).
    pub social: f64,
    /// Lower bound of the inertia w, paper eq. (29) (0 to 1.2).
    pub inertia_min: f64,
    /// Upper bound of w (0 to 1.2).
    pub inertia_max: f64,
    /// Lower bound of the common ratio rho, paper eq. (30) (0 to 1).
    pub ratio_min: f64,
    /// Upper bound of rho (0 to 1).
    pub ratio_max: f64,
    /// Weights of displacement, velocity and acceleration errors, relative to 1/variance (W of eq. (25)).
    pub weights: [f64; 3],
    /// The search box: a factor around the instrumental-variable estimate, both ways (1.5 to 1000).
    pub search_factor: f64,
    /// Bound f on the jerk |z'''| of paper eq. (15) (m/s^3); estimated from the ride when absent.
    pub jerk_bound_m_s3: Option<f64>,
    /// Whether to look for missing physics.
    pub diagnosis: bool,
    /// Significance level of the diagnosis's tests, family-wise (0.001 to 0.2). Clean rides are given an effect more rarely, since the
    /// held-out part has to confirm it.
    pub alpha: f64,
    /// Share of the ride, at its end, on which nothing is fitted (0.1 to 0.7).
    pub held_out: f64,
    /// Effects that remove less than this share of the plain model's held-out error (RMS) are
    /// called immaterial in the report (0 to 1).
    pub materiality: f64,
    /// Steps of the integrator, each for eight parameter sets, that the search for missing physics may take per sample of an
    /// axle (100 to 1 000 000). When they are used up, the search reports its best result so far.
    pub search_budget: f64,
    /// A custom law (TOML) to test in addition to the library: see docs/own-law.md.
    pub law: Option<String>,
    /// Stiffness k (N/m) and damping B (N s/m) that output error and the search hold, by axle and quantity: `{"f.k": 60000}`.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub fix: BTreeMap<String, f64>,
    /// Lower and upper bounds of k (N/m) and B (N s/m) in the same fits: `{"r.B": [0, 2000]}`.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub bound: BTreeMap<String, [f64; 2]>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            seed: 1,
            trials: 10,
            particles: 30,
            iterations: 20,
            objective: Objective::Consistent,
            cognitive: 1.49618,
            social: 1.49618,
            inertia_min: 0.1,
            inertia_max: 0.9,
            ratio_min: 0.5,
            ratio_max: 0.8,
            weights: [1.0; 3],
            search_factor: 20.0,
            jerk_bound_m_s3: None,
            diagnosis: true,
            alpha: 0.01,
            held_out: 0.4,
            materiality: 0.01,
            search_budget: 7500.0,
            law: None,
            fix: BTreeMap::new(),
            bound: BTreeMap::new(),
        }
    }
}

/// Simulations of the whole ride that one identification may ask of the swarm.
const MAX_SIMULATIONS: usize = 2_000_000;

impl Settings {
    /// Rejects numbers that are out of range or would take the machine hostage.
    pub fn within_range(&self) -> Result<(), EngineError> {
        within("trials", self.trials as f64, 1.0, 100.0)?;
        within("particles", self.particles as f64, 2.0, 10_000.0)?;
        within("iterations", self.iterations as f64, 1.0, 10_000.0)?;
        within("cognitive", self.cognitive, 0.0, 4.0)?;
        within("social", self.social, 0.0, 4.0)?;
        within("inertia_max", self.inertia_max, 0.0, 1.2)?;
        within("inertia_min", self.inertia_min, 0.0, self.inertia_max)?;
        within("ratio_max", self.ratio_max, 0.0, 1.0)?;
        within("ratio_min", self.ratio_min, 0.0, self.ratio_max)?;
        within("search_factor", self.search_factor, 1.5, 1000.0)?;
        within("alpha", self.alpha, 0.001, 0.2)?;
        within("held_out", self.held_out, 0.1, 0.7)?;
        within("materiality", self.materiality, 0.0, 1.0)?;
        within("search_budget", self.search_budget, 100.0, 1e6)?;
        for weight in self.weights {
            within("weights", weight, 0.0, 1e12)?;
        }
        if self.weights.iter().all(|w| *w == 0.0) {
            return Err(EngineError::Setting {
                name: "weights",
                problem: SettingProblem::NoWeight,
            });
        }
        if let Some(bound) = self.jerk_bound_m_s3 {
            within("jerk_bound_m_s3", bound, 1e-6, 1e9)?;
        }
        limits::check(&self.fix, &self.bound).map_err(limit)?;
        let simulations = self.trials * self.particles * self.iterations;
        if simulations > MAX_SIMULATIONS {
            return Err(EngineError::Setting {
                name: "trials x particles x iterations",
                problem: SettingProblem::TooManySimulations {
                    simulations,
                    most: MAX_SIMULATIONS,
                },
            });
        }
        Ok(())
    }
}

impl Settings {
    /// The bicycle with what these settings fix and bound.
    pub fn limited(&self, bike: &Bike) -> Result<Bike, EngineError> {
        bike.with_limits(&self.fix, &self.bound).map_err(limit)
    }
}

/// A setting that fixes or bounds what cannot be.
pub fn limit(problem: LimitError) -> EngineError {
    EngineError::Setting {
        name: "fix or bound",
        problem: problem.into(),
    }
}

pub fn within(name: &'static str, value: f64, low: f64, high: f64) -> Result<(), EngineError> {
    if value >= low && value <= high {
        return Ok(());
    }
    Err(EngineError::Setting {
        name,
        problem: SettingProblem::OutOfRange { value, low, high },
    })
}
