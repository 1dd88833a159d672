//! The user's own law as settings hold it.

use super::Kind;
use crate::diagnosis::law::OwnLaw;
use crate::settings::Settings;
use crate::{EngineError, SettingProblem};

/// The user's own law, if there is one.
///
/// # Errors
/// [`EngineError::Setting`]: it cannot be read, or bears the id of one of the library.
pub fn users_law(settings: &Settings) -> Result<Option<OwnLaw>, EngineError> {
    let Some(text) = &settings.law else {
        return Ok(None);
    };
    let law = OwnLaw::read(text).map_err(|e| wrong(SettingProblem::Law(e.to_string())))?;
    match Kind::by_id(&law.id) {
        Some(_) => Err(wrong(SettingProblem::LawTaken { id: law.id })),
        None => Ok(Some(law)),
    }
}

fn wrong(problem: SettingProblem) -> EngineError {
    EngineError::Setting {
        name: "law",
        problem,
    }
}
