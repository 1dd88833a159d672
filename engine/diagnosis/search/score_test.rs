//! What an effect would add to a fitted model's residual, to first order: its signature, whitened and
//! without what the model's own parameters can do.

use nalgebra::{DMatrix, DVector};

use crate::residual::replicate::exceeds;
use veloid_core::numerics::lanes::LANES;
use veloid_core::numerics::projection::{dot, orthonormal, without};
use veloid_model::dataset::Dataset;
use veloid_model::fit::COARSE;
use veloid_model::fit::tangent::{Tangent, tangent_for};
use veloid_model::fit::{Fitter, Model, Point, Term, Unit};
use veloid_model::law::Values;

/// Whitened, projected signatures of one candidate: what it would add to the residual.
pub struct Signatures {
    pub term: Term,
    /// One entry for each start: its parameters scaled to the residual, the gain in log likelihood
    /// that a linear fit of it predicts, and the projected columns by axle of the unit.
    pub starts: Vec<Prediction>,
    /// How many of them, the first ones, do not depend on the residual; the others lie about the best of these.
    pub given: usize,
}

impl Signatures {
    /// Gain that the best start predicts.
    pub fn predicted_gain(&self) -> f64 {
        self.starts.iter().map(|p| p.gain).fold(0.0, f64::max)
    }
}

pub struct Prediction {
    pub values: Values,
    /// The start before scaling, and the length of what it adds in standard deviations of the noise.
    pub unit: Values,
    pub size: f64,
    pub gain: f64,
    /// Orthonormal columns that span what the start adds, orthogonal to the model's own derivatives,
    /// all axles of the unit one after the other.
    pub basis: Vec<Vec<f64>>,
}

/// A fitted model of a ride, along which effects are looked for.
pub struct Along<'a> {
    pub fitter: &'a Fitter<'a>,
    pub tangent: &'a Tangent,
    pub substeps: usize,
}

/// Signatures of adding `term` to all rides alike at each of its starts, as the first ride's sizes give them; those without any
/// effect are left out.
pub fn signatures(rides: &[Along], term: Term) -> Signatures {
    let dataset = rides[0].fitter.dataset;
    let (unit, at, _) = rides[0].tangent.with(term);
    let spec = term.kind.spec();
    let group = if spec.amplitudes.len() == 2 { 2 } else { 1 };
    let predicted_gains = |starts: &[Values]| -> Vec<Prediction> {
        let columns: Vec<_> = rides.iter().map(|r| r.columns(term, starts)).collect();
        let predicted_gain = |(i, starts): (usize, &[Values])| {
            let columns = columns
                .iter()
                .map(|c| &c[i * group..i * group + starts.len()]);
            predicted_gain(rides, (&unit, at), starts, columns.collect())
        };
        starts
            .chunks(group)
            .enumerate()
            .filter_map(predicted_gain)
            .collect()
    };
    let mut found = predicted_gains(&(spec.starts)(unit.scale(dataset, at)));
    let given = found.len();
    for zoom in 1..=3 {
        let best = found.iter().max_by(|a, b| a.gain.total_cmp(&b.gain));
        let nearer = best.map_or(Vec::new(), |p| {
            (spec.nearer)(&p.values, unit.scale(dataset, at), zoom)
        });
        found.extend(predicted_gains(&nearer));
    }
    Signatures {
        term,
        starts: found,
        given,
    }
}

impl Along<'_> {
    /// What `term` adds to the ride at each of its starts, whitened.
    fn columns(&self, term: Term, starts: &[Values]) -> Vec<Vec<f64>> {
        let (unit, at, base) = self.tangent.with(term);
        let mut columns = Vec::new();
        for chunk in starts.chunks(LANES) {
            let mut points: [Point; LANES] = std::array::from_fn(|_| base.clone());
            for (lane, start) in chunk.iter().enumerate() {
                points[lane].values[at] = *start;
            }
            columns.extend(self.tangent.departures(
                self.fitter,
                &unit,
                &points,
                self.substeps,
                chunk.len(),
            ));
        }
        columns
    }
}

