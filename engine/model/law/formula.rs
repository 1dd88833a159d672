//! What an effect does, written out beside its code: for exports, which simulate it elsewhere.

/// An effect's hooks as expressions in the language of [laws of one's own](super::own); where one is empty the effect does nothing
/// there. They speak of what such laws speak of, of the effect's parameters by the names that the fit knows, of [`SIZES`], and of what
/// [`Law`](veloid_report::simulation::Law) adds.
pub struct Formula {
    /// Comes to the tyre's force (N), which it may name.
    pub tyre: &'static str,
    /// Comes to the other forces on the axle mass (N).
    pub body: &'static str,
    /// The acceleration (m/s^2) in the place of the one without the effect, `acceleration`.
    pub acceleration: &'static str,
    /// The effect's own states, each with its rate.
    pub states: &'static [(&'static str, &'static str)],
    /// Where the road is read: that much earlier (s), averaged over so much to both sides (s), and height (m) and rate (m/s) that
    /// come to it.
    pub shift: &'static str,
    pub half_window: &'static str,
    pub height: &'static str,
    pub slope: &'static str,
    /// What the displacement sensor, or the force's, makes of its reading: delay (s), factor, what comes to it, and time constant (s) of
    /// the lag with which it follows.
    pub delay: &'static str,
    pub gain: &'static str,
    pub offset: &'static str,
    pub lag: &'static str,
    /// Names of values beyond the fitted parameters: choices.
    pub choices: &'static [&'static str],
}

impl Formula {
    pub const NONE: Formula = Formula {
        tyre: "",
        body: "",
        acceleration: "",
        states: &[],
        shift: "",
        half_window: "",
        height: "",
        slope: "",
        delay: "",
        gain: "",
        offset: "",
        lag: "",
        choices: &[],
    };
}

/// Sizes of the ride that formulas may name: RMS of deflection (m) and of its rate (m/s), mean speed (m/s), radius of the wheel (m), and
/// force on the axle per height of the centre of gravity and acceleration (kg/m).
pub const SIZES: [&str; 5] = ["d_rms", "w_rms", "mean_speed", "wheel_radius", "lift"];
