//! What a parameter depends on.

use std::collections::BTreeMap;

use axum::Json;
use axum::extract::State;
use serde::Deserialize;
use utoipa::IntoParams;

use super::access::Caller;
use super::bikes::existing;
use super::extract::Query;
use super::problem::{Kind, Problem};
use super::{App, Server, names};
use crate::fleet::{DATE, Dependence, Question};
use crate::store::dependence::{DependenceQuery, rides};
use crate::store::parameter::AXLES;
use crate::time;
use crate::unique::shown;

/// Latest rides that are looked at.
const RIDES: i64 = 10_000;
/// Most facts of a question.
const FACTS: usize = 12;
const DAY_MS: f64 = 86_400_000.0;

#[derive(Default, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct Params {
    /// Only this bike; by default all bikes, each with its own level.
    pub bike: Option<String>,
    /// `front` unless asked otherwise.
    #[param(schema_with = names::axles)]
    pub axle: Option<String>,
    /// `k_n_m` unless asked otherwise; a parameter of an effect is `effect.parameter`.
    #[param(schema_with = names::parameters)]
    pub name: Option<String>,
    /// Comma-separated facts, the most important first: `pressure_front_bar,temperature_c,date`. A fact in words (`rider`, `tyres`,
    /// `road`) stands for its categories. By default the numbers that three quarters of the rides have.
    #[param(pattern = r"^([a-z][a-z0-9_]*(,[a-z][a-z0-9_]*){0,11})?$")]
    pub on: Option<String>,
    /// Where to predict, the other facts being at their means: `pressure_front_bar:2.5,date:2026-05-01`.
    #[param(
        pattern = r"^((date:([0-9]{4}-((0[13578]|1[02])-(0[1-9]|[12][0-9]|3[01])|(0[469]|11)-(0[1-9]|[12][0-9]|30)|02-(0[1-9]|1[0-9]|2[0-8]))|([0-9]{2}(0[48]|[2468][048]|[13579][26])|([02468][048]|[13579][26])00)-02-29)|([a-ce-z][a-z0-9_]*|d([b-z0-9_][a-z0-9_]*)?|da([a-su-z0-9_][a-z0-9_]*)?|dat([a-df-z0-9_][a-z0-9_]*)?|date[a-z0-9_]+):-?[0-9]{1,9}(\.[0-9]{1,6})?)(,(date:([0-9]{4}-((0[13578]|1[02])-(0[1-9]|[12][0-9]|3[01])|(0[469]|11)-(0[1-9]|[12][0-9]|30)|02-(0[1-9]|1[0-9]|2[0-8]))|([0-9]{2}(0[48]|[2468][048]|[13579][26])|([02468][048]|[13579][26])00)-02-29)|([a-ce-z][a-z0-9_]*|d([b-z0-9_][a-z0-9_]*)?|da([a-su-z0-9_][a-z0-9_]*)?|dat([a-df-z0-9_][a-z0-9_]*)?|date[a-z0-9_]+):-?[0-9]{1,9}(\.[0-9]{1,6})?)){0,11})?$"
    )]
    pub at: Option<String>,
    /// Ridden from this time on, inclusive.
    #[param(schema_with = time::schema)]
    pub from: Option<String>,
    /// Ridden before this time, exclusive; a day counts whole.
    #[param(schema_with = time::schema)]
    pub to: Option<String>,
}

/// Dependence of a parameter on the rides' facts.
///
/// Mixed-effects regression over the latest 10 000 rides: each ride's error is known, the additional variance between rides is
/// estimated, and each of several bicycles has its own level. A bicycle whose slope differs from that of the others is named with its
/// slope; where more than a third differ there is no common slope. Confounded facts are not fitted; the reason is given.
#[utoipa::path(get, path = "/v1/fleet/dependence", operation_id = "get_dependence", tag = "fleet", params(Params),
    responses(
        (status = 200, description = "Influences with their intervals, confounded facts, and a summary", body = Dependence),
        (status = 400, description = "Malformed query", body = Problem, content_type = "application/problem+json"),
        (status = 404, description = "No such bike, or a fact that no ride has", body = Problem, content_type = "application/problem+json")))]
pub async fn dependence(
    State(server): App,
    caller: Caller,
    Query(params): Query<Params>,
) -> Result<Json<Dependence>, Problem> {
    Ok(Json(answer(&server, &caller.group, &params).await?))
}

/// The answer to a question.
pub async fn answer(server: &Server, group: &str, params: &Params) -> Result<Dependence, Problem> {
    let axle = params.axle.clone().unwrap_or_else(|| "front".to_owned());
    names::one_of("axle", Some(&axle), &AXLES)?;
    let name = params.name.clone().unwrap_or_else(|| "k_n_m".to_owned());
    let on = params.on.as_deref().map(facts).transpose()?;
    let at = params.at.as_deref().map_or(Ok(BTreeMap::new()), places)?;
    // A span that ends before it begins holds no ride, and the answer says so.
    let (from_ms, _) = time::span(params.from.as_deref(), None)?;
    let (_, to_ms) = time::span(None, params.to.as_deref())?;
    let bike = params.bike.as_deref();
    if let Some(bike) = bike {
        existing(server, group, bike).await?;
    }
    let asked = DependenceQuery {
        group,
        bike,
        axle: &axle,
        name: &name,
        from_ms,
        to_ms,
    };
    let rows = rides(&server.db, &asked, RIDES).await?;
    if rows.is_empty() {
        names::one_of("name", Some(&name), &names::PARAMETERS)?;
    }
    let asked = on.clone();
    let found = tokio::task::spawn_blocking(move || {
        let question = Question {
            axle: &axle,
            name: &name,
            on: on.as_deref(),
            at: &at,
        };
        (Dependence::of(&question, &rows), at)
    });
    let (found, at) = found.await?;
    if !found.known.is_empty() {
        let numbers = found.known.iter().map(|fact| fact.name.as_str());
        let in_words = found.known_categories.iter().map(|fact| fact.name.as_str());
        let known: Vec<&str> = numbers.chain(in_words).collect();
        for fact in asked.iter().flatten() {
            names::one_of("on", Some(fact), &known).map_err(no_such)?;
        }
        let asked: Vec<&str> = found.facts.iter().map(|fact| fact.name.as_str()).collect();
        for fact in at.keys().filter(|_| !asked.is_empty()) {
            names::one_of("at", Some(fact), &asked).map_err(no_such)?;
        }
    }
    Ok(found)
}

