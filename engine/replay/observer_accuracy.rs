use veloid_methods::observer::States;
use veloid_report::ObserverReport;

/// Errors within this many RMS of the ride's second half count as converged.
const CONVERGED: f64 = 6.0;
/// Time (s) for which they have to stay there.
const HOLD_S: f64 = 0.2;

/// How well the observer follows the measurement `y` and its spline derivative `slope`, which has no
/// phase shift; samples not `valid` do not count.
pub fn accuracy(
    states: &States,
    y: &[f64],
    slope: &[f64],
    valid: &[bool],
    step: f64,
    jerk_bound: f64,
) -> ObserverReport {
    let n = y.len();
    let errors: Vec<[f64; 2]> = (0..n)
        .map(|i| {
            if valid[i] {
                [states.position[i] - y[i], states.velocity[i] - slope[i]]
            } else {
                [0.0; 2]
            }
        })
        .collect();
    let settled = rms(&errors[n / 2..]);
    let inside = |e: &[f64; 2]| e.iter().zip(settled).all(|(e, s)| e.abs() <= CONVERGED * s);
    let hold = ((HOLD_S / step).ceil() as usize).clamp(1, n);
    let mut run = 0;
    let converged = errors
        .iter()
        .position(|e| {
            run = if inside(e) { run + 1 } else { 0 };
            run == hold
        })
        .map_or(n / 2, |end| end + 1 - hold);
    let after = &errors[converged..];
    let largest = |q: usize| after.iter().fold(0.0_f64, |m, e| m.max(e[q].abs()));
    let [position_rms_m, velocity_rms_m_s] = rms(after);
    ObserverReport {
        position_max_m: largest(0),
        velocity_max_m_s: largest(1),
        position_rms_m,
        velocity_rms_m_s,
        jerk_bound_m_s3: jerk_bound,
        converged_after_s: converged as f64 * step,
    }
}

fn rms(errors: &[[f64; 2]]) -> [f64; 2] {
    [0, 1].map(|q| {
        let sum: f64 = errors.iter().map(|e| e[q] * e[q]).sum();
        (sum / errors.len().max(1) as f64).sqrt()
    })
}
