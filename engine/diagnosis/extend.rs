//! Adding one effect to a fitted model: signatures from the model's own simulated motion say where
//! to start, an exact refit says how well it fits.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::output_error::colour::Colour;
use crate::simulate::lanes::{LANES, Lanes, widest};

use super::effects::{ALL, Acts, FOILS, Values};
use super::fit::{Effort, Fitted, Fitter, whitened};
use super::model::{Point, Term, Unit};
use super::scene::Scene;
use super::{Place, SwitchedOff};

/// A set of effects, exactly fitted.
#[derive(Clone, Debug)]
pub struct Model {
    pub terms: Vec<Term>,
    pub fits: Vec<Fitted>,
    /// Sum of the units' profile log likelihoods.
    pub likelihood: f64,
}

impl Model {
    pub fn new(mut terms: Vec<Term>, fits: Vec<Fitted>) -> Self {
        terms.sort();
        let likelihood = fits.iter().map(|f| f.likelihood).sum();
        Self {
            terms,
            fits,
            likelihood,
        }
    }

    /// Steps of the integrator for each sample, so that the stiffest axle turns by no more than `angle`
    /// (rad) in one.
    pub fn substeps(&self, scene: &Scene, angle: f64) -> usize {
        let mut fastest: f64 = 0.0;
        for fit in &self.fits {
            for t in &fit.unit.tracks {
                let track = &scene.tracks[*t];
                let added: f64 = fit
                    .unit
                    .terms
                    .iter()
                    .zip(&fit.point.values)
                    .filter(|(term, _)| term.acts_on(track.axle))
                    .map(|(term, values)| (term.kind.spec().stiffens)(values, &track.scale))
                    .sum();
                let s = &track.scale;
                fastest = fastest
                    .max((s.k_size().min(4.0 * s.k.abs()) + added) / s.mass)
                    .max(0.0);
            }
        }
        ((fastest.sqrt() * scene.step / angle).ceil() as usize).clamp(1, 20)
    }

    /// Noise of one track's residual.
    pub fn colour(&self, track: usize) -> &Colour {
        let (fit, a) = self.of_track(track);
        &fit.colours[a]
    }

    /// The fit that a track belongs to, and which of its axles it is.
    pub fn of_track(&self, track: usize) -> (&Fitted, usize) {
        self.fits
            .iter()
            .find_map(|f| {
                f.unit
                    .tracks
                    .iter()
                    .position(|t| *t == track)
                    .map(|a| (f, a))
            })
            .unwrap_or((&self.fits[0], 0))
    }

    /// Where a fit of `unit` starts when this model is what is known: new terms at zero.
    fn carried(&self, unit: &Unit) -> (Point, Vec<Colour>) {
        let mut point = Point {
            base: Vec::new(),
            values: Vec::new(),
            initial: Vec::new(),
        };
        let mut colours = Vec::new();
        for t in &unit.tracks {
            let (fit, a) = self.of_track(*t);
            point.base.push(fit.point.base[a]);
            colours.push(fit.colours[a].clone());
        }
        for term in &unit.terms {
            let known = self
                .fits
                .iter()
                .find_map(|f| f.unit.terms.iter().position(|t| t == term).map(|i| (f, i)));
            point
                .values
                .push(known.map_or([0.0; 3], |(f, i)| f.point.values[i]));
            point
                .initial
                .push(known.map_or([0.0; 2], |(f, i)| f.point.initial[i]));
        }
        (point, colours)
    }
}

/// Everything that may be named on this ride, and what may not, with the reason.
pub fn candidates(scene: &Scene) -> (Vec<Term>, Vec<SwitchedOff>) {
    let mut terms = Vec::new();
    let mut off: Vec<SwitchedOff> = Vec::new();
    for kind in ALL.iter().filter(|k| !FOILS.contains(k)) {
        let spec = kind.spec();
        let mut why = None;
        let mut allowed = Vec::new();
        for track in &scene.tracks {
            match spec.needs.iter().find_map(|n| scene.lacks(track, *n)) {
                Some(w) => why = Some(w),
                None => allowed.push(track.axle),
            }
        }
        let place = |axle| {
            if axle == crate::bicycle::Axle::Front {
                Place::Front
            } else {
                Place::Rear
            }
        };
        match spec.acts {
            Acts::OneAxle => terms.extend(allowed.iter().map(|a| Term {
                kind: *kind,
                place: place(*a),
            })),
            Acts::Rear => terms.extend(
                allowed
                    .iter()
                    .map(|a| place(*a))
                    .filter(|p| *p == Place::Rear)
                    .map(|p| Term {
                        kind: *kind,
                        place: p,
                    }),
            ),
            Acts::Both if allowed.len() == 2 => terms.push(Term {
                kind: *kind,
                place: Place::Both,
            }),
            Acts::Both => why = why.or(Some("both axles are needed")),
        }
        if let Some(why) = why {
            off.push(SwitchedOff {
                id: spec.id.to_owned(),
                why: why.to_owned(),
            });
        }
    }
    (terms, off)
}

