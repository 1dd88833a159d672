//! One bicycle of the fleet.

use askama::Template;
use axum::extract::State;
use axum::response::Html;
use veloid_engine::document::format_number::{Quantity, fixed, significant};

use crate::api::App;
use crate::api::access::Caller;
use crate::api::bikes::existing;
use crate::api::jobs::view::JobView;
use crate::api::pressure;
use crate::api::problem::Problem;
use crate::erasure::DAY_MS;
use crate::fleet::words::{became, capital, quantity, subject};
use crate::fleet::{self, BikeEvent, Course, ProposedRide};
use crate::pages::layout::{Fault, Path, html};
use crate::pages::{verdict, words};
use crate::store::{job, now_ms};
use crate::time;

/// Latest jobs on a bicycle's page.
const JOBS: i64 = 20;

/// What a parameter of an axle is called.
pub fn label(axle: &str, name: &str) -> String {
    match name {
        "k_n_m" => format!("k {axle}"),
        "b_n_s_m" => format!("B {axle}"),
        name => format!("{axle} {}", quantity(name)),
    }
}

#[derive(Template)]
#[template(path = "bike.html")]
struct BikePage {
    name: String,
    /// The name as it stands in a query.
    query: String,
    /// Address of the data of the plots.
    course: String,
    courses: Vec<CourseRow>,
    notices: Vec<String>,
    /// What tyre pressure does, in a sentence for each axle.
    pressure: Vec<String>,
    proposals: Vec<ProposedRide>,
    /// Whether there are rides that could be identified as one.
    can_study: bool,
    events: Vec<BikeEvent>,
    today: String,
    jobs: Vec<verdict::Listed>,
    document: String,
    grace_days: i64,
}

struct CourseRow {
    name: String,
    rides: usize,
    pooled: Quantity,
    heterogeneity: String,
    now: Quantity,
}

impl BikePage {
    fn has_parquet(&self) -> bool {
        cfg!(feature = "parquet")
    }

    fn here(&self) -> &'static str {
        ""
    }
}

fn chance(p: f64) -> String {
    if p < 1e-3 {
        "p\u{a0}<\u{a0}0.001".to_owned()
    } else {
        format!("p\u{a0}=\u{a0}{}", significant(p, 2))
    }
}

impl CourseRow {
    fn of(course: &Course) -> Option<Self> {
        let pooled = course.pooled.as_ref()?;
        let plain = |x: f64| Quantity::rough(x, 3, &course.unit).to_string();
        let share = fixed(100.0 * pooled.heterogeneity, 0);
        Some(Self {
            name: label(&course.axle, &course.name),
            rides: pooled.rides,
            pooled: Quantity::new(pooled.value, Some(pooled.std_error), &course.unit),
            heterogeneity: match pooled.p_heterogeneous {
                _ if pooled.rides < 2 => "one ride only".to_owned(),
                Some(p) => format!(
                    "{} ({share} % of the total, {})",
                    plain(pooled.between_rides),
                    chance(p)
                ),
                None => plain(pooled.between_rides),
            },
            now: course.development.as_ref().map_or_else(
                || Quantity::new(pooled.value, Some(pooled.std_error), &course.unit),
                |d| Quantity::new(d.now, Some(d.now_std_error), &course.unit),
            ),
        })
    }
}

/// The day of an RFC 3339 time.
pub fn day(time: &str) -> &str {
    time.get(..10).unwrap_or(time)
}

/// What became of each parameter, in a sentence each.
fn notices(courses: &[Course]) -> Vec<String> {
    let reported = |course: &Course| {
        let said = became(course.development.as_ref()?, &course.unit)?;
        Some(format!(
            "{} {said}.",
            capital(&subject(&course.axle, &course.name))
        ))
    };
    courses.iter().filter_map(reported).collect()
}

pub async fn bike(
    State(server): App,
    caller: Caller,
    Path(name): Path<String>,
) -> Result<Html<String>, Fault> {
    let row = existing(&server, &caller.group, &name).await?;
    let history = fleet::history(&server.db, &caller.group, &name).await?;
    let filter = job::Filter {
        group: &caller.group,
        bike: Some(&name),
        ..job::Filter::default()
    };
    let jobs = job::page(&server.db, &filter, JOBS).await?;
    let jobs = jobs.into_iter().map(JobView::from).collect();
    html(&BikePage {
        query: form_urlencoded::byte_serialize(name.as_bytes()).collect(),
        course: format!("/v1{}/course", words::bike_page(&name)),
        courses: history.courses.iter().filter_map(CourseRow::of).collect(),
        notices: notices(&history.courses),
        pressure: pressure::of(&server, &caller.group, Some(&name)).await?,
        proposals: fleet::proposals(&server.db, &caller.group, &name).await?,
        can_study: history.courses.iter().any(|course| course.points.len() > 1),
        events: history.events,
        today: day(&time::text(now_ms())).to_owned(),
        jobs: verdict::listed(&server.db, jobs).await?,
        document: serde_json::to_string_pretty(&row.document.0).map_err(Problem::internal)?,
        grace_days: server.policy.grace_ms / DAY_MS,
        name,
    })
}
