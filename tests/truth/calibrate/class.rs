//! Classes of clean rides, each unusual in one way.

use crate::chance::Chance;
use crate::suite::case::{Noise, Setting};
use crate::trial::plan::{self, Plan};

pub struct Class {
    /// As files are named.
    pub id: &'static str,
    pub name: &'static str,
    change: Change,
}

enum Change {
    /// Between these (m/s).
    Speed(f64, f64),
    /// The same on a road that ends at [`SIMULATED_PER_M`].
    SmoothRoad(f64, f64),
    RateHz(f64),
    /// Density at 0.1 cycles/m (m^3).
    Road(f64),
    Bench(Setting),
    /// Between these (N/m).
    Stiffness(f64, f64),
}

/// Where the roads of `veloid simulate` end (cycles/m). At walking pace nothing is then faster than a few hertz, and the engine thins
/// the record.
const SIMULATED_PER_M: f64 = 4.0;

const fn class(id: &'static str, name: &'static str, change: Change) -> Class {
    Class { id, name, change }
}

pub const CLASSES: [Class; 20] = [
    class("walking", "1 to 1.5 m/s", Change::Speed(1.05, 1.45)),
    class("speed3", "3 m/s", Change::Speed(3.0, 3.0)),
    class("speed6", "6 m/s", Change::Speed(6.0, 6.0)),
    class("speed12", "12 m/s", Change::Speed(12.0, 12.0)),
    class("rate20", "20 Hz", Change::RateHz(20.0)),
    class("rate50", "50 Hz", Change::RateHz(50.0)),
    class("rate100", "100 Hz", Change::RateHz(100.0)),
    class("rate200", "200 Hz", Change::RateHz(200.0)),
    class("rate500", "500 Hz", Change::RateHz(500.0)),
    class("road_a", "road A", Change::Road(16e-6)),
    class("road_b", "road B", Change::Road(64e-6)),
    class("road_c", "road C", Change::Road(256e-6)),
    class("road_d", "road D", Change::Road(1024e-6)),
    class("road_e", "road E", Change::Road(4096e-6)),
    class("plate", "plate shaker", Change::Bench(Setting::Plate)),
    class("force", "force shaker", Change::Bench(Setting::Shaker)),
    class("release", "release", Change::Bench(Setting::Decay)),
    class("stiff", "300 to 800 kN/m", Change::Stiffness(300e3, 800e3)),
    class("soft", "10 to 40 kN/m", Change::Stiffness(10e3, 40e3)),
    class(
        "smooth_walking",
        "0.8 to 1.5 m/s, road to 4 cycles/m",
        Change::SmoothRoad(0.8, 1.5),
    ),
];

impl Class {
    /// Ride `number` of the class; its kind of noise goes round.
    pub fn plan(&self, number: u64, chance: &mut Chance) -> Plan {
        let stiffness = match self.change {
            Change::Stiffness(low, high) => [low, high],
            _ => [60e3, 150e3],
        };
        let damping = match self.change {
            // A release must still ring in the part that is held out.
            Change::Bench(Setting::Decay) => [5.0, 12.0],
            _ => [200.0, 1200.0],
        };
        let mut plan = Plan::usual(plan::bike(stiffness, damping, chance), chance);
        plan.case.noise = Noise::ALL[number as usize % Noise::ALL.len()];
        match self.change {
            Change::Speed(low, high) => plan.speed_m_s = chance.uniform(low, high),
            Change::SmoothRoad(low, high) => {
                plan.speed_m_s = chance.uniform(low, high);
                plan.highest_per_m = SIMULATED_PER_M;
            }
            Change::RateHz(rate) => plan.case.rate_hz = rate,
            Change::Road(density) => plan.density_m3 = density,
            Change::Bench(setting) => plan.case = plan::clean(setting, plan.case.noise),
            Change::Stiffness(..) => {}
        }
        plan
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_class_is_unusual_in_its_way() {
        let plan = |id: &str| {
            let class = CLASSES.iter().find(|c| c.id == id).expect("a class");
            class.plan(3, &mut Chance::new(1, 0))
        };
        assert_eq!(plan("rate500").case.rate_hz, 500.0);
        assert!(plan("walking").speed_m_s < 1.5);
        let smooth = plan("smooth_walking");
        assert!(smooth.speed_m_s < 1.5 && smooth.highest_per_m == SIMULATED_PER_M);
        assert!(plan("soft").bike.stiffness_n_m.iter().all(|k| *k < 40e3));
        let release = plan("release");
        assert_eq!(release.case.setting, Setting::Decay);
        assert!(release.bike.damping_n_s_m.iter().all(|b| *b < 12.1));
        assert_eq!(release.case.noise, Noise::Road);
    }
}
