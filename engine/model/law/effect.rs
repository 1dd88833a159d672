//! Where an effect acts on the motion of an axle, and what it may ask there.

use super::limits::{LaneValues, MAX_STATES, States, Values};
use super::scale::Scale;
use super::spec::Spec;
use veloid_core::numerics::lanes::Lanes;

/// Decay of a state in one step that it bears: it would blow up at 2.78.
pub const STABLE: f64 = 1.5;

/// One axle at one instant, for eight parameter sets.
pub struct Motion<'a> {
    /// Deflection across the tyre d = u - z (m) and its rate w (m/s).
    pub d: Lanes,
    pub w: Lanes,
    /// Height (m) and velocity (m/s) of the axle mass.
    pub z: Lanes,
    pub v: Lanes,
    /// k/m (1/s^2), B/m (1/s), 1/m (1/kg).
    pub kappa: Lanes,
    pub beta: Lanes,
    pub per_mass: Lanes,
    /// Time since the first sample (s).
    pub t: f64,
    /// Speed (m/s) and its smoothed rate (m/s^2).
    pub speed: f64,
    pub speed_rate: f64,
    pub crank: Crank,
    /// Distance ridden (m).
    pub distance: f64,
    /// Step of the integrator (s).
    pub step: f64,
    /// Time (s) after which a force is felt in the rate: a step, or never (0) where the motion is prescribed.
    pub felt_after: f64,
    pub scale: &'a Scale,
}

/// The crank at one instant.
#[derive(Clone, Copy)]
pub struct Crank {
    /// Its angle (rad).
    pub angle: f64,
    /// Sine and cosine of twice its angle shortly before, and how far (rad) that has turned since.
    pub before: [f64; 2],
    pub turned: f64,
}

impl Crank {
    /// Sine and cosine of twice the angle.
    #[inline(always)]
    pub fn double(&self) -> [f64; 2] {
        turned(self.before, self.turned)
    }
}

/// Sine and cosine of an angle from those of one that is smaller by `turn` (rad). Small turns, and these are small
/// unless a crank is logged at some 10 Hz, by their series, right to 1e-8.
#[inline(always)]
fn turned([sin, cos]: [f64; 2], turn: f64) -> [f64; 2] {
    let [s, c] = if turn.abs() < 0.5 {
        let q = turn * turn;
        [
            turn * (1.0 - q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0))),
            1.0 - q / 2.0 * (1.0 - q / 12.0 * (1.0 - q / 30.0 * (1.0 - q / 56.0))),
        ]
    } else {
        far(turn)
    };
    [sin * c + cos * s, cos * c - sin * s]
}

/// Apart, since the compiler takes sines for cheap and has them ready at every step.
#[cold]
#[inline(never)]
fn far(turn: f64) -> [f64; 2] {
    turn.sin_cos().into()
}

/// Where an effect reads the road at one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tap {
    /// The road is read `shift` (s) earlier, averaged over `half_window` (s) to both sides.
    pub shift: Lanes,
    pub half_window: Lanes,
    /// Added height (m) and its rate (m/s).
    pub value: Lanes,
    pub slope: Lanes,
}

/// What is known of the sample at which the road is read.
pub struct Spot {
    pub speed: f64,
    /// Distance ridden (m).
    pub distance: f64,
}

/// How the displacement sensor reads, for one parameter set at one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pickup {
    pub delay: f64,
    pub gain: f64,
    pub offset: f64,
    /// Time constant (s) with which the reading follows.
    pub lag: f64,
}

/// The hooks of an effect. Forces are divided by the axle mass (m/s^2).
pub trait Effect {
    const SPEC: Spec;

    /// The tyre's force with this effect, given the force without it.
    #[inline(always)]
    fn tyre(_p: &LaneValues, _m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force
    }

    /// The other forces on the axle mass.
    #[inline(always)]
    fn body(_p: &LaneValues, _m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force
    }

    /// The acceleration, given the force over the axle mass.
    #[inline(always)]
    fn inertia(_p: &LaneValues, _m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force
    }

    /// Rates of the effect's own states.
    #[inline(always)]
    fn rates(_p: &LaneValues, _m: &Motion, _s: &States) -> States {
        [Lanes::ZERO; MAX_STATES]
    }

    #[inline(always)]
    fn road(_p: &LaneValues, _spot: &Spot, _scale: &Scale, _tap: &mut Tap) {}

    fn sensor(_p: &Values, _t: f64, _pickup: &mut Pickup) {}

    /// The values that are reported as these, in the order of the report.
    fn from_reported(reported: &[f64], _scale: &Scale) -> Values {
        as_reported(reported)
    }
}

/// The values of an effect that reports them as they are.
pub fn as_reported(reported: &[f64]) -> Values {
    std::array::from_fn(|i| reported.get(i).copied().unwrap_or(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::padded;

    #[test]
    fn a_crank_turns_as_sine_and_cosine_do_near_and_far() {
        for turn in [0.0, 0.01, -0.3, 0.499, 0.501, -2.0, 9.0] {
            let start: f64 = 0.7;
            let crank = Crank {
                angle: 0.0,
                before: [start.sin(), start.cos()],
                turned: turn,
            };
            let [sin, cos] = crank.double();
            let (true_sin, true_cos) = (start + turn).sin_cos();
            assert!(
                (sin - true_sin).abs() < 2e-8 && (cos - true_cos).abs() < 2e-8,
                "{turn}"
            );
        }
    }

    #[test]
    fn values_that_are_not_reported_are_none() {
        assert_eq!(as_reported(&[3.0, -2.0]), padded([3.0, -2.0]));
    }
}
