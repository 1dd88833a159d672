//! On what a ride is ridden: bicycle, road, speed, and the loggers.

use super::class::Class;
use super::logger::Logger;
use crate::chance::Chance;
use crate::simulate::speed::Profile;
use crate::simulate::tracks::Ground;
use crate::simulate::vehicle::Bike;
use crate::trial::plan;

/// Roads of the classes B, C and D: density at 0.1 cycles/m, m^3.
const ROADS: [f64; 3] = [64e-6, 256e-6, 1024e-6];
const RATES_HZ: [f64; 4] = [100.0, 200.0, 250.0, 500.0];
/// Ratio by which k/m or B/m of the axles differ at least.
const DIFFER: f64 = 1.15;

pub struct Conditions {
    pub duration_s: f64,
    pub ground: Ground,
    pub speed: Profile,
    pub cadence: Profile,
    pub logger: Logger,
}

impl Conditions {
    pub fn draw(class: Class, chance: &mut Chance) -> Self {
        let (density_m3, least_m_s) = match class {
            Class::Lift => (ROADS[2], 7.0),
            _ => (chance.pick(&ROADS), 4.0),
        };
        let duration_s = match chance.happens(0.1) {
            true => 20.0,
            false => chance.log_uniform(60.0, 300.0).round(),
        };
        let base = chance.uniform(least_m_s, 8.0);
        let patch = |chance: &mut Chance| chance.uniform(0.06, 0.1);
        let front = patch(chance);
        let rear = match chance.happens(1.0 / 3.0) {
            true => patch(chance),
            false => front,
        };
        let [low, high] = class.offset_m();
        Self {
            duration_s,
            ground: Ground {
                density_m3,
                patch_m: [front, rear],
                offset_m: [0, 1].map(|_| chance.uniform(low, high)),
            },
            speed: Profile::wobble(base, 0.04 * base, chance),
            cadence: Profile::wobble(chance.uniform(62.0, 92.0), 4.0, chance),
            logger: Logger::draw(chance.pick(&RATES_HZ), chance),
        }
    }
}

/// A bicycle whose axles differ, unless the class is of equal ones.
pub fn bike(class: Class, chance: &mut Chance) -> Bike {
    loop {
        let mut bike = plan::bike([60e3, 150e3], [200.0, 1200.0], chance);
        bike.damping_n_s_m[0] = chance.log_uniform(300.0, 1200.0);
        if class == Class::Equal {
            let mut bike = plan::alike(bike);
            bike.stiffness_n_m[1] *= chance.uniform(0.99, 1.01);
            bike.damping_n_s_m[1] *= chance.uniform(0.99, 1.01);
            return bike;
        }
        if ratios(&bike).into_iter().any(|ratio| ratio >= DIFFER) {
            return bike;
        }
    }
}

/// By which factor k/m and B/m of the axles differ, at least 1.
fn ratios(bike: &Bike) -> [f64; 2] {
    [bike.stiffness_n_m, bike.damping_n_s_m].map(|[front, rear]| {
        let ratio = front / bike.mass_kg[0] / (rear / bike.mass_kg[1]);
        ratio.max(1.0 / ratio)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axles_differ_except_where_they_are_to_be_equal() {
        let chance = &mut Chance::new(1, 0);
        for _ in 0..200 {
            let [k, b] = ratios(&bike(Class::Clean, chance));
            assert!(k >= DIFFER || b >= DIFFER, "{k} {b}");
            let alike = ratios(&bike(Class::Equal, chance));
            assert!(alike.iter().all(|r| *r < 1.011), "{alike:?}");
        }
    }

    #[test]
    fn a_tenth_is_short_and_a_third_has_other_patches() {
        let chance = &mut Chance::new(1, 0);
        let all: Vec<_> = (0..600)
            .map(|_| Conditions::draw(Class::CleanApart, chance))
            .collect();
        let count = |is: &dyn Fn(&Conditions) -> bool| all.iter().filter(|c| is(c)).count();
        assert!((40..80).contains(&count(&|c| c.duration_s == 20.0)));
        assert!((160..240).contains(&count(&|c| c.ground.patch_m[0] != c.ground.patch_m[1])));
        assert!((160..240).contains(&count(&|c| c.logger.speed_m_s > 0.03)));
        let apart = |c: &Conditions| c.ground.offset_m.iter().all(|s| (0.01..0.03).contains(s));
        assert_eq!(count(&apart), 600);
    }
}
