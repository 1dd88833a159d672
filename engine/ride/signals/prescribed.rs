//! Whether a mass moves at all: on a rig for dampers or tyres a motor prescribes the motion, and the force answers to it.
//! Told by the force that is measured, in the equation's weak form (smooth windows, integrated by parts, so that no record is
//! differentiated; Shinbrot 1957, Trans. ASME 79:587-603): F = k z + B z' + c, or with m z'' beside them.

use veloid_core::numerics::modulating::{Windows, regress};

/// Halves of the windows (samples), and the fewest windows on either part.
const HALVES: [usize; 6] = [4, 8, 16, 32, 64, 128];
const FEWEST: usize = 20;
/// Share of the windows that is fitted; the rest judges.
const FITTED: f64 = 0.6;
/// Inertia acts if at some width of window it takes off this part of the held-out squares that spring and damper leave. On
/// benches that drive a mass it takes off 77 to 99 % at the best width, on those that prescribe the motion 1 % (../shared/real).
const ACTS: f64 = 0.3;
/// Spring and damper answer to a prescribed motion if they take off this part of the force's held-out squares.
const ANSWERS: f64 = 0.2;
/// Part of the held-out squares below which nothing is left that inertia could take off: rounding.
const NOTHING: f64 = 1e-9;

/// Half of the windows (samples) in which a motion rests or does not, and the part of its RMS rate below which it rests.
const REST_HALF: usize = 16;
const REST: f64 = 0.05;
/// Share of a record in which a motion rests from which that shows something (a sine is so slow for 2 % of the time), and share
/// of the force's changes that fall into it, over its share of the time, from which the force is none that answers: on a
/// rig that holds still it relaxes.
const RESTS: f64 = 0.2;
const CHANGES: f64 = 0.3;

/// How a force belongs to a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// Most and least part of held-out squares that inertia takes off, over the widths.
    pub inertia: f64,
    /// Part of the force's held-out squares that spring and damper take off at the best width.
    pub explained: f64,
    /// Whether the force goes on changing while the motion rests.
    pub sticks: bool,
}

impl Answer {
    /// Whether the force is what a rig without a mass answers with.
    pub fn is_prescribed(&self) -> bool {
        self.inertia < ACTS && self.is_an_answer() && !self.sticks
    }

    /// Whether the force has anything to do with the motion.
    pub fn is_an_answer(&self) -> bool {
        self.explained > ANSWERS
    }
}

/// Looks at `motion` (m) and `force` (N) where `valid`; nothing where there is too little of it.
pub fn answer(motion: &[f64], force: &[f64], valid: &[bool]) -> Option<Answer> {
    let mut found: Option<Answer> = None;
    for half in HALVES {
        let rows = seen(motion, force, valid, half);
        let fitted = (FITTED * rows.len() as f64) as usize;
        if fitted < FEWEST || rows.len() - fitted < FEWEST {
            continue;
        }
        let left = |columns: &[usize]| {
            let found = regress(&rows, fitted, columns)?;
            Some((found.left, found.by[2]))
        };
        let (Some((alone, _)), Some((plain, _)), Some((massive, mass))) =
            (left(&[3]), left(&[0, 1, 3]), left(&[0, 1, 2, 3]))
        else {
            continue;
        };
        let inertia = if mass > 0.0 && plain > NOTHING * alone {
            1.0 - massive / plain
        } else {
            0.0
        };
        if !(alone > 0.0) {
            continue;
        }
        let explained = 1.0 - plain / alone;
        let before = found.unwrap_or(Answer {
            inertia: 0.0,
            explained: 0.0,
            sticks: sticks(motion, force, valid),
        });
        found = Some(Answer {
            sticks: before.sticks,
            inertia: before.inertia.max(inertia),
            explained: before.explained.max(explained),
        });
    }
    found
}

/// Whether the force goes on changing while the motion rests, as one does that pushes against dry friction.
fn sticks(motion: &[f64], force: &[f64], valid: &[bool]) -> bool {
    let windows = Windows::new(REST_HALF);
    let see = |first: &usize| {
        (
            windows.see(motion, *first)[1],
            windows.see(force, *first)[0],
        )
    };
    let seen: Vec<(f64, f64)> = windows.places(valid).iter().map(see).collect();
    let mean = seen.iter().map(|(v, _)| v * v).sum::<f64>() / seen.len().max(1) as f64;
    let rests = |v: f64| v * v < REST * REST * mean;
    // Force and square of its change from one window to the next.
    let pairs = seen
        .windows(2)
        .map(|p| (rests(p[0].0) && rests(p[1].0), (p[1].1 - p[0].1).powi(2)));
    let (mut time, mut changes, mut all) = (0.0, 0.0, 0.0);
    for (is_at_rest, change) in pairs {
        all += change;
        if is_at_rest {
            time += 1.0;
            changes += change;
        }
    }
    let share = time / seen.len().max(1) as f64;
    share > RESTS && changes > CHANGES * share * all
}

