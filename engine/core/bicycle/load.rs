//! Wheel load, paper eq. (2).

/// F_n = F_c + k (u - z) + B (u' - z') (N), from the static load `static_load` (N), `deflection` = u - z
/// (m) and `rate` = u' - z' (m/s).
///
/// Like eq. (1) this lets the tyre pull on the road: a negative load says that the wheel would have
/// left the ground.
pub fn wheel_load(static_load: f64, k: f64, b: f64, deflection: f64, rate: f64) -> f64 {
    static_load + k * deflection + b * rate
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bicycle::{Axle, Bike, GRAVITY};

    #[test]
    fn load_at_rest_is_the_weighed_one_and_else_the_weight() {
        let bike = Bike {
            mass_front_kg: Some(23.0),
            mass_rear_kg: Some(63.0),
            static_load_front_n: Some(225.63),
            ..Bike::default()
        };
        let at_rest = |axle| {
            bike.static_load(axle)
                .map(|f| wheel_load(f, 110e3, 1150.0, 0.0, 0.0))
        };
        assert_eq!(at_rest(Axle::Front), Some(225.63));
        assert_eq!(at_rest(Axle::Rear), Some(63.0 * GRAVITY));
    }

    /// The paper's weighed loads 225.63 N and 608.22 N are those of 23.0 and 62.0 kg.
    #[test]
    fn golden_loads_of_the_paper() {
        assert!((225.63 / GRAVITY - 23.0).abs() < 0.05 && (608.22 / GRAVITY - 62.0).abs() < 0.05);
        // 2 mm of compression with the paper's k, closing at 10 mm/s with its B.
        let load = wheel_load(225.63, 110_600.0, 1135.0, 0.002, 0.01);
        assert!((load - (225.63 + 221.2 + 11.35)).abs() < 1e-10);
    }
}
