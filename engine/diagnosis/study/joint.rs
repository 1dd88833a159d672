//! One model of several rides: effects' parameters in common and, where that is asked, stiffness and damping; where a ride
//! rests and how it begins is its own.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::diagnosis::fit::damped::{Normal, Range, inverse, minimise};
use crate::diagnosis::fit::fitter::expected;
use crate::diagnosis::fit::{Effort, Fitted, Fitter, Point, Slot, Unit};
use crate::numerics::autoregressive::NoiseModel;
use crate::numerics::lanes::LANES;
use crate::plant::Coefficient;

/// What the rides have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Common {
    Effects,
    /// k and B, and 1/m where the mass is unknown.
    EffectsAndAxles,
}

/// Fits the same axles of several rides as one.
pub struct Together<'a> {
    pub rides: Vec<&'a Fitter<'a>>,
    pub unit: Unit,
    pub common: Common,
}

/// Which of all numbers each ride's slots are, and what to multiply it by.
struct Layout {
    slots: Vec<Vec<Slot>>,
    places: Vec<Vec<(usize, f64)>>,
    count: usize,
}

impl Together<'_> {
    /// The fits of all rides from where each starts, under each one's own noise; nothing where one has no finite cost.
    pub fn fit(
        &self,
        starts: &[Point],
        noise_models: &[Vec<NoiseModel>],
        effort: Effort,
    ) -> Option<Vec<Fitted>> {
        let layout = self.layout();
        let substeps = effort.substeps;
        let (values, normal) = minimise(
            layout.mean(starts),
            &self.ranges(&layout),
            effort,
            |values| {
                let points = layout.points(starts, values);
                let of = |(r, point): (usize, &Point)| {
                    let slots = &layout.slots[r];
                    let own =
                        self.rides[r].normal(&self.unit, slots, point, &noise_models[r], substeps);
                    own.map(|own| self.expected_once(r, slots, point, own))
                };
                let each: Option<Vec<Normal>> = points.par_iter().enumerate().map(of).collect();
                let sum = layout.sum(&each?);
                sum.cost.is_finite().then_some(sum)
            },
            |all| self.costs(&layout, starts, all, noise_models, substeps),
        )?;
        let covariance = inverse(&normal.matrix)?;
        let points = layout.points(starts, &values);
        let finish = |(r, point): (usize, Point)| {
            let residuals = self.rides[r].residuals(&self.unit, &point, substeps);
            let own = layout.covariance(r, &covariance);
            self.rides[r].finish(&self.unit, point, residuals, own)
        };
        points.into_par_iter().enumerate().map(finish).collect()
    }

    /// Sums of the rides' costs at eight sets of numbers.
    fn costs(
        &self,
        layout: &Layout,
        starts: &[Point],
        all: &[Vec<f64>; LANES],
        noise_models: &[Vec<NoiseModel>],
        substeps: usize,
    ) -> [f64; LANES] {
        let points = all.each_ref().map(|values| layout.points(starts, values));
        let of = |r: usize| {
            let own: [Point; LANES] = std::array::from_fn(|i| points[i][r].clone());
            let costs = self.rides[r].costs(&self.unit, &own, &noise_models[r], substeps);
            let twice = |i: usize| costs[i] - self.expected_again(r, &own[i]);
            std::array::from_fn(twice)
        };
        let each: Vec<[f64; LANES]> = (0..self.rides.len()).into_par_iter().map(of).collect();
        std::array::from_fn(|i| each.iter().map(|costs| costs[i]).sum())
    }

    /// What is expected of an effect is expected once, not by every ride: the cost of it that is too much.
    fn expected_again(&self, ride: usize, point: &Point) -> f64 {
        let each = expected(&self.unit).filter(|_| ride > 0);
        each.map(|(slot, value, deviation)| ((point.get(slot) - value) / deviation).powi(2))
            .sum()
    }

    /// A ride's normal equations without what the first ride's hold already.
    fn expected_once(&self, ride: usize, slots: &[Slot], point: &Point, mut own: Normal) -> Normal {
        own.cost -= self.expected_again(ride, point);
        for (slot, value, deviation) in expected(&self.unit).filter(|_| ride > 0) {
            if let Some(i) = slots.iter().position(|s| *s == slot) {
                own.gradient[i] += (point.get(slot) - value) / (deviation * deviation);
                own.matrix[(i, i)] -= 1.0 / (deviation * deviation);
            }
        }
        own
    }

    fn layout(&self) -> Layout {
        let mut common: Vec<(Slot, usize)> = Vec::new();
        let mut layout = Layout {
            slots: Vec::new(),
            places: Vec::new(),
            count: 0,
        };
        for ride in &self.rides {
            let slots = self.unit.slots(ride.dataset);
            let mut place = |slot: &Slot| {
                let known = common.iter().find(|(s, _)| s == slot);
                let at = match known {
                    Some((_, at)) if self.is_common(*slot) => *at,
                    _ => {
                        common.push((*slot, layout.count));
                        layout.count += 1;
                        layout.count - 1
                    }
                };
                (at, self.per_first(ride, *slot))
            };
            let places = slots.iter().map(&mut place).collect();
            layout.places.push(places);
            layout.slots.push(slots);
        }
        layout
    }

    fn is_common(&self, slot: Slot) -> bool {
        match slot {
            Slot::Value(..) => true,
            Slot::Base(_, Coefficient::Kappa | Coefficient::Beta | Coefficient::PerMass) => {
                self.common == Common::EffectsAndAxles
            }
            Slot::Base(..) => false,
            Slot::Initial(..) => false,
        }
    }

    /// k/m and B/m of a ride for those of the first where k and B are the same.
    fn per_first(&self, ride: &Fitter, slot: Slot) -> f64 {
        match slot {
            Slot::Base(a, Coefficient::Kappa | Coefficient::Beta) => {
                let track = self.unit.tracks[a];
                let [first, own] = [self.rides[0], ride].map(|r| &r.dataset.tracks[track]);
                match first.free_mass || own.free_mass {
                    true => 1.0,
                    false => first.scale.mass / own.scale.mass,
                }
            }
            _ => 1.0,
        }
    }

    /// Sizes and limits; of what is common those that every ride allows.
    fn ranges(&self, layout: &Layout) -> Vec<Range> {
        let mut ranges = vec![(0.0, [f64::NEG_INFINITY, f64::INFINITY]); layout.count];
        for (r, ride) in self.rides.iter().enumerate() {
            for (slot, (at, factor)) in layout.slots[r].iter().zip(&layout.places[r]) {
                let (size, [low, high]) = self.unit.range(ride.dataset, *slot);
                let (known, limits) = &mut ranges[*at];
                *known = f64::max(*known, size / factor);
                *limits = [limits[0].max(low / factor), limits[1].min(high / factor)];
            }
        }
        ranges
    }
}

