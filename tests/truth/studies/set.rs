//! Kinds of sets: several rides of one bicycle on different roads, at different speeds, with different noise.

use crate::chance::Chance;
use crate::simulate::vehicle::Bike;
use crate::trial::plan::{self, Plan};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Clean,
    /// Half as large as one ride shows.
    Weak,
    /// Three times as large as one ride shows.
    Ordinary,
    /// Logs of 20 to 40 Hz.
    Slow,
    Accelerometers,
    /// 20 to 60 N s/m.
    LightlyDamped,
    /// Both axles have the same mass, stiffness and damping.
    Alike,
    /// The stiffness of one axle changes between two rides.
    Groups,
}

impl Kind {
    pub const ALL: [Kind; 8] = [
        Kind::Clean,
        Kind::Weak,
        Kind::Ordinary,
        Kind::Slow,
        Kind::Accelerometers,
        Kind::LightlyDamped,
        Kind::Alike,
        Kind::Groups,
    ];

    /// As files are named, and in words.
    pub fn names(self) -> [&'static str; 2] {
        match self {
            Kind::Clean => ["clean", "clean"],
            Kind::Weak => ["weak", "an effect of 0.5 of what one ride shows"],
            Kind::Ordinary => ["ordinary", "an effect of 3 times what one ride shows"],
            Kind::Slow => ["slow", "20 to 40 Hz"],
            Kind::Accelerometers => ["accelerometers", "accelerometers only"],
            Kind::LightlyDamped => ["light", "lightly damped axles"],
            Kind::Alike => ["alike", "alike axles"],
            Kind::Groups => ["groups", "two groups with another k on one axle"],
        }
    }

    /// Size of the effect, in sizes that one ride shows.
    pub fn times(self) -> Option<f64> {
        match self {
            Kind::Weak => Some(0.5),
            Kind::Ordinary => Some(3.0),
            _ => None,
        }
    }

    /// Plans of two to ten rides, and the axle whose stiffness changes.
    pub fn plans(self, chance: &mut Chance) -> (Vec<Plan>, Option<usize>) {
        let bike = self.bike(chance);
        let least = if self == Kind::Groups { 4 } else { 2 };
        let rides = least + chance.index(11 - least);
        let changed = (self == Kind::Groups).then(|| chance.index(2));
        let other = Bike {
            stiffness_n_m: changed.map_or(bike.stiffness_n_m, |axle| {
                let mut stiffness = bike.stiffness_n_m;
                stiffness[axle] *= chance.pick(&[0.8, 0.9, 1.1, 1.25]);
                stiffness
            }),
            ..bike.clone()
        };
        let rate_hz = match self {
            Kind::Slow => chance.pick(&[20.0, 25.0, 30.0, 40.0]),
            _ => 100.0,
        };
        let plan = |i: usize| {
            let bike = if i < rides / 2 { &bike } else { &other };
            let mut plan = Plan::usual(bike.clone(), chance);
            plan.case.rate_hz = rate_hz;
            plan
        };
        ((0..rides).map(plan).collect(), changed)
    }

    fn bike(self, chance: &mut Chance) -> Bike {
        let damping = match self {
            Kind::LightlyDamped => [20.0, 60.0],
            _ => [200.0, 1200.0],
        };
        let bike = plan::bike([60e3, 150e3], damping, chance);
        match self {
            Kind::Alike => plan::alike(bike),
            _ => bike,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_of_one_bicycle_and_two_groups_differ_on_one_axle() {
        for (i, kind) in Kind::ALL.into_iter().enumerate() {
            let (plans, changed) = kind.plans(&mut Chance::new(2, i as u64));
            assert!((2..=10).contains(&plans.len()));
            let (first, last) = (&plans[0].bike, &plans[plans.len() - 1].bike);
            assert_eq!(first.mass_kg, last.mass_kg);
            assert_eq!(first.damping_n_s_m, last.damping_n_s_m);
            for axle in 0..2 {
                let same = first.stiffness_n_m[axle] == last.stiffness_n_m[axle];
                assert_eq!(same, changed != Some(axle), "{kind:?}");
            }
        }
    }
}
