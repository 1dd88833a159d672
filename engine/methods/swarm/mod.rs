//! Particle swarm, paper eqs. (24) to (30): parameters whose simulated motion comes nearest to the
//! measured one in position, velocity and acceleration, over the whole horizon and both axles.
//!
//! The three readings of the errors of eq. (26) are in [`veloid_core::Objective`]. The search box is even
//! in log(k/m) and log(B/m), a factor around the instrumental-variable estimate.

mod benchmark;
mod kernel;
mod search;
#[doc(hidden)]
pub mod straight;
pub mod target;
pub mod unknowns;

pub use benchmark::{Line, benchmark};

use kernel::{Kernel, Width};
use search::{Axis, Rules, minimise};
use target::Target;
use unknowns::Unknowns;
use veloid_core::Progress;
use veloid_core::bicycle::{Bike, PerAxle};
use veloid_core::document::checked;
use veloid_core::settings::Settings;
use veloid_core::{Divergence, EngineError};
use veloid_report::Trial;
use veloid_report::stages::Observed;
use veloid_ride::Ride;

/// A ride made ready for its trials: what all of them share.
pub struct Swarm {
    unknowns: Unknowns,
    axes: Vec<Axis>,
    kernels: PerAxle<Kernel>,
    rules: Rules,
    seed: u64,
}

impl Swarm {
    /// # Errors
    /// An axle without anything to compare with.
    pub fn new(
        ride: &Ride,
        bike: &Bike,
        settings: &Settings,
        observed: &Observed,
    ) -> Result<Self, EngineError> {
        let ride = &*ride.with_masses();
        let unknowns = Unknowns::new(bike, &observed.instrumental);
        let axes = unknowns.axes(settings.search_factor, ride.step_s, ride.samples);
        let middle: Vec<f64> = axes.iter().map(|a| a.at(0.5)).collect();
        let kernels = ride.axles.try_map(|axle, record| {
            let theta = unknowns.theta(axle, &middle);
            let target = Target::new(axle, record, ride, settings, theta)?;
            Ok::<_, EngineError>(Kernel::new(&target, Width::widest()).with_lags(theta))
        })?;
        Ok(Self {
            unknowns,
            axes,
            kernels,
            rules: Rules {
                particles: settings.particles,
                iterations: settings.iterations,
                cognitive: settings.cognitive,
                social: settings.social,
                inertia: (settings.inertia_min, settings.inertia_max),
                ratio: (settings.ratio_min, settings.ratio_max),
            },
            seed: settings.seed,
        })
    }

    /// One swarm, from the first seed + `index`; without a curve where every motion is prescribed and there is nothing to
    /// search.
    ///
    /// # Errors
    /// Cancellation; costs that are no numbers.
    pub fn trial(&self, index: usize, progress: &dyn Progress) -> Result<Trial, EngineError> {
        let (particles, groups) = (self.rules.particles, self.unknowns.groups());
        let seed = self.seed.wrapping_add(index as u64);
        if self.axes.is_empty() {
            // Where every motion is prescribed, or no road was recorded, there is nothing to search.
            return Ok(Trial {
                seed,
                ..Trial::default()
            });
        }
        let course = minimise(
            &self.axes,
            &groups,
            &self.rules,
            seed,
            |values, costs| {
                costs.fill(0.0);
                for (i, (axle, kernel)) in self.kernels.iter().enumerate() {
                    let positions = values.chunks(self.axes.len());
                    let thetas: Vec<_> = positions.map(|x| self.unknowns.theta(axle, x)).collect();
                    let group = i.min(groups.len() - 1) * particles;
                    kernel.add_costs(&thetas, &mut costs[group..][..particles]);
                }
            },
            |iteration, best| {
                if !best.is_finite() {
                    return Err(EngineError::Diverged {
                        stage: "swarm",
                        problem: Divergence::NoParticle { trial: index },
                    });
                }
                progress.iteration(index, iteration, best);
                if progress.cancelled() {
                    return Err(EngineError::Cancelled);
                }
                Ok(())
            },
        )?;
        checked("trial", self.unknowns.trial(seed, course))
    }
}
