//! What is computed, apart from queue and database, so that it can be done here or in a child process.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use uuid::Uuid;
use veloid_engine::bicycle::Bike;
use veloid_engine::report::study::StudyReport;
use veloid_engine::report::{Report, Trial};
use veloid_engine::ride::Ride;
use veloid_engine::swarm::Swarm;
use veloid_engine::{Conclusion, EngineError, Observed, Progress, Ridden, Settings};

use super::errand::{Errand, Found};
use super::unread::Unread;
use crate::crash;

/// What is to be done: a stage of a job, or an errand that is nobody's.
#[derive(Serialize, Deserialize)]
pub enum Order {
    /// The subject is left out where who is to do it knows it.
    Stage(Option<Arc<Subject>>, Task),
    Errand(Arc<Errand>),
    Study(Arc<Study>),
}

/// Rides that are identified as one.
#[derive(Serialize, Deserialize)]
pub struct Study {
    /// Each with its name and the bicycle as it was ridden.
    pub rides: Vec<(String, Arc<Ride>, Bike)>,
    pub settings: Settings,
}

/// What a job is about.
#[derive(Serialize, Deserialize)]
pub struct Subject {
    pub job: Uuid,
    pub ride: Arc<Ride>,
    pub bike: Bike,
    pub settings: Settings,
}

/// One stage, with what those before it found.
#[derive(Serialize, Deserialize)]
pub enum Task {
    Observe,
    Trials {
        observed: Arc<Observed>,
        indices: Range<usize>,
    },
    Conclude {
        observed: Arc<Observed>,
        trials: Vec<Trial>,
    },
    Diagnose {
        observed: Arc<Observed>,
        conclusion: Box<Conclusion>,
    },
}

/// What came of an [`Order`].
#[derive(Serialize, Deserialize)]
pub enum Outcome {
    Observed(Box<Observed>),
    Trials(Vec<Trial>),
    /// With the report, where no diagnosis is wanted.
    Concluded(Box<Conclusion>, Option<Box<Report>>),
    Diagnosed(Box<Report>),
    Errand(Result<Found, Unread>),
    Studied(Box<StudyReport>),
}

impl Study {
    pub fn perform(&self, progress: &dyn Progress) -> Result<Outcome, EngineError> {
        crash::poison("study", self.settings.seed);
        let rides: Vec<Ridden> = (self.rides.iter())
            .map(|(name, ride, bike)| Ridden {
                name: name.clone(),
                ride,
                bike,
            })
            .collect();
        let report = veloid_engine::study(&rides, &self.settings, progress)?;
        Ok(Outcome::Studied(Box::new(report)))
    }
}

impl Task {
    fn stage(&self) -> &'static str {
        match self {
            Task::Observe => "observe",
            Task::Trials { .. } => "trial",
            Task::Conclude { .. } => "conclude",
            Task::Diagnose { .. } => "diagnose",
        }
    }
}

impl Subject {
    /// What the trials share.
    pub fn swarm(&self, observed: &Observed) -> Result<Swarm, EngineError> {
        Swarm::new(&self.ride, &self.bike, &self.settings, observed)
    }

    /// Carries a task out; trials with the swarm that is ready, if one is.
    pub fn perform(
        &self,
        task: Task,
        swarm: Option<&Swarm>,
        progress: &dyn Progress,
    ) -> Result<Outcome, EngineError> {
        crash::poison(task.stage(), self.settings.seed);
        match task {
            Task::Observe => self.observe(),
            Task::Trials { observed, indices } => {
                let made;
                let swarm = match swarm {
                    Some(swarm) => swarm,
                    None => {
                        made = self.swarm(&observed)?;
                        &made
                    }
                };
                let trials = indices.into_par_iter();
                let trials = trials.map(|index| swarm.trial(index, progress));
                Ok(Outcome::Trials(trials.collect::<Result<_, _>>()?))
            }
            Task::Conclude { observed, trials } => {
                self.conclude(Arc::unwrap_or_clone(observed), trials)
            }
            Task::Diagnose {
                observed,
                conclusion,
            } => self.diagnose(Arc::unwrap_or_clone(observed), *conclusion, progress),
        }
    }

    fn observe(&self) -> Result<Outcome, EngineError> {
        let observed = veloid_engine::observe(&self.ride, &self.bike, &self.settings)?;
        Ok(Outcome::Observed(Box::new(observed)))
    }

    fn conclude(&self, observed: Observed, trials: Vec<Trial>) -> Result<Outcome, EngineError> {
        let (ride, bike, settings) = (&self.ride, &self.bike, &self.settings);
        let conclusion = veloid_engine::conclude(ride, bike, settings, &observed, trials)?;
        let report = match settings.diagnosis {
            true => None,
            false => {
                let concluded = conclusion.clone();
                let report =
                    veloid_engine::assemble(ride, bike, settings, observed, concluded, None);
                Some(Box::new(report?))
            }
        };
        Ok(Outcome::Concluded(Box::new(conclusion), report))
    }

    fn diagnose(
        &self,
        observed: Observed,
        conclusion: Conclusion,
        progress: &dyn Progress,
    ) -> Result<Outcome, EngineError> {
        let (ride, bike, settings) = (&self.ride, &self.bike, &self.settings);
        let found = veloid_engine::diagnose(ride, bike, settings, &conclusion, progress)?;
        let report =
            veloid_engine::assemble(ride, bike, settings, observed, conclusion, Some(found));
        Ok(Outcome::Diagnosed(Box::new(report?)))
    }
}
