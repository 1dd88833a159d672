//! What models make of the other axle's acceleration.

use rayon::prelude::*;

use super::law::Law;
use super::model::{Model, Moments, lanes};
use super::motion::{Deflected, Driven, drive, invert};
use super::nuisance::Course;
use super::record::{Record, Segment, spectrum};
use veloid_core::bicycle::{Axle, PerAxle};
use veloid_core::numerics::lanes::{LANES, Lanes};
use veloid_fourier::Complex;
use veloid_model::law::Scale;

/// Spectra of one model by segment.
pub type Spectra = Vec<Vec<Complex<f64>>>;

/// What the prediction needs beside the model.
#[derive(Clone, Copy)]
pub struct Predictor<'a> {
    pub record: &'a Record,
    pub scales: &'a PerAxle<Scale>,
    /// Where the other axle is on the leading one's road, by segment.
    pub courses: &'a [Course],
}

/// Both axles with eight models along a segment.
pub struct Ridden {
    pub lead: Deflected,
    /// Rate of the road under the leading axle (m/s).
    pub road: Vec<Lanes>,
    pub other: Driven,
}

impl Predictor<'_> {
    /// Spectra of models that have the same effects and whose wheels have rolled alike.
    pub fn spectra(&self, models: &[Model]) -> Vec<Spectra> {
        let segments = self.record.segments.len();
        let parts: Vec<(usize, usize)> = (0..models.len().div_ceil(LANES))
            .flat_map(|chunk| (0..segments).map(move |s| (chunk * LANES, s)))
            .collect();
        let found: Vec<Vec<Vec<Complex<f64>>>> = parts
            .par_iter()
            .map(|(first, s)| {
                let models = &models[*first..(first + LANES).min(models.len())];
                let segment = &self.record.segments[*s];
                let a = self.ridden(models, *s).other.a;
                (0..models.len())
                    .map(|lane| self.spectrum_of(segment, &a, lane))
                    .collect()
            })
            .collect();
        let mut spectra: Vec<Spectra> = models.iter().map(|_| Vec::new()).collect();
        for ((first, _), of_part) in parts.iter().zip(found) {
            for (lane, own) in of_part.into_iter().enumerate() {
                spectra[first + lane].push(own);
            }
        }
        spectra
    }

    pub fn spectrum_of(&self, segment: &Segment, a: &[Lanes], lane: usize) -> Vec<Complex<f64>> {
        let values = a.iter().zip(&segment.window).map(|(a, w)| a.0[lane] * w);
        let record = self.record;
        spectrum(
            &*record.fourier,
            values.collect(),
            &record.lines,
            segment.over,
        )
    }

    /// Both axles along a segment.
    pub fn ridden(&self, models: &[Model], s: usize) -> Ridden {
        let segment = &self.record.segments[s];
        let lead = self.record.lead;
        let other = self.record.other();
        let [lead_lanes, other_lanes] =
            [lead, other].map(|axle| lanes(models, axle, 1.0 / self.scale(axle).mass));
        let law = |lanes, axle, felt_after| Law {
            lanes,
            scale: self.scale(axle),
            segment,
            rolled: models[0].rolled.get(s).copied().unwrap_or(0.0),
            felt_after,
        };
        let leading = law(&lead_lanes, lead, 0.0);
        let deflected = invert(&leading);
        let mut road: Vec<Lanes> = (deflected.w.iter().zip(&segment.lead.v))
            .map(|(w, v)| *w + Lanes::all(*v))
            .collect();
        if leading.turns() {
            for (i, road) in road.iter_mut().enumerate() {
                *road += -leading.wheel(i);
            }
        }
        let following = law(&other_lanes, other, segment.step);
        let mut under = self.courses[s].under(&road);
        if following.turns() {
            for (i, road) in under.iter_mut().enumerate() {
                *road += following.wheel(i);
            }
        }
        Ridden {
            other: drive(&following, &under),
            lead: deflected,
            road,
        }
    }

    fn scale(&self, axle: Axle) -> &Scale {
        self.scales.get(axle).unwrap_or(&Scale::TYPICAL)
    }

    /// The sizes of both axles' motion with one model, by segment.
    pub fn moments(&self, model: &Model) -> PerAxle<Vec<Moments>> {
        let mut both = [Vec::new(), Vec::new()];
        for (s, segment) in self.record.segments.iter().enumerate() {
            let ridden = self.ridden(std::slice::from_ref(model), s);
            both[0].push(Moments::of_lead(
                &ridden.lead,
                &segment.lead.a,
                &segment.window,
            ));
            both[1].push(Moments::of_other(&ridden.other, &segment.window));
        }
        let [lead, other] = both;
        let (front, rear) = match self.record.lead {
            Axle::Front => (lead, other),
            Axle::Rear => (other, lead),
        };
        PerAxle {
            front: Some(front),
            rear: Some(rear),
        }
    }
}
