//! Records for tests, here and in the crates above.

/// White noise of deviation 1.
pub fn white(n: usize, mut state: u64) -> Vec<f64> {
    let mut uniform = || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..n)
        .map(|_| (0..12).map(|_| uniform()).sum::<f64>() - 6.0)
        .collect()
}

/// Displacement of an axle at 3 Hz, damping ratio 0.3, under a white force.
pub fn shaken(n: usize, seed: u64) -> Vec<f64> {
    let (step, kappa, beta) = (0.01, 355.0, 11.3);
    let (mut z, mut v) = (0.0, 0.0);
    white(n, seed)
        .iter()
        .map(|f| {
            v += step * (f - kappa * z - beta * v);
            z += step * v;
            z
        })
        .collect()
}
