//! One model of several rides: effects' parameters in common and, where that is asked, stiffness and damping; where a ride
//! rests and how it begins is its own.

use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::fit::damped::{Normal, Range, inverse, minimise};
use crate::fit::fitter::expected;
use crate::fit::{Effort, Fitted, Fitter, Point, Slot, Term, Unit};
use veloid_core::numerics::autoregressive::NoiseModel;
use veloid_core::numerics::lanes::LANES;
use veloid_core::plant::Coefficient;

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
    /// The axles of each ride, the same in all, and the effects that act on them there.
    pub units: Vec<Unit>,
    pub common: Common,
    /// Effects whose parameters are each ride's own, and which need not act on every ride.
    pub own: &'a [Term],
}

/// What a slot of one ride is over all rides.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shared {
    /// Track; number of its base model.
    Base(usize, Coefficient),
    /// Effect; parameter.
    Value(Term, usize),
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
                    let own = self.rides[r].normal(
                        &self.units[r],
                        slots,
                        point,
                        &noise_models[r],
                        substeps,
                    );
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
            let residuals = self.rides[r].residuals(&self.units[r], &point, substeps);
            let own = layout.covariance(r, &covariance);
            self.rides[r].finish(&self.units[r], point, residuals, own)
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
            let costs = self.rides[r].costs(&self.units[r], &own, &noise_models[r], substeps);
            let twice = |i: usize| costs[i] - self.expected_again(r, &own[i]);
            std::array::from_fn(twice)
        };
        let each: Vec<[f64; LANES]> = (0..self.rides.len()).into_par_iter().map(of).collect();
        std::array::from_fn(|i| each.iter().map(|costs| costs[i]).sum())
    }

    /// What is expected of a common effect is expected once, by the first ride.
    fn expected_by_others(&self, ride: usize) -> impl Iterator<Item = (Slot, f64, f64)> + '_ {
        let expected = expected(&self.units[ride]);
        expected.filter(move |(slot, ..)| ride > 0 && self.shared(ride, *slot).is_some())
    }

    /// The cost of what is expected that is too much.
    fn expected_again(&self, ride: usize, point: &Point) -> f64 {
        let each = self.expected_by_others(ride);
        each.map(|(slot, value, deviation)| ((point.get(slot) - value) / deviation).powi(2))
            .sum()
    }

    /// A ride's normal equations without what the first ride's hold already.
    fn expected_once(&self, ride: usize, slots: &[Slot], point: &Point, mut own: Normal) -> Normal {
        own.cost -= self.expected_again(ride, point);
        for (slot, value, deviation) in self.expected_by_others(ride) {
            if let Some(i) = slots.iter().position(|s| *s == slot) {
                own.gradient[i] += (point.get(slot) - value) / (deviation * deviation);
                own.matrix[(i, i)] -= 1.0 / (deviation * deviation);
            }
        }
        own
    }

    fn layout(&self) -> Layout {
        let mut common: Vec<(Shared, usize)> = Vec::new();
        let mut layout = Layout {
            slots: Vec::new(),
            places: Vec::new(),
            count: 0,
        };
        for (r, ride) in self.rides.iter().enumerate() {
            let slots = self.units[r].slots(ride.dataset);
            let mut place = |slot: &Slot| {
                let shared = self.shared(r, *slot);
                let known = common.iter().find(|(known, _)| Some(*known) == shared);
                let at = known.map_or(layout.count, |(_, at)| *at);
                if at == layout.count {
                    common.extend(shared.map(|shared| (shared, at)));
                    layout.count += 1;
                }
                (at, self.per_first(ride, *slot))
            };
            let places = slots.iter().map(&mut place).collect();
            layout.places.push(places);
            layout.slots.push(slots);
        }
        layout
    }

    /// What a ride's slot is over all rides; nothing where it is that ride's own.
    fn shared(&self, ride: usize, slot: Slot) -> Option<Shared> {
        let unit = &self.units[ride];
        match slot {
            Slot::Value(i, q) => {
                let term = unit.terms[i];
                (!self.own.contains(&term)).then_some(Shared::Value(term, q))
            }
            Slot::Base(
                a,
                number @ (Coefficient::Kappa | Coefficient::Beta | Coefficient::PerMass),
            ) => {
                let is_common = self.common == Common::EffectsAndAxles;
                is_common.then_some(Shared::Base(unit.tracks[a], number))
            }
            Slot::Base(..) | Slot::Initial(..) => None,
        }
    }

    /// k/m and B/m of a ride for those of the first where k and B are the same.
    fn per_first(&self, ride: &Fitter, slot: Slot) -> f64 {
        match slot {
            Slot::Base(a, Coefficient::Kappa | Coefficient::Beta) => {
                let track = self.units[0].tracks[a];
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
                let (size, [low, high]) = self.units[r].range(ride.dataset, *slot);
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
        let mut sum = Normal::zero(self.count);
        sum.cost = each.iter().map(|n| n.cost).sum();
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use nalgebra::DVector;

    use super::*;
    use crate::effects::Kind;
    use crate::example;
    use crate::law::padded;
    use veloid_core::bicycle::Axle;

    /// The front axle, with one law.
    fn unit() -> Unit {
        Unit {
            tracks: vec![0],
            terms: vec![example::term(Kind::CubicStiffness, Axle::Front)],
        }
    }

    /// Two rides of a bicycle, on the second of which it carries twice as much.
    fn rides() -> [crate::dataset::Dataset; 2] {
        [1.0, 2.0].map(|times| example::loaded(times * example::FRONT, example::REAR))
    }

    fn together<'a>(fitters: &'a [Fitter<'a>], common: Common) -> Together<'a> {
        Together {
            rides: fitters.iter().collect(),
            units: vec![unit(); fitters.len()],
            common,
            own: &[],
        }
    }

    #[test]
    fn what_rides_share_is_one_number_and_the_rest_is_each_ones_own() {
        let datasets = rides();
        let fitters = datasets.each_ref().map(example::fitter);
        // k, B and the start of each ride, and one parameter of the law.
        let own = unit().slots(&datasets[0]).len() - 1;
        assert_eq!(own, 4);
        let of = |common| together(&fitters, common).layout();
        assert_eq!(of(Common::Effects).count, 2 * own + 1);
        assert_eq!(of(Common::EffectsAndAxles).count, 2 * (own - 2) + 2 + 1);
    }

    #[test]
    fn an_effect_of_one_ride_has_numbers_of_its_own_and_only_there() {
        let datasets = rides();
        let fitters = datasets.each_ref().map(example::fitter);
        let own = unit().terms;
        let mut together = Together {
            own: &own,
            ..together(&fitters, Common::EffectsAndAxles)
        };
        let both = together.layout().count;
        assert_eq!(both, 2 * (4 - 2) + 2 + 2);
        together.units[1].terms.clear();
        let layout = together.layout();
        assert_eq!(layout.count, both - 1);
        assert_eq!(layout.slots[0].len(), layout.slots[1].len() + 1);
    }

    #[test]
    fn the_same_spring_is_less_over_a_larger_mass() {
        let datasets = rides();
        let fitters = datasets.each_ref().map(example::fitter);
        let together = together(&fitters, Common::EffectsAndAxles);
        let layout = together.layout();
        let starts = datasets
            .each_ref()
            .map(|d| example::point(d, &unit(), vec![padded([1e9])]));
        // Both rides have the same k, B and law already, so that their mean is that of each.
        let values = layout.mean(&starts);
        for (found, start) in layout.points(&starts, &values).iter().zip(&starts) {
            for slot in unit().slots(&datasets[0]) {
                let (found, start) = (found.get(slot), start.get(slot));
                assert!((found - start).abs() <= 1e-12 * start.abs(), "{slot:?}");
            }
        }
        // A common number that moves by a share moves so on every ride.
        let (at, first) = layout.places[0][0];
        let mut moved = values;
        moved[at] *= 1.5;
        assert_eq!(first, 1.0);
        for (found, start) in layout.points(&starts, &moved).iter().zip(&starts) {
            let slot = Slot::Base(0, Coefficient::Kappa);
            assert!((found.get(slot) / start.get(slot) - 1.5).abs() < 1e-12);
        }
    }

    #[test]
    fn the_mean_of_what_is_common_is_taken_over_all_rides() {
        let dataset = example::dataset();
        let start = |value: f64, z: f64| {
            let point = example::point(&dataset, &unit(), vec![padded([])]);
            point.with(
                &[Slot::Value(0, 0), Slot::Base(0, Coefficient::Height)],
                &[value, z],
            )
        };
        let mean = shared().mean(&[start(3.0, 0.1), start(4.0, 0.2)]);
        assert_eq!(mean, [(3.0 + 4.0 / 0.5) / 2.0, 0.1, 0.2]);
    }

    /// A layout of two rides with one common number, half as large on the second, and one of each one's own.
    fn shared() -> Layout {
        Layout {
            slots: vec![vec![Slot::Value(0, 0), Slot::Base(0, Coefficient::Height)]; 2],
            places: vec![vec![(0, 1.0), (1, 1.0)], vec![(0, 0.5), (2, 1.0)]],
            count: 3,
        }
    }

    #[test]
    fn normal_equations_add_up_by_the_chain_rule() {
        let own = |cost: f64, gradient: [f64; 2], [a, b, c]: [f64; 3]| Normal {
            cost,
            gradient: DVector::from_row_slice(&gradient),
            matrix: DMatrix::from_row_slice(2, 2, &[a, b, b, c]),
            residuals: Vec::new(),
        };
        let each = [
            own(10.0, [1.0, 2.0], [4.0, 1.0, 3.0]),
            own(5.0, [6.0, -2.0], [8.0, 2.0, 7.0]),
        ];
        let sum = shared().sum(&each);
        assert_eq!(sum.cost, 10.0 + 5.0);
        assert_eq!(sum.gradient.as_slice(), [1.0 + 0.5 * 6.0, 2.0, -2.0]);
        let expected = [
            [4.0 + 0.25 * 8.0, 1.0, 0.5 * 2.0],
            [1.0, 3.0, 0.0],
            [0.5 * 2.0, 0.0, 7.0],
        ];
        for (i, row) in expected.iter().enumerate() {
            for (j, x) in row.iter().enumerate() {
                assert_eq!(sum.matrix[(i, j)], *x, "{i} {j}");
            }
        }
    }

    #[test]
    fn a_rides_covariance_is_its_part_of_the_whole_in_its_own_numbers() {
        let whole = DMatrix::from_row_slice(3, 3, &[4.0, 1.0, 2.0, 1.0, 9.0, 3.0, 2.0, 3.0, 16.0]);
        let second = shared().covariance(1, &whole);
        let expected = [0.25 * 4.0, 0.5 * 2.0, 0.5 * 2.0, 16.0];
        assert_eq!(second, DMatrix::from_row_slice(2, 2, &expected));
    }

    #[test]
    fn rides_of_one_bicycle_have_one_spring_and_damper() {
        let datasets = rides();
        let fitters = datasets.each_ref().map(example::fitter);
        let together = together(&fitters, Common::EffectsAndAxles);
        let starts = datasets.each_ref().map(|dataset| {
            let mut point = example::point(dataset, &unit(), vec![padded([])]);
            for (slot, times) in [
                (Slot::Base(0, Coefficient::Kappa), 1.2),
                (Slot::Base(0, Coefficient::Beta), 0.7),
            ] {
                point.set(slot, times * point.get(slot));
            }
            point
        });
        let white = vec![vec![NoiseModel::white(example::NOISE.powi(2))]; 2];
        let effort = Effort {
            iterations: 30,
            gain: 1e-6,
            substeps: 3,
        };
        let fits = together.fit(&starts, &white, effort).unwrap();
        let of = |q: usize| {
            let each = fits.iter().zip([example::FRONT, 2.0 * example::FRONT]);
            each.map(move |(fit, mass)| mass * fit.point.get(Slot::Base(0, Coefficient::ALL[q])))
        };
        let [k, same] = of(0).collect::<Vec<_>>()[..] else {
            panic!("two rides");
        };
        assert!((k / same - 1.0).abs() < 1e-9, "{k} {same}");
        assert!((k / example::K - 1.0).abs() < 0.01, "{k}");
        let b = of(1).next().unwrap();
        assert!((b / example::B - 1.0).abs() < 0.03, "{b}");
    }
}
