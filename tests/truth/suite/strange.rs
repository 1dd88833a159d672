//! Sizes of the physics outside the library: each made strong enough to be seen.

mod around;
mod known;
mod memory;
mod plain;

pub use around::Around;

use crate::chance::Chance;
use crate::simulate::outside::{Outside, Strange};

/// Draws one strange law; every kind has one.
pub fn draw(kind: Strange, axle: usize, around: &Around, chance: &mut Chance) -> Option<Outside> {
    let law = known::draw(kind, around, chance)
        .or_else(|| plain::draw(kind, around, chance))
        .or_else(|| memory::draw(kind, around, chance))?;
    Some(Outside {
        kind,
        axle,
        values: law.values,
        events: law.events,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::contact::Contact;
    use crate::simulate::vehicle::Bike;
    use crate::suite::sizes::Scale;

    const STEP_S: f64 = 1.0 / 8000.0;

    fn bike() -> Bike {
        Bike {
            mass_kg: [30.0, 60.0],
            arm_m: [0.7, 0.35],
            wheel_radius_m: [0.34; 2],
            stiffness_n_m: [1e5; 2],
            damping_n_s_m: [500.0; 2],
        }
    }

    /// What 20 s of two sines (3.1 and 8.3 Hz, 1.5 mm rms) are to the axle at `t`.
    fn contact(t: f64) -> Contact {
        let (slow, fast) = (std::f64::consts::TAU * 3.1, std::f64::consts::TAU * 8.3);
        let d = 1.5e-3 * ((slow * t).sin() + (fast * t).sin());
        let w = 1.5e-3 * (slow * (slow * t).cos() + fast * (fast * t).cos());
        Contact {
            t,
            x: 5.0 * t,
            speed: 5.0,
            crank: 9.0 * t,
            d,
            w,
            z: 2e-3 * (slow * t + 1.0).sin() - 1e-3 * (fast * t - 0.5).sin(),
            z_rate: 2e-3 * slow * (slow * t + 1.0).cos() - 1e-3 * fast * (fast * t - 0.5).cos(),
            other_d: 1.5e-3 * (33.0 * t).sin(),
            k: 1e5,
            b: 500.0,
        }
    }

    fn scale() -> Scale {
        let moments = || (0..8000).map(|i| contact(2.5e-3 * i as f64));
        let rms = |of: fn(&Contact) -> f64| {
            let sum: f64 = moments().map(|c| of(&c).powi(2)).sum();
            (sum / 8000.0).sqrt()
        };
        Scale {
            deflection_m: [rms(|c| c.d); 2],
            rate_m_s: [rms(|c| c.w); 2],
            fastest_m_s: 5.0,
            mean_speed_m_s: 5.0,
            duration_s: 20.0,
            noise_m: 1e-4,
        }
    }

    /// The force of a law at every hundredth step, with deflection and rate.
    fn forces(law: &Outside) -> Vec<[f64; 3]> {
        let mut states = vec![0.0; law.kind.states()];
        let mut rows = Vec::new();
        for i in 0..160_000 {
            let c = contact(STEP_S * i as f64);
            let mut rate = vec![0.0; states.len()];
            let force = law.force(&c, &states, &mut rate);
            let step = states.iter_mut().zip(rate);
            step.for_each(|(s, rate)| *s += STEP_S * rate);
            if i % 100 == 0 {
                rows.push([force, c.d, c.w]);
            }
        }
        rows
    }

    /// Root mean square of what no k and B explain, N.
    fn unexplained(rows: &[[f64; 3]]) -> f64 {
        let sum = |a: usize, b: usize| rows.iter().map(|r| r[a] * r[b]).sum::<f64>();
        let det = sum(1, 1) * sum(2, 2) - sum(1, 2).powi(2);
        let k = (sum(0, 1) * sum(2, 2) - sum(0, 2) * sum(1, 2)) / det;
        let b = (sum(0, 2) * sum(1, 1) - sum(0, 1) * sum(1, 2)) / det;
        let left = rows.iter().map(|r| (r[0] - k * r[1] - b * r[2]).powi(2));
        (left.sum::<f64>() / rows.len() as f64).sqrt()
    }

    #[test]
    fn every_law_is_bounded_and_seen_at_every_size() {
        let (bike, scale) = (bike(), scale());
        for kind in Strange::all() {
            for size in 0..3 {
                let around = Around::new(0, size, 1.0, &bike, &scale);
                let law = draw(kind, 0, &around, &mut Chance::new(3, 0));
                let rows = forces(&law.expect("every kind has a law"));
                let largest = rows.iter().map(|r| r[0].abs()).fold(0.0, f64::max);
                let share = unexplained(&rows) / around.load;
                let id = kind.id();
                assert!(largest < 30.0 * around.load, "{id}: {largest} N");
                assert!(share > 0.02, "{id}, size {size}: {share} of the load");
            }
        }
    }

    #[test]
    fn larger_sizes_are_stronger() {
        let (bike, scale) = (bike(), scale());
        for kind in Strange::OPEN.into_iter().chain(Strange::KEPT_BACK) {
            let [small, large] = [0, 2].map(|size| {
                let around = Around::new(0, size, 1.0, &bike, &scale);
                let law = draw(kind, 0, &around, &mut Chance::new(3, 0));
                unexplained(&forces(&law.expect("every kind has a law")))
            });
            assert!(large > 1.3 * small, "{}: {small} and {large} N", kind.id());
        }
    }
}
