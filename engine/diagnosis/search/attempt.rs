//! Models that the search has fitted to the end, kept for the report.

use super::refit::LEADERS;
use veloid_model::effects::Kind;
use veloid_model::fit::{Fitted, Model, Term};

/// A model that was fitted to the end.
#[derive(Clone, Debug)]
pub struct Attempt {
    /// Without its residuals, which take most of the memory.
    pub model: Model,
    /// Gain in log likelihood over the model that it extends by one effect, and what noise alone gains with probability `alpha`
    /// among all that were tried; nothing where this was not asked.
    pub chance: Option<[f64; 2]>,
}

impl Attempt {
    /// Of the models that a round `found`, best first, those that were fitted to the end and those with a law of the user's own.
    pub fn of_round(found: &[Model], chance: impl Fn(&Model) -> Option<[f64; 2]>) -> Vec<Self> {
        let kept = (found.iter().enumerate()).filter(|(i, m)| *i < LEADERS || has_own_law(m));
        kept.map(|(_, model)| Self {
            model: light(model),
            chance: chance(model),
        })
        .collect()
    }
}

pub fn has_own_law(model: &Model) -> bool {
    model.terms.iter().any(is_own)
}

pub fn is_own(term: &Term) -> bool {
    matches!(term.kind, Kind::Own(_))
}

fn light(model: &Model) -> Model {
    let without = |fit: &Fitted| Fitted {
        unit: fit.unit.clone(),
        point: fit.point.clone(),
        residuals: Vec::new(),
        noise_models: fit.noise_models.clone(),
        likelihood: fit.likelihood,
        covariance: fit.covariance.clone(),
    };
    Model {
        terms: model.terms.clone(),
        fits: model.fits.iter().map(without).collect(),
        likelihood: model.likelihood,
    }
}