/// Whitened, projected signatures of one candidate: what it would add to the residual.
pub struct Signatures {
    pub term: Term,
    /// One entry for each start: its parameters scaled to the residual, the gain in log likelihood
    /// that a linear fit of it promises, and the projected columns by axle of the unit.
    pub starts: Vec<Promise>,
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

/// The model's own whitened derivatives of one unit, as an orthonormal basis, and its whitened
/// residual in units of its standard deviation.
pub struct Tangent {
    pub unit: Unit,
    pub point: Point,
    pub basis: Vec<Vec<f64>>,
    pub residual: Vec<f64>,
    colours: Vec<Colour>,
    /// Displacement of the model itself, by axle of the unit.
    own: Vec<Vec<f64>>,
}

impl Tangent {
    pub fn new(fitter: &Fitter, model: &Model, unit: &Unit, substeps: usize) -> Self {
        let (point, colours) = model.carried(unit);
        let slots = unit.slots(fitter.scene);
        let own: [Point; LANES] = std::array::from_fn(|_| point.clone());
        let own = unit
            .simulate(fitter.scene, &own, None, fitter.samples, substeps)
            .iter()
            .map(|z| z.iter().map(|z| z.0[0]).collect())
            .collect();
        let mut columns = Vec::new();
        let mut residual = Vec::new();
        for chunk in slots.chunks(LANES - 1) {
            let mut points: [Point; LANES] = std::array::from_fn(|_| point.clone());
            for (lane, slot) in chunk.iter().enumerate() {
                let (size, _) = unit.range(fitter.scene, *slot);
                let value = point.get(*slot);
                points[lane + 1].set(*slot, value + 1e-4 * size.abs().max(value.abs()));
            }
            let found = differences(fitter, unit, &points, &colours, substeps, chunk.len());
            residual = found.0;
            columns.extend(found.1);
        }
        Self {
            unit: unit.clone(),
            point,
            basis: orthonormal(columns, &[]),
            residual,
            colours,
            own,
        }
    }

