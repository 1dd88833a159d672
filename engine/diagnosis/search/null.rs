//! What the best of many offers gains on pure noise: the family-wise null of the search.

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::score_test::Signatures;
use crate::numerics::projection::dot;
use crate::numerics::random::normal;
use crate::report::diagnosis::Place;

/// Replicates of the largest gain.
const REPLICATES: usize = 2000;
/// Least p value that these can tell; no other test here is good for less.
pub const FINEST: f64 = 1.0 / (1 + REPLICATES) as f64;

/// Added to the diagonal so that directions that lie in each other's span do no harm.
const RIDGE: f64 = 1e-6;

/// Sorted gains of the best offer on white-noise residuals.
///
/// The score of a white residual along each offer's directions is normal with the directions' own
/// inner products as its covariance, so it is drawn without drawing the residual.
pub struct Null {
    gains: Vec<f64>,
}

impl Null {
    pub fn new(offers: &[Signatures], seed: u64, round: usize) -> Self {
        let starts: Vec<&Vec<Vec<f64>>> = offers
            .iter()
            .flat_map(|o| o.starts.iter().map(|p| &p.basis))
            .collect();
        let directions: Vec<(Place, &[f64])> = offers
            .iter()
            .flat_map(|o| o.starts.iter().map(|p| (o.term.place, &p.basis)))
            .flat_map(|(place, basis)| basis.iter().map(move |b| (place, b.as_slice())))
            .collect();
        let n = directions.len();
        let mut inner = DMatrix::identity(n, n) * (1.0 + RIDGE);
        for i in 0..n {
            for j in 0..i {
                inner[(i, j)] = overlap(directions[i], directions[j]);
            }
        }
        let root = inner.cholesky().map_or(DMatrix::identity(n, n), |c| c.l());
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(round as u64 + 1);
        let mut gains: Vec<f64> = (0..REPLICATES)
            .map(|_| {
                let scores = &root * DVector::from_fn(n, |_, _| normal(&mut rng));
                let mut at = 0;
                let gain = |basis: &&Vec<Vec<f64>>| {
                    let part = scores.rows(at, basis.len());
                    at += basis.len();
                    0.5 * part.norm_squared()
                };
                starts.iter().map(gain).fold(0.0, f64::max)
            })
            .collect();
        gains.sort_by(f64::total_cmp);
        Self { gains }
    }

    /// Share of white residuals on which the best offer gains as much.
    pub fn p_value(&self, gain: f64) -> f64 {
        let below = self.gains.partition_point(|g| *g < gain);
        (1 + REPLICATES - below) as f64 / (1 + REPLICATES) as f64
    }

    /// Gain that noise alone exceeds with probability `alpha`.
    pub fn bound(&self, alpha: f64) -> f64 {
        let at = ((1.0 - alpha) * REPLICATES as f64) as usize;
        self.gains[at.min(REPLICATES - 1)]
    }
}

/// Inner product of two directions: on one axle, or on both with the front's samples first.
fn overlap(a: (Place, &[f64]), b: (Place, &[f64])) -> f64 {
    let (short, long) = if a.1.len() <= b.1.len() {
        (a, b)
    } else {
        (b, a)
    };
    if short.1.len() < long.1.len() {
        let from = match short.0 {
            Place::Rear => long.1.len() - short.1.len(),
            _ => 0,
        };
        dot(short.1, &long.1[from..from + short.1.len()])
    } else {
        let same = short.0 == long.0 || short.0 == Place::Both || long.0 == Place::Both;
        if same { dot(short.1, long.1) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::effects::Kind;
    use crate::diagnosis::fit::Term;
    use crate::diagnosis::law::MAX_PARAMETERS;
    use crate::diagnosis::search::score_test::Promise;

    fn offer(place: Place, basis: Vec<Vec<f64>>) -> Signatures {
        let start = Promise {
            values: [0.0; MAX_PARAMETERS],
            unit: [0.0; MAX_PARAMETERS],
            size: 1.0,
            gain: 0.0,
            basis,
        };
        let kind = Kind::CubicStiffness;
        Signatures {
            term: Term { kind, place },
            starts: vec![start],
        }
    }

    #[test]
    fn val_one_direction_is_half_a_chi_square() {
        let null = Null::new(&[offer(Place::Front, vec![vec![0.6, 0.8]])], 1, 0);
        // 3.84 and 6.63: 5 % and 1 % of the chi-square distribution with one degree of freedom.
        assert!((null.p_value(0.5 * 3.84) - 0.05).abs() < 0.015);
        assert!((null.bound(0.01) - 0.5 * 6.63).abs() < 0.7);
    }

    #[test]
    fn val_independent_offers_add_their_chances() {
        let offers: Vec<Signatures> = (0..8)
            .map(|i| {
                offer(
                    Place::Front,
                    vec![(0..8).map(|j| f64::from(i == j)).collect()],
                )
            })
            .collect();
        let expected = 1.0 - 0.95_f64.powi(8);
        assert!((Null::new(&offers, 1, 0).p_value(0.5 * 3.84) - expected).abs() < 0.03);
        let twins = [
            offers[0].starts[0].basis.clone(),
            offers[0].starts[0].basis.clone(),
        ];
        let twins = twins.map(|b| offer(Place::Front, b));
        assert!((Null::new(&twins, 1, 0).p_value(0.5 * 3.84) - 0.05).abs() < 0.015);
    }

    #[test]
    fn axles_share_no_samples() {
        let (front, rear) = ([1.0, 0.0], [1.0, 0.0]);
        let both = [0.0, 0.0, 1.0, 0.0];
        assert_eq!(overlap((Place::Front, &front), (Place::Rear, &rear)), 0.0);
        assert_eq!(overlap((Place::Rear, &rear), (Place::Both, &both)), 1.0);
        assert_eq!(overlap((Place::Front, &front), (Place::Both, &both)), 0.0);
    }
}
