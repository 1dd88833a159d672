//! Every identified parameter, filtered.

use askama::Template;
use axum::extract::{OriginalUri, State};
use axum::response::Html;
use serde::Deserialize;
use veloid_engine::document::format_number::{Quantity, fixed};
use veloid_engine::report::diagnosis::Verdict;

use super::layout::{Fault, Query, filled, html};
use super::words;
use crate::api::App;
use crate::api::access::Caller;
use crate::api::list::{Page, without_cursor};
use crate::api::names::{EFFECTS, PARAMETERS};
use crate::api::parameters::{MOST, Params, cursor, rows};
use crate::store::parameter::{self, AXLES, Filter, METHODS, ParameterRow};
use crate::time;

const PAGE: i64 = 50;

/// Names of the formats that this server writes, and what an address calls them.
const FORMATS: &[(&str, &str)] = &[
    ("CSV", "csv"),
    ("JSON", "json"),
    #[cfg(feature = "parquet")]
    ("Parquet", "parquet"),
];

#[derive(Template)]
#[template(path = "parameters.html")]
struct Parameters {
    /// Fields of the filter; dates with name, label and value.
    bike: String,
    choices: Vec<Choice>,
    dates: Vec<(&'static str, &'static str, String)>,
    rows: Vec<Row>,
    next: Option<String>,
    exports: Vec<(&'static str, String)>,
    /// Rows of an export, where there are more than that.
    cut: Option<String>,
}

/// A list to choose one name from.
struct Choice {
    name: &'static str,
    label: &'static str,
    chosen: String,
    /// Names with the words that the page has for them.
    known: Vec<(String, String)>,
}

impl Choice {
    fn new(
        name: &'static str,
        label: &'static str,
        chosen: Option<&str>,
        known: &[impl AsRef<str>],
        words: fn(&str) -> String,
    ) -> Self {
        let known = known.iter().map(AsRef::as_ref);
        Self {
            name,
            label,
            chosen: chosen.unwrap_or_default().to_owned(),
            known: known.map(|name| (name.to_owned(), words(name))).collect(),
        }
    }
}

/// A parameter as a row of a table.
struct Row {
    job: String,
    identified_at: String,
    bike: String,
    method: String,
    axle: String,
    name: String,
    value: Quantity,
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
pub struct ParametersQuery {
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

impl From<ParametersQuery> for Params {
    fn from(asked: ParametersQuery) -> Self {
        Self {
            bike: filled(asked.bike),
            method: filled(asked.method),
            axle: filled(asked.axle),
            name: filled(asked.name),
            effect: filled(asked.effect),
            verdict: filled(asked.verdict),
            job: None,
            newest: None,
            from: filled(asked.from),
            to: filled(asked.to),
            format: None,
            limit: None,
            cursor: asked.cursor,
        }
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
    Query(asked): Query<ParametersQuery>,
) -> Result<Html<String>, Fault> {
    let params = Params::from(asked);
    let found = rows(&server, &caller.group, &params, PAGE).await?;
    let page = Page::cut(found, PAGE, cursor, Row::from);
    // An export begins with the newest, whatever page this is.
    let all = Filter {
        after: None,
        ..params.filter(&caller.group)?
    };
    let more = page.next.is_some() && parameter::last_of(&server.db, &all, MOST).await?.is_some();
    let here = without_cursor(&uri);
    let mark = if here.contains('?') { '&' } else { '?' };
    let asked = query(&params);
    let export = |format: &str| format!("/v1/parameters?{asked}&format={format}&limit={MOST}");
    let text = |value: &Option<String>| value.clone().unwrap_or_default();
    let day = |value: &Option<String>| text(value).chars().take(10).collect::<String>();
    html(&Parameters {
        bike: text(&params.bike),
        choices: vec![
            Choice::new(
                "name",
                "Parameter",
                params.name.as_deref(),
                &PARAMETERS,
                words::parameter,
            ),
            Choice::new(
                "effect",
                "Effect",
                params.effect.as_deref(),
                &EFFECTS,
                words::plain,
            ),
            Choice::new(
                "method",
                "Method",
                params.method.as_deref(),
                &METHODS,
                words::method,
            ),
            Choice::new("axle", "Axle", params.axle.as_deref(), &AXLES, words::plain),
            Choice::new(
                "verdict",
                "Verdict",
                params.verdict.as_deref(),
                &Verdict::NAMES,
                words::plain,
            ),
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
        cut: more.then(|| fixed(MOST as f64, 0)),
        exports: FORMATS
            .iter()
            .map(|(name, format)| (*name, export(format)))
            .collect(),
    })
}