    /// Signatures of adding `term` at each of its starts; those without any effect are left out.
    pub fn signatures(&self, fitter: &Fitter, term: Term, substeps: usize) -> Signatures {
        let scene = fitter.scene;
        let mut terms = self.unit.terms.clone();
        terms.push(term);
        terms.sort();
        let unit = Unit {
            tracks: self.unit.tracks.clone(),
            terms,
        };
        let at = unit.terms.iter().position(|t| *t == term).unwrap_or(0);
        let spec = term.kind.spec();
        let starts = (spec.starts)(unit.scale(scene, at));
        let mut base = self.point.clone();
        base.values.insert(at, [0.0; 3]);
        base.initial.insert(at, [0.0; 2]);
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

/// Residual and differences of the lanes to lane 0, whitened and over the noise's deviation.
fn differences(
    fitter: &Fitter,
    unit: &Unit,
    points: &[Point; LANES],
    colours: &[Colour],
    substeps: usize,
    count: usize,
) -> (Vec<f64>, Vec<Vec<f64>>) {
    let moved = unit.simulate(fitter.scene, points, None, fitter.samples, substeps);
    let mut columns = vec![Vec::new(); count];
    let mut residual = Vec::new();
    for ((z, t), colour) in moved.iter().zip(&unit.tracks).zip(colours) {
        let track = &fitter.scene.tracks[*t];
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
        let white = whitened(&raw, &colour.a);
        let per = colour.variance.sqrt().recip();
        residual.extend(white.iter().map(|x| x.0[0] * per));
        spread(&white, colour, count, &mut columns);
    }
    (residual, columns)
}

/// Appends lanes 1.. to the columns.
fn spread(white: &[Lanes], colour: &Colour, count: usize, columns: &mut [Vec<f64>]) {
    let per = colour.variance.sqrt().recip();
    for (lane, column) in columns.iter_mut().enumerate().take(count) {
        column.extend(white.iter().map(|x| x.0[lane + 1] * per));
    }
}

pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    widest(
        #[inline(always)]
        || {
            let (a, a_rest) = a.as_chunks::<LANES>();
            let (b, b_rest) = b.as_chunks::<LANES>();
            let mut sums = Lanes::ZERO;
            for (a, b) in a.iter().zip(b) {
                sums += Lanes(*a) * Lanes(*b);
            }
            let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
            sums.0.iter().sum::<f64>() + rest
        },
    )
}

/// What is left of `x` outside the span of an orthonormal basis.
pub fn without(x: &[f64], basis: &[Vec<f64>]) -> Vec<f64> {
    let mut left = x.to_vec();
    // Twice, against rounding.
    for _ in 0..2 {
        for b in basis {
            let along = dot(&left, b);
            for (x, b) in left.iter_mut().zip(b) {
                *x -= along * b;
            }
        }
    }
    left
}

/// Orthonormal basis of the columns outside the span of `beyond`; dependent ones are dropped.
pub fn orthonormal(columns: Vec<Vec<f64>>, beyond: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for column in columns {
        let size = dot(&column, &column);
        let mut left = without(&without(&column, beyond), &basis);
        let rest = dot(&left, &left);
        if rest > 1e-10 * size && rest.is_finite() {
            let per = rest.sqrt().recip();
            left.iter_mut().for_each(|x| *x *= per);
            basis.push(left);
        }
    }
    basis
}

/// Whether the model is so far from the ride on the axles of `unit` that its own stiffness and
/// damping may be wrong by factors, and linear promises mean little.
pub fn is_far(scene: &Scene, model: &Model, unit: &Unit) -> bool {
    unit.tracks.iter().any(|t| {
        let track = &scene.tracks[*t];
        let sensor = 0.5 * track.sensor_floor / scene.step;
        let excess = model.colour(*t).total_variance() - 1.5 * sensor;
        excess > (FAR * track.scale.d_rms).powi(2)
    })
}

/// A residual larger than this share of the deflection is far.
const FAR: f64 = 0.03;
/// Samples on which distant starts are tried.
const SHORT: usize = 1000;

/// The unit that a term joins when it is added to a model.
pub fn joined(scene: &Scene, model: &Model, term: Term) -> Option<Unit> {
    let mut terms = model.terms.clone();
    terms.push(term);
    Unit::all(scene, &terms)
        .into_iter()
        .find(|u| u.terms.contains(&term))
}

/// Where a refit starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// At the most promising linear step from the model.
    Near,
    /// At full size beside other stiffnesses.
    Far,
}

/// Refits `model` with a term added.
pub fn extend(
    fitter: &Fitter,
    model: &Model,
    signatures: &Signatures,
    effort: Effort,
    reach: Reach,
) -> Option<Model> {
    let scene = fitter.scene;
    let term = signatures.term;
    let unit = joined(scene, model, term)?;
    let at = unit.terms.iter().position(|t| *t == term)?;
    let (base, colours) = model.carried(&unit);
    let white: Vec<Colour> = colours
        .iter()
        .map(|c| Colour::white(c.total_variance()))
        .collect();
    let mut order: Vec<&Promise> = signatures.starts.iter().collect();
    order.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let near = if unit.terms[at].kind.spec().amplitudes.is_empty() {
        2
    } else {
        1
    };
    let starts: Vec<Point> = match reach {
        Reach::Near => order
            .iter()
            .take(near)
            .map(|p| with_values(&base, at, p.values))
            .collect(),
        Reach::Far => far_starts(fitter, &unit, at, &base, &white, effort),
    };
    let fit = starts
        .into_iter()
        .filter_map(|start| fitter.fit(&unit, start, &white, effort))
        .max_by(|a, b| a.likelihood.total_cmp(&b.likelihood))?;
    let mut fits = vec![fit];
    fits.extend(
        model
            .fits
            .iter()
            .filter(|f| f.unit.tracks.iter().all(|t| !unit.tracks.contains(t)))
            .cloned(),
    );
    let mut terms = model.terms.clone();
    terms.push(term);
    Some(Model::new(terms, fits))
}

fn with_values(base: &Point, at: usize, values: Values) -> Point {
    let mut point = base.clone();
    point.values[at] = values;
    point
}

/// The two best of short fits on a short part of the ride, from the effect's starts at several sizes
/// beside several stiffnesses.
fn far_starts(
    fitter: &Fitter,
    unit: &Unit,
    at: usize,
    base: &Point,
    white: &[Colour],
    effort: Effort,
) -> Vec<Point> {
    let spec = unit.terms[at].kind.spec();
    if spec.local || spec.amplitudes.len() == 2 {
        return Vec::new();
    }
    let scale = unit.scale(fitter.scene, at);
    let short = Fitter {
        scene: fitter.scene,
        samples: fitter.samples.min(SHORT),
    };
    let starts = (spec.starts)(scale);
    let sizes: &[f64] = match (spec.amplitudes.len(), starts.len()) {
        (0, _) => &[1.0],
        (_, 1) => &[1.0, 4.0, 16.0],
        _ => &[3.0],
    };
    let stiffer: &[f64] = if starts.len() > 6 {
        &[1.0]
    } else {
        &[0.1, 0.35, 1.0]
    };
    let mut ranked: Vec<(f64, Point)> = Vec::new();
    for start in starts {
        for size in sizes {
            let mut values = start;
            for a in spec.amplitudes {
                let [low, high] = (spec.parameters[*a].limits)(scale);
                values[*a] = (values[*a] * size).max(low).min(0.9 * high);
            }
            for stiffer in stiffer {
                let mut point = with_values(base, at, values);
                point.base.iter_mut().for_each(|b| b[0] *= stiffer);
                let quick = Effort {
                    iterations: 7,
                    gain: 1.0,
                    ..effort
                };
                if let Some(fit) = short.fit(unit, point, white, quick) {
                    let cost = fit.residuals.iter().flatten().map(|r| r * r).sum();
                    ranked.push((cost, fit.point));
                }
            }
        }
    }
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    ranked.truncate(2);
    ranked.into_iter().map(|(_, p)| p).collect()
}

/// Fits the model with fewer terms than `known` has, starting from there; units that do not change
/// are kept.
pub fn reduce(fitter: &Fitter, known: &Model, terms: &[Term], effort: Effort) -> Option<Model> {
    let fits = Unit::all(fitter.scene, terms)
        .into_iter()
        .map(|unit| match known.fits.iter().find(|f| f.unit == unit) {
            Some(same) => Some(same.clone()),
            None => {
                let (point, colours) = known.carried(&unit);
                fitter.fit(&unit, point, &colours, effort)
            }
        })
        .collect::<Option<Vec<_>>>()?;
    Some(Model::new(terms.to_vec(), fits))
}

/// Fits every unit again from where it is, in turns with its own noise model, until neither moves.
pub fn polish(fitter: &Fitter, model: &Model, effort: Effort) -> Option<Model> {
    let fits = model
        .fits
        .par_iter()
        .map(|f| {
            let mut best = f.clone();
            for _ in 0..5 {
                let next = fitter.fit(&best.unit, best.point.clone(), &best.colours, effort)?;
                let gained = next.likelihood - best.likelihood;
                if gained > 0.0 {
                    best = next;
                }
                if gained < 0.1 {
                    break;
                }
            }
            Some(best)
        })
        .collect::<Option<Vec<_>>>()?;
    Some(Model::new(model.terms.clone(), fits))
}

/// Tangents for adding terms on one axle and on both: the units a new term may belong to.
pub fn tangent_for(fitter: &Fitter, model: &Model, term: Term, substeps: usize) -> Tangent {
    let scene = fitter.scene;
    let mut terms = model.terms.clone();
    terms.push(term);
    let unit = Unit::all(scene, &terms)
        .into_iter()
        .find(|u| u.terms.contains(&term));
    let mut unit = unit.unwrap_or(Unit {
        tracks: vec![0],
        terms: Vec::new(),
    });
    unit.terms.retain(|t| *t != term);
    Tangent::new(fitter, model, &unit, substeps)
}
