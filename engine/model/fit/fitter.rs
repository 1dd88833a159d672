//! Exact refit of an extended model: Levenberg-Marquardt on the whitened residual of the simulated
//! displacement. Eight parameter sets are simulated together: derivatives are differences between
//! them, and every step tries eight dampings at once.

use nalgebra::DMatrix;

use super::damped::{Effort, Normal, Range, inverse, minimise};
use super::normal_equations::{Equations, whitened};
use super::unit::{Point, Slot, Unit};
use crate::dataset::Dataset;
use veloid_core::numerics::autoregressive::NoiseModel;
use veloid_core::numerics::lanes::{LANES, Lanes};
use veloid_core::plant::Coefficient;

/// Steps from where a fit ended to where a parameter is expected.
const TOWARDS: usize = 12;

/// An extended model at its best on the fitted part.
#[derive(Clone, Debug)]
pub struct Fitted {
    pub unit: Unit,
    pub point: Point,
    /// Measured minus simulated (m) on the fitted part, by axle of the unit; zero where not valid.
    pub residuals: Vec<Vec<f64>>,
    /// Noise of each axle, from the residual.
    pub noise_models: Vec<NoiseModel>,
    /// Profile log likelihood, summed over the unit's axles.
    pub likelihood: f64,
    /// Inverse of the Gauss-Newton matrix for unit noise variance, over the unit's slots.
    pub covariance: DMatrix<f64>,
}

/// Profile log likelihood of a residual: -N/2 ln(innovation variance).
pub fn likelihood(residual: &[f64], valid: usize, noise_model: &NoiseModel) -> f64 {
    if residual.is_empty() {
        0.0
    } else {
        -0.5 * valid as f64 * noise_model.variance.max(1e-300).ln()
    }
}

/// Parameters that are expected where the ride says nothing: the slot, its value and deviation.
pub fn expected(unit: &Unit) -> impl Iterator<Item = (Slot, f64, f64)> {
    unit.terms.iter().enumerate().flat_map(|(i, term)| {
        let expected = term.kind.spec().expected.iter();
        expected.map(move |(q, value, deviation)| (Slot::Value(i, *q), *value, *deviation))
    })
}

#[derive(Clone, Copy)]
pub struct Fitter<'a> {
    pub dataset: &'a Dataset,
    /// Samples to fit on.
    pub samples: usize,
}

