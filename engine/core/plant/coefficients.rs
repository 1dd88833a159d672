/// The numbers of a linear plant of one degree of freedom: y'' = kappa (u - y) + beta (u' - y') + per_mass F + constant, from
/// y(0) = height and y'(0) = velocity on; paper eq. (1) for one axle, over its mass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coefficients<T = f64> {
    /// k/m (1/s^2).
    pub kappa: T,
    /// B/m (1/s).
    pub beta: T,
    /// 1/m (1/kg).
    pub per_mass: T,
    /// Constant force over the mass (m/s^2).
    pub constant: T,
    /// Height at the first sample (m).
    pub height: T,
    /// Velocity at the first sample (m/s).
    pub velocity: T,
}

/// One of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Coefficient {
    /// k/m.
    Kappa,
    /// B/m.
    Beta,
    /// 1/m.
    PerMass,
    /// Constant force over the mass.
    Constant,
    /// Height at the first sample.
    Height,
    /// Velocity at the first sample.
    Velocity,
}

impl Coefficient {
    /// All of them, in the order in which fits take them.
    pub const ALL: [Coefficient; 6] = [
        Coefficient::Kappa,
        Coefficient::Beta,
        Coefficient::PerMass,
        Coefficient::Constant,
        Coefficient::Height,
        Coefficient::Velocity,
    ];
    /// Where a motion starts.
    pub const START: [Coefficient; 2] = [Coefficient::Height, Coefficient::Velocity];

    /// Whether it belongs to where a motion starts.
    pub fn is_start(self) -> bool {
        Self::START.contains(&self)
    }
}

impl<T: Copy> Coefficients<T> {
    /// All of them, each by its name.
    pub fn from_fn(mut of: impl FnMut(Coefficient) -> T) -> Self {
        Self {
            kappa: of(Coefficient::Kappa),
            beta: of(Coefficient::Beta),
            per_mass: of(Coefficient::PerMass),
            constant: of(Coefficient::Constant),
            height: of(Coefficient::Height),
            velocity: of(Coefficient::Velocity),
        }
    }

    /// The one of this name.
    pub fn get(&self, number: Coefficient) -> T {
        match number {
            Coefficient::Kappa => self.kappa,
            Coefficient::Beta => self.beta,
            Coefficient::PerMass => self.per_mass,
            Coefficient::Constant => self.constant,
            Coefficient::Height => self.height,
            Coefficient::Velocity => self.velocity,
        }
    }

    /// Gives the one of this name another value.
    pub fn set(&mut self, number: Coefficient, value: T) {
        let place = match number {
            Coefficient::Kappa => &mut self.kappa,
            Coefficient::Beta => &mut self.beta,
            Coefficient::PerMass => &mut self.per_mass,
            Coefficient::Constant => &mut self.constant,
            Coefficient::Height => &mut self.height,
            Coefficient::Velocity => &mut self.velocity,
        };
        *place = value;
    }

    /// The same, starting where another does.
    pub fn starting_as(self, other: &Self) -> Self {
        Self {
            height: other.height,
            velocity: other.velocity,
            ..self
        }
    }
}

impl Coefficients {
    /// Height (m) and velocity (m/s) at the first sample.
    pub fn start(&self) -> [f64; 2] {
        [self.height, self.velocity]
    }

    /// Whether all of them are numbers.
    pub fn is_finite(&self) -> bool {
        Coefficient::ALL.iter().all(|n| self.get(*n).is_finite())
    }

    /// Mass (kg).
    pub fn mass(&self) -> f64 {
        1.0 / self.per_mass
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_number_has_its_own_place() {
        let mut numbers = Coefficients::default();
        for (i, number) in Coefficient::ALL.into_iter().enumerate() {
            numbers.set(number, i as f64);
        }
        assert_eq!(
            Coefficient::ALL.map(|n| numbers.get(n)),
            [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
        );
        assert_eq!(Coefficients::from_fn(|n| numbers.get(n)), numbers);
        let start = Coefficients::default().starting_as(&numbers);
        assert_eq!((start.height, start.velocity, start.kappa), (4.0, 5.0, 0.0));
    }
}
