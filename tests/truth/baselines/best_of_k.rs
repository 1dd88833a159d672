//! Output error with the plain model, then the best of K extensions, each confirmed on the held-out part, again and again.
//!
//! The extensions enter linearly, by their signatures: the plain model's response to the force that the effect would add.

use super::columns::{Adds, groups};
use super::design::{Design, MOST};
use super::gram::{Gram, Model, to_unit};
use super::signals::Signals;
use crate::chance::Chance;
use crate::outcome::Name;
use crate::refit::fit::{FITTED, GAP_S};

/// Substeps per sample of the signature's integration.
const SUBSTEPS: usize = 8;
/// Samples after which a signature has forgotten its start.
const SETTLED: usize = 200;
/// Contiguous parts of the held-out part, whose gains change their signs together.
const BLOCKS: usize = 16;
const FLIPS: usize = 400;
/// Chance of a name where nothing acts: 5 % over both axles.
const FALSE: f64 = 0.05 / 2.0;

pub fn choose(s: &Signals) -> Vec<Name> {
    let n = s.t.len();
    let cut = (n as f64 * FITTED) as usize;
    let from = cut + (GAP_S / s.dt) as usize;
    if from + BLOCKS > n || cut <= 2 * SETTLED {
        return Vec::new();
    }
    let groups = groups(s, true);
    let mut columns = vec![response(s, &s.deflection()), response(s, &s.rate())];
    if s.u.iter().all(|u| *u == 0.0) {
        columns.push(response(s, &vec![1.0; n]));
    }
    let base = columns.len();
    for group in &groups {
        columns.extend(group.columns.iter().map(|c| match group.adds {
            Adds::Force => response(s, c),
            Adds::Output => c.clone(),
        }));
    }
    to_unit(&mut columns);
    let held_out = Gram::blocks(&columns, &s.residual, from..n, BLOCKS);
    let fitted = vec![Gram::new(&columns, &s.residual, SETTLED..cut)];
    confirmed(&Design::new(groups, base, fitted, s.axle), &held_out)
}

/// Takes the best on the fitted part as long as the held-out part confirms it.
fn confirmed(design: &Design, held_out: &[Gram]) -> Vec<Name> {
    let mut names: Vec<Name> = Vec::new();
    let fitted = &design.blocks[0];
    let Some(mut model) = fitted.fit(&design.plain()) else {
        return names;
    };
    while names.len() < MOST {
        let Some((best, next)) = design.next(fitted, &model.subset, &names) else {
            break;
        };
        let all: Vec<Vec<f64>> = (0..design.groups.len())
            .filter_map(|group| fitted.fit(&design.with(&model.subset, group)))
            .map(|with| gains(held_out, &model, &with))
            .collect();
        if sum(&gains(held_out, &model, &next)) <= by_chance(&all) {
            break;
        }
        names.push(design.name(best));
        model = next;
    }
    names
}

/// What a model leaves less of each block, in units of their root sum of squares.
fn gains(held_out: &[Gram], before: &Model, after: &Model) -> Vec<f64> {
    let gain = |block: &Gram| block.error(before) - block.error(after);
    let each: Vec<f64> = held_out.iter().map(gain).collect();
    let size = each.iter().map(|gain| gain * gain).sum::<f64>().sqrt();
    each.iter().map(|gain| gain / size.max(1e-300)).collect()
}

fn sum(gains: &[f64]) -> f64 {
    gains.iter().sum()
}

/// What the largest gain of all candidates exceeds with the chance [`FALSE`] where the sign of a block is a coin's.
fn by_chance(all: &[Vec<f64>]) -> f64 {
    let chance = &mut Chance::new(1, 0);
    let mut flip = || {
        let signs = [0.0; BLOCKS].map(|_| chance.normal().signum());
        let flipped = |gains: &Vec<f64>| gains.iter().zip(signs).map(|(g, s)| g * s).sum::<f64>();
        all.iter().map(flipped).fold(0.0, f64::max)
    };
    let mut largest: Vec<f64> = (0..FLIPS).map(|_| flip()).collect();
    largest.sort_by(f64::total_cmp);
    largest[((1.0 - FALSE) * FLIPS as f64) as usize]
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

    #[test]
    fn only_a_gain_on_most_blocks_is_more_than_chance() {
        let size = 1.0 / (BLOCKS as f64).sqrt();
        let steady = vec![size; BLOCKS];
        let mixed: Vec<f64> = (0..BLOCKS)
            .map(|i| if i % 3 == 0 { -size } else { size })
            .collect();
        let all = [steady.clone(), mixed.clone()];
        assert!(sum(&steady) > by_chance(&all) && sum(&mixed) < by_chance(&all));
    }
}
