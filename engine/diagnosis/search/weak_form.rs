//! Starts that know no wrong basin: the equation of motion as a regression on the measured motion, in its weak form. Both
//! sides are multiplied by smooth windows and integrated by parts, so that no record is differentiated twice
//! (modulating functions: Shinbrot 1957, Trans. ASME 79:587-603; Preisig & Rippin 1993, doi:10.1016/0098-1354(93)80001-4).

use nalgebra::{DMatrix, DVector};

use veloid_core::numerics::lanes::Lanes;
use veloid_core::numerics::modulating::window;
use veloid_core::plant::{Coefficient, Coefficients};
use veloid_methods::simulate::linear::Input;
use veloid_model::dataset::{Dataset, Track};
use veloid_model::effects::Kind;
use veloid_model::fit::{Fitter, Point, Unit};
use veloid_model::law::{Crank, Motion, Values};

/// Half widths of the windows (s) that are tried, as parts of the plain axle's period.
const WIDTHS: [f64; 2] = [0.12, 0.4];
/// Fewest samples in half a window.
const LEAST: usize = 6;
/// Parts of the record at least that half a window is shorter than where the force is judged.
const MOST_PARTS: usize = 40;
/// Samples that starts are taken from at most: they need be no better than a fit's first step.
const MOST_SAMPLES: usize = 20_000;
/// Parts of a sample's time in which an effect's own state follows the measured motion.
const PARTS: usize = 4;
/// Windows that start within half a width of each other.
const OVERLAP: usize = 2;

/// Points at which an effect alone beside the plain model solves the regression, one for each start and width, those that leave
/// least first. Nothing for second masses and for effects on the road or on the sensor, whose force the measured motion does not
/// give.
pub fn starts(fitter: &Fitter, unit: &Unit, at: usize, base: &Point) -> Vec<Point> {
    let spec = unit.terms[at].kind.spec();
    let ([track], [slot]) = (&unit.tracks[..], spec.amplitudes) else {
        return Vec::new();
    };
    if unit.terms.len() > 1 || spec.second_mass || spec.on_road || spec.on_sensor || spec.local {
        return Vec::new();
    }
    let dataset = fitter.dataset;
    let track = &dataset.tracks[*track];
    let mut found = Vec::new();
    for width in WIDTHS {
        let half = (width * track.scale.period() / dataset.step) as usize;
        let half = half.clamp(LEAST, (fitter.samples / 20).max(LEAST));
        let rows = Rows::new(track, fitter.samples.min(MOST_SAMPLES), half);
        for start in (spec.starts)(&track.scale) {
            let force = rows.forces(dataset, track, unit.terms[at].kind, &start);
            found.extend(rows.solved(track, base, &force, (start, *slot, at)));
        }
    }
    found.sort_by(|a: &(f64, Point), b| a.0.total_cmp(&b.0));
    found.into_iter().map(|(_, point)| point).collect()
}

/// The measured motion as the windows see it.
struct Rows<'a> {
    input: &'a Input,
    z: Vec<f64>,
    /// Velocity, smoothed over a part of a window.
    v: Vec<f64>,
    /// First samples of the windows, all valid, and their weights.
    windows: Vec<usize>,
    weights: Vec<f64>,
    /// What each window sees of acceleration, deflection, its rate, the force and a constant.
    sums: Vec<[f64; 5]>,
}

impl<'a> Rows<'a> {
    fn new(track: &'a Track, samples: usize, half: usize) -> Self {
        let input = &track.input;
        // On a rig nothing moves but what the motor moves, and the force stands in the place of the acceleration.
        let z = track.height(track.measured[..samples].to_vec());
        let width = 2 * half + 1;
        let windows = (0..samples.saturating_sub(width)).step_by((half / OVERLAP).max(1));
        let valid = |first: &usize| track.valid[*first..*first + width].iter().all(|v| *v);
        let windows: Vec<usize> = windows.filter(valid).collect();
        let reach = half as f64;
        let shapes: Vec<[f64; 3]> = (0..width).map(|j| window(j as f64 / reach - 1.0)).collect();
        let pushes = input.force.as_ref().map(|(f, _)| &f[..]);
        let seen = |first: &usize| {
            let mut sums = [0.0; 5];
            for (i, [phi, slope, curve]) in (*first..).zip(&shapes) {
                let d = input.road[i] - z[i];
                let answer = match input.prescribed {
                    true => phi * track.measured[i],
                    false => curve / (reach * input.step).powi(2) * z[i],
                };
                let parts = [
                    answer,
                    phi * d,
                    -slope / (reach * input.step) * d,
                    phi * pushes.map_or(0.0, |f| f[i]),
                    *phi,
                ];
                sums.iter_mut().zip(parts).for_each(|(s, p)| *s += p);
            }
            sums
        };
        Self {
            input,
            v: smoothed_slope(&z, (half / 4).max(1), input.step),
            sums: windows.iter().map(seen).collect(),
            weights: shapes.iter().map(|[phi, ..]| *phi).collect(),
            windows,
            z,
        }
    }

