//! What effects ask of a ride.

/// What a ride must have for an effect to be spoken about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// A road that moves.
    Road,
    Speed,
    VaryingSpeed,
    Cadence,
    /// The masses of both axles and their distances from the centre of gravity.
    Geometry,
    WheelRadius,
    StaticLoad,
    /// A rig that prescribes the motion, whose force is measured.
    PrescribedMotion,
    /// A mass that moves, whose displacement is measured.
    Mass,
    /// A road or a force that drives the axle: in a free decay time, size and the sensor's scale go together.
    Drive,
    /// A spring, or anything else that holds the mass in its place.
    Hold,
}
