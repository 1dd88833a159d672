//! Random numbers: ChaCha's, and normal ones by the ziggurat of `rand_distr`.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// A standard normal number.
pub fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// A source of standard normal numbers.
pub struct Normal(ChaCha8Rng);

impl Normal {
    /// The same seed gives the same numbers.
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// The next one.
    pub fn draw(&mut self) -> f64 {
        normal(&mut self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::statistics::normal_tail;

    /// Shares beyond 0.5, 1, 2 and 3 lie within five standard errors of the normal's tail, on both sides.
    #[test]
    fn tails_are_as_heavy_as_the_normal_ones() {
        const COUNT: usize = 200_000;
        let mut source = Normal::new(7);
        let drawn: Vec<f64> = (0..COUNT).map(|_| source.draw()).collect();
        for at in [0.5, 1.0, 2.0, 3.0] {
            let tail = normal_tail(at);
            let error = (tail * (1.0 - tail) / COUNT as f64).sqrt();
            for sign in [1.0, -1.0] {
                let beyond = drawn.iter().filter(|x| sign * **x > at).count();
                let share = beyond as f64 / COUNT as f64;
                assert!(
                    (share - tail).abs() < 5.0 * error,
                    "{at}: {share} for {tail}"
                );
            }
        }
    }

    #[test]
    fn a_seed_gives_its_own_numbers_again() {
        let draw = |seed| Normal::new(seed).draw().to_bits();
        assert_eq!(draw(3), draw(3));
        assert_ne!(draw(3), draw(4));
    }
}