    /// The force over the mass of an effect with unit mass along the measured motion (m/s^2).
    fn forces(&self, dataset: &Dataset, track: &Track, kind: Kind, values: &Values) -> Vec<f64> {
        let p = values.map(Lanes::all);
        let mut states = vec![Lanes::ZERO; kind.spec().states];
        let mut rates = states.clone();
        let step = dataset.step / PARTS as f64;
        let mut forces = Vec::with_capacity(self.z.len());
        for i in 0..self.z.len() {
            let motion = self.motion(dataset, track, i, dataset.step);
            let [tyre, body] = kind.forces(&p, &motion, &states, [Lanes::ZERO; 2]);
            forces.push((tyre + body).0[0]);
            if states.is_empty() || i + 1 == self.z.len() {
                continue;
            }
            let next = self.motion(dataset, track, i + 1, step);
            for part in 0..PARTS {
                let s = (part as f64 + 0.5) / PARTS as f64;
                let between = Motion {
                    d: motion.d + (next.d - motion.d) * s,
                    w: motion.w + (next.w - motion.w) * s,
                    ..self.motion(dataset, track, i, step)
                };
                kind.moved(&p, &between, &states, Lanes::ZERO, &mut rates);
                for (state, rate) in states.iter_mut().zip(&rates) {
                    *state += *rate * step;
                }
            }
        }
        forces
    }

    /// The measured motion of a unit mass at a sample.
    fn motion<'t>(&self, dataset: &Dataset, track: &'t Track, i: usize, step: f64) -> Motion<'t> {
        let (d, w) = (
            self.input.road[i] - self.z[i],
            self.input.road_slope[i] - self.v[i],
        );
        Motion {
            d: Lanes::all(d),
            w: Lanes::all(w),
            z: Lanes::all(self.z[i]),
            v: Lanes::all(self.v[i]),
            kappa: Lanes::ZERO,
            beta: Lanes::ZERO,
            per_mass: Lanes::all(1.0),
            t: i as f64 * dataset.step,
            speed: dataset.speed[i],
            speed_rate: dataset.speed_rate[i],
            crank: Crank {
                angle: dataset.crank[i],
                before: dataset.double_crank[i],
                turned: 0.0,
            },
            distance: dataset.distance[i],
            step,
            felt_after: self.input.felt_after(step),
            scale: &track.scale,
        }
    }

    /// Solves for k/m, B/m, [1/m], [a constant] and the size of the effect.
    fn solved(
        &self,
        track: &Track,
        base: &Point,
        force: &[f64],
        (mut values, slot, at): (Values, usize, usize),
    ) -> Option<(f64, Point)> {
        let mut point = base.clone();
        let row = |(first, sums): (&usize, &[f64; 5])| {
            let mut felt = 0.0;
            for (i, phi) in (*first..).zip(&self.weights) {
                felt += phi * force[i];
            }
            let [a, d, w, push, one] = *sums;
            [a, d, w, push, one, felt]
        };
        let rows: Vec<[f64; 6]> = self.windows.iter().zip(&self.sums).map(row).collect();
        let mut unknown = self.unknown(track);
        unknown.push(5);
        let solution = solve(&rows, &unknown, track)?;
        let found = solution.values;
        let per_mass = match unknown.contains(&3) {
            true => found[3],
            false => track.scale.mass.recip(),
        };
        if !(per_mass > 0.0) {
            return None;
        }
        let own = &mut point.base[0];
        (own.kappa, own.beta, own.per_mass) = (found[1], found[2], per_mass);
        if unknown.contains(&4) {
            own.constant = found[4];
        }
        // The factor belongs to a mass of one.
        values[slot] *= found[5] / per_mass;
        point.values[at] = values;
        let finite = point.base.iter().all(Coefficients::is_finite);
        finite.then_some((solution.left, point))
    }

    /// Which columns the plain model has to find: k/m, B/m, 1/m, a constant.
    fn unknown(&self, track: &Track) -> Vec<usize> {
        let free = |q: &usize| match q {
            1 => track.is_free(Coefficient::Kappa),
            3 => track.is_free(Coefficient::PerMass) && self.input.force.is_some(),
            4 => track.is_free(Coefficient::Constant),
            _ => true,
        };
        (1..5).filter(free).collect()
    }
}

