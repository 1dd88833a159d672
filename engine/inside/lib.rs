//! Inside an identified model: `dynamics` (natural frequency, damping ratio, poles, step response, covariance) and `validation`, the
//! model beside the record it came from (docs/inside.md).

mod dynamics;
mod oscillator;
mod periodic;
mod record;
mod residual;
mod response;
mod restoring;
mod validation;
mod welch;

pub use dynamics::{dynamics, without_dynamics};
pub use oscillator::Oscillator;
pub use record::{Extended, Models, Record};
pub use validation::{validation, without_validation};
