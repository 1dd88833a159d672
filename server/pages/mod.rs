//! The web pages, rendered on the server; they work without JavaScript, plots aside.

pub mod assets;
mod bicycle;
mod bikes;
mod compare;
mod deletion;
mod dependence;
mod effect;
mod effects;
mod estimate;
mod facts;
mod feed;
mod fleet;
mod job;
mod jobs;
pub mod layout;
mod parameters;
mod sign_in;
mod upload;
mod verdict;
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
        .route("/jobs.atom", get(feed::feed))
        .route("/jobs/{id}", get(job::page))
        .route("/jobs/{id}/cancel", post(job::cancel))
        .route("/jobs/{id}/retry", post(job::retry))
        .route("/rides/{id}/delete", post(deletion::delete_ride))
        .route("/rides/{id}/restore", post(deletion::restore_ride))
        .route("/rides/{id}/facts", post(facts::keep))
        .route("/bikes/{bike}/delete", post(deletion::delete_bike))
        .route("/bikes/{bike}/restore", post(deletion::restore_bike))
        .route("/compare", get(compare::compare))
        .route("/effects", get(effects::list))
        .route("/effects/{effect}", get(effect::page))
        .route("/bikes", get(bikes::bikes))
        .route("/dependence", get(dependence::page))
        .route("/bikes/{bike}", get(fleet::bike))
        .route("/parameters", get(parameters::list))
        .route("/favicon.ico", get(assets::icon))
        .route("/assets/{version}/{name}", get(assets::serve))
}
