//! What a fitted model's own parameters do to its residual, to first order.

use super::fitter::Fitter;
use super::model::Model;
use super::normal_equations::whitened;
use super::unit::{Point, Term, Unit};
use crate::law::{AT_REST, MAX_PARAMETERS, Values};
use veloid_core::numerics::autoregressive::NoiseModel;
use veloid_core::numerics::lanes::{LANES, Lanes};
use veloid_core::numerics::projection::{dot, orthonormal, without};

/// The model's own whitened derivatives of one unit, as an orthonormal basis, and its whitened
/// residual in units of its standard deviation.
pub struct Tangent {
    pub unit: Unit,
    pub point: Point,
    pub basis: Vec<Vec<f64>>,
    pub residual: Vec<f64>,
    pub noise_models: Vec<NoiseModel>,
    /// Displacement of the model itself, by axle of the unit.
    pub own: Vec<Vec<f64>>,
}

impl Tangent {
    pub fn new(fitter: &Fitter, model: &Model, unit: &Unit, substeps: usize) -> Self {
        let (point, noise_models) = model.carried(unit);
        let slots = unit.slots(fitter.dataset);
        let own: [Point; LANES] = std::array::from_fn(|_| point.clone());
        let own = unit
            .simulate(fitter.dataset, &own, None, 0..fitter.samples, substeps)
            .iter()
            .map(|z| z.iter().map(|z| z.0[0]).collect())
            .collect();
        let mut columns = Vec::new();
        let mut residual = Vec::new();
        for chunk in slots.chunks(LANES - 1) {
            let mut points: [Point; LANES] = std::array::from_fn(|_| point.clone());
            for (lane, slot) in chunk.iter().enumerate() {
                let (size, _) = unit.range(fitter.dataset, *slot);
                let value = point.get(*slot);
                points[lane + 1].set(*slot, value + 1e-4 * size.abs().max(value.abs()));
            }
            let found = differences(fitter, unit, &points, &noise_models, substeps, chunk.len());
            residual = found.0;
            columns.extend(found.1);
        }
        Self {
            unit: unit.clone(),
            point,
            basis: orthonormal(columns, &[]),
            residual,
            noise_models,
            own,
        }
    }
}

/// Residual and differences of the lanes to lane 0, whitened and over the noise's deviation.
fn differences(
    fitter: &Fitter,
    unit: &Unit,
    points: &[Point; LANES],
    noise_models: &[NoiseModel],
    substeps: usize,
    count: usize,
) -> (Vec<f64>, Vec<Vec<f64>>) {
    let moved = unit.simulate(fitter.dataset, points, None, 0..fitter.samples, substeps);
    let mut columns = vec![Vec::new(); count];
    let mut residual = Vec::new();
    for ((z, t), noise_model) in moved.iter().zip(&unit.tracks).zip(noise_models) {
        let track = &fitter.dataset.tracks[*t];
        let raw: Vec<Lanes> = (0..fitter.samples)
            .map(|i| {
                if !track.valid[i] {
                    return Lanes::ZERO;
                }
                let base = z[i].0[0];
                let mut out = z[i] - base;
                out.0[0] = track.measured[i] - base;
                out
            })
            .collect();
        let white = whitened(&raw, &noise_model.a);
        let per = noise_model.variance.sqrt().recip();
        residual.extend(white.iter().map(|x| x.0[0] * per));
        spread(&white, noise_model, 1, &mut columns);
    }
    (residual, columns)
}

/// Appends the lanes from `first` on to the columns, in standard deviations.
pub fn spread(white: &[Lanes], noise_model: &NoiseModel, first: usize, columns: &mut [Vec<f64>]) {
    let per = noise_model.variance.sqrt().recip();
    for (lane, column) in (first..).zip(columns) {
        column.extend(white.iter().map(|x| x.0[lane] * per));
    }
}

/// Tangents for adding terms on one axle and on both: the units a new term may belong to.
pub fn tangent_for(fitter: &Fitter, model: &Model, term: Term, substeps: usize) -> Tangent {
    let dataset = fitter.dataset;
    let mut terms = model.terms.clone();
    terms.push(term);
    let unit = Unit::all(dataset, &terms)
        .into_iter()
        .find(|u| u.terms.contains(&term));
    let mut unit = unit.unwrap_or(Unit {
        tracks: vec![0],
        terms: Vec::new(),
    });
    unit.terms.retain(|t| *t != term);
    Tangent::new(fitter, model, &unit, substeps)
}

impl Tangent {
    /// The unit with `term` at zero added, and which of its terms that is.
    pub fn with(&self, term: Term) -> (Unit, usize, Point) {
        let mut terms = self.unit.terms.clone();
        terms.push(term);
        terms.sort();
        let unit = Unit {
            tracks: self.unit.tracks.clone(),
            terms,
        };
        let at = unit.terms.iter().position(|t| *t == term).unwrap_or(0);
        let mut base = self.point.clone();
        base.values.insert(at, [0.0; MAX_PARAMETERS]);
        base.initial.insert(at, AT_REST);
        (unit, at, base)
    }

