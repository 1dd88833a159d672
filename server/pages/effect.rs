//! One effect across the fleet.

use askama::Template;
use axum::extract::State;
use axum::response::Html;
use veloid_engine::document::format_number::Quantity;

use super::layout::{Fault, Path, html};
use super::words;
use crate::api::App;
use crate::api::access::Caller;
use crate::api::fleet::across;
use crate::effects::{EffectView, library};

#[derive(Template)]
#[template(path = "effect.html")]
struct Page {
    id: String,
    /// What the library says of it; nothing of a law of one's own.
    known: Option<EffectView>,
    rows: Vec<Row>,
    /// Of all bicycles, in words.
    rides: String,
}

struct Row {
    bike: String,
    axle: String,
    rides: usize,
    sizes: Vec<(String, Option<Quantity>)>,
    last_job: String,
    last_day: String,
}

impl Page {
    fn here(&self) -> &'static str {
        "/effects"
    }
}

pub async fn page(
    State(server): App,
    caller: Caller,
    Path(id): Path<String>,
) -> Result<Html<String>, Fault> {
    let found = across(&server, &caller.group, &id).await?;
    let rides = match found.iter().map(|bike| bike.rides).sum() {
        1usize => "1 ride".to_owned(),
        rides => format!("{rides} rides"),
    };
    let rows = found.into_iter().map(|bike| Row {
        sizes: (bike.parameters.into_iter())
            .map(|size| {
                let quantity = size
                    .pooled
                    .map(|p| Quantity::new(p.value, Some(p.std_error), &size.unit));
                (words::plain(&size.name), quantity)
            })
            .collect(),
        bike: bike.bike,
        axle: bike.axle,
        rides: bike.rides,
        last_job: bike.last_job.to_string(),
        last_day: bike.last_at.get(..10).unwrap_or(&bike.last_at).to_owned(),
    });
    html(&Page {
        rows: rows.collect(),
        rides,
        known: library().into_iter().find(|effect| effect.id == id),
        id,
    })
}