/// Names with commas between, each once.
fn facts(text: &str) -> Result<Vec<String>, Problem> {
    let mut names: Vec<String> = Vec::new();
    for name in text
        .split(',')
        .map(str::trim)
        .filter(|name| !name.is_empty())
    {
        if !names.iter().any(|known| known == name) {
            names.push(name.to_owned());
        }
    }
    if let Some(odd) = names.iter().find(|name| !is_name(name)) {
        let odd = shown(odd);
        return Err(bad(format!(
            "on: '{odd}', expected names of facts such as pressure_front_bar"
        )));
    }
    match names.len() {
        0..=FACTS => Ok(names),
        n => Err(bad(format!("on: {n} facts, expected at most {FACTS}"))),
    }
}

/// Whether a fact may have this name: small letters, digits and underscores, a letter first.
fn is_name(name: &str) -> bool {
    let mut letters = name.chars();
    letters.next().is_some_and(|c| c.is_ascii_lowercase())
        && letters.all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
}

fn places(text: &str) -> Result<BTreeMap<String, f64>, Problem> {
    let pairs = text.split(',').filter(|pair| !pair.trim().is_empty());
    pairs.map(|pair| {
        let expected = || bad(format!("at: '{}', expected a fact and a number such as temperature_c:20, or date:2026-05-01", shown(pair)));
        let (name, value) = pair.split_once(':').ok_or_else(expected)?;
        let (name, value) = (name.trim(), value.trim());
        let number = match name {
            DATE => time::span(Some(value), None)?.0.map(|ms| ms as f64 / DAY_MS),
            _ => value.parse().ok(),
        };
        let number = number.filter(|number: &f64| number.is_finite() && number.abs() < 1e12);
        Ok((name.to_owned(), number.ok_or_else(expected)?))
    }).collect()
}

/// What no ride has is no fault of the question's form.
fn no_such(problem: Problem) -> Problem {
    Problem::new(Kind::NotFound, problem.detail)
}

fn bad(detail: String) -> Problem {
    Problem::new(Kind::BadRequest, detail)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use proptest::prelude::*;
    use proptest::string::string_regex;
    use regex_lite::Regex;
    use utoipa::openapi::path::ParameterIn;
    use utoipa::openapi::{RefOr, Schema};

    use super::*;

    /// What the API's document says of `at`.
    fn pattern() -> String {
        let all = Params::into_params(|| Some(ParameterIn::Query));
        let at = all
            .into_iter()
            .find(|parameter| parameter.name == "at")
            .unwrap();
        let Some(RefOr::T(Schema::Object(at))) = at.schema else {
            panic!("no schema");
        };
        at.pattern.unwrap()
    }

    proptest! {
        #[test]
        fn a_date_is_one_to_the_document_if_it_is_one(day in "([0-9]{4}|20[0-9]{2})-[01][0-9]-[0-3][0-9]", more in 0..3_u8) {
            let pattern = Regex::new(&pattern()).unwrap();
            let at = ["", ",temperature_c:20", ",dated:-1.5,date_2:0"][usize::from(more)];
            let at = format!("date:{day}{at}");
            prop_assert_eq!(pattern.is_match(&at), places(&at).is_ok(), "{}", at);
            let at = format!("da:1,{at}");
            prop_assert_eq!(pattern.is_match(&at), places(&at).is_ok(), "{}", at);
        }

        #[test]
        fn what_the_document_lets_pass_is_taken(at in string_regex(&pattern().replace(['^', '$'], "")).unwrap()) {
            prop_assert!(places(&at).is_ok(), "{}", at);
        }
    }

    #[test]
    fn every_day_of_a_year_is_a_date() {
        let pattern = Regex::new(&pattern()).unwrap();
        for year in [0, 1900, 1999, 2000, 2024, 2026, 9999] {
            let first = jiff::civil::date(year, 1, 1);
            let days = first.series(jiff::Span::new().days(1));
            for day in days.take_while(|day| day.year() == year) {
                assert!(pattern.is_match(&format!("date:{day}")), "{day}");
            }
        }
        for wrong in [
            "date:2026-02-29",
            "date:1900-02-29",
            "date:2026-04-31",
            "date:5",
        ] {
            assert!(!pattern.is_match(wrong), "{wrong}");
        }
    }

    #[test]
    fn questions_are_read_or_refused() {
        assert_eq!(facts(" a_bar, b,a_bar,,").unwrap(), ["a_bar", "b"]);
        let many: Vec<String> = (0..13).map(|i| format!("f{i}")).collect();
        assert!(
            facts(&many.join(","))
                .unwrap_err()
                .detail
                .contains("at most 12")
        );
        let at = places("a_bar:2.5, date:1970-01-11").unwrap();
        assert_eq!((at["a_bar"], at["date"]), (2.5, 10.0));
        for wrong in ["a", "a:", "a:inf", "a:1e300", "date:5", "a:2:3"] {
            assert!(places(wrong).is_err(), "{wrong}");
        }
    }
}