/// What starts with one direction each are predicted to gain together; `columns` by ride.
fn predicted_gain(
    rides: &[Along],
    (unit, at): (&Unit, usize),
    starts: &[Values],
    columns: Vec<&[Vec<f64>]>,
) -> Option<Prediction> {
    let n = starts.len();
    if !columns
        .iter()
        .all(|c| c.iter().flatten().all(|x| x.is_finite()))
    {
        return None;
    }
    let left = |i: usize| {
        let each = rides.iter().zip(&columns);
        let each = each.map(|(ride, c)| without(&c[i], &ride.tangent.basis));
        joined(unit.tracks.len(), each.collect())
    };
    let projected: Vec<Vec<f64>> = (0..n).map(left).collect();
    for (i, left) in projected.iter().enumerate() {
        let raw: f64 = columns.iter().map(|c| dot(&c[i], &c[i])).sum();
        // Nothing left after projection: the model's own parameters do the same.
        if !(dot(left, left) > 1e-7 * raw && dot(left, left) > 1e-8) {
            return None;
        }
    }
    let residuals = rides.iter().map(|r| r.tangent.residual.clone());
    let residual = joined(unit.tracks.len(), residuals.collect());
    let h = DMatrix::from_fn(n, n, |i, j| dot(&projected[i], &projected[j]));
    let g = DVector::from_fn(n, |i, _| dot(&projected[i], &residual));
    let amounts = h.clone().cholesky()?.solve(&g);
    let gain = 0.5 * amounts.dot(&g);
    let spec = unit.terms[at].kind.spec();
    let mut values = starts[0];
    for (slot, amount) in spec.amplitudes.iter().zip(amounts.iter()) {
        let parameter = &spec.parameters[*slot];
        let [low, high] = (parameter.limits)(unit.scale(rides[0].fitter.dataset, at));
        let start = starts[if n == 2 { *slot } else { 0 }][*slot];
        values[*slot] = (start * amount).max(low).min(high);
    }
    Some(Prediction {
        values,
        unit: starts[0],
        size: h[(0, 0)].sqrt(),
        gain,
        basis: orthonormal(projected, &[]),
    })
}

/// Columns of several rides as one: the first axle of all of them, then the second.
fn joined(axles: usize, mut rides: Vec<Vec<f64>>) -> Vec<f64> {
    if rides.len() == 1 {
        return rides.remove(0);
    }
    let part = |a: usize| {
        let of_axle =
            move |x: &Vec<f64>| x[a * x.len() / axles..(a + 1) * x.len() / axles].to_vec();
        rides.iter().flat_map(of_axle)
    };
    (0..axles).flat_map(part).collect()
}

/// Whether `term` gains more on rides, to first order, than on their replicates under their models.
pub fn stands_out(rides: &[(&Fitter, &Model)], term: Term, seed: u64) -> bool {
    let datasets: Vec<(&Dataset, &Model)> = rides.iter().map(|(f, m)| (f.dataset, *m)).collect();
    let score = |again: &[&Dataset]| {
        let each = rides.iter().zip(again);
        let fitters: Vec<Fitter> = each
            .map(|((fitter, _), dataset)| Fitter {
                dataset,
                samples: fitter.samples,
            })
            .collect();
        let tangents: Vec<(Tangent, usize)> = (fitters.iter().zip(rides))
            .map(|(fitter, (own, model))| {
                let substeps = model.substeps(own.dataset, COARSE);
                (tangent_for(fitter, model, term, substeps), substeps)
            })
            .collect();
        let along = (fitters.iter().zip(&tangents)).map(|(fitter, (tangent, substeps))| Along {
            fitter,
            tangent,
            substeps: *substeps,
        });
        let along: Vec<Along> = along.collect();
        (2.0 * signatures(&along, term).predicted_gain()).sqrt()
    };
    let recorded: Vec<&Dataset> = datasets.iter().map(|(dataset, _)| *dataset).collect();
    exceeds(score(&recorded), &datasets, seed, |again| {
        score(&again.iter().collect::<Vec<_>>())
    })
}
