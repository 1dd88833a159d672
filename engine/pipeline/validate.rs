//! What settings may say.

use crate::EngineError;
use crate::diagnosis::effects::users_law;
use crate::settings::Settings;

impl Settings {
    /// Rejects values that are out of range or would take the machine hostage, and a law that is none.
    ///
    /// # Errors
    /// [`EngineError::Setting`] with the key, the value and the range.
    pub fn validate(&self) -> Result<(), EngineError> {
        self.within_range()?;
        users_law(self).map(|_| ())
    }
}
