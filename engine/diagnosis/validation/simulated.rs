//! The model simulated along the ride from a start that was fitted to the ride's beginning, and fitted to the whole of it.

use veloid_core::numerics::autoregressive::NoiseModel;
use veloid_core::numerics::lanes::{LANES, Lanes};
use veloid_core::plant::Coefficient;
use veloid_model::dataset::{Dataset, Track};
use veloid_model::fit::{Effort, Fitted, Fitter, Model, Point, Slot, Unit, sandwich};

/// Time (s) at the beginning of the ride to which the start is fitted, and periods of the axle that it holds at least where a rest point is
/// fitted too.
const START_S: f64 = 1.0;
const PERIODS: f64 = 2.0;
/// Part of a short ride that it takes at most.
const MOST: f64 = 0.25;
/// Samples without which nothing is compared.
const LEAST: usize = 40;
/// Fits of the model to the ride, each under the noise of the one before.
const REFITS: usize = 2;

/// How a simulation starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// As suits the beginning of the ride best.
    Fitted,
    /// At rest, on the road where there is one.
    AtRest,
}

/// Axles that move together, on the ride.
pub struct Simulated {
    pub unit: Unit,
    pub point: Point,
    /// Measured minus predicted by track of the unit; 0 where not valid.
    pub residuals: Vec<Vec<f64>>,
    /// First sample that is compared.
    pub from: usize,
}

impl Simulated {
    /// The model along the ride.
    ///
    /// # Errors
    /// Why there is nothing to compare.
    pub fn new(dataset: &Dataset, unit: Unit, point: Point) -> Result<Self, &'static str> {
        const DIVERGES: &str = "the model diverges along this ride";
        let first = |t: &usize| first_compared(&dataset.tracks[*t]);
        let from = unit.tracks.iter().map(first).max().unwrap_or(0);
        let enough = |t: &usize| {
            let valid = dataset.tracks[*t].valid.get(from..).unwrap_or_default();
            valid.iter().filter(|v| **v).count() >= LEAST
        };
        if !unit.tracks.iter().all(enough) {
            return Err(
                "fewer than 40 samples are left behind the part that the start is fitted to",
            );
        }
        let substeps = unit.fine_substeps(dataset, &point);
        let point = started(dataset, &unit, point, substeps).ok_or(DIVERGES)?;
        let whole = Fitter {
            dataset,
            samples: dataset.samples,
        };
        let residuals = whole.residuals(&unit, &point, substeps);
        let is_finite = residuals.iter().flatten().all(|r| r.is_finite());
        match is_finite {
            true => Ok(Self {
                unit,
                point,
                residuals,
                from,
            }),
            false => Err(DIVERGES),
        }
    }

    /// The same model with all its numbers fitted to the compared part of the ride, which is all that is valid in the dataset beside it.
    pub fn refitted(&self, dataset: &Dataset) -> Option<(Dataset, Model)> {
        let mut compared = dataset.clone();
        for t in &self.unit.tracks {
            compared.tracks[*t].valid[..self.from].fill(false);
        }
        let fitter = Fitter {
            dataset: &compared,
            samples: compared.samples,
        };
        let mut point = self.point.clone();
        let mut residuals = self.residuals.clone();
        let mut fitted: Option<Fitted> = None;
        for _ in 0..REFITS {
            for residual in &mut residuals {
                residual[..self.from].fill(0.0);
            }
            let noise = |r: &Vec<f64>| NoiseModel::of_order(r, compared.noise_order);
            let noise: Vec<NoiseModel> = residuals.iter().map(noise).collect();
            let effort = Effort {
                iterations: 30,
                gain: 1e-3,
                substeps: self.unit.fine_substeps(&compared, &point),
            };
            let fit = fitter.fit(&self.unit, point, &noise, effort)?;
            (point, residuals) = (fit.point.clone(), fit.residuals.clone());
            fitted = Some(fit);
        }
        let model = Model::new(self.unit.terms.clone(), vec![fitted?]);
        let model = sandwich::widened(&fitter, &model, model.clone());
        Some((compared, model))
    }
}

/// What the model predicts at every sample, by track of the unit; nothing where it diverges.
pub fn predicted(
    dataset: &Dataset,
    unit: &Unit,
    point: Point,
    start: Start,
) -> Option<Vec<Vec<f64>>> {
    let substeps = unit.fine_substeps(dataset, &point);
    let point = match start {
        Start::Fitted => started(dataset, unit, point, substeps)?,
        Start::AtRest => at_rest(dataset, unit, point),
    };
    let points: [Point; LANES] = std::array::from_fn(|_| point.clone());
    let predicted = unit.simulate(dataset, &points, None, 0..dataset.samples, substeps);
    let lane = |values: Vec<Lanes>| values.iter().map(|x| x.0[0]).collect();
    let predicted: Vec<Vec<f64>> = predicted.into_iter().map(lane).collect();
    let is_finite = predicted.iter().flatten().all(|x| x.is_finite());
    is_finite.then_some(predicted)
}

/// Samples to which the start is fitted: all of a free decay, which is nothing but its start, and of a mass that no spring holds, which never
/// forgets it.
pub fn beginning(track: &Track) -> usize {
    if keeps_its_start(track) {
        return track.valid.len();
    }
    let swings = match track.rest_point && track.swings() {
        true => PERIODS * track.scale.period(),
        false => 0.0,
    };
    let samples = (START_S.max(swings) / track.input.step).ceil() as usize;
    let first = track.valid.iter().position(|v| *v).unwrap_or(0);
    first + samples.min((MOST * track.valid.len() as f64) as usize)
}

fn keeps_its_start(track: &Track) -> bool {
    !track.is_driven() || (track.plant.moves() && !track.swings())
}

fn first_compared(track: &Track) -> usize {
    match keeps_its_start(track) {
        true => 0,
        false => beginning(track),
    }
}

/// The point with the start, and the rest point where the ride has one, that suit the ride's beginning best.
fn started(dataset: &Dataset, unit: &Unit, point: Point, substeps: usize) -> Option<Point> {
    let samples = unit.tracks.iter().map(|t| beginning(&dataset.tracks[*t]));
    let samples = samples.max()?.min(dataset.samples);
    let fitter = Fitter { dataset, samples };
    let is_of_start =
        |slot: &Slot| slot.is_start() || matches!(slot, Slot::Base(_, Coefficient::Constant));
    let slots = unit.slots(dataset).into_iter().filter(is_of_start);
    let slots: Vec<Slot> = slots.collect();
    if slots.is_empty() {
        return Some(point);
    }
    let loudness = |t: &usize| dataset.tracks[*t].spread().powi(2).max(f64::MIN_POSITIVE);
    let noise = unit.tracks.iter().map(|t| NoiseModel::white(loudness(t)));
    let noise: Vec<NoiseModel> = noise.collect();
    let effort = Effort {
        iterations: 20,
        gain: 1e-6,
        substeps,
    };
    let fitted = fitter.fit_over(&slots, unit, point, &noise, effort)?;
    Some(fitted.point)
}

/// The point at rest: on the road where there is one, else where it is.
fn at_rest(dataset: &Dataset, unit: &Unit, mut point: Point) -> Point {
    for (base, t) in point.base.iter_mut().zip(&unit.tracks) {
        let track = &dataset.tracks[*t];
        if track.has_road && track.plant.moves() {
            base.height = track.input.road[0];
        }
    }
    point
}
