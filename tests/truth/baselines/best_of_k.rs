//! Output error with the plain model, then the best of K extensions by a likelihood ratio at 5 %, again and again.
//!
//! The extensions enter linearly, by their signatures: the plain model's response to the force that the effect would add.

use super::columns::{Adds, groups};
use super::gram::Gram;
use super::signals::Signals;
use crate::prove::outcome::Name;

const MOST: usize = 3;
/// 95 % quantiles of chi-square with one and two degrees of freedom.
const CRITICAL: [f64; 2] = [3.841, 5.991];
/// Substeps per sample of the signature's integration.
const SUBSTEPS: usize = 8;
/// Samples after which a signature has forgotten its start.
const SETTLED: usize = 200;

pub fn choose(s: &Signals) -> Vec<Name> {
    let groups = groups(s, true);
    let mut columns = vec![response(s, &s.deflection()), response(s, &s.rate())];
    if s.u.iter().all(|u| *u == 0.0) {
        columns.push(response(s, &vec![1.0; s.t.len()]));
    }
    let base = columns.len();
    let mut index = Vec::new();
    for group in &groups {
        index.push((columns.len()..columns.len() + group.columns.len()).collect::<Vec<_>>());
        columns.extend(group.columns.iter().map(|c| match group.adds {
            Adds::Force => response(s, c),
            Adds::Output => c.clone(),
        }));
    }
    let late: Vec<Vec<f64>> = columns
        .iter()
        .map(|c| c[SETTLED.min(c.len() / 2)..].to_vec())
        .collect();
    let gram = Gram::new(&late, &s.residual[SETTLED.min(s.residual.len() / 2)..]);
    let n = gram.rows as f64;
    let mut subset: Vec<usize> = (0..base).collect();
    let mut names: Vec<Name> = Vec::new();
    while names.len() < MOST {
        let Some((_, before)) = gram.fit(&subset) else {
            break;
        };
        let with = |i: usize| [subset.clone(), index[i].clone()].concat();
        let next = (0..groups.len())
            .filter(|&i| !names.contains(&groups[i].name(s.axle)))
            .filter_map(|i| {
                Some((
                    i,
                    n * (before / gram.fit(&with(i))?.1).ln() / CRITICAL[index[i].len() - 1],
                ))
            })
            .max_by(|a, b| a.1.total_cmp(&b.1));
        match next {
            Some((i, ratio)) if ratio > 1.0 => {
                subset = with(i);
                names.push(groups[i].name(s.axle));
            }
            _ => break,
        }
    }
    names
}

/// The plain axle's motion under an additional force (Newmark, average acceleration, force linear between samples).
fn response(s: &Signals, force: &[f64]) -> Vec<f64> {
    let h = s.dt / SUBSTEPS as f64;
    let stiff = s.mass_kg + 0.5 * h * s.b + 0.25 * h * h * s.k;
    let (mut y, mut v, mut a) = (0.0, 0.0, 0.0);
    let mut out = Vec::with_capacity(force.len());
    for i in 0..force.len() {
        out.push(y);
        let next = force[(i + 1).min(force.len() - 1)];
        for sub in 1..=SUBSTEPS {
            let f = force[i] + (next - force[i]) * sub as f64 / SUBSTEPS as f64;
            let (y_guess, v_guess) = (y + h * v + 0.25 * h * h * a, v + 0.5 * h * a);
            a = (f - s.b * v_guess - s.k * y_guess) / stiff;
            (y, v) = (y_guess + 0.25 * h * h * a, v_guess + 0.5 * h * a);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_response_settles_at_the_static_deflection() {
        let s = Signals {
            mass_kg: 20.0,
            k: 1e5,
            b: 500.0,
            dt: 0.01,
            ..Signals::default()
        };
        let y = response(&s, &vec![50.0; 400]);
        assert!((y[399] - 5e-4).abs() < 1e-9);
    }
}
