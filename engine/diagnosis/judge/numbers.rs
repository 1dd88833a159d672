//! The numbers that decide.

use crate::policy;

/// As in [`policy`] unless stored scores are judged by others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numbers {
    pub support: f64,
    pub share: f64,
    pub floor: f64,
    pub patience: f64,
    pub occam: f64,
    pub quiet: f64,
    pub outgrows: f64,
}

impl Default for Numbers {
    fn default() -> Self {
        Self {
            support: policy::SUPPORT,
            share: policy::SHARE,
            floor: policy::FLOOR,
            patience: policy::PATIENCE,
            occam: policy::OCCAM,
            quiet: policy::QUIET,
            outgrows: policy::OUTGROWS,
        }
    }
}