    /// Length (deviations of the noise) of what `term` adds at each of some values and the model's own parameters
    /// cannot do; infinite where the integrator does not follow.
    pub fn lengths(
        &self,
        fitter: &Fitter,
        term: Term,
        values: &[Values],
        substeps: usize,
    ) -> Vec<f64> {
        let (unit, at, base) = self.with(term);
        let mut lengths = Vec::new();
        for chunk in values.chunks(LANES) {
            let mut points: [Point; LANES] = std::array::from_fn(|_| base.clone());
            for (lane, values) in chunk.iter().enumerate() {
                points[lane].values[at] = *values;
            }
            for column in self.departures(fitter, &unit, &points, substeps, chunk.len()) {
                let left = without(&column, &self.basis);
                let square = dot(&left, &left);
                lengths.push(if square.is_finite() {
                    square.sqrt()
                } else {
                    f64::INFINITY
                });
            }
        }
        lengths
    }

    /// Whitened departures of each lane from this model's own motion.
    pub fn departures(
        &self,
        fitter: &Fitter,
        unit: &Unit,
        points: &[Point; LANES],
        substeps: usize,
        count: usize,
    ) -> Vec<Vec<f64>> {
        let moved = unit.simulate(fitter.dataset, points, None, 0..fitter.samples, substeps);
        let mut columns = vec![Vec::new(); count];
        for ((z, z0), (t, noise_model)) in moved
            .iter()
            .zip(&self.own)
            .zip(unit.tracks.iter().zip(&self.noise_models))
        {
            let valid = &fitter.dataset.tracks[*t].valid;
            let raw: Vec<Lanes> = (0..fitter.samples)
                .map(|i| if valid[i] { z[i] - z0[i] } else { Lanes::ZERO })
                .collect();
            let white = whitened(&raw, &noise_model.a);
            spread(&white, noise_model, 0, &mut columns);
        }
        columns
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Kind;
    use crate::example;
    use veloid_core::bicycle::Axle;
    use veloid_core::numerics::projection::dot;

    #[test]
    fn columns_are_lanes_in_standard_deviations() {
        let white = [1.0, 2.0].map(|by| Lanes(std::array::from_fn(|i| by * i as f64)));
        let mut columns = vec![vec![-1.0], Vec::new(), vec![7.0]];
        spread(&white, &NoiseModel::white(4.0), 1, &mut columns[..2]);
        assert_eq!(columns, [vec![-1.0, 0.5, 1.0], vec![1.0, 2.0], vec![7.0]]);
        spread(&white, &NoiseModel::white(1.0), 0, &mut columns[2..]);
        assert_eq!(columns[2], [7.0, 0.0, 0.0]);
    }

    #[test]
    fn a_tangent_holds_what_every_number_of_the_model_does() {
        let dataset = example::dataset();
        let fitter = example::fitter(&dataset);
        let model = example::model(&dataset, &[]);
        let unit = model.fits[0].unit.clone();
        let tangent = Tangent::new(&fitter, &model, &unit, 2);
        assert_eq!(tangent.basis.len(), unit.slots(&dataset).len());
        for (i, a) in tangent.basis.iter().enumerate() {
            for (j, b) in tangent.basis.iter().enumerate() {
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((dot(a, b) - expected).abs() < 1e-6);
            }
        }
        // A larger z(0) decays as the axle swings: e^{-bt/2} (cos wt + b/2w sin wt).
        let (b, kappa) = (example::B / example::FRONT, example::K / example::FRONT);
        let w = (kappa - 0.25 * b * b).sqrt();
        let swing = |i: usize| {
            let t = dataset.step * i as f64;
            let swing = (-0.5 * b * t).exp() * ((w * t).cos() + 0.5 * b / w * (w * t).sin());
            if dataset.tracks[0].valid[i] {
                swing
            } else {
                0.0
            }
        };
        let decay: Vec<f64> = (0..fitter.samples).map(swing).collect();
        let inside: f64 = tangent.basis.iter().map(|a| dot(a, &decay).powi(2)).sum();
        let all = dot(&decay, &decay);
        assert!((inside / all - 1.0).abs() < 1e-3, "{inside} of {all}");
    }

    #[test]
    fn a_term_is_tried_on_the_axles_that_it_would_join() {
        let dataset = example::dataset();
        let fitter = example::fitter(&dataset);
        let cubic = example::term(Kind::CubicStiffness, Axle::Front);
        let model = example::model(&dataset, &[(cubic, 0.0)]);
        let of = |axle| {
            let gain = example::term(Kind::SensorGain, axle);
            tangent_for(&fitter, &model, gain, 2).unit
        };
        assert_eq!(
            (of(Axle::Front).tracks, of(Axle::Front).terms),
            (vec![0], vec![cubic])
        );
        assert_eq!(
            (of(Axle::Rear).tracks, of(Axle::Rear).terms),
            (vec![1], vec![])
        );
    }
}
