//! What lists of parameters may be asked for, and the rows that answer it.

use serde::Deserialize;
use utoipa::openapi::path::{Parameter, ParameterIn};
use utoipa::{IntoParams, ToSchema};
use uuid::Uuid;
use veloid_engine::report::diagnosis::Verdict;

use crate::api::names::{EFFECTS, PARAMETERS};
use crate::api::problem::{Kind, Problem};
use crate::api::{Server, names};
use crate::store::parameter::{self, AXLES, Filter, Key, METHODS, ParameterRow};
use crate::time;

/// Most rows of one answer.
pub const MOST: i64 = 100_000;

#[derive(Clone, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct Params {
    /// Only this bike.
    pub bike: Option<String>,
    /// Only by this method.
    #[param(schema_with = names::methods)]
    pub method: Option<String>,
    /// Only of this axle.
    #[param(schema_with = names::axles)]
    pub axle: Option<String>,
    /// Only this parameter: of the bicycle, or `effect.parameter`; also of a law of one's own that a stored result names.
    #[param(schema_with = names::parameters)]
    pub name: Option<String>,
    /// Only parameters of this effect; also of a law of one's own that a stored result names.
    #[param(schema_with = names::effects)]
    pub effect: Option<String>,
    /// Only of jobs with this verdict.
    #[param(schema_with = names::verdicts)]
    pub verdict: Option<String>,
    /// Only this job.
    pub job: Option<Uuid>,
    /// Only of the newest identification of each ride and bike; not of studies.
    pub newest: Option<bool>,
    /// Identified from this time on, inclusive (RFC 3339). A day, such as 2026-09-01, counts whole, from its
    /// beginning (UTC).
    #[param(schema_with = time::schema)]
    pub from: Option<String>,
    /// Identified before this time, exclusive (RFC 3339). A day, such as 2026-09-30, counts whole, to its end
    /// (UTC). Not earlier than `from`.
    #[param(schema_with = time::schema)]
    pub to: Option<String>,
    #[param(inline)]
    pub format: Option<Format>,
    /// Items per page; 50 by default.
    #[param(minimum = 1, maximum = 100_000)]
    pub limit: Option<i64>,
    /// `next` of the previous page.
    #[param(
        pattern = "^[0-9a-f]{8}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{12}/[a-z_]+/[a-z]+/.+$"
    )]
    pub cursor: Option<String>,
}

/// The same where the address names the bike.
pub struct OfBike;

impl IntoParams for OfBike {
    fn into_params(place: impl Fn() -> Option<ParameterIn>) -> Vec<Parameter> {
        let mut all = Params::into_params(place);
        all.retain(|parameter| parameter.name != "bike");
        all
    }
}

/// `json` by default.
#[derive(Clone, Copy, Default, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = ParametersFormat)]
pub enum Format {
    #[default]
    Json,
    Csv,
    Parquet,
}

impl Params {
    /// Refuses a parameter or an effect that neither the library knows nor any stored result names.
    async fn known(&self, server: &Server, group: &str) -> Result<(), Problem> {
        let (name, effect) = (self.name.as_deref(), self.effect.as_deref());
        let of_library = names::one_of("name", name, &PARAMETERS)
            .and_then(|()| names::one_of("effect", effect, &EFFECTS));
        let Err(unknown) = of_library else {
            return Ok(());
        };
        let any = Filter {
            group,
            name,
            effect,
            ..Filter::default()
        };
        match parameter::page(&server.db, &any, 1).await?.is_empty() {
            true => Err(unknown),
            false => Ok(()),
        }
    }

    /// What is asked of the store.
    pub fn filter<'a>(&'a self, group: &'a str) -> Result<Filter<'a>, Problem> {
        let (method, axle, name) = (&self.method, &self.axle, &self.name);
        let (effect, verdict) = (&self.effect, &self.verdict);
        names::one_of("method", method.as_deref(), &METHODS)?;
        names::one_of("axle", axle.as_deref(), &AXLES)?;
        names::one_of("verdict", verdict.as_deref(), &Verdict::NAMES)?;
        let (from_ms, to_ms) = time::span(self.from.as_deref(), self.to.as_deref())?;
        let after = self.cursor.as_deref();
        Ok(Filter {
            group,
            bike: self.bike.as_deref(),
            method: method.as_deref(),
            axle: axle.as_deref(),
            name: name.as_deref(),
            effect: effect.as_deref(),
            verdict: verdict.as_deref(),
            job: self.job,
            newest: self.newest.unwrap_or_default(),
            from_ms,
            to_ms,
            after: after.map(parse_cursor).transpose()?,
            through: None,
        })
    }
}

/// The rows that the parameters ask for, and one more where there are more.
pub async fn rows(
    server: &Server,
    group: &str,
    params: &Params,
    limit: i64,
) -> Result<Vec<ParameterRow>, Problem> {
    params.known(server, group).await?;
    let filter = params.filter(group)?;
    Ok(parameter::page(&server.db, &filter, limit + 1).await?)
}

pub fn cursor(row: &ParameterRow) -> String {
    of_key(&row.key())
}

/// A key as a cursor.
pub fn of_key(key: &Key) -> String {
    format!("{}/{}/{}/{}", key.job_id, key.method, key.axle, key.name)
}

fn parse_cursor(cursor: &str) -> Result<Key, Problem> {
    key(cursor).ok_or_else(|| {
        let detail = "cursor: expected the `next` of an earlier page";
        Problem::new(Kind::BadRequest, detail)
    })
}

fn key(cursor: &str) -> Option<Key> {
    let mut parts = cursor.splitn(4, '/');
    Some(Key {
        job_id: parts.next()?.parse().ok()?,
        method: parts.next()?.to_owned(),
        axle: parts.next()?.to_owned(),
        name: parts.next()?.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn only_cursors_are_cursors() {
        let id = Uuid::now_v7();
        let known = Key {
            job_id: id,
            method: "extended".into(),
            axle: "front".into(),
            name: "a/b".into(),
        };
        assert_eq!(key(&format!("{id}/extended/front/a/b")), Some(known));
        for bad in ["", "zz", "x/extended/front/a", &format!("{id}/front/a")] {
            assert_eq!(key(bad), None, "{bad}");
        }
    }

    proptest! {
        #[test]
        fn any_text_is_a_cursor_or_none(text in "\\PC{0,80}", parts in "[0-9a-f-]{30,38}(/[a-z_.]{0,9}){0,5}") {
            for text in [text, parts] {
                if let Some(known) = key(&text) {
                    prop_assert_eq!(key(&of_key(&known)), Some(known));
                }
            }
        }

        #[test]
        fn every_cursor_is_read_back(id in any::<u128>(), axle in "front|rear|both", name in "[a-z_./]{1,30}") {
            let known = Key {
                job_id: Uuid::from_u128(id),
                method: "extended".to_owned(),
                axle,
                name,
            };
            prop_assert_eq!(key(&of_key(&known)), Some(known));
        }
    }
}
