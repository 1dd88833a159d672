//! How often noise scores as the best effect of the library does on an axle, without a model of the noise: whitened residuals whose
//! blocks change their signs are as likely as the one that was measured (Good 2005, Permutation, Parametric and Bootstrap Tests of
//! Hypotheses, 3rd ed., ch. 3, doi:10.1007/b138696).

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::null::FINEST;
use super::score_test::Signatures;
use veloid_core::numerics::projection::dot;
use veloid_model::fit::tangent::Tangent;
use veloid_report::diagnosis::Place;

/// Blocks of the fitted part, each longer than what whitening leaves of the noise's memory.
const BLOCKS: usize = 40;

/// What each block of a residual adds to the score of an effect's start, by the columns that span the start.
pub type Scores = Vec<[f64; BLOCKS]>;

/// The scores of effects that act on one axle alone.
pub fn scores(offers: &[Signatures], (place, tangent): (Place, &Tangent)) -> Vec<Scores> {
    let own = offers.iter().filter(|offer| offer.term.place == place);
    // Starts that were sought about the best of a residual would give that one alone a finer look.
    let starts = own.flat_map(|offer| &offer.starts[..offer.given]);
    let by_column = starts.map(|start| {
        let columns = start.basis.iter();
        columns.map(|q| by_block(q, &tangent.residual)).collect()
    });
    by_column.collect()
}

/// p value (0 to 1) of the largest of these scores, less the gain (nats) that what lies between the samples may bring; nothing where
/// there are none.
pub fn chance(starts: &[Scores], unresolved: f64, seed: u64) -> Option<f64> {
    if starts.is_empty() {
        return None;
    }
    let largest = |signs: &[f64; BLOCKS]| {
        let score =
            |columns: &Scores| -> f64 { columns.iter().map(|c| dot(c, signs).powi(2)).sum() };
        starts.iter().map(score).fold(0.0, f64::max)
    };
    let measured = largest(&[1.0; BLOCKS]) - 2.0 * unresolved;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let draws = FINEST.recip() as usize - 1;
    let reached = (0..draws).filter(|_| {
        let signs = std::array::from_fn(|_| if rng.random() { 1.0 } else { -1.0 });
        largest(&signs) >= measured
    });
    Some((1 + reached.count()) as f64 * FINEST)
}

/// Inner product of each block.
fn by_block(q: &[f64], residual: &[f64]) -> [f64; BLOCKS] {
    let n = q.len().min(residual.len());
    std::array::from_fn(|b| {
        let block = b * n / BLOCKS..(b + 1) * n / BLOCKS;
        dot(&q[block.clone()], &residual[block])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;
    use veloid_core::bicycle::Axle;
    use veloid_core::numerics::random::normal;
    use veloid_model::effects::Kind;
    use veloid_model::fit::{COARSE, tangent::tangent_for};

    /// Noise whose deviation grows tenfold along the ride is no effect, and one that goes with an effect is.
    #[test]
    fn val_noise_of_any_loudness_scores_as_often_as_the_p_value_says() {
        let dataset = example::dataset();
        let mut search = example::search(&dataset);
        let kinds = [
            Kind::CubicStiffness,
            Kind::QuadraticDamping,
            Kind::CoulombFriction,
        ];
        search.candidates = kinds.map(|kind| example::term(kind, Axle::Front)).into();
        let offers = search.offers(&search.plain, &[]);
        let term = example::term(Kind::CubicStiffness, Axle::Front);
        let substeps = search.plain.substeps(&dataset, COARSE);
        let mut tangent = tangent_for(&search.fitter, &search.plain, term, substeps);
        let n = tangent.residual.len();
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let (mut below, rides) = (0, 200);
        for ride in 0..rides {
            let loud = |i: usize| 1.0 + 9.0 * i as f64 / n as f64;
            tangent.residual = (0..n).map(|i| loud(i) * normal(&mut rng)).collect();
            let p = chance(&scores(&offers, (Place::Front, &tangent)), 0.0, ride);
            below += usize::from(p.unwrap_or(0.0) < 0.1);
        }
        assert!((8..35).contains(&below), "{below} of {rides} below 0.1");
        let cubic = offers.iter().find(|offer| offer.term == term);
        let direction = &cubic.map(|offer| &offer.starts[0].basis[0]);
        let along = direction.iter().flat_map(|q| q.iter());
        tangent
            .residual
            .iter_mut()
            .zip(along)
            .for_each(|(r, q)| *r += 200.0 * q);
        let scored = scores(&offers, (Place::Front, &tangent));
        let with = |unresolved| chance(&scored, unresolved, 1);
        assert!(with(0.0).is_some_and(|p| p < 0.01));
        // What may come from between the samples is no evidence.
        assert!(with(1e6).is_some_and(|p| p == 1.0));
    }
}
