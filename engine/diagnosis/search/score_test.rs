//! What an effect would add to a fitted model's residual, to first order: its signature, whitened and
//! without what the model's own parameters can do.

use nalgebra::{DMatrix, DVector};

use crate::diagnosis::dataset::Scene;
use crate::diagnosis::fit::COARSE;
use crate::diagnosis::fit::fitter::whitened;
use crate::diagnosis::fit::tangent::{Tangent, spread, tangent_for};
use crate::diagnosis::fit::{Fitter, Model, Point, Term, Unit};
use crate::diagnosis::law::{MAX_PARAMETERS, Values};
use crate::diagnosis::residual::replicate::exceeds;
use crate::numerics::lanes::{LANES, Lanes};
use crate::numerics::projection::{dot, orthonormal, without};

/// Whitened, projected signatures of one candidate: what it would add to the residual.
pub struct Signatures {
    pub term: Term,
    /// One entry for each start: its parameters scaled to the residual, the gain in log likelihood
    /// that a linear fit of it promises, and the projected columns by axle of the unit.
    pub starts: Vec<Promise>,
}

impl Signatures {
    /// Gain that the best start promises.
    pub fn promise(&self) -> f64 {
        self.starts.iter().map(|p| p.gain).fold(0.0, f64::max)
    }
}

pub struct Promise {
    pub values: Values,
    /// The start before scaling, and the length of what it adds in standard deviations of the noise.
    pub unit: Values,
    pub size: f64,
    pub gain: f64,
    /// Orthonormal columns that span what the start adds, orthogonal to the model's own derivatives,
    /// all axles of the unit one after the other.
    pub basis: Vec<Vec<f64>>,
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
        base.initial.insert(at, [0.0; 2]);
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
        for chunk in values.chunks(LANES - 1) {
            let mut points: [Point; LANES] = std::array::from_fn(|_| base.clone());
            for (lane, values) in chunk.iter().enumerate() {
                points[lane + 1].values[at] = *values;
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

    /// Signatures of adding `term` at each of its starts; those without any effect are left out.
    pub fn signatures(&self, fitter: &Fitter, term: Term, substeps: usize) -> Signatures {
        let scene = fitter.scene;
        let (unit, at, base) = self.with(term);
        let spec = term.kind.spec();
        let starts = (spec.starts)(unit.scale(scene, at));
        let promise = |starts: &[Values]| -> Vec<Promise> {
            let mut columns: Vec<Vec<f64>> = Vec::new();
            for chunk in starts.chunks(LANES - 1) {
                let mut points: [Point; LANES] = std::array::from_fn(|_| base.clone());
                for (lane, start) in chunk.iter().enumerate() {
                    points[lane + 1].values[at] = *start;
                }
                columns.extend(self.departures(fitter, &unit, &points, substeps, chunk.len()));
            }
            let group = if spec.amplitudes.len() == 2 { 2 } else { 1 };
            starts
                .chunks(group)
                .zip(columns.chunks(group))
                .filter_map(|(starts, columns)| self.promise(&unit, at, starts, columns, scene))
                .collect()
        };
        let mut promises = promise(&starts);
        for zoom in 1..=3 {
            let best = promises.iter().max_by(|a, b| a.gain.total_cmp(&b.gain));
            let nearer = best.map_or(Vec::new(), |p| {
                (spec.nearer)(&p.values, unit.scale(scene, at), zoom)
            });
            promises.extend(promise(&nearer));
        }
        Signatures {
            term,
            starts: promises,
        }
    }

    /// Whitened departures of each lane from this model's own motion.
    fn departures(
        &self,
        fitter: &Fitter,
        unit: &Unit,
        points: &[Point; LANES],
        substeps: usize,
        count: usize,
    ) -> Vec<Vec<f64>> {
        let moved = unit.simulate(fitter.scene, points, None, fitter.samples, substeps);
        let mut columns = vec![Vec::new(); count];
        for ((z, z0), (t, colour)) in moved
            .iter()
            .zip(&self.own)
            .zip(unit.tracks.iter().zip(&self.colours))
        {
            let valid = &fitter.scene.tracks[*t].valid;
            let raw: Vec<Lanes> = (0..fitter.samples)
                .map(|i| if valid[i] { z[i] - z0[i] } else { Lanes::ZERO })
                .collect();
            spread(&whitened(&raw, &colour.a), colour, count, &mut columns);
        }
        columns
    }

    fn promise(
        &self,
        unit: &Unit,
        at: usize,
        starts: &[Values],
        columns: &[Vec<f64>],
        scene: &Scene,
    ) -> Option<Promise> {
        if columns.iter().any(|c| c.iter().any(|x| !x.is_finite())) {
            return None;
        }
        let n = columns.len();
        let projected: Vec<Vec<f64>> = columns.iter().map(|c| without(c, &self.basis)).collect();
        for (raw, left) in columns.iter().zip(&projected) {
            // Nothing left after projection: the model's own parameters do the same.
            if !(dot(left, left) > 1e-7 * dot(raw, raw) && dot(left, left) > 1e-8) {
                return None;
            }
        }
        let h = DMatrix::from_fn(n, n, |i, j| dot(&projected[i], &projected[j]));
        let g = DVector::from_fn(n, |i, _| dot(&projected[i], &self.residual));
        let amounts = h.clone().cholesky()?.solve(&g);
        let gain = 0.5 * amounts.dot(&g);
        let spec = unit.terms[at].kind.spec();
        let mut values = starts[0];
        for (slot, amount) in spec.amplitudes.iter().zip(amounts.iter()) {
            let parameter = &spec.parameters[*slot];
            let [low, high] = (parameter.limits)(unit.scale(scene, at));
            let start = starts[if n == 2 { *slot } else { 0 }][*slot];
            values[*slot] = (start * amount).max(low).min(high);
        }
        Some(Promise {
            values,
            unit: starts[0],
            size: h[(0, 0)].sqrt(),
            gain,
            basis: orthonormal(projected, &[]),
        })
    }
}

/// Whether `term` gains more on the ride, to first order, than on its replicates under `model`.
pub fn stands_out(fitter: &Fitter, model: &Model, term: Term, seed: u64) -> bool {
    let substeps = model.substeps(fitter.scene, COARSE);
    let score = |scene: &Scene| {
        let fitter = Fitter {
            scene,
            samples: fitter.samples,
        };
        let tangent = tangent_for(&fitter, model, term, substeps);
        (2.0 * tangent.signatures(&fitter, term, substeps).promise()).sqrt()
    };
    let own = score(fitter.scene);
    exceeds(own, fitter.scene, model, seed, score)
}
