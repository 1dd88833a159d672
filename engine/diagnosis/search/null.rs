//! What the best of many offers gains on pure noise: the family-wise null of the search.

use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::score_test::Signatures;
use veloid_core::numerics::lanes::{LANES, Lanes, widest};
use veloid_core::numerics::projection::{dot, dots};
use veloid_core::numerics::random::normal;
use veloid_report::diagnosis::Place;

/// Replicates of the largest gain, a multiple of [`LANES`].
const REPLICATES: usize = 2000;
/// Least p value that these can give; no other test here is good for less.
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
        let inner = inner_products(&directions) + DMatrix::identity(n, n) * RIDGE;
        let root = inner.cholesky().map_or(DMatrix::identity(n, n), |c| c.l());
        // Its rows up to the diagonal, one after the other.
        let rows: Vec<f64> = (0..n)
            .flat_map(|i| (0..=i).map(move |j| (i, j)))
            .map(|at| root[at])
            .collect();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(round as u64 + 1);
        let sizes: Vec<usize> = starts.iter().map(|basis| basis.len()).collect();
        let drawn: Vec<Vec<Lanes>> = (0..REPLICATES / LANES)
            .map(|_| white(n, &mut rng))
            .collect();
        let mut gains: Vec<f64> = (drawn.par_iter())
            .flat_map_iter(|drawn| best_gains(&rows, &sizes, drawn).0)
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

/// Eight replicates of `n` independent scores.
fn white(n: usize, rng: &mut ChaCha8Rng) -> Vec<Lanes> {
    let mut scores = vec![Lanes::ZERO; n];
    for lane in 0..LANES {
        scores.iter_mut().for_each(|s| s.0[lane] = normal(rng));
    }
    scores
}

/// The largest gain of all starts, which have so many directions each, when the rows of a lower triangular matrix mix what was
/// drawn.
fn best_gains(rows: &[f64], sizes: &[usize], drawn: &[Lanes]) -> Lanes {
    widest(
        #[inline(always)]
        || {
            let (mut row, mut i) = (0, 0);
            let mut best = Lanes::ZERO;
            for size in sizes {
                let mut gain = Lanes::ZERO;
                for _ in 0..*size {
                    let mut score = Lanes::ZERO;
                    for (factor, drawn) in rows[row..].iter().zip(&drawn[..=i]) {
                        score += *drawn * *factor;
                    }
                    gain += score * score;
                    i += 1;
                    row += i;
                }
                best = best.max(gain * 0.5);
            }
            best
        },
    )
}

/// Samples on which all inner products are summed before the next ones are read: what they need stays in the cache.
const AT_ONCE: usize = 256;

/// Inner products of directions, on and below the diagonal: on one axle, or on both with the front's samples first.
fn inner_products(directions: &[(Place, &[f64])]) -> DMatrix<f64> {
    let samples = |(place, x): &(Place, &[f64])| match place {
        Place::Both => x.len() / 2,
        Place::Front | Place::Rear => x.len(),
    };
    let samples = directions.iter().map(samples).min().unwrap_or(0);
    let on = |axle| of_axle(directions, axle, samples);
    let (front, rear) = rayon::join(|| on(Place::Front), || on(Place::Rear));
    front + rear
}

/// The part of the inner products that is summed over one axle's samples.
fn of_axle(directions: &[(Place, &[f64])], axle: Place, samples: usize) -> DMatrix<f64> {
    let mut parts: Vec<(usize, &[f64])> = Vec::new();
    for (i, (place, x)) in directions.iter().enumerate() {
        match place {
            Place::Both if axle == Place::Front => parts.push((i, &x[..samples])),
            Place::Both => parts.push((i, &x[samples..])),
            Place::Front | Place::Rear if *place == axle => parts.push((i, x)),
            Place::Front | Place::Rear => {}
        }
    }
    let mut inner = DMatrix::zeros(directions.len(), directions.len());
    for start in (0..samples).step_by(AT_ONCE) {
        let here = start..samples.min(start + AT_ONCE);
        for (at, (i, x)) in parts.iter().enumerate() {
            let x = &x[here.clone()];
            let (fours, rest) = parts[..=at].as_chunks::<4>();
            for four in fours {
                let products = dots(x, four.map(|(_, y)| &y[here.clone()]));
                for ((j, _), product) in four.iter().zip(products) {
                    inner[(*i, *j)] += product;
                }
            }
            for (j, y) in rest {
                inner[(*i, *j)] += dot(x, &y[here.clone()]);
            }
        }
    }
    inner
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::score_test::Prediction;
    use veloid_model::effects::Kind;
    use veloid_model::fit::Term;
    use veloid_model::law::MAX_PARAMETERS;

    fn offer(place: Place, basis: Vec<Vec<f64>>) -> Signatures {
        let start = Prediction {
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
            given: 1,
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
        let (front, rear, both) = ([1.0, 0.0], [1.0, 0.0], [0.0, 0.0, 1.0, 0.0]);
        let directions: [(Place, &[f64]); 3] = [
            (Place::Front, &front),
            (Place::Rear, &rear),
            (Place::Both, &both),
        ];
        let inner = inner_products(&directions);
        assert_eq!(
            [inner[(1, 0)], inner[(2, 0)], inner[(2, 1)]],
            [0.0, 0.0, 1.0]
        );
    }
}