impl Layout {
    /// All numbers, what is common as the mean of the rides.
    fn mean(&self, starts: &[Point]) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); self.count];
        for ((slots, places), start) in self.slots.iter().zip(&self.places).zip(starts) {
            for (slot, (at, factor)) in slots.iter().zip(places) {
                sums[*at].0 += start.get(*slot) / factor;
                sums[*at].1 += 1.0;
            }
        }
        sums.into_iter().map(|(sum, n)| sum / n).collect()
    }

    fn points(&self, starts: &[Point], values: &[f64]) -> Vec<Point> {
        let own = |(r, start): (usize, &Point)| {
            let own: Vec<f64> = (self.places[r].iter())
                .map(|(at, factor)| values[*at] * factor)
                .collect();
            start.with(&self.slots[r], &own)
        };
        starts.iter().enumerate().map(own).collect()
    }

    fn sum(&self, each: &[Normal]) -> Normal {
        let mut sum = Normal {
            cost: each.iter().map(|n| n.cost).sum(),
            gradient: DVector::zeros(self.count),
            matrix: DMatrix::zeros(self.count, self.count),
        };
        for (own, places) in each.iter().zip(&self.places) {
            for (i, (row, by)) in places.iter().enumerate() {
                sum.gradient[*row] += by * own.gradient[i];
                for (j, (column, and)) in places.iter().enumerate() {
                    sum.matrix[(*row, *column)] += by * and * own.matrix[(i, j)];
                }
            }
        }
        sum
    }

    /// The part of a covariance that is one ride's.
    fn covariance(&self, ride: usize, whole: &DMatrix<f64>) -> DMatrix<f64> {
        let places = &self.places[ride];
        DMatrix::from_fn(places.len(), places.len(), |i, j| {
            places[i].1 * places[j].1 * whole[(places[i].0, places[j].0)]
        })
    }
}
