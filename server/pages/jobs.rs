//! The list of jobs.

use askama::Template;
use axum::extract::{OriginalUri, State};
use axum::response::Html;
use serde::Deserialize;
use uuid::Uuid;
use veloid_engine::report::diagnosis::Verdict;

use super::layout::{Fault, Query, filled, html};
use super::search::{Field, fields, names};
use super::{verdict, words};
use crate::api::App;
use crate::api::access::Caller;
use crate::api::jobs::search::SearchParams;
use crate::api::jobs::view::JobView;
use crate::api::known;
use crate::api::list::{Page, without_cursor};
use crate::api::names::{EFFECTS, one_of};
use crate::erasure::DAY_MS;
use crate::store::bike;
use crate::store::job::{self, State as JobState};
use crate::time;

const PAGE: i64 = 50;
const STATES: [JobState; 5] = [
    JobState::Queued,
    JobState::Running,
    JobState::Succeeded,
    JobState::Failed,
    JobState::Cancelled,
];

/// The names of the address, beside those of a search.
const NAMES: [&str; 11] = [
    "state", "bike", "verdict", "tag", "name", "effect", "from", "to", "deleted", "cursor", "theme",
];

/// The filter, blank where the form's field was.
#[derive(Deserialize)]
pub struct Params {
    state: Option<String>,
    bike: Option<String>,
    verdict: Option<String>,
    tag: Option<String>,
    name: Option<String>,
    effect: Option<String>,
    from: Option<String>,
    to: Option<String>,
    /// Those that are deleted.
    deleted: Option<String>,
    cursor: Option<Uuid>,
}

#[derive(Template)]
#[template(path = "jobs.html")]
struct Jobs {
    jobs: Vec<verdict::Listed>,
    next: Option<String>,
    states: [&'static str; 5],
    verdicts: [&'static str; 6],
    state: Option<String>,
    bike: Option<String>,
    verdict: Option<String>,
    tag: Option<String>,
    name: Option<String>,
    effect: Option<String>,
    /// Names with their words.
    effects: Vec<(&'static str, String)>,
    from: Option<String>,
    to: Option<String>,
    search: SearchParams,
    deleted: bool,
    /// The bicycle that the list is of, if it is deleted too.
    deleted_bike: Option<String>,
    grace_days: i64,
}

impl Jobs {
    fn here(&self) -> &'static str {
        "/jobs"
    }

    fn filtered(&self) -> bool {
        [
            &self.state,
            &self.bike,
            &self.verdict,
            &self.tag,
            &self.name,
            &self.effect,
            &self.from,
            &self.to,
        ]
        .into_iter()
        .any(Option::is_some)
            || self.searches()
    }

    /// Whether facts or results are searched for.
    fn searches(&self) -> bool {
        let fields = fields(&self.search);
        fields.iter().any(|field| !field.value.is_empty())
    }

    fn fields(&self) -> Vec<Field> {
        fields(&self.search)
    }
}

fn known_names() -> Vec<String> {
    let own = NAMES.into_iter();
    own.chain(names()).map(str::to_owned).collect()
}

pub async fn list(
    State(server): App,
    caller: Caller,
    OriginalUri(uri): OriginalUri,
    Query(params): Query<Params>,
    Query(search): Query<SearchParams>,
) -> Result<Html<String>, Fault> {
    known::only(&known_names(), uri.query().unwrap_or_default())?;
    let names = STATES.map(JobState::name);
    let (state, verdict) = (filled(params.state), filled(params.verdict));
    one_of("state", state.as_deref(), &names)?;
    one_of("verdict", verdict.as_deref(), &Verdict::NAMES)?;
    let bike = filled(params.bike);
    let deleted = filled(params.deleted);
    one_of("deleted", deleted.as_deref(), &["true"])?;
    let deleted = deleted.is_some();
    let (tag, from, to) = (filled(params.tag), filled(params.from), filled(params.to));
    let (name, effect) = (filled(params.name), filled(params.effect));
    one_of("effect", effect.as_deref(), &EFFECTS)?;
    let (from_ms, to_ms) = time::span(from.as_deref(), to.as_deref())?;
    let of_name = |name: &str| STATES.into_iter().find(|state| state.name() == name);
    let filter = job::Filter {
        group: &caller.group,
        state: state.as_deref().and_then(of_name),
        bike: bike.as_deref(),
        verdict: verdict.as_deref(),
        ride: None,
        tag: tag.as_deref(),
        name: name.as_deref(),
        effect: effect.as_deref(),
        search: search.search()?,
        from_ms,
        to_ms,
        of_one_ride: false,
        deleted,
        before: params.cursor,
    };
    let there = match bike.as_deref().filter(|_| deleted) {
        Some(name) => bike::find(&server.db, &caller.group, name).await?.is_some(),
        None => true,
    };
    let deleted_bike = bike.clone().filter(|_| !there);
    let rows = job::page(&server.db, &filter, PAGE + 1).await?;
    let page: Page<JobView> = Page::cut(rows, PAGE, |row| row.id.to_string(), JobView::from);
    let here = without_cursor(&uri);
    let mark = if here.contains('?') { '&' } else { '?' };
    html(&Jobs {
        jobs: verdict::listed(&server.db, page.items).await?,
        next: page.next.map(|next| format!("{here}{mark}cursor={next}")),
        states: names,
        verdicts: Verdict::NAMES,
        state,
        bike,
        verdict,
        tag,
        name,
        effect,
        effects: EFFECTS.iter().map(|id| (*id, words::plain(id))).collect(),
        from,
        to,
        search,
        deleted,
        deleted_bike,
        grace_days: server.policy.grace_ms / DAY_MS,
    })
}
