//! Particles that go through the record together.

use super::lanes::Lanes;

/// Vectors that go through the record side by side: enough to hide the latency of a multiply-add,
/// few enough for the registers.
pub const SIDE_BY_SIDE: usize = 2;

/// Room for the costs of a block, whatever the width.
pub const MOST_LANES: usize = 8 * SIDE_BY_SIDE;

/// Coefficients of a block of particles: C numbers each, by coefficient, then by lane.
pub struct Block<const C: usize> {
    rows: [[f64; MOST_LANES]; C],
}

impl<const C: usize> Block<C> {
    /// Lanes beyond the last particle repeat it.
    #[inline(always)]
    pub fn new(
        lanes: usize,
        thetas: &[[f64; 3]],
        coefficients: impl Fn([f64; 3]) -> [f64; C],
    ) -> Self {
        let mut rows = [[0.0; MOST_LANES]; C];
        for lane in 0..lanes {
            let theta = thetas[lane.min(thetas.len() - 1)];
            for (row, c) in rows.iter_mut().zip(coefficients(theta)) {
                row[lane] = c;
            }
        }
        Self { rows }
    }

    /// The vectors of every coefficient.
    #[inline(always)]
    pub fn vectors<L: Lanes>(&self) -> [[L; C]; SIDE_BY_SIDE] {
        std::array::from_fn(|v| std::array::from_fn(|c| L::load(&self.rows[c][v * L::WIDTH..])))
    }
}

/// Writes vectors of costs one after the other.
#[inline(always)]
pub fn unpack<L: Lanes>(vectors: [L; SIDE_BY_SIDE]) -> [f64; MOST_LANES] {
    let mut all = [0.0; MOST_LANES];
    for (v, vector) in vectors.into_iter().enumerate() {
        vector.store(&mut all[v * L::WIDTH..]);
    }
    all
}
