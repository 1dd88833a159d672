//! The web pages, rendered on the server; they work without JavaScript, plots aside.

pub mod assets;
mod bicycle;
pub mod bike;
mod compare;
mod deletion;
mod dependence;
mod effect;
mod effects;
mod events;
mod facts;
mod feed;
pub mod fleet;
mod job;
mod jobs;
pub mod layout;
mod parameters;
mod refused;
mod search;
mod sign_in;
mod study;
mod upload;
mod validation;
mod verdict;
pub mod words;

use std::sync::Arc;

use axum::Router;
use axum::middleware::from_fn;
use axum::routing::{get, post};

use crate::api::Server;

/// The pages, and what their forms send. Each refuses names in its query that it does not know.
pub fn routes() -> Router<Arc<Server>> {
    without_query()
        .route_layer(from_fn(layout::takes_no_query))
        .merge(with_query())
        .route("/favicon.ico", get(assets::icon))
        .route("/assets/{version}/{name}", get(assets::serve))
}

fn with_query() -> Router<Arc<Server>> {
    Router::new()
        .route("/", get(upload::form).post(upload::send))
        .route("/sign-in", get(sign_in::form))
        .route("/jobs", get(jobs::list))
        .route("/compare", get(compare::compare))
        .route("/jobs/{id}/validation", get(validation::page))
        .route("/bikes", get(fleet::bikes))
        .route("/dependence", get(dependence::page))
        .route("/parameters", get(parameters::list))
}

fn without_query() -> Router<Arc<Server>> {
    Router::new()
        .route("/sign-in", post(sign_in::sign_in))
        .route("/sign-out", post(sign_in::sign_out))
        .route("/jobs.atom", get(feed::feed))
        .route("/jobs/{id}", get(job::page))
        .route("/jobs/{id}/cancel", post(job::cancel))
        .route("/jobs/{id}/retry", post(job::retry))
        .route("/rides/{id}/delete", post(deletion::delete_ride))
        .route("/rides/{id}/restore", post(deletion::restore_ride))
        .route("/rides/{id}/facts", post(facts::keep))
        .route("/bikes/{bike}/delete", post(deletion::delete_bike))
        .route("/bikes/{bike}/restore", post(deletion::restore_bike))
        .route("/bikes/{bike}/study", post(study::create))
        .route("/bikes/{bike}/events", post(events::create))
        .route("/bikes/{bike}/events/{id}/delete", post(events::delete))
        .route("/refused", get(refused::list))
        .route("/effects", get(effects::list))
        .route("/effects/{effect}", get(effect::page))
        .route("/bikes/{bike}", get(bike::bike))
}
