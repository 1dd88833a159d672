//! What is unusual of a ride.

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Circumstance {
    /// 1 to 1.5 m/s.
    Walking,
    /// A log of 20 Hz.
    Slow,
    /// A log of 500 Hz.
    Fast,
    /// 10 s.
    Short,
    /// 10 min.
    Long,
    /// The log has the front axle alone.
    FrontAlone,
    /// The log has the rear axle alone.
    RearAlone,
    /// Displacements saturate at a level that 3 % of the samples reach.
    Clipped,
    /// Masses in the bike file are 10 % off and declared with a standard deviation of 10 %.
    MassDeclared,
    /// Masses in the bike file are 10 % off, and nothing says so.
    MassWrong,
    /// 300 to 800 kN/m.
    Stiff,
    /// Sensors without noise.
    Noiseless,
    /// The road moves the axles up to nearly half the rate, as accelerometers need it.
    Rough,
}

impl Circumstance {
    pub fn name(self) -> &'static str {
        match self {
            Circumstance::Walking => "walking",
            Circumstance::Slow => "slow",
            Circumstance::Fast => "fast",
            Circumstance::Short => "short",
            Circumstance::Long => "long",
            Circumstance::FrontAlone => "front_alone",
            Circumstance::RearAlone => "rear_alone",
            Circumstance::Clipped => "clipped",
            Circumstance::MassDeclared => "mass_wrong_declared",
            Circumstance::MassWrong => "mass_wrong",
            Circumstance::Stiff => "stiff",
            Circumstance::Noiseless => "noiseless",
            Circumstance::Rough => "rough",
        }
    }

    /// The only axle that the log has.
    pub fn alone(self) -> Option<usize> {
        match self {
            Circumstance::FrontAlone => Some(0),
            Circumstance::RearAlone => Some(1),
            _ => None,
        }
    }

    pub fn has_wrong_mass(self) -> bool {
        matches!(self, Circumstance::MassDeclared | Circumstance::MassWrong)
    }
}
