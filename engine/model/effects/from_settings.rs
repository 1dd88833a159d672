//! The user's own law as settings hold it.

use super::Kind;
use crate::law::OwnLaw;
use veloid_core::settings::Settings;
use veloid_core::{EngineError, SettingProblem};

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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn with_law(id: &str, force: &str) -> Result<Option<OwnLaw>, EngineError> {
        let parameters = "parameters.a = { start = 1, range = [0, 50] }";
        users_law(&Settings {
            law: Some(format!("id = '{id}'\nforce = '{force}'\n{parameters}")),
            ..Settings::default()
        })
    }

    #[test]
    fn a_law_is_read_where_there_is_one() {
        assert!(users_law(&Settings::default()).unwrap().is_none());
        let law = with_law("my_spring", "a * d").unwrap().unwrap();
        assert_eq!(law.id, "my_spring");
        assert_eq!(law.parameters[0].range, [0.0, 50.0]);
    }

    #[test]
    fn a_law_under_the_id_of_an_effect_is_refused() {
        let refused = with_law("cubic_stiffness", "a * d").unwrap_err();
        let text = refused.to_string();
        assert!(
            text.contains("'cubic_stiffness' is already an effect of the library"),
            "{text}"
        );
    }

    #[test]
    fn a_law_that_cannot_be_read_is_refused_with_its_place() {
        let text = with_law("my_spring", "a * d +").unwrap_err().to_string();
        assert!(text.contains("law") && text.contains("column 8"), "{text}");
    }
}
