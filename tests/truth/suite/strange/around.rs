//! What the sizes of a strange law are drawn from, and what is drawn.

use crate::simulate::vehicle::Bike;
use crate::suite::sizes::Scale;

/// The axle on which a law is to be seen.
pub struct Around<'a> {
    pub(super) m: f64,
    pub(super) k: f64,
    pub(super) b: f64,
    /// Deflection (m) and its rate (m/s) on the plain bicycle, root mean square.
    pub(super) d: f64,
    pub(super) w: f64,
    /// Force of spring and damper at those, N.
    pub(super) load: f64,
    pub(super) radius: f64,
    pub(super) strength: f64,
    pub(super) scale: &'a Scale,
}

/// Values and stretches of one law.
pub struct Law {
    pub values: Vec<f64>,
    pub events: Vec<[f64; 3]>,
}

impl Law {
    pub fn of(values: Vec<f64>) -> Self {
        Self::in_stretches(values, Vec::new())
    }

    pub fn in_stretches(values: Vec<f64>, events: Vec<[f64; 3]>) -> Self {
        Self { values, events }
    }
}

impl<'a> Around<'a> {
    /// `size` 0..3 and `boost` (1 or more) enlarge what is drawn.
    pub fn new(axle: usize, size: usize, boost: f64, bike: &Bike, scale: &'a Scale) -> Self {
        let (k, b) = (bike.stiffness_n_m[axle], bike.damping_n_s_m[axle]);
        let (d, w) = (scale.deflection_m[axle], scale.rate_m_s[axle]);
        Self {
            m: bike.mass_kg[axle],
            k,
            b,
            d,
            w,
            load: k * d + b * w,
            radius: bike.wheel_radius_m[axle],
            strength: [0.7, 1.0, 1.5][size] * boost,
            scale,
        }
    }
}
