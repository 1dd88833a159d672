/// What is reported of a plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// Its name, under an axle in a report's `result`.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Which of an estimate's numbers it is.
    pub of: Of,
}

/// What an estimate says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Of {
    /// k.
    Stiffness,
    /// B.
    Damping,
    /// m.
    Mass,
    /// sqrt(k/m)/2pi.
    NaturalFrequency,
    /// B/(2 sqrt(k m)).
    DampingRatio,
}

pub(super) const STIFFNESS: Quantity = Quantity {
    name: "k",
    unit: "N/m",
    of: Of::Stiffness,
};
pub(super) const DAMPING: Quantity = Quantity {
    name: "B",
    unit: "N s/m",
    of: Of::Damping,
};
pub(super) const MASS: Quantity = Quantity {
    name: "mass",
    unit: "kg",
    of: Of::Mass,
};
pub(super) const NATURAL_FREQUENCY: Quantity = Quantity {
    name: "natural_frequency",
    unit: "Hz",
    of: Of::NaturalFrequency,
};
pub(super) const DAMPING_RATIO: Quantity = Quantity {
    name: "damping_ratio",
    unit: "-",
    of: Of::DampingRatio,
};
