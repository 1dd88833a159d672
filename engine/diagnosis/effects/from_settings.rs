//! The user's own law as settings hold it.

use super::Kind;
use crate::EngineError;
use crate::diagnosis::law::OwnLaw;
use crate::settings::{Settings, out_of_range};

/// The user's own law, if there is one.
///
/// # Errors
/// [`EngineError::Setting`]: it cannot be read, or bears the id of one of the library.
pub fn users_law(settings: &Settings) -> Result<Option<OwnLaw>, EngineError> {
    let Some(text) = &settings.law else {
        return Ok(None);
    };
    let law = OwnLaw::read(text).map_err(|e| out_of_range("law", e.to_string()))?;
    match Kind::by_id(&law.id) {
        Some(_) => {
            let problem = format!("id: '{}' is an effect of the library already", law.id);
            Err(out_of_range("law", problem))
        }
        None => Ok(Some(law)),
    }
}
