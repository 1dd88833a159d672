//! The facts of a ride, as fields of a form and as lines to read.

use axum::Form;
use axum::extract::State;
use axum::response::Redirect;
use serde_json::{Map, Value};
use uuid::Uuid;

use super::layout::{Fault, Path};
use super::words;
use crate::api::App;
use crate::api::access::Caller;
use crate::api::problem::Problem;
use crate::api::rides::patch::{change, present};
use crate::facts::{Facts, MOMENT, NUMBERS, TEXTS, from_form};

/// A field of the form.
pub struct Field {
    pub name: &'static str,
    pub label: &'static str,
    pub value: String,
    pub hint: &'static str,
    /// Whether a keypad with digits and a decimal sign, and no minus, is enough.
    pub is_decimal: bool,
    pub lines: bool,
}

impl Field {
    fn new(name: &'static str, label: &'static str, value: Option<String>) -> Self {
        Self {
            name,
            label,
            value: value.unwrap_or_default(),
            hint: "",
            is_decimal: false,
            lines: false,
        }
    }

    fn lines(self) -> Self {
        Self {
            lines: true,
            ..self
        }
    }

    fn hint(self, hint: &'static str) -> Self {
        Self { hint, ..self }
    }
}

/// The form's fields, filled with the known facts.
pub fn fields(facts: &Facts) -> Vec<Field> {
    let mut facts = facts.clone();
    let date = Field::new(MOMENT, "Ridden on", facts.ridden_at.clone());
    let mut fields = vec![date.hint("A date such as 2026-05-01, or a date and time")];
    for (name, _, least, _, label) in NUMBERS {
        let value = facts.number(name).and_then(|value| *value);
        fields.push(Field {
            is_decimal: least >= 0.0,
            ..Field::new(name, label, value.map(|value| value.to_string()))
        });
    }
    for (name, _, label) in TEXTS.into_iter().filter(|known| known.0 != "notes") {
        let value = facts.text(name).and_then(|value| value.clone());
        fields.push(Field::new(name, label, value));
    }
    let tags = Field::new("tags", "Tags", Some(facts.tags.join(", ")));
    fields.push(tags.hint("Separated by commas"));
    fields.push(Field::new("notes", "Notes", facts.notes.clone()).lines());
    let more = facts
        .more
        .iter()
        .map(|(name, value)| format!("{name}: {value}\n"));
    let more = Field::new("more", "Other numbers", Some(more.collect()));
    fields.push(more.lines().hint("One name: number per line"));
    fields
}

/// The known facts, in words.
pub fn lines(facts: &Facts) -> Vec<(String, String)> {
    let mut facts = facts.clone();
    let mut lines = Vec::new();
    if let Some(date) = &facts.ridden_at {
        lines.push(("Ridden on".to_owned(), date.clone()));
    }
    for (name, unit, ..) in NUMBERS {
        if let Some(value) = facts.number(name).and_then(|value| *value) {
            let what = name.strip_suffix(&format!("_{unit}")).unwrap_or(name);
            let what = what.strip_suffix("_c").unwrap_or(what);
            let unit = if unit == "degC" { "°C" } else { unit };
            lines.push((words::title(what), format!("{} {unit}", value)));
        }
    }
    for (name, _, label) in TEXTS {
        if let Some(text) = facts.text(name).and_then(|text| text.clone()) {
            lines.push((label.to_owned(), text));
        }
    }
    if !facts.tags.is_empty() {
        lines.push(("Tags".to_owned(), facts.tags.join(", ")));
    }
    let more = facts.more.iter();
    lines.extend(more.map(|(name, value)| (words::title(name), value.to_string())));
    lines
}

/// Replaces the facts by those of the form.
pub async fn keep(
    State(server): App,
    caller: Caller,
    Path(id): Path<Uuid>,
    Form(form): Form<Vec<(String, String)>>,
) -> Result<Redirect, Fault> {
    let known = present(&server, &caller, id).await?;
    let mut filled = Map::new();
    for (name, text) in form.iter().filter(|(_, text)| !text.trim().is_empty()) {
        from_form(&mut filled, name, text.trim()).map_err(Problem::from)?;
    }
    let gone = known
        .facts
        .document()
        .into_iter()
        .map(|(name, _)| (name, Value::Null));
    let patch = gone.chain(filled).collect();
    let page = known.jobs.first().map(|job| job.links.page.clone());
    change(&server, &caller, known, patch).await?;
    Ok(Redirect::to(page.as_deref().unwrap_or("/jobs")))
}
