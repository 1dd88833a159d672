//! A spring and a damper between road and mass: paper eq. (1).

use super::quantity::{DAMPING, DAMPING_RATIO, MASS, NATURAL_FREQUENCY, STIFFNESS};
use super::{Damper, Plant, Quantity};

/// An axle of a bicycle, or a bench with a spring.
#[derive(Debug)]
pub struct Axle {
    moves: bool,
}

impl Axle {
    /// Its mass moves.
    pub const MOVING: Axle = Axle { moves: true };
    /// A rig prescribes the motion.
    pub const DRIVEN: Axle = Axle { moves: false };
}

impl Plant for Axle {
    fn id(&self) -> &'static str {
        match self.moves {
            true => "axle",
            false => "driven_axle",
        }
    }

    fn quantities(&self) -> &'static [Quantity] {
        match self.moves {
            true => &[STIFFNESS, DAMPING, MASS, NATURAL_FREQUENCY, DAMPING_RATIO],
            false => &[STIFFNESS, DAMPING],
        }
    }

    fn moves(&self) -> bool {
        self.moves
    }

    fn without_spring(&self) -> Option<&'static dyn Plant> {
        Some(match self.moves {
            true => &Damper::MOVING,
            false => &Damper::DRIVEN,
        })
    }

    fn driven(&self) -> Option<&'static dyn Plant> {
        Some(&Self::DRIVEN)
    }
}
