//! What settings may say.

use veloid_core::EngineError;
use veloid_core::settings::Settings;
use veloid_model::effects::users_law;

/// Rejects values that are out of range or would take the machine hostage, and a law that is none.
///
/// # Errors
/// [`EngineError::Setting`] with the key, the value and the range.
pub fn validate(settings: &Settings) -> Result<(), EngineError> {
    settings.within_range()?;
    users_law(settings).map(|_| ())
}
