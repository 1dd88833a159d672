//! Uploads that were refused within the last week.

use askama::Template;
use axum::extract::State;
use axum::response::Html;

use super::layout::{Fault, html};
use crate::api::App;
use crate::api::access::Caller;
use crate::api::rides::refused::RefusedView;
use crate::store::refused::{self, KEPT};

#[derive(Template)]
#[template(path = "refused.html")]
struct RefusedUploads {
    uploads: Vec<RefusedView>,
}

impl RefusedUploads {
    fn here(&self) -> &'static str {
        "/jobs"
    }
}

pub async fn list(State(server): App, caller: Caller) -> Result<Html<String>, Fault> {
    let rows = refused::page(&server.db, &caller.group, None, KEPT).await?;
    html(&RefusedUploads {
        uploads: rows.into_iter().map(RefusedView::from).collect(),
    })
}
