//! What each fact does, out of a fit.

use nalgebra::DVector;

use super::variables::{label, unit};
use super::view::{Influence, OwnSlope, Place};
use crate::fleet::regression::{Confounding, Fit, Prediction, Refusal};

/// Places at which a line is given.
const PLACES: usize = 21;
/// A slope is called common where no more than one bicycle in so many differs.
const COMMON: usize = 3;

impl Influence {
    pub fn new(
        name: &str,
        column: &DVector<f64>,
        confounding: &Confounding,
        with: Option<String>,
    ) -> Self {
        Self {
            reason: confounding
                .refused
                .map(|refusal| reason(refusal, with.as_deref())),
            name: name.to_owned(),
            unit: unit(name).to_owned(),
            mean: column.mean(),
            least: column.min(),
            most: column.max(),
            slope: None,
            own: Vec::new(),
            shared: confounding.shared,
            goes_with: with,
            correlation: confounding.with.map(|(_, correlation)| correlation),
            between_bikes: confounding.between_bikes,
            line: Vec::new(),
        }
    }

    /// Takes the slope of a fitted column, and those of the bicycles that differ.
    pub fn take(
        &mut self,
        fit: &Fit,
        place: usize,
        own: Vec<OwnSlope>,
        bikes: usize,
        other: Option<OwnSlope>,
    ) {
        self.own = own;
        if self.own.len() * COMMON > bikes {
            self.own
                .extend(other.filter(|_| self.own.len() + 1 == bikes));
            self.reason =
                Some("the bicycles differ, so that no one slope holds for them".to_owned());
            return;
        }
        self.slope = Some(fit.slopes[place]);
        self.line = line(fit, place, self);
    }
}

/// Why a fact is not fitted.
pub fn reason(refusal: Refusal, with: Option<&str>) -> String {
    match (refusal, with) {
        (Refusal::Constant, _) => "it is the same on all of these rides".to_owned(),
        (Refusal::Shared, Some(with)) => {
            format!("it goes with {}, and their influences cannot be separated", label(with))
        }
        (Refusal::Shared, None) => "it goes with the other facts".to_owned(),
        (Refusal::FewBikes, _) => {
            "it differs between bicycles only, and these are too few to separate it from other differences between them".to_owned()
        }
    }
}

fn line(fit: &Fit, place: usize, fact: &Influence) -> Vec<Place> {
    let at = |i: usize| {
        let x = fact.least + (fact.most - fact.least) * i as f64 / (PLACES - 1) as f64;
        let mut facts = fit.means.clone();
        facts[place] = x;
        let Prediction {
            value, low, high, ..
        } = fit.at(&facts);
        Place {
            x,
            value,
            low,
            high,
        }
    };
    (0..PLACES).map(at).collect()
}
