//! The numbers that decide.

use crate::policy;

/// As in [`policy`] unless stored scores are judged by others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numbers {
    pub support: f64,
    /// Share that a name must take, and one that a law without a name must take beyond every name.
    pub share: f64,
    /// Whether a road is ridden: there nearest shapes of what is none of the library's do not tie, and a general law does not speak for a
    /// name.
    pub is_ridden: bool,
    pub nameless_share: f64,
    /// Share that an effect of a sensor must take.
    pub strict_share: f64,
    pub floor: f64,
    pub patience: f64,
    pub occam: f64,
    pub quiet: f64,
    pub outgrows: f64,
}

impl Numbers {
    /// Those of a ride without a road: the noise is what the best set leaves, so that a share of it says nothing, and every nat counts.
    pub fn without_road() -> Self {
        Self {
            share: 0.0,
            strict_share: 0.0,
            nameless_share: 0.0,
            is_ridden: true,
            floor: 0.0,
            patience: f64::INFINITY,
            occam: 2.0 * policy::OCCAM,
            ..Self::default()
        }
    }

    /// Those of a ride, where a nearest shape takes much of what is none of the library's.
    pub fn on_road() -> Self {
        Self {
            share: policy::STRICT_SHARE,
            is_ridden: true,
            ..Self::default()
        }
    }
}

impl Default for Numbers {
    fn default() -> Self {
        Self {
            support: policy::SUPPORT,
            share: policy::SHARE,
            is_ridden: false,
            nameless_share: policy::SHARE,
            strict_share: policy::STRICT_SHARE,
            floor: policy::FLOOR,
            patience: policy::PATIENCE,
            occam: policy::OCCAM,
            quiet: policy::QUIET,
            outgrows: policy::OUTGROWS,
        }
    }
}
