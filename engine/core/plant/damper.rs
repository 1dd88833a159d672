//! A damper alone: a drive, a sled, a shock absorber on a bench.

use super::quantity::{DAMPING, MASS};
use super::{Plant, Quantity};

/// A mass on a damper, or a damper that a rig moves.
#[derive(Debug)]
pub struct Damper {
    moves: bool,
}

impl Damper {
    /// Its mass moves.
    pub const MOVING: Damper = Damper { moves: true };
    /// A rig prescribes the motion.
    pub const DRIVEN: Damper = Damper { moves: false };
}

impl Plant for Damper {
    fn id(&self) -> &'static str {
        match self.moves {
            true => "damper",
            false => "driven_damper",
        }
    }

    fn quantities(&self) -> &'static [Quantity] {
        match self.moves {
            true => &[DAMPING, MASS],
            false => &[DAMPING],
        }
    }

    fn moves(&self) -> bool {
        self.moves
    }

    fn has_spring(&self) -> bool {
        false
    }

    fn driven(&self) -> Option<&'static dyn Plant> {
        Some(&Self::DRIVEN)
    }
}
