//! The sizes of a ride from which effects take their starts and limits.

use std::sync::Arc;

use super::own::OwnLaw;

/// Typical sizes on one axle, by the plain fit.
#[derive(Clone, Debug)]
pub struct Scale {
    pub mass: f64,
    /// Plain stiffness (N/m) and damping (N s/m).
    pub k: f64,
    pub b: f64,
    /// Deflection d = u - z and its rate by the plain model: RMS, lowest, highest (m, m/s).
    pub d_rms: f64,
    pub d_low: f64,
    pub d_high: f64,
    pub d_peak: f64,
    pub w_rms: f64,
    pub z_rms: f64,
    pub v_rms: f64,
    /// RMS of the acceleration by the plain model (m/s^2).
    pub a_rms: f64,
    /// Length of the fitted part and of the whole ride, and the sample interval (s).
    pub train_s: f64,
    pub duration: f64,
    pub step: f64,
    /// NaN where unknown.
    pub static_load: f64,
    pub wheel_radius: f64,
    /// Mean speed and spread of the speed (m/s).
    pub mean_speed: f64,
    pub speed_span: f64,
    /// Distance of the fitted part (m).
    pub train_distance: f64,
    /// Force on this axle per height of the centre of gravity and acceleration: +-m/L (kg/m).
    pub lift: f64,
    /// m l_F l_R (kg m^2).
    pub balanced_pitch_inertia: f64,
    /// The user's own law.
    pub own: Option<Arc<OwnLaw>>,
}

impl Scale {
    /// A bicycle of no particular ride, for what does not depend on one.
    pub const TYPICAL: Scale = Scale {
        mass: 30.0,
        k: 60e3,
        b: 500.0,
        d_rms: 1e-3,
        d_low: -3e-3,
        d_high: 3e-3,
        d_peak: 3e-3,
        w_rms: 0.1,
        z_rms: 1e-3,
        v_rms: 0.1,
        a_rms: 5.0,
        train_s: 60.0,
        duration: 100.0,
        step: 5e-3,
        static_load: 300.0,
        wheel_radius: 0.34,
        mean_speed: 5.0,
        speed_span: 1.0,
        train_distance: 300.0,
        lift: 30.0,
        balanced_pitch_inertia: 10.0,
        own: None,
    };

    /// RMS of the net force on the axle mass (N), from which forces take their sizes.
    pub fn force_rms(&self) -> f64 {
        self.mass * self.a_rms
    }

    /// Stiffness (N/m) and damping (N s/m) whose forces are a tenth of what is felt: as good as none.
    pub fn as_good_as_none(&self) -> [f64; 2] {
        [self.d_rms, self.w_rms].map(|rms| 0.1 * self.force_rms() / rms)
    }

    /// A positive stiffness to measure others by, also where the plain one is near zero.
    pub fn k_size(&self) -> f64 {
        self.k.abs().max(0.1 * self.force_rms() / self.d_rms)
    }

    /// A positive damping to measure others by.
    pub fn b_size(&self) -> f64 {
        self.b.abs().max(0.02 * self.force_rms() / self.w_rms)
    }

    /// Period of the undamped axle (s), within what the ride can show.
    pub fn period(&self) -> f64 {
        let period =
            std::f64::consts::TAU * (self.mass / self.k.abs().max(f64::MIN_POSITIVE)).sqrt();
        period.clamp(4.0 * self.step, 0.5 * self.train_s)
    }

    /// Change of the relative rolling radius that turns the wheel's phase by a radian over the
    /// fitted part.
    pub fn radius_step(&self) -> f64 {
        (self.wheel_radius / self.train_distance.max(10.0 * self.wheel_radius)).clamp(1e-4, 0.03)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TAU: f64 = std::f64::consts::TAU;

    #[test]
    fn a_period_is_that_of_the_mass_on_its_spring_within_what_a_ride_shows() {
        let period = |k: f64| {
            let scale = Scale {
                mass: 25.0,
                k,
                ..Scale::TYPICAL
            };
            scale.period()
        };
        for natural in [0.1, 2.0] {
            let k = 25.0 * (TAU / natural).powi(2);
            assert!((period(k) / natural - 1.0).abs() < 1e-12);
            assert_eq!(period(-k), period(k));
        }
        let Scale { step, train_s, .. } = Scale::TYPICAL;
        assert_eq!([period(1e12), period(0.0)], [4.0 * step, 0.5 * train_s]);
    }

    #[test]
    fn a_size_is_the_plain_one_or_what_is_felt_at_least() {
        let sizes = |k: f64, b: f64| {
            let scale = Scale {
                k,
                b,
                ..Scale::TYPICAL
            };
            [scale.k_size(), scale.b_size()]
        };
        assert_eq!(sizes(-60e3, -500.0), [60e3, 500.0]);
        // Forces of which a tenth and a fiftieth are felt: m a = 30 kg x 5 m/s^2, over 1 mm and 0.1 m/s.
        let felt = 30.0 * 5.0;
        let [k, b] = sizes(0.0, 0.0);
        assert!((k - 0.1 * felt / 1e-3).abs() < 1e-9 && (b - 0.02 * felt / 0.1).abs() < 1e-9);
        let [none, _] = Scale::TYPICAL.as_good_as_none();
        assert!((none - k).abs() < 1e-9);
    }

    #[test]
    fn a_radius_off_by_a_step_turns_the_wheel_by_a_radian_over_the_ride() {
        let step = |distance: f64| {
            let scale = Scale {
                wheel_radius: 0.34,
                train_distance: distance,
                ..Scale::TYPICAL
            };
            scale.radius_step()
        };
        // Over x the wheel turns by x / r, and by x / r times the step less on a larger one.
        assert!((step(300.0) * 300.0 / 0.34 - 1.0).abs() < 1e-12);
        assert_eq!([step(0.0), step(1e9)], [0.03, 1e-4]);
    }
}