impl Fitter<'_> {
    /// Fits from `start` under the noise models `colours` (one for each axle of the unit).
    pub fn fit(
        &self,
        unit: &Unit,
        start: Point,
        noise_models: &[NoiseModel],
        effort: Effort,
    ) -> Option<Fitted> {
        self.fit_over(&unit.slots(self.dataset), unit, start, noise_models, effort)
    }

    /// Fits some of the slots; the covariance is theirs alone.
    pub fn fit_over(
        &self,
        slots: &[Slot],
        unit: &Unit,
        start: Point,
        noise_models: &[NoiseModel],
        effort: Effort,
    ) -> Option<Fitted> {
        let start = unit.within(self.dataset, start);
        let ranges: Vec<Range> = slots.iter().map(|s| unit.range(self.dataset, *s)).collect();
        let at = |values: &[f64]| start.with(slots, values);
        let (values, normal) = minimise(
            slots.iter().map(|s| start.get(*s)).collect(),
            &ranges,
            effort,
            |values| self.normal(unit, slots, &at(values), noise_models, effort.substeps),
            |all| {
                let points = std::array::from_fn(|i| at(&all[i]));
                self.costs(unit, &points, noise_models, effort.substeps)
            },
        )?;
        self.finish(
            unit,
            at(&values),
            normal.residuals,
            inverse(&normal.matrix)?,
        )
    }

    /// The model at a point whose starting states alone are fitted.
    pub fn started(
        &self,
        unit: &Unit,
        point: &Point,
        noise_models: &[NoiseModel],
        effort: Effort,
    ) -> Option<Fitted> {
        let slots = unit.slots(self.dataset);
        let own: Vec<Slot> = slots
            .iter()
            .filter(|slot| slot.is_start())
            .copied()
            .collect();
        let point = match own.is_empty() {
            true => point.clone(),
            false => (self.fit_over(&own, unit, point.clone(), noise_models, effort))?.point,
        };
        let normal = self.normal(unit, &slots, &point, noise_models, effort.substeps)?;
        self.finish(unit, point, normal.residuals, inverse(&normal.matrix)?)
    }

    /// The best fit with every expected parameter held where it is expected, reached in small steps from `start`: along
    /// a flat and curved ridge a fit of all creeps. Nothing if no parameter is.
    pub fn fit_as_expected(
        &self,
        unit: &Unit,
        start: &Point,
        noise_models: &[NoiseModel],
        effort: Effort,
    ) -> Option<Point> {
        let mut slots = unit.slots(self.dataset);
        let all = slots.len();
        slots.retain(|slot| expected(unit).all(|(held, ..)| held != *slot));
        if slots.len() == all {
            return None;
        }
        let mut point = start.clone();
        for left in (0..TOWARDS).rev() {
            for (slot, value, _) in expected(unit) {
                let now = point.get(slot);
                point.set(slot, now + (value - now) / (left + 1) as f64);
            }
            point = (self.fit_over(&slots, unit, point, noise_models, effort))?.point;
        }
        Some(point)
    }

    /// The fit that ended at a point, with its noise and likelihood; nothing where that is no number.
    pub fn finish(
        &self,
        unit: &Unit,
        point: Point,
        residuals: Vec<Vec<f64>>,
        covariance: DMatrix<f64>,
    ) -> Option<Fitted> {
        let mut total = 0.0;
        let mut noise_models = Vec::new();
        for (r, t) in residuals.iter().zip(&unit.tracks) {
            let noise_model = NoiseModel::of_order(r, self.dataset.noise_order);
            let valid = self.dataset.tracks[*t].valid[..self.samples]
                .iter()
                .filter(|v| **v)
                .count();
            total += likelihood(r, valid, &noise_model);
            noise_models.push(noise_model);
        }
        total.is_finite().then_some(Fitted {
            unit: unit.clone(),
            point,
            residuals,
            noise_models,
            likelihood: total,
            covariance,
        })
    }

    /// Measured minus simulated on the fitted part.
    pub fn residuals(&self, unit: &Unit, point: &Point, substeps: usize) -> Vec<Vec<f64>> {
        self.residuals_to(unit, point, substeps, self.samples)
    }

    /// Measured minus simulated up to sample `end`; zero where not valid.
    pub fn residuals_to(
        &self,
        unit: &Unit,
        point: &Point,
        substeps: usize,
        end: usize,
    ) -> Vec<Vec<f64>> {
        let points: [Point; LANES] = std::array::from_fn(|_| point.clone());
        let z = unit.simulate(self.dataset, &points, None, 0..end, substeps);
        z.iter()
            .zip(&unit.tracks)
            .map(|(z, t)| {
                let track = &self.dataset.tracks[*t];
                (0..end)
                    .map(|i| {
                        if track.valid[i] {
                            track.measured[i] - z[i].0[0]
                        } else {
                            0.0
                        }
                    })
                    .collect()
            })
            .collect()
    }

    /// Whitened costs of eight points.
    pub fn costs(
        &self,
        unit: &Unit,
        points: &[Point; LANES],
        noise_models: &[NoiseModel],
        substeps: usize,
    ) -> [f64; LANES] {
        let z = unit.simulate(self.dataset, points, None, 0..self.samples, substeps);
        let mut total = Lanes::ZERO;
        for ((z, t), noise_model) in z.iter().zip(&unit.tracks).zip(noise_models) {
            let track = &self.dataset.tracks[*t];
            let residual: Vec<Lanes> = (0..self.samples)
                .map(|i| {
                    if track.valid[i] {
                        Lanes::all(track.measured[i]) - z[i]
                    } else {
                        Lanes::ZERO
                    }
                })
                .collect();
            let mut sum = Lanes::ZERO;
            for x in whitened(&residual, &noise_model.a) {
                sum += x * x;
            }
            total += sum / noise_model.variance;
        }
        std::array::from_fn(|i| {
            let cost = total.0[i]
                + self
                    .prior(unit, &points[i])
                    .map(|(_, x, _)| x * x)
                    .sum::<f64>();
            if cost.is_finite() {
                cost
            } else {
                f64::INFINITY
            }
        })
    }

    /// What is known of the initial state before the fit: the slot, its departure from the first
    /// measurement in (wide) standard deviations, and one over that deviation. A driven, damped axle
    /// forgets where it started, and nothing else would hold these numbers.
    fn prior<'b>(
        &'b self,
        unit: &'b Unit,
        point: &'b Point,
    ) -> impl Iterator<Item = (Slot, f64, f64)> + 'b {
        let effects = expected(unit).map(|(slot, value, deviation)| {
            (slot, (point.get(slot) - value) / deviation, 1.0 / deviation)
        });
        let moving = unit.tracks.iter().enumerate();
        let moving = moving.filter(|(_, t)| self.dataset.tracks[**t].plant.moves());
        let starts = moving.flat_map(move |(a, t)| {
            let track = &self.dataset.tracks[*t];
            let expected = [track.measured[0], 0.0];
            let wide = [0.3 / track.scale.z_rms, 0.3 / track.scale.v_rms];
            let per = track.at_rest.map_or(wide, |[z, v]| [1.0 / z, 1.0 / v]);
            [0, 1].map(|q| {
                let slot = Slot::Base(a, Coefficient::START[q]);
                (slot, (point.get(slot) - expected[q]) * per[q], per[q])
            })
        });
        starts.chain(effects)
    }

    /// The whitened normal equations over some slots at a point.
    pub fn normal(
        &self,
        unit: &Unit,
        slots: &[Slot],
        point: &Point,
        noise_models: &[NoiseModel],
        substeps: usize,
    ) -> Option<Normal> {
        let mut normal = Normal::zero(slots.len());
        let coupled =
            (0..unit.tracks.len()).all(|a| slots.iter().all(|s| unit.touches(self.dataset, *s, a)));
        let groups: Vec<(Option<usize>, Vec<usize>)> = match coupled {
            true => vec![(None, (0..slots.len()).collect())],
            false => (0..unit.tracks.len())
                .map(|a| {
                    let touches = |s: &usize| unit.touches(self.dataset, slots[*s], a);
                    (Some(a), (0..slots.len()).filter(touches).collect())
                })
                .collect(),
        };
        let equations = Equations {
            dataset: self.dataset,
            samples: self.samples,
            unit,
            slots,
            point,
            noise_models,
            substeps,
        };
        for (wanted, touching) in groups {
            equations.add(wanted, &touching, &mut normal);
        }
        for (slot, x, per) in self.prior(unit, point) {
            normal.cost += x * x;
            if let Some(i) = slots.iter().position(|s| *s == slot) {
                normal.gradient[i] -= x * per;
                normal.matrix[(i, i)] += per * per;
            }
        }
        (normal.cost.is_finite() && normal.matrix.iter().all(|x| x.is_finite())).then_some(normal)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::effects::Kind;
    use crate::example;
    use crate::law::padded;
    use veloid_core::bicycle::Axle;

    #[test]
    fn whitened_is_a_number_with_parts_of_those_before() {
        let x = [2.0, 3.0, 5.0, 7.0].map(Lanes::all);
        let white: Vec<f64> = whitened(&x, &[-0.5, 0.25]).iter().map(|x| x.0[3]).collect();
        let expected = [
            2.0,
            3.0 - 0.5 * 2.0,
            5.0 - 0.5 * 3.0 + 0.25 * 2.0,
            7.0 - 0.5 * 5.0 + 0.25 * 3.0,
        ];
        assert_eq!(white, expected);
    }

    #[test]
    fn products_are_sums_over_samples_of_every_pair_of_columns() {
        let column = |by: f64| Lanes(std::array::from_fn(|i| by * (i + 1) as f64));
        let (first, second) = ([column(1.0), column(2.0)], [column(3.0), column(-1.0)]);
        let found = crate::fit::normal_equations::products(&first, &second);
        for (i, row) in found.iter().enumerate() {
            for (j, sum) in row.0.iter().enumerate() {
                let pair = ((i + 1) * (j + 1)) as f64;
                assert_eq!(*sum, (1.0 * 3.0 - 2.0 * 1.0) * pair);
            }
        }
    }

    #[test]
    fn a_likelihood_counts_valid_samples_alone() {
        let noise_model = NoiseModel::white(2.0);
        let found = likelihood(&[0.0; 9], 6, &noise_model);
        assert!((found + 3.0 * 2_f64.ln()).abs() < 1e-12);
        assert_eq!(likelihood(&[], 6, &noise_model), 0.0);
    }

    #[test]
    fn a_fit_finds_the_springs_and_dampers_that_made_a_ride() {
        let dataset = example::dataset();
        let fitter = example::fitter(&dataset);
        let unit = Unit {
            tracks: vec![0],
            terms: Vec::new(),
        };
        let mut start = example::point(&dataset, &unit, Vec::new());
        let slots = [
            Slot::Base(0, Coefficient::Kappa),
            Slot::Base(0, Coefficient::Beta),
        ];
        let truth = slots.map(|slot| start.get(slot));
        for (slot, times) in slots.into_iter().zip([1.3, 0.6]) {
            start.set(slot, times * start.get(slot));
        }
        let effort = Effort {
            iterations: 30,
            gain: 1e-6,
            substeps: 3,
        };
        let white = [NoiseModel::white(example::NOISE.powi(2))];
        let fit = fitter.fit(&unit, start, &white, effort).unwrap();
        for (slot, truth) in slots.into_iter().zip(truth) {
            let found = fit.point.get(slot);
            assert!(
                (found / truth - 1.0).abs() < 0.01,
                "{slot:?}: {found} of {truth}"
            );
        }
    }

    #[test]
    fn the_gradient_is_the_slope_of_the_cost() {
        let dataset = example::dataset();
        let fitter = example::fitter(&dataset);
        let cubic = example::term(Kind::CubicStiffness, Axle::Front);
        let unit = Unit {
            tracks: vec![0],
            terms: vec![cubic],
        };
        let slots = unit.slots(&dataset);
        let mut at = example::point(&dataset, &unit, vec![padded([1e9])]);
        at.set(
            Slot::Base(0, Coefficient::Kappa),
            1.1 * at.get(Slot::Base(0, Coefficient::Kappa)),
        );
        let white = [NoiseModel::white(example::NOISE.powi(2))];
        let normal = fitter.normal(&unit, &slots, &at, &white, 3).unwrap();
        let points = std::array::from_fn(|_| at.clone());
        let cost = fitter.costs(&unit, &points, &white, 3)[0];
        assert!((normal.cost / cost - 1.0).abs() < 1e-9);
        for (i, slot) in slots.iter().enumerate() {
            let (size, _) = unit.range(&dataset, *slot);
            let step = 1e-4 * size.abs().max(at.get(*slot).abs());
            let costs: [f64; LANES] = {
                let moved = std::array::from_fn(|lane| {
                    let by = if lane == 0 { step } else { -step };
                    at.with(&[*slot], &[at.get(*slot) + by])
                });
                fitter.costs(&unit, &moved, &white, 3)
            };
            // The gradient is minus half the slope, in units of the curvature's root.
            let slope = (costs[0] - costs[1]) / (4.0 * step);
            let unit_of = (normal.matrix[(i, i)] * cost).sqrt();
            assert!(
                (normal.gradient[i] + slope).abs() < 2e-3 * unit_of,
                "{slot:?}"
            );
        }
    }
}
