use std::fmt::Debug;

use super::{Coefficient, Quantity};

/// A base model.
pub trait Plant: Debug + Send + Sync {
    /// Its name in rides and documents; no two have the same.
    fn id(&self) -> &'static str;

    /// What is reported of it, in this order.
    fn quantities(&self) -> &'static [Quantity];

    /// Whether its mass moves, so that a sensor reads where it is; else a rig prescribes the motion and the sensor reads the force
    /// that answers.
    fn moves(&self) -> bool {
        true
    }

    /// Whether it has a spring.
    fn has_spring(&self) -> bool {
        true
    }

    /// The same without a spring, where such a thing exists.
    fn without_spring(&self) -> Option<&'static dyn Plant> {
        None
    }

    /// The same where a rig prescribes the motion, where such a thing exists.
    fn driven(&self) -> Option<&'static dyn Plant> {
        None
    }

    /// Whether a fit may move a number.
    fn is_free(&self, number: Coefficient, known: Known) -> bool {
        match number {
            Coefficient::Kappa => self.has_spring(),
            Coefficient::Beta => true,
            Coefficient::PerMass => !known.mass,
            Coefficient::Constant => !known.rest,
            Coefficient::Height | Coefficient::Velocity => self.moves(),
        }
    }

    /// A typical size of a number, and its limits.
    fn range(&self, number: Coefficient, sizes: &Sizes) -> (f64, [f64; 2]) {
        let free = [f64::NEG_INFINITY, f64::INFINITY];
        let [most_kappa, most_beta] = sizes.most;
        match number {
            Coefficient::Kappa => {
                let limits = [-sizes.slack, most_kappa];
                let size = 0.1 * sizes.stiffness / sizes.mass;
                (size, if self.moves() { limits } else { free })
            }
            Coefficient::Beta => {
                let limits = [-most_beta, most_beta];
                let size = 0.1 * sizes.damping / sizes.mass;
                (size, if self.moves() { limits } else { free })
            }
            Coefficient::PerMass => (0.1 / sizes.mass, [1e-9, f64::INFINITY]),
            Coefficient::Constant => (0.05 * sizes.acceleration, free),
            Coefficient::Height => (0.1 * sizes.height, free),
            Coefficient::Velocity => (0.1 * sizes.velocity, free),
        }
    }
}

/// What is known of an axle without a fit.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// Its mass.
    pub mass: bool,
    /// Where it rests.
    pub rest: bool,
}

/// Typical sizes on an axle, from which fits take their steps and limits. For a plant that turns: rad for m, N m for N, kg m^2 for kg.
#[derive(Clone, Copy, Debug)]
pub struct Sizes {
    /// Stiffness (N/m) and damping (N s/m) to measure others by.
    pub stiffness: f64,
    /// Damping (N s/m).
    pub damping: f64,
    /// Mass (kg).
    pub mass: f64,
    /// Acceleration (m/s^2, RMS).
    pub acceleration: f64,
    /// Height (m, RMS).
    pub height: f64,
    /// Velocity (m/s, RMS).
    pub velocity: f64,
    /// How far k/m (1/s^2) may lie below none: what the length of the record cannot distinguish from it.
    pub slack: f64,
    /// Largest k/m (1/s^2) and B/m (1/s) that the sample interval shows.
    pub most: [f64; 2],
}
