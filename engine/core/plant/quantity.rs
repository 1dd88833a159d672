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

/// Coefficients of an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Of {
    /// k.
    Stiffness,
    /// B.
    Damping,
    /// m.
    Mass,
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
