//! The swarm itself, paper eqs. (27) to (30): positions in a box, whatever the cost.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// How the swarm moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    pub particles: usize,
    pub iterations: usize,
    /// c1, c2 of eq. (28).
    pub cognitive: f64,
    pub social: f64,
    /// (w_min, w_max) of eq. (29) and (rho_min, rho_max) of eq. (30).
    pub inertia: (f64, f64),
    pub ratio: (f64, f64),
}

/// One axis of the search box; the swarm sees it as 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Axis {
    /// Even in the logarithm; both ends positive.
    Log {
        low: f64,
        high: f64,
    },
    Linear {
        low: f64,
        high: f64,
    },
}

impl Axis {
    /// The value at `x` of [0, 1].
    pub fn at(self, x: f64) -> f64 {
        match self {
            Self::Log { low, high } => low * (x * (high / low).ln()).exp(),
            Self::Linear { low, high } => low + x * (high - low),
        }
    }
}

/// Best cost and best position after each iteration.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CostCurve {
    pub best_cost: Vec<f64>,
    pub best_position: Vec<Vec<f64>>,
}

/// Largest speed, in widths of the box per iteration.
const MOST_SPEED: f64 = 0.5;

/// Minimises a sum of costs, each of which depends on its own coordinates: `groups` holds how many
/// axes each one has, one group after the other. Every group has its own P and G of eq. (28).
///
/// `costs(x, cost)` gets the coordinates of every particle, one particle after the other, and fills in
/// the first group's cost of every particle, then the second's, and so on. `heard(iteration, best
/// cost)` hears the sum of the best costs after each iteration, until it says stop.
///
/// All random numbers are drawn here, one after the other, so that the course depends on the seed
/// alone. A particle that meets a wall stops there. Costs that are not numbers never become best.
pub fn minimise<E>(
    axes: &[Axis],
    groups: &[usize],
    rules: &Rules,
    seed: u64,
    mut costs: impl FnMut(&[f64], &mut [f64]),
    mut heard: impl FnMut(usize, f64) -> Result<(), E>,
) -> Result<CostCurve, E> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = move || random.random::<f64>();
    let (d, particles) = (axes.len(), rules.particles);
    let mut x: Vec<f64> = (0..particles * d).map(|_| uniform()).collect();
    let mut v: Vec<f64> = (0..particles * d)
        .map(|_| (uniform() - 0.5) * MOST_SPEED)
        .collect();
    let mut own_x = x.clone();
    let mut own = vec![f64::INFINITY; particles * groups.len()];
    let mut lead_x = vec![0.5; d];
    let mut lead = vec![f64::INFINITY; groups.len()];
    let mut values = vec![0.0; particles * d];
    let mut cost = vec![0.0; particles * groups.len()];
    let mut course = CostCurve::default();
    let mut delta = 1.0;
    let (w_min, w_max) = rules.inertia;
    for iteration in 0..rules.iterations {
        for (value, (x, axis)) in values.iter_mut().zip(x.iter().zip(axes.iter().cycle())) {
            *value = axis.at(*x);
        }
        costs(&values, &mut cost);
        let mut first = 0;
        for (g, width) in groups.iter().enumerate() {
            for p in 0..particles {
                let (now, at) = (cost[g * particles + p], p * d + first);
                if now < own[g * particles + p] {
                    own[g * particles + p] = now;
                    own_x[at..at + width].copy_from_slice(&x[at..at + width]);
                }
                if now < lead[g] {
                    lead[g] = now;
                    lead_x[first..first + width].copy_from_slice(&x[at..at + width]);
                }
            }
            first += width;
        }
        let best: f64 = lead.iter().sum();
        course.best_cost.push(best);
        let position = lead_x.iter().zip(axes).map(|(x, axis)| axis.at(*x));
        course.best_position.push(position.collect());
        heard(iteration, best)?;

        let w = w_min + delta * (w_max - w_min);
        delta *= rules.ratio.0 + (rules.ratio.1 - rules.ratio.0) * uniform();
        for i in 0..particles * d {
            let to_own = rules.cognitive * uniform() * (own_x[i] - x[i]);
            let to_lead = rules.social * uniform() * (lead_x[i % d] - x[i]);
            v[i] = (w * v[i] + to_own + to_lead).clamp(-MOST_SPEED, MOST_SPEED);
            let moved = x[i] + v[i];
            x[i] = moved.clamp(0.0, 1.0);
            if moved != x[i] {
                v[i] = 0.0;
            }
        }
    }
    Ok(course)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const RULES: Rules = Rules {
        particles: 30,
        iterations: 60,
        cognitive: 1.49618,
        social: 1.49618,
        inertia: (0.3, 0.9),
        ratio: (0.5, 0.8),
    };

    fn bowl(values: &[f64], cost: &mut [f64]) {
        for (c, p) in cost.iter_mut().zip(values.chunks(2)) {
            *c = (p[0].ln() - 3.0).powi(2) + 4.0 * (p[1] - 0.25).powi(2);
        }
    }

    const AXES: [Axis; 2] = [
        Axis::Log {
            low: 1.0,
            high: 400.0,
        },
        Axis::Linear {
            low: -1.0,
            high: 2.0,
        },
    ];

    #[test]
    fn finds_the_bottom_of_a_bowl() {
        for seed in 0..20 {
            let course = minimise(&AXES, &[2], &RULES, seed, bowl, |_, _| Ok::<_, ()>(())).unwrap();
            assert!(*course.best_cost.last().unwrap() < 1e-10);
            assert!(course.best_cost.is_sorted_by(|a, b| a >= b));
            let end = course.best_position.last().unwrap();
            assert!((end[0].ln() - 3.0).abs() < 1e-4 && (end[1] - 0.25).abs() < 1e-4);
        }
    }

    #[test]
    fn the_seed_is_all_that_matters() {
        let run = |seed| minimise(&AXES, &[2], &RULES, seed, bowl, |_, _| Ok::<_, ()>(())).unwrap();
        assert_eq!(run(5), run(5));
        assert_ne!(run(5), run(6));
    }

    #[test]
    fn stops_when_reported_and_never_follows_what_is_no_number() {
        let stopped = minimise(&AXES, &[2], &RULES, 1, bowl, |i, _| {
            if i == 3 { Err(i) } else { Ok(()) }
        });
        assert_eq!(stopped, Err(3));
        let hole = |values: &[f64], cost: &mut [f64]| {
            bowl(values, cost);
            cost[7] = f64::NAN;
        };
        let course = minimise(&AXES, &[2], &RULES, 1, hole, |_, _| Ok::<_, ()>(())).unwrap();
        assert!(*course.best_cost.last().unwrap() < 1e-8);
    }
}
