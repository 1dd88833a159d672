//! What is searched: the ride at the rate that carries it, with noise laid over where it has none, and the plain model of it.

use std::sync::Arc;

use veloid_core::bicycle::{Bike, PerAxle};
use veloid_core::numerics::autoregressive::NoiseModel;
use veloid_core::numerics::spectrum;
use veloid_core::settings::Settings;
use veloid_core::{Divergence, EngineError};
use veloid_methods::output_error::start::starts_from;
use veloid_methods::output_error::{self, AxleFit, Split};
use veloid_model::dataset::Dataset;
use veloid_model::dataset::dither::{between, lay_over};
use veloid_model::effects::users_law;
use veloid_model::fit::model::stable_substeps;
use veloid_model::fit::{Effort, FINE, Fitter, Model, Point, Unit};
use veloid_report::diagnosis::Base;
use veloid_report::stages::Conclusion;
use veloid_ride::{AxleRecord, Ride, decimated};

/// A ride made ready for the search.
pub struct Prepared {
    pub base: Base,
    pub split: Split,
    /// Fits of the plain model to the record itself.
    pub recorded: PerAxle<AxleFit>,
    /// The same with noise laid over.
    dithered: Option<PerAxle<AxleFit>>,
    /// What is searched.
    pub dataset: Dataset,
    /// The record itself, where noise was laid over.
    undithered: Option<Dataset>,
    /// The plain model of what is searched.
    pub plain: Model,
    /// What reading the ride gave cause to say.
    pub warnings: Vec<String>,
}

impl Prepared {
    pub fn new(
        ride: &Ride,
        bike: &Bike,
        settings: &Settings,
        conclusion: &Conclusion,
        base: Base,
    ) -> Result<Self, EngineError> {
        let slower = slower(ride);
        let recorded_step = ride.step_s;
        let ride = slower.as_ref().unwrap_or(ride);
        // The density of white noise is that of the record, so a sample of several has less of it.
        let quieter = (recorded_step / ride.step_s).sqrt();
        let split = Split::of(ride, settings);
        // Every axle for itself: what one pair for both cannot say is not missing physics.
        let separate = Bike {
            equal_axles: false,
            noise_displacement_m: bike.noise_displacement_m.map(|noise| quieter * noise),
            noise_road_m: bike.noise_road_m.map(|noise| quieter * noise),
            ..bike.clone()
        };
        let starts = [
            starts_from(&conclusion.output_error),
            starts_from(&conclusion.instrumental),
        ];
        let fit = |ride: &Ride| match base {
            Base::SpringAndDamper => output_error::fit(ride, &separate, settings, &starts),
            Base::Damper => output_error::fit_without_spring(ride, &separate, settings),
        };
        let recorded = fit(ride)?;
        let between = between(ride, &separate, &recorded, split.train.end, settings.seed);
        let noise = between.noise;
        let laid_over = lay_over(ride, &noise);
        let dithered = laid_over.as_ref().map(fit).transpose()?;
        let fits = dithered.as_ref().unwrap_or(&recorded);
        let searched = laid_over.as_ref().unwrap_or(ride);
        let mut dataset = Dataset::new(searched, &separate, fits, split.train.end);
        for track in &mut dataset.tracks {
            track.unresolved = (between.unresolved.get(track.axle).copied()).unwrap_or_default();
            track.beyond_lifting =
                (between.beyond_lifting.get(track.axle).copied()).unwrap_or_default();
        }
        if base == Base::Damper {
            dataset.remove_springs();
        }
        if let Some(law) = users_law(settings)? {
            dataset.set_law(&Arc::new(law));
        }
        let fitter = Fitter {
            dataset: &dataset,
            samples: split.train.end,
        };
        Ok(Self {
            base,
            plain: plain_model(&fitter, fits)?,
            undithered: laid_over.as_ref().map(|_| dataset.without(&noise)),
            warnings: ride.summary.warnings.clone(),
            split,
            recorded,
            dithered,
            dataset,
        })
    }

    pub fn is_dithered(&self) -> bool {
        self.undithered.is_some()
    }

    /// Fits of the plain model to what is searched.
    pub fn fits(&self) -> &PerAxle<AxleFit> {
        self.dithered.as_ref().unwrap_or(&self.recorded)
    }

    /// The record itself, on which what was found is measured.
    pub fn record(&self) -> &Dataset {
        self.undithered.as_ref().unwrap_or(&self.dataset)
    }

    /// Fits what is searched.
    pub fn fitter(&self) -> Fitter<'_> {
        Fitter {
            dataset: &self.dataset,
            samples: self.split.train.end,
        }
    }

    /// Fits the record itself.
    pub fn on_record(&self) -> Fitter<'_> {
        Fitter {
            dataset: self.record(),
            samples: self.split.train.end,
        }
    }

    /// The plain model of the record itself.
    pub fn plain_of_record(&self) -> Result<Model, EngineError> {
        match self.is_dithered() {
            true => plain_model(&self.on_record(), &self.recorded),
            false => Ok(self.plain.clone()),
        }
    }
}

/// The ride at the rate that carries it; nothing where that is its own.
pub fn slower(ride: &Ride) -> Option<Ride> {
    decimated(ride, fastest(ride))
}

/// The fastest that anything in the record moves (Hz).
fn fastest(ride: &Ride) -> f64 {
    let of = |record: &AxleRecord| {
        let road = Some(&record.road).filter(|_| record.has_road());
        let channels = [Some(&record.displacement), road, record.force.as_ref()];
        let driven = record.has_road() || record.force.is_some();
        let fastest = |x: &Vec<f64>| spectrum::fastest(x, driven, ride.step_s);
        (channels.into_iter().flatten())
            .map(fastest)
            .fold(0.0, f64::max)
    };
    let axles = ride.axles.iter();
    axles.map(|(_, record)| of(record)).fold(0.0, f64::max)
}

/// The plain model of every track under its own noise.
fn plain_model(fitter: &Fitter, fits: &PerAxle<AxleFit>) -> Result<Model, EngineError> {
    let dataset = fitter.dataset;
    let mut found = Vec::new();
    for unit in Unit::all(dataset, &[]) {
        let track = &dataset.tracks[unit.tracks[0]];
        let diverged = || EngineError::Diverged {
            stage: "diagnosis",
            problem: Divergence::NoPlainModel { axle: track.axle },
        };
        let fit = fits.get(track.axle).ok_or_else(diverged)?;
        let point = Point {
            base: vec![fit.plain],
            values: Vec::new(),
            initial: Vec::new(),
        };
        let masked: Vec<f64> = (0..fitter.samples)
            .map(|i| if track.valid[i] { fit.residual[i] } else { 0.0 })
            .collect();
        let noise_models = [NoiseModel::of_order(&masked, dataset.noise_order)];
        let effort = Effort {
            iterations: 20,
            gain: 1e-3,
            substeps: plain_substeps(dataset, unit.tracks[0], fit.plain.beta),
        };
        let fitted = fitter.fit(&unit, point, &noise_models, effort);
        found.push(fitted.ok_or_else(diverged)?);
    }
    Ok(Model::new(Vec::new(), found))
}

fn plain_substeps(dataset: &Dataset, track: usize, beta: f64) -> usize {
    if dataset.tracks[track].input.prescribed {
        return 1;
    }
    let s = &dataset.tracks[track].scale;
    let turns = (s.k.abs() / s.mass).sqrt() * dataset.step / FINE;
    (turns.ceil() as usize)
        .max(stable_substeps(dataset, beta))
        .clamp(1, 20)
}
