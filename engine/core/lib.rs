//! What every part of the engine shares: bicycles, documents, base models, settings, errors and numerics.
//!
//! Everything is SI unless a name says otherwise.

pub mod bicycle;
pub mod document;
mod error;
pub mod numerics;
pub mod plant;
mod progress;
pub mod settings;

pub use bicycle::Bike;
pub use error::{Divergence, EngineError, ImposedProblem, RideProblem, SettingProblem};
pub use progress::{Progress, Silent};
pub use settings::{Objective, Settings};
