//! Every identified parameter, filtered.

use askama::Template;
use axum::extract::{OriginalUri, State};
use axum::response::Html;
use serde::Deserialize;
use veloid_engine::number::Quantity;

use super::jobs::VERDICTS;
use super::layout::{Fault, Query, filled, html, one_of};
use crate::api::App;
use crate::api::access::Caller;
use crate::api::list::{Page, without_cursor};
use crate::api::parameters::{Params, cursor, rows};
use crate::api::problem::Problem;
use crate::api::time::{self, Bound};
use crate::store::parameter::{AXLES, METHODS, ParameterRow};

const PAGE: i64 = 50;
#[derive(Template)]
#[template(path = "parameters.html")]
struct Parameters {
    /// Fields of the filter: name, label, value, and choices.
    texts: Vec<(&'static str, &'static str, String)>,
    choices: Vec<(&'static str, &'static str, String, &'static [&'static str])>,
    dates: Vec<(&'static str, &'static str, String)>,
    rows: Vec<Row>,
    next: Option<String>,
    exports: Vec<(&'static str, String)>,
}

/// A parameter as a row of a table.
pub struct Row {
    job: String,
    identified_at: String,
    bike: String,
    pub method: String,
    pub axle: String,
    pub name: String,
    pub value: Quantity,
    verdict: Option<String>,
}

impl Parameters {
    fn here(&self) -> &'static str {
        "/parameters"
    }
}

impl From<ParameterRow> for Row {
    fn from(row: ParameterRow) -> Self {
        Self {
            job: row.job_id.to_string(),
            identified_at: time::text(row.identified_at),
            value: Quantity::new(row.value, row.std_error, &row.unit),
            bike: row.bike,
            method: row.method,
            axle: row.axle,
            name: row.name,
            verdict: row.verdict,
        }
    }
}

/// The filter, blank where the form's field was.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Asked {
    bike: Option<String>,
    method: Option<String>,
    axle: Option<String>,
    name: Option<String>,
    effect: Option<String>,
    verdict: Option<String>,
    from: Option<String>,
    to: Option<String>,
    cursor: Option<String>,
}

impl Asked {
    /// What is asked of the store.
    fn params(self) -> Result<Params, Problem> {
        let day = |name: &str, text: Option<String>, bound: Bound| {
            let text = filled(text);
            if let Some(text) = &text {
                time::parse(name, text, bound)?;
            }
            Ok::<_, Problem>(text)
        };
        Ok(Params {
            bike: filled(self.bike),
            method: one_of("method", self.method, &METHODS)?,
            axle: one_of("axle", self.axle, &AXLES)?,
            name: filled(self.name),
            effect: filled(self.effect),
            verdict: one_of("verdict", self.verdict, &VERDICTS)?,
            job: None,
            from: day("from", self.from, Bound::From)?,
            to: day("to", self.to, Bound::To)?,
            format: None,
            limit: None,
            cursor: self.cursor,
        })
    }
}

/// The query without what is blank and without the cursor.
fn query(params: &Params) -> String {
    let mut query = form_urlencoded::Serializer::new(String::new());
    for (name, value) in [
        ("bike", &params.bike),
        ("method", &params.method),
        ("axle", &params.axle),
        ("name", &params.name),
        ("effect", &params.effect),
        ("verdict", &params.verdict),
        ("from", &params.from),
        ("to", &params.to),
    ] {
        if let Some(value) = value {
            query.append_pair(name, value);
        }
    }
    query.finish()
}

pub async fn list(
    State(server): App,
    caller: Caller,
    OriginalUri(uri): OriginalUri,
    Query(asked): Query<Asked>,
) -> Result<Html<String>, Fault> {
    let params = asked.params()?;
    let found = rows(&server, &caller.group, &params, PAGE).await?;
    let page = Page::cut(found, PAGE, cursor, Row::from);
    let here = without_cursor(&uri);
    let mark = if here.contains('?') { '&' } else { '?' };
    let asked = query(&params);
    let export = |format: &str| format!("/v1/parameters?{asked}&format={format}&limit=100000");
    let text = |value: &Option<String>| value.clone().unwrap_or_default();
    let day = |value: &Option<String>| text(value).chars().take(10).collect::<String>();
    html(&Parameters {
        texts: vec![
            ("bike", "Bicycle", text(&params.bike)),
            ("name", "Parameter", text(&params.name)),
            ("effect", "Effect", text(&params.effect)),
        ],
        choices: vec![
            ("method", "Method", text(&params.method), &METHODS),
            ("axle", "Axle", text(&params.axle), &AXLES),
            ("verdict", "Verdict", text(&params.verdict), &VERDICTS),
        ],
        dates: vec![
            ("from", "From", day(&params.from)),
            ("to", "To", day(&params.to)),
        ],
        next: page.next.map(|next| {
            let next: String = form_urlencoded::byte_serialize(next.as_bytes()).collect();
            format!("{here}{mark}cursor={next}")
        }),
        rows: page.items,
        exports: vec![
            ("CSV", export("csv")),
            ("JSON", export("json")),
            ("Parquet", export("parquet")),
        ],
    })
}
