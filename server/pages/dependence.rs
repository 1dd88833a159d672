//! What influences a parameter: a form, and what was computed.

use askama::Template;
use axum::extract::{RawQuery, State};
use axum::response::Html;
use veloid_engine::document::format_number::{Number, Quantity, WIDE, fixed, significant};

use super::layout::{Fault, html};
use super::words;
use crate::api::App;
use crate::api::access::Caller;
use crate::api::dependence::{Params, answer};
use crate::api::names::PARAMETERS;
use crate::api::problem::{Kind, Problem};
use crate::fleet::{Categories, Category, Coefficient, DATE, Dependence, Influence, label};
use crate::store::parameter::AXLES;
use crate::unique::shown;

/// Names of the address, beside those of the fields for places.
const FIELDS: [&str; 7] = ["bike", "axle", "name", "on", "from", "to", "theme"];
/// Share of a fact's variance from which on it is said to be shared with others.
const WORTH_SAYING: f64 = 0.05;
/// What the name of a field for a place begins with.
const AT: &str = "at.";

#[derive(Template)]
#[template(path = "dependence.html")]
struct Page {
    bike: String,
    axle: String,
    name: String,
    names: Vec<(String, String)>,
    facts: Vec<Choice>,
    /// Facts in words: name, label, whether it is chosen, and how many categories it has.
    in_words: Vec<(String, String, bool, usize)>,
    found: Dependence,
    rows: Vec<Row>,
    /// How far a single ride scatters about a prediction.
    single_ride: String,
    /// Address of the same answer as JSON.
    address: String,
}

/// A fact that may be asked for.
struct Choice {
    name: String,
    label: String,
    chosen: bool,
    /// The place that was asked for.
    at: String,
    hint: String,
}

struct Row {
    name: String,
    /// What stands in place of a slope.
    missing: &'static str,
    slope: Option<Quantity>,
    per: String,
    chance: String,
    note: String,
    /// Identifier of its figure.
    figure: Option<String>,
}

impl Page {
    fn here(&self) -> &'static str {
        ""
    }
}

pub async fn page(
    State(server): App,
    caller: Caller,
    RawQuery(query): RawQuery,
) -> Result<Html<String>, Fault> {
    let mut asked: Vec<(String, String)> =
        form_urlencoded::parse(query.unwrap_or_default().as_bytes())
            .map(|(name, value)| (name.into_owned(), value.trim().replace('\0', "\u{fffd}")))
            .collect();
    if let Some((stranger, _)) = asked.iter().find(|(name, _)| is_strange(name)) {
        let known = FIELDS.join(", ");
        let detail = format!(
            "unknown name `{}`, expected {known}, or `{AT}` and a fact",
            shown(stranger)
        );
        return Err(Problem::new(Kind::BadRequest, detail).into());
    }
    asked.retain(|(_, value)| !value.is_empty());
    let params = params(&asked);
    let found = answer(&server, &caller.group, &params).await?;
    let chosen: Vec<&str> = found.facts.iter().map(|fact| fact.name.as_str()).collect();
    let places = |name: &str| {
        asked
            .iter()
            .find(|(key, _)| key.strip_prefix(AT) == Some(name))
    };
    let in_words = found.known_categories.iter().map(|fact| {
        let chosen = found.categories.iter().any(|known| known.fact == fact.name);
        (
            fact.name.clone(),
            label(&fact.name),
            chosen,
            fact.categories,
        )
    });
    let facts = found.known.iter().map(|fact| Choice {
        label: label(&fact.name),
        chosen: chosen.contains(&fact.name.as_str()),
        at: places(&fact.name).map_or_else(String::new, |(_, value)| value.clone()),
        hint: match fact.name.as_str() {
            DATE => "a day".to_owned(),
            _ if fact.least == fact.most => {
                format!("always {} {}", Number::rough(fact.least, 4), fact.unit)
            }
            _ => format!(
                "{} to {} {}",
                Number::rough(fact.least, 4),
                Number::rough(fact.most, 4),
                fact.unit
            ),
        },
        name: fact.name.clone(),
    });
    let mut names: Vec<(String, String)> = PARAMETERS
        .iter()
        .map(|name| (name.clone(), words::parameter(name)))
        .collect();
    if !names.iter().any(|(name, _)| *name == found.name) {
        names.push((found.name.clone(), words::parameter(&found.name)));
    }
    html(&Page {
        bike: params.bike.clone().unwrap_or_default(),
        axle: found.axle.clone(),
        name: found.name.clone(),
        names,
        facts: facts.collect(),
        in_words: in_words.collect(),
        rows: rows(&found),
        single_ride: found
            .prediction
            .as_ref()
            .map_or_else(String::new, |predicted| {
                Quantity::rough(predicted.prediction.single_ride, 2, &found.unit).to_string()
            }),
        address: address(&params),
        found,
    })
}

