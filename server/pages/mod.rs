//! The web pages, rendered on the server; they work without JavaScript, plots aside.

pub mod assets;
mod compare;
mod estimate;
mod fleet;
mod job;
mod jobs;
pub mod layout;
mod parameters;
mod sign_in;
mod upload;
pub mod words;

use std::sync::Arc;

use axum::Router;
use axum::routing::{get, post};

use crate::api::Server;

pub fn routes() -> Router<Arc<Server>> {
    Router::new()
        .route("/", get(upload::form).post(upload::send))
        .route("/sign-in", get(sign_in::form).post(sign_in::sign_in))
        .route("/sign-out", post(sign_in::sign_out))
        .route("/jobs", get(jobs::list))
        .route("/jobs/{id}", get(job::page))
        .route("/jobs/{id}/cancel", post(job::cancel))
        .route("/jobs/{id}/retry", post(job::retry))
        .route("/compare", get(compare::compare))
        .route("/bikes", get(fleet::bikes))
        .route("/bikes/{bike}", get(fleet::bike))
        .route("/parameters", get(parameters::list))
        .route("/favicon.ico", get(assets::icon))
        .route("/assets/{version}/{name}", get(assets::serve))
}
