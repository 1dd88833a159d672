use super::{Axle, Damper, Plant};

/// Every base model.
static ALL: &[&dyn Plant] = &[
    &Axle::MOVING,
    &Axle::DRIVEN,
    &Damper::MOVING,
    &Damper::DRIVEN,
];

/// The base model of this name.
pub fn by_id(id: &str) -> Option<&'static dyn Plant> {
    ALL.iter().copied().find(|plant| plant.id() == id)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::plant::{Coefficient, Known, Sizes};

    const KNOWN: Known = Known {
        mass: true,
        rest: true,
    };
    const SIZES: Sizes = Sizes {
        stiffness: 60e3,
        damping: 500.0,
        mass: 20.0,
        acceleration: 4.0,
        height: 2e-3,
        velocity: 0.1,
        slack: 7.0,
        most: [9e5, 900.0],
    };

    #[test]
    fn every_plant_is_found_by_its_name() {
        for plant in ALL {
            assert_eq!(by_id(plant.id()).unwrap().id(), plant.id());
            let names: Vec<_> = plant.quantities().iter().map(|q| q.name).collect();
            let mut apart = names.clone();
            apart.dedup();
            assert!(!names.is_empty() && apart == names, "{names:?}");
        }
        assert!(by_id("unicycle").is_none());
    }

    #[test]
    fn a_fit_moves_what_is_not_known() {
        let free = |plant: &dyn Plant, known| Coefficient::ALL.map(|n| plant.is_free(n, known));
        assert_eq!(
            free(&Axle::MOVING, KNOWN),
            [true, true, false, false, true, true]
        );
        assert_eq!(
            free(&Damper::MOVING, KNOWN),
            [false, true, false, false, true, true]
        );
        assert_eq!(
            free(&Axle::DRIVEN, KNOWN),
            [true, true, false, false, false, false]
        );
        let unknown = Known {
            mass: false,
            rest: false,
        };
        assert_eq!(free(&Axle::MOVING, unknown), [true; 6]);
    }

    #[test]
    fn only_what_moves_has_limits_to_stiffness_and_damping() {
        let [moving, driven] = [&Axle::MOVING, &Axle::DRIVEN].map(|plant| {
            [Coefficient::Kappa, Coefficient::Beta].map(|number| plant.range(number, &SIZES))
        });
        assert_eq!(moving, [(300.0, [-7.0, 9e5]), (2.5, [-900.0, 900.0])]);
        let free = [f64::NEG_INFINITY, f64::INFINITY];
        assert_eq!(driven, [(300.0, free), (2.5, free)]);
    }

    #[test]
    fn springs_and_masses_are_taken_away_in_any_order() {
        let bench = Axle::MOVING.driven().unwrap().without_spring().unwrap();
        let same = Axle::MOVING.without_spring().unwrap().driven().unwrap();
        assert_eq!(bench.id(), same.id());
        assert!(!bench.moves() && !bench.has_spring());
    }
}