fn is_strange(name: &str) -> bool {
    !FIELDS.contains(&name) && !name.starts_with(AT)
}

/// The question of a form, in which facts are boxes that are ticked and places a field each.
fn params(asked: &[(String, String)]) -> Params {
    let one = |name: &str| {
        asked
            .iter()
            .find(|(key, _)| key == name)
            .map(|(_, value)| value.clone())
    };
    let all = |name: &str| {
        asked
            .iter()
            .filter(|(key, _)| key == name)
            .map(|(_, value)| value.as_str())
            .collect::<Vec<_>>()
    };
    let on = all("on");
    let places = asked.iter().filter_map(|(key, value)| {
        let name = key.strip_prefix(AT)?;
        // What is not ticked is not asked.
        on.contains(&name).then(|| format!("{name}:{value}"))
    });
    let places: Vec<String> = places.collect();
    Params {
        bike: one("bike"),
        axle: one("axle"),
        name: one("name"),
        on: (!on.is_empty()).then(|| on.join(",")),
        at: (!places.is_empty()).then(|| places.join(",")),
        from: one("from"),
        to: one("to"),
    }
}

fn address(params: &Params) -> String {
    let mut query = form_urlencoded::Serializer::new("/v1/fleet/dependence?".to_owned());
    for (name, value) in [
        ("bike", &params.bike),
        ("axle", &params.axle),
        ("name", &params.name),
        ("on", &params.on),
        ("at", &params.at),
        ("from", &params.from),
        ("to", &params.to),
    ] {
        if let Some(value) = value {
            query.append_pair(name, value);
        }
    }
    query.finish()
}

fn rows(found: &Dependence) -> Vec<Row> {
    let facts = found.facts.iter().enumerate();
    let numbers = facts.flat_map(|(i, fact)| Row::of(i, fact, &found.unit));
    let in_words = found
        .categories
        .iter()
        .flat_map(|fact| Row::of_categories(fact, &found.unit));
    numbers.chain(in_words).collect()
}

impl Row {
    /// A fact, and the bicycles that differ.
    fn of(i: usize, fact: &Influence, unit: &str) -> Vec<Self> {
        let goes_with = fact
            .goes_with
            .as_deref()
            .zip(fact.correlation)
            .filter(|_| fact.shared >= WORTH_SAYING)
            .map(|(with, r)| {
                let share = fixed(100.0 * fact.shared, 0);
                format!(
                    "{share} % of its variance is shared with the facts above, most with {} (correlation {})",
                    label(with),
                    fixed(r, 2)
                )
            });
        let per = match fact.unit.as_str() {
            "" => "unit".to_owned(),
            unit => unit.to_owned(),
        };
        let row = |name: String, slope: Option<Coefficient>, note: String| Self {
            name,
            slope: slope.map(|slope| quantity(&slope, unit)),
            per: per.clone(),
            chance: slope.map_or_else(String::new, |slope| p_value(slope.p_value)),
            missing: "not fitted",
            note,
            figure: None,
        };
        let own = fact.own.iter().map(|own| {
            let name = format!("{}, {} only", label(&fact.name), own.bike);
            row(
                name,
                Some(own.slope),
                format!("{} rides; differs from the others", own.rides),
            )
        });
        let note = fact.reason.clone().or(goes_with).unwrap_or_default();
        let common = Self {
            figure: fact.slope.map(|_| format!("on-{i}")),
            ..row(label(&fact.name), fact.slope, note)
        };
        std::iter::once(common).chain(own).collect()
    }

    /// The categories of a fact in words.
    fn of_categories(fact: &Categories, unit: &str) -> Vec<Self> {
        let row = |category: &Category| Self {
            name: format!("{}: {}", label(&fact.fact), category.name),
            slope: category.effect.map(|effect| quantity(&effect, unit)),
            per: String::new(),
            chance: category
                .effect
                .map_or_else(String::new, |effect| p_value(effect.p_value)),
            missing: match category.name == fact.reference {
                true => "reference",
                false => "not fitted",
            },
            note: match (&fact.reason, &category.reason) {
                (Some(reason), _) => reason.clone(),
                (None, Some(reason)) => reason.clone(),
                (None, None) if category.name == fact.reference => {
                    format!("{} rides", category.rides)
                }
                (None, None) => format!(
                    "{} rides, compared with '{}'",
                    category.rides, fact.reference
                ),
            },
            figure: None,
        };
        fact.categories.iter().map(row).collect()
    }
}

fn p_value(p: f64) -> String {
    match p < 1e-3 {
        true => "<\u{a0}0.001".to_owned(),
        false => significant(p, 2),
    }
}

fn quantity(coefficient: &Coefficient, unit: &str) -> Quantity {
    Quantity::new(coefficient.value, coefficient.margin() / WIDE, unit)
}