/// Mean power (in units of the record's step) that the force brings into the motion: negative where it is the reaction.
pub fn power(motion: &[f64], force: &[f64], valid: &[bool]) -> f64 {
    let steps = motion
        .windows(2)
        .zip(force.windows(2))
        .zip(valid.windows(2));
    steps
        .filter(|(_, valid)| valid[0] && valid[1])
        .map(|((z, f), _)| (z[1] - z[0]) * 0.5 * (f[0] + f[1]))
        .sum()
}

/// What each window sees of motion, velocity, acceleration, a constant and the force; time in samples.
fn seen(motion: &[f64], force: &[f64], valid: &[bool], half: usize) -> Vec<[f64; 5]> {
    let windows = Windows::new(half);
    let row = |first: usize| {
        let [z, v, a] = windows.see(motion, first);
        [z, v, a, windows.one(), windows.see(force, first)[0]]
    };
    windows.places(valid).into_iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 0.01;

    /// A motion of several sines (m) and what it is after its first and second derivative.
    fn motion(i: usize) -> [f64; 3] {
        let t = i as f64 * STEP;
        let sines = [(0.01, 3.0, 0.0), (0.004, 11.0, 1.0), (0.002, 29.0, 2.0)];
        let sum =
            |of: &dyn Fn(f64, f64, f64) -> f64| sines.iter().map(|(a, w, p)| of(*a, *w, *p)).sum();
        [
            sum(&|a, w, p| a * (w * t + p).sin()),
            sum(&|a, w, p| a * w * (w * t + p).cos()),
            sum(&|a, w, p| -a * w * w * (w * t + p).sin()),
        ]
    }

    /// The force of k = 2000 N/m, B = 50 N s/m, a mass (kg) and dry friction (N).
    fn looked_at(mass: f64, friction: f64) -> Answer {
        let force = |i: usize| {
            let [z, v, a] = motion(i);
            2000.0 * z + 50.0 * v + mass * a + friction * v.signum()
        };
        let force: Vec<f64> = (0..3000).map(force).collect();
        let z: Vec<f64> = (0..3000).map(|i| motion(i)[0]).collect();
        answer(&z, &force, &[true; 3000]).unwrap_or(Answer {
            inertia: f64::NAN,
            explained: f64::NAN,
            sticks: false,
        })
    }

    #[test]
    fn a_mass_that_acts_is_seen_and_one_that_does_not_is_not() {
        for friction in [0.0, 5.0, 20.0] {
            let moved = looked_at(20.0, friction);
            assert!(!moved.is_prescribed(), "{friction} N: {moved:?}");
            let held = looked_at(0.0, friction);
            assert!(held.is_prescribed(), "{friction} N: {held:?}");
        }
    }

    #[test]
    fn a_force_that_has_nothing_to_do_with_the_motion_answers_to_nothing() {
        let z: Vec<f64> = (0..3000).map(|i| motion(i)[0]).collect();
        let other: Vec<f64> = (0..3000).map(|i| (i as f64 * 0.0937).sin()).collect();
        let found = answer(&z, &other, &[true; 3000]);
        assert!(found.is_some_and(|a| !a.is_prescribed()), "{found:?}");
    }

    /// A force that swings while the motion holds still pushes against friction; on a rig that holds still it relaxes.
    #[test]
    fn a_rig_that_holds_still_is_reported_from_a_drive_that_sticks() {
        let holds = |i: usize| i / 100 % 2 == 1;
        let mut at = 0;
        let paused: Vec<usize> = (0..6000)
            .map(|i| {
                at += usize::from(!holds(i));
                at
            })
            .collect();
        let z: Vec<f64> = paused.iter().map(|i| motion(*i)[0]).collect();
        let answering = |(i, at): (usize, &usize)| {
            let [z, v, _] = motion(*at);
            let since = (i % 100) as f64;
            2000.0 * z
                + if holds(i) {
                    5.0 * (-since / 20.0).exp()
                } else {
                    50.0 * v
                }
        };
        let rig: Vec<f64> = paused.iter().enumerate().map(answering).collect();
        let drive: Vec<f64> = (0..6000).map(|i| 20.0 * (0.05 * i as f64).sin()).collect();
        assert!(!sticks(&z, &rig, &[true; 6000]));
        assert!(sticks(&z, &drive, &[true; 6000]));
    }

    #[test]
    fn short_and_flat_records_are_left_alone() {
        assert_eq!(answer(&[0.0; 50], &[1.0; 50], &[true; 50]), None);
        assert_eq!(answer(&[1.0; 5000], &[1.0; 5000], &[false; 5000]), None);
        let flat = answer(&[0.0; 5000], &[1.0; 5000], &[true; 5000]);
        assert!(flat.is_none_or(|found| !found.is_prescribed()), "{flat:?}");
    }

    #[test]
    fn a_reaction_takes_power() {
        let z: Vec<f64> = (0..1000).map(|i| motion(i)[0]).collect();
        let v: Vec<f64> = (0..1000).map(|i| motion(i)[1]).collect();
        let against: Vec<f64> = v.iter().map(|v| -v).collect();
        assert!(power(&z, &v, &[true; 1000]) > 0.0 && power(&z, &against, &[true; 1000]) < 0.0);
    }
}
