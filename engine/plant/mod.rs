//! Base models: what an axle is where nothing is left out. What departs from one is an effect ([`crate::diagnosis`]).
//!
//! Every one here has one degree of freedom and is linear ([`Coefficients`]), which is what the integrator and the exact
//! solution compute; a [`Plant`] says which of its numbers exist, which of them a fit may move and how far, and under which names and
//! units they are reported. A new one is a folder or file of its own and a line in [`ALL`] (docs/decisions/plant.md).

mod axle;
mod coefficients;
mod damper;
#[cfg(test)]
mod pendulum;
mod quantity;
mod reference;

use std::fmt::Debug;

pub use axle::Axle;
pub use coefficients::{Coefficient, Coefficients};
pub use damper::Damper;
pub use quantity::{Of, Quantity};
pub use reference::PlantRef;

/// Every base model.
static ALL: &[&dyn Plant] = &[
    &Axle::MOVING,
    &Axle::DRIVEN,
    &Damper::MOVING,
    &Damper::DRIVEN,
    #[cfg(test)]
    &pendulum::Pendulum,
];

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

/// The base model of this name.
pub fn by_id(id: &str) -> Option<&'static dyn Plant> {
    ALL.iter().copied().find(|plant| plant.id() == id)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const KNOWN: Known = Known {
        mass: true,
        rest: true,
    };
    const SIZES: Sizes = Sizes {
        stiffness: 60e3,
        damping: 500.0,
        mass: 20.0,
        acceleration: 4.0,
        height: 2e-3,
        velocity: 0.1,
        slack: 7.0,
        most: [9e5, 900.0],
    };

    #[test]
    fn every_plant_is_found_by_its_name() {
        for plant in ALL {
            assert_eq!(by_id(plant.id()).unwrap().id(), plant.id());
            let names: Vec<_> = plant.quantities().iter().map(|q| q.name).collect();
            let mut apart = names.clone();
            apart.dedup();
            assert!(!names.is_empty() && apart == names, "{names:?}");
        }
        assert!(by_id("unicycle").is_none());
    }

    #[test]
    fn a_fit_moves_what_is_not_known() {
        let free = |plant: &dyn Plant, known| Coefficient::ALL.map(|n| plant.is_free(n, known));
        assert_eq!(
            free(&Axle::MOVING, KNOWN),
            [true, true, false, false, true, true]
        );
        assert_eq!(
            free(&Damper::MOVING, KNOWN),
            [false, true, false, false, true, true]
        );
        assert_eq!(
            free(&Axle::DRIVEN, KNOWN),
            [true, true, false, false, false, false]
        );
        let unknown = Known {
            mass: false,
            rest: false,
        };
        assert_eq!(free(&Axle::MOVING, unknown), [true; 6]);
    }

    #[test]
    fn only_what_moves_has_limits_to_stiffness_and_damping() {
        let [moving, driven] = [&Axle::MOVING, &Axle::DRIVEN].map(|plant| {
            [Coefficient::Kappa, Coefficient::Beta].map(|number| plant.range(number, &SIZES))
        });
        assert_eq!(moving, [(300.0, [-7.0, 9e5]), (2.5, [-900.0, 900.0])]);
        let free = [f64::NEG_INFINITY, f64::INFINITY];
        assert_eq!(driven, [(300.0, free), (2.5, free)]);
    }

    #[test]
    fn springs_and_masses_are_taken_away_in_any_order() {
        let bench = Axle::MOVING.driven().unwrap().without_spring().unwrap();
        let same = Axle::MOVING.without_spring().unwrap().driven().unwrap();
        assert_eq!(bench.id(), same.id());
        assert!(!bench.moves() && !bench.has_spring());
    }
}
