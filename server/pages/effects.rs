//! The library of effects.

use askama::Template;
use axum::response::Html;

use super::layout::{Fault, html};
use crate::effects::{EffectView, library, preface};

#[derive(Template)]
#[template(path = "effects.html")]
struct Effects {
    preface: String,
    named: Vec<EffectView>,
    general: Vec<EffectView>,
}

impl Effects {
    fn here(&self) -> &'static str {
        "/effects"
    }
}

pub async fn list() -> Result<Html<String>, Fault> {
    let (named, general) = library().into_iter().partition(|e: &EffectView| e.is_named);
    html(&Effects {
        preface: preface(),
        named,
        general,
    })
}