struct Solution {
    /// By column; zero where nothing was to be found.
    values: [f64; 6],
    /// Share of what is to be explained that is left, as a part of its deviation.
    left: f64,
}

/// Solves rows of acceleration, deflection, its rate, force, a constant and one more for some of these; the force of a known mass
/// is moved to the other side.
fn solve(rows: &[[f64; 6]], unknown: &[usize], track: &Track) -> Option<Solution> {
    if rows.len() < 3 * unknown.len() {
        return None;
    }
    let scale = |q: usize| rows.iter().map(|r| r[q] * r[q]).sum::<f64>().sqrt();
    let scales: Vec<f64> = unknown.iter().map(|q| scale(*q)).collect();
    if scales.iter().any(|s| !(*s > 0.0)) {
        return None;
    }
    let matrix = DMatrix::from_fn(rows.len(), unknown.len(), |r, c| {
        rows[r][unknown[c]] / scales[c]
    });
    let given = match track.free_mass {
        true => 0.0,
        false => track.scale.mass.recip(),
    };
    let target = DVector::from_fn(rows.len(), |r, _| rows[r][0] - given * rows[r][3]);
    let normal = matrix.tr_mul(&matrix);
    let solution = normal.cholesky()?.solve(&matrix.tr_mul(&target));
    let mut values = [0.0; 6];
    for (c, q) in unknown.iter().enumerate() {
        values[*q] = solution[c] / scales[c];
    }
    let rest = &target - &matrix * &solution;
    let left = (rest.norm_squared() / target.add_scalar(-target.mean()).norm_squared()).sqrt();
    Some(Solution { values, left })
}

/// Share of the force on the mass (RMS) that the plain model misses along the measured motion, without a simulation: what is left
/// of the regression in windows of a `period` (s). Nothing where there are too few of them.
pub fn missed(dataset: &Dataset, track: &Track, samples: usize, period: f64) -> Option<f64> {
    let half = (0.5 * period / dataset.step) as usize;
    let half = half.clamp(LEAST, (samples / MOST_PARTS).max(LEAST));
    let rows = Rows::new(track, samples, half);
    let rest = rows
        .sums
        .iter()
        .map(|[a, d, w, push, one]| [*a, *d, *w, *push, *one, 0.0]);
    let all: Vec<[f64; 6]> = rest.collect();
    let left = solve(&all, &rows.unknown(track), track)?.left;
    left.is_finite().then_some(left)
}

/// Slope of the line through `reach` samples to both sides.
fn smoothed_slope(x: &[f64], reach: usize, step: f64) -> Vec<f64> {
    (0..x.len())
        .map(|i| {
            let reach = reach.min(i).min(x.len() - 1 - i);
            if reach == 0 {
                let (a, b) = (i.saturating_sub(1), (i + 1).min(x.len() - 1));
                return (x[b] - x[a]) / ((b - a).max(1) as f64 * step);
            }
            let (mut top, mut bottom) = (0.0, 0.0);
            for j in 1..=reach {
                top += j as f64 * (x[i + j] - x[i - j]);
                bottom += 2.0 * (j * j) as f64;
            }
            top / (bottom * step)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lines_slope_is_found_up_to_its_ends() {
        let x: Vec<f64> = (0..20).map(|i| 0.5 * i as f64).collect();
        assert!(
            smoothed_slope(&x, 4, 0.1)
                .iter()
                .all(|v| (v - 5.0).abs() < 1e-12)
        );
    }
}
